"""The loop of `QuaternionEkf`: to rounding what filterpy makes of `quaternion_matrices`, in less time.

It computes from what is special about these matrices: blocks, rotations, symmetry.  State and covariance are
tuples of numbers (`registers`).  With a diagonal R the measurement vector is taken one component after the
other, so that no matrix is inverted and a rejected component is merely passed over.  Nothing is allocated
within the loop.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import fused, inlined
from baroarma.estimators.attitude.quaternion_matrices import (
    EkfSettings,
    fill_up,
    level_quaternion,
    up_gradient,
    upward,
)
from baroarma.estimators.attitude.registers import (
    dot4,
    plus3,
    plus4,
    plus_outer3,
    plus_outer4,
    scaled4,
    sine,
    times4,
    versine,
)
from baroarma.estimators.attitude.samples import forget_rate, is_lost, is_sample, levelled, take_rate

Array = NDArray[np.float64]
Vector = tuple[float, ...] | Array


class EkfBelief(NamedTuple):
    """State (q, b) and covariance [[P_qq, P_qb], [P_qb', P_bb]] of `QuaternionEkf`."""

    q: Vector
    b: Vector
    P_qq: Vector
    """4 x 4, ten numbers."""
    P_qb: tuple[Vector, Vector, Vector]
    """4 x 3, by columns."""
    P_bb: Vector
    """3 x 3, six numbers."""


@fused
def run_quaternion_ekf(
    t: Array,
    before: float,
    accel: Array,
    gyro: Array,
    gyro_bias: Array,
    gravity: float,
    s: EkfSettings,
    x: Array,
    P: Array,
    held: Array,
    ups: Array,
    vertical: Array,
    vertical_sd: Array,
) -> None:
    """Run SG14's filter over all samples, the first of which comes at t[0] - `before`.

    x, P, held go on, the last three are filled.
    """
    belief = load_belief(x, P)
    now: Vector = held[0], held[1], held[2], held[3]
    for k in range(len(t)):
        dt = t[k] - before
        before = t[k]
        f, up = accel[k], ups[k]
        now = forget_rate(now, dt)
        belief = predict_quaternion(belief, now, dt, s)
        new = is_sample(f)
        if new and is_lost(now):
            store_belief(belief, x, P)
            if level_quaternion(x, P, f, s.initial_quaternion_sd):
                now = levelled(now)
            belief = load_belief(x, P)
        elif new:
            belief = correct_quaternion(belief, f, gravity, s)
        fill_up(up, belief.q)
        vertical[k] = vertical_sd[k] = math.nan
        if new:
            vertical[k] = f[0] * up[0] + f[1] * up[1] + f[2] * up[2] - gravity
            vertical_sd[k] = math.sqrt(max(lean_variance(belief, f, up) + s.accel_noise_sd**2, 0.0))
        now = take_rate(now, gyro[k], gyro_bias)
    store_belief(belief, x, P)
    held[0], held[1], held[2], held[3] = now


@inlined
def predict_quaternion(belief: EkfBelief, held: Vector, dt: float, s: EkfSettings) -> EkfBelief:
    """Let x = F x and P = F P F' + Q, with F = [[F_q, 0], [0, exp(-alpha dt) I]] [SG14, Eqs. 2-12].

    Block by block: F_q P_qq F_q' + Q_q, F_q P_qb exp(-alpha dt), P_bb exp(-2 alpha dt) + Q_b I.
    """
    q, P = belief.q, belief.P_qq
    turn = half_turn(held, dt)
    angle = (s.gyro_noise_sd * dt / 2) ** 2
    trace = angle * (dot4(q, q) + (P[0] + P[4]) + (P[7] + P[9]))
    N = plus_outer4(P, 1.0, q)  # Q_q = angle (trace(N) I - N), N = q q' + P_qq   [Eq. 12]
    T = turned_covariance(P, turn)
    P_qq = (
        T[0] - angle * N[0] + trace,
        T[1] - angle * N[1],
        T[2] - angle * N[2],
        T[3] - angle * N[3],
        T[4] - angle * N[4] + trace,
        T[5] - angle * N[5],
        T[6] - angle * N[6],
        T[7] - angle * N[7] + trace,
        T[8] - angle * N[8],
        T[9] - angle * N[9] + trace,
    )
    G = turned(belief.P_qb[0], turn), turned(belief.P_qb[1], turn), turned(belief.P_qb[2], turn)
    b, B, keep, walk = belief.b, belief.P_bb, 1.0, dt
    if s.bias_decay > 0:
        keep, walk = math.exp(-s.bias_decay * dt), math.expm1(-2 * s.bias_decay * dt) / (-2 * s.bias_decay)
        b = keep * b[0], keep * b[1], keep * b[2]
        G = scaled4(keep, G[0]), scaled4(keep, G[1]), scaled4(keep, G[2])
    k, w = keep * keep, walk * s.bias_walk_sd**2
    P_bb = k * B[0] + w, k * B[1], k * B[2], k * B[3] + w, k * B[4], k * B[5] + w
    return EkfBelief(turned(q, turn), b, P_qq, G, P_bb)


@inlined
def correct_quaternion(belief: EkfBelief, f: Array, gravity: float, s: EkfSettings) -> EkfBelief:
    """Take the components of the specific force `f` that lie within the gate; then |q| = 1 [Eqs. 17-21].

    f = g up(q) + b, H = [h, I] with h = g d up/d q, and [m_c; n_c] is column c of P H'.  S = H P H' + R is
    taken apart as L D L', so that its components come one after the other: what the first says about the
    second and third is taken from these.  A component beyond the gate says nothing, its share 1/D is 0.
    """
    q, P, G, B = belief.q, belief.P_qq, belief.P_qb, belief.P_bb
    up, r = upward(q), s.accel_noise_sd**2
    h0, h1 = scaled4(gravity, up_gradient(q, 0)), scaled4(gravity, up_gradient(q, 1))
    h2 = scaled4(gravity, up_gradient(q, 2))
    m0, m1 = plus4(times4(P, h0), 1.0, G[0]), plus4(times4(P, h1), 1.0, G[1])
    m2 = plus4(times4(P, h2), 1.0, G[2])
    n0: Vector = dot4(G[0], h0) + B[0], dot4(G[1], h0) + B[1], dot4(G[2], h0) + B[2]
    n1: Vector = dot4(G[0], h1) + B[1], dot4(G[1], h1) + B[3], dot4(G[2], h1) + B[4]
    n2: Vector = dot4(G[0], h2) + B[2], dot4(G[1], h2) + B[4], dot4(G[2], h2) + B[5]
    y0, y1, y2 = f[0] - gravity * up[0], f[1] - gravity * up[1], f[2] - gravity * up[2]
    y0, y1, y2 = y0 - belief.b[0], y1 - belief.b[1], y2 - belief.b[2]
    near0, near1, near2 = abs(y0) <= s.gate, abs(y1) <= s.gate, abs(y2) <= s.gate

    share0 = 1 / (dot4(h0, m0) + n0[0] + r) if near0 else 0.0
    S10, S20, S21 = dot4(h0, m1) + n1[0], dot4(h0, m2) + n2[0], dot4(h1, m2) + n2[1]
    L10, L20 = share0 * S10, share0 * S20
    share1 = 1 / (dot4(h1, m1) + n1[1] + r - L10 * S10) if near1 else 0.0
    L21 = share1 * (S21 - L10 * S20)
    D2 = dot4(h2, m2) + n2[2] + r - L20 * S20 - L21 * (S21 - L10 * S20)
    share2 = 1 / D2 if near2 else 0.0

    m1, n1, y1 = plus4(m1, -L10, m0), plus3(n1, -L10, n0), y1 - L10 * y0
    m2, n2, y2 = plus4(m2, -L20, m0), plus3(n2, -L20, n0), y2 - L20 * y0
    m2, n2, y2 = plus4(m2, -L21, m1), plus3(n2, -L21, n1), y2 - L21 * y1
    belief = take_component(belief, m0, n0, share0, share0 * y0)
    belief = take_component(belief, m1, n1, share1, share1 * y1)
    belief = take_component(belief, m2, n2, share2, share2 * y2)
    unit = scaled4(1 / math.sqrt(dot4(belief.q, belief.q)), belief.q)
    return EkfBelief(unit, belief.b, belief.P_qq, belief.P_qb, belief.P_bb)


@inlined
def take_component(belief: EkfBelief, m: Vector, n: Vector, share: float, y: float) -> EkfBelief:
    """Let x = x + [m; n] y and P = P - [m; n] share [m; n]': Joseph's form, with the optimal gain put in."""
    G = belief.P_qb
    return EkfBelief(
        plus4(belief.q, y, m),
        plus3(belief.b, y, n),
        plus_outer4(belief.P_qq, -share, m),
        (plus4(G[0], -share * n[0], m), plus4(G[1], -share * n[1], m), plus4(G[2], -share * n[2], m)),
        plus_outer3(belief.P_bb, -share, n),
    )


@inlined
def lean_variance(belief: EkfBelief, f: Array, up: Array) -> float:
    """Return f_h' J P_qq J' f_h, as `vertical_acceleration` has it."""
    along = f[0] * up[0] + f[1] * up[1] + f[2] * up[2]
    lever = scaled4(f[0] - along * up[0], up_gradient(belief.q, 0))
    lever = plus4(lever, f[1] - along * up[1], up_gradient(belief.q, 1))
    lever = plus4(lever, f[2] - along * up[2], up_gradient(belief.q, 2))
    return dot4(lever, times4(belief.P_qq, lever))


@inlined
def half_turn(held: Vector, dt: float) -> Vector:
    """Return (cos(|w| dt/2), w sin(|w| dt/2)/|w|): the turn in dt as a quaternion, scalar *first*."""
    p, q, r = held[0], held[1], held[2]
    u = (p * p + q * q + r * r) * (dt * dt / 4)
    s = sine(u) * dt / 2
    return 1 - u * versine(u), s * p, s * q, s * r


@inlined
def turned(v: Vector, turn: Vector) -> Vector:
    """Return F_q v: `fill_quaternion_transition` without its zeros."""
    c, p, q, r = turn
    return (
        c * v[0] + r * v[1] - q * v[2] + p * v[3],
        c * v[1] - r * v[0] + p * v[2] + q * v[3],
        c * v[2] + q * v[0] - p * v[1] + r * v[3],
        c * v[3] - p * v[0] - q * v[1] - r * v[2],
    )


@inlined
def turned_covariance(P: Vector, turn: Vector) -> Vector:
    """Return F_q P F_q' for a symmetric P, 4 x 4: its columns turned, then the rows of that."""
    a = turned((P[0], P[1], P[2], P[3]), turn)
    b = turned((P[1], P[4], P[5], P[6]), turn)
    c = turned((P[2], P[5], P[7], P[8]), turn)
    d = turned((P[3], P[6], P[8], P[9]), turn)
    e = turned((a[0], b[0], c[0], d[0]), turn)
    f = turned((a[1], b[1], c[1], d[1]), turn)
    g = turned((a[2], b[2], c[2], d[2]), turn)
    h = turned((a[3], b[3], c[3], d[3]), turn)
    return e[0], e[1], e[2], e[3], f[1], f[2], f[3], g[2], g[3], h[3]


@fused
def load_belief(x: Array, P: Array) -> EkfBelief:
    """Take the numbers out of x, (7,), and P, (7, 7)."""
    return EkfBelief(
        (x[0], x[1], x[2], x[3]),
        (x[4], x[5], x[6]),
        (P[0, 0], P[0, 1], P[0, 2], P[0, 3], P[1, 1], P[1, 2], P[1, 3], P[2, 2], P[2, 3], P[3, 3]),
        (
            (P[0, 4], P[1, 4], P[2, 4], P[3, 4]),
            (P[0, 5], P[1, 5], P[2, 5], P[3, 5]),
            (P[0, 6], P[1, 6], P[2, 6], P[3, 6]),
        ),
        (P[4, 4], P[4, 5], P[4, 6], P[5, 5], P[5, 6], P[6, 6]),
    )


@fused
def store_belief(belief: EkfBelief, x: Array, P: Array) -> None:
    """Put the numbers back into x and P."""
    k = m = 0
    for i in range(4):
        x[i] = belief.q[i]
        for j in range(i, 4):
            P[i, j] = P[j, i] = belief.P_qq[k]
            k += 1
        for j in range(3):
            P[i, 4 + j] = P[4 + j, i] = belief.P_qb[j][i]
    for i in range(3):
        x[4 + i] = belief.b[i]
        for j in range(i, 3):
            P[4 + i, 4 + j] = P[4 + j, 4 + i] = belief.P_bb[m]
            m += 1
