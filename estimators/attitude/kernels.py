"""Compiled matrices and loops of the attitude filters.

The functions `fill_*` write the matrices of the two filters into arrays that exist already, for filterpy's
own predict and update.  The loops `run_*` compute the same to rounding, for a recording or a single step,
from what is special about these matrices: blocks, rotations, symmetry.  State and covariance are tuples of
numbers there, which the compiler keeps in registers; of a symmetric matrix the upper triangle, row after row.
With a diagonal R the measurement vector is taken one component after the other, so that no matrix is inverted
and a rejected component is merely passed over.

Nothing is allocated within a loop.  Letters are the papers'; the equations stand in `quaternion_ekf` and
`tilt_kalman`.  Everything compiled is in this one file, because numba's cache watches no other.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Vector = tuple[float, ...] | Array
fused = njit(cache=True, fastmath={"contract"}, error_model="numpy")
"""Compile with a b + c in one rounding; nothing else that a NaN could notice."""
inlined = njit(cache=True, fastmath={"contract"}, error_model="numpy", inline="always")

LONGEST_HOLD: Final = 0.5
"""A missing gyro sample is replaced by the last one for so many seconds (chosen by us: about the time in
which a limb's turn comes to its end).  After a longer gap the next specific force gives the tilt anew."""
LEVELLING_SD: Final = 0.1
"""Error of that tilt in `TiltKalman`, rad (chosen by us): the body may be accelerated by 1 m/s² sideways."""
MOST_FORCE: Final = 1000.0
"""Specific force, m/s², that is no sample but a broken transfer (chosen by us): 100 g, where such sensors end
at 32."""
LEAST_FORCE: Final = 1.0
"""Specific force, m/s², below which a body falls freely and none points up (chosen by us)."""
MOST_RATE: Final = 100.0
"""Angular rate, rad/s, likewise: 5700 °/s, where gyros end at 4000."""


class EkfSettings(NamedTuple):
    """Settings of `QuaternionEkf`, in its units."""

    gyro_noise_sd: float
    accel_noise_sd: float
    bias_walk_sd: float
    bias_decay: float
    gate: float
    initial_quaternion_sd: float
    initial_bias_sd: float


class TiltSettings(NamedTuple):
    """Settings of `TiltKalman`, in its units."""

    gyro_noise_sd: float
    accel_noise_sd: float
    acceleration_memory: float
    exponential: bool


def as_array(values: ArrayLike) -> Array:
    """Return a copy in the one layout that is compiled for: floats, writeable, row after row."""
    return np.array(values, dtype=float, order="C")


def as_rows(values: ArrayLike, width: int = 0) -> Array:
    """Return the values as a read-only view, (n,) or (n, `width`), without a copy where that can be."""
    rows = np.ascontiguousarray(values, float)
    rows = rows.reshape(-1, width) if width else rows.view()
    rows.flags.writeable = False
    return rows


@njit(cache=True)
def vertical_acceleration(
    accel: Array, up: Array, jacobian: Array, P: Array, gravity: float, noise_sd: float
) -> tuple[float, float]:
    """Project the specific force on the vertical, without gravity; return it with its sd, m/s².

    a_z = up . f - gravity.  An error of the vertical, d_up = J dx with cov(dx) = P, turns the horizontal
    force f_h = f - (up . f) up into the vertical (it cannot stretch the unit vector), hence

        var(a_z) = f_h' J P J' f_h + noise_sd².

    `jacobian` is (3, m); the leading m x m block of `P` is used.
    """
    along = accel[0] * up[0] + accel[1] * up[1] + accel[2] * up[2]
    m = jacobian.shape[1]
    variance = noise_sd * noise_sd
    for i in range(m):
        for j in range(m):
            variance += (
                _lever(i, accel, along, up, jacobian) * P[i, j] * _lever(j, accel, along, up, jacobian)
            )
    return along - gravity, math.sqrt(max(variance, 0.0))


@njit(cache=True)
def _lever(i: int, accel: Array, along: float, up: Array, jacobian: Array) -> float:
    """Component i of J' f_h."""
    total = 0.0
    for c in range(3):
        total += jacobian[c, i] * (accel[c] - along * up[c])
    return total


@njit(cache=True)
def is_sample(v: Array) -> bool:
    """Return whether all three components of a specific force are there, and can be."""
    return bool(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] < MOST_FORCE**2)


@njit(cache=True)
def has_vertical(force: Array) -> bool:
    """Return whether a specific force is no free fall's."""
    return bool(force[0] ** 2 + force[1] ** 2 + force[2] ** 2 > LEAST_FORCE**2)


@njit(cache=True)
def is_rate(v: Array) -> bool:
    """Return whether all three components of an angular rate are there, and can be."""
    return bool(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] < MOST_RATE**2)


@njit(cache=True)
def project(
    accel: Array, ups: Array, P: Array, gravity: float, noise_sd: float, vertical: Array, vertical_sd: Array
) -> None:
    """Fill the last two from given verticals, (n, 3), that have the covariance `P`, (3, 3)."""
    J = np.eye(3)
    for k in range(len(ups)):
        vertical[k] = vertical_sd[k] = math.nan
        if is_sample(accel[k]):
            vertical[k], vertical_sd[k] = vertical_acceleration(accel[k], ups[k], J, P, gravity, noise_sd)


@njit(cache=True)
def hold_last(rows: Array, last: Array) -> None:
    """Replace rows without a sample, (n, 3), by the row before, the first by `last`; update `last`."""
    for k in range(len(rows)):
        if is_sample(rows[k]):
            last[:] = rows[k]
        else:
            rows[k] = last


@inlined
def forget_rate(held: Vector, dt: float) -> Vector:
    """Return `held`, the rate in use and the time since its sample, `dt` later: too old, it is forgotten."""
    if held[3] + dt <= LONGEST_HOLD:
        return held[0], held[1], held[2], held[3] + dt
    return 0.0, 0.0, 0.0, held[3] + dt


@inlined
def is_lost(held: Vector) -> bool:
    """Return whether the tilt is lost, because the last gyro sample was too old."""
    return held[3] > LONGEST_HOLD


@inlined
def take_rate(held: Vector, gyro: Array, bias: Array) -> Vector:
    """Return `held` with gyro - bias for the next interval, if there is a sample.  A lost tilt stays lost."""
    if not is_rate(gyro):
        return held[0], held[1], held[2], held[3]
    return gyro[0] - bias[0], gyro[1] - bias[1], gyro[2] - bias[2], held[3] if is_lost(held) else 0.0


@inlined
def levelled(held: Vector) -> Vector:
    """Return `held` when the tilt has been found again."""
    return held[0], held[1], held[2], 0.0


@njit(cache=True)
def normalise(v: Array) -> None:
    """Give the vector unit length, in place [SG14, Eq. 21]."""
    square = 0.0
    for c in v:
        square += c * c
    norm = math.sqrt(square)
    for i in range(len(v)):
        v[i] /= norm


@njit(cache=True)
def fill_up(up: Array, q: Vector) -> None:
    """Write the vertical in body axes: the last row of C^nb [SG14, Eq. 23, sign corrected]."""
    up[0], up[1], up[2] = upward(q)


@inlined
def upward(q: Vector) -> Vector:
    """Return what `fill_up` writes."""
    return (
        2.0 * (q[0] * q[2] - q[1] * q[3]),
        2.0 * (q[1] * q[2] + q[0] * q[3]),
        1.0 - 2.0 * (q[0] * q[0] + q[1] * q[1]),
    )


@njit(cache=True)
def fill_up_jacobian(J: Array, q: Array) -> None:
    """Write d up/d q, shape (3, 4): `fill_up` differentiated, SG14 Eq. 18 for g = (0, 0, -1)."""
    for c in range(3):
        for i in range(4):
            J[c, i] = up_gradient(q, c)[i]


@njit(cache=True)
def up_gradient(q: Vector, c: int) -> Vector:
    """Return row c of d up/d q."""
    if c == 0:
        return 2 * q[2], -2 * q[3], 2 * q[0], -2 * q[1]
    if c == 1:
        return 2 * q[3], 2 * q[2], 2 * q[1], 2 * q[0]
    return -4 * q[0], -4 * q[1], 0.0, 0.0


@njit(cache=True)
def fill_level(q: Array, up: Array) -> None:
    """Write the shortest rotation that has this vertical, of any length; upside down it is a turn about x."""
    horizontal = math.hypot(up[0], up[1])
    half = math.atan2(horizontal, up[2]) / 2
    q[:] = 0.0
    q[3] = math.cos(half)
    if horizontal > 0:
        q[0] = math.sin(half) * up[1] / horizontal
        q[1] = -math.sin(half) * up[0] / horizontal
    else:
        q[0] = math.sin(half)


@njit(cache=True)
def fill_turn_covariance(P: Array, q: Array, sd: float) -> None:
    """Write sd² (I - q q') into q's block and 0 beside it: errors that turn q and do not stretch it."""
    P[:4, :] = 0.0
    P[:, :4] = 0.0
    for i in range(4):
        for j in range(4):
            P[i, j] = -sd * sd * q[i] * q[j]
        P[i, i] += sd * sd


@njit(cache=True)
def level_quaternion(x: Array, P: Array, accel: Array, sd: float) -> bool:
    """Level q by this specific force, with P0's `sd`; return False in free fall, which has no vertical.

    A wide covariance would be wrong here: a single component inside the gate could then turn the tilt away.
    """
    if not has_vertical(accel):
        return False
    fill_level(x[:4], accel)
    fill_turn_covariance(P, x[:4], sd)
    return True


@njit(cache=True)
def fill_quaternion_transition(F: Array, held: Array, dt: float, decay: float) -> None:
    """Write F, shape (7, 7), whose other elements are 0 [SG14, Eqs. 3, 5, 8]."""
    p, q, r = held[0], held[1], held[2]
    speed = math.sqrt(p * p + q * q + r * r)
    c = math.cos(speed * dt / 2)
    s = math.sin(speed * dt / 2) / speed if speed > 0 else dt / 2
    F[0, 0], F[0, 1], F[0, 2], F[0, 3] = c, s * r, -s * q, s * p
    F[1, 0], F[1, 1], F[1, 2], F[1, 3] = -s * r, c, s * p, s * q
    F[2, 0], F[2, 1], F[2, 2], F[2, 3] = s * q, -s * p, c, s * r
    F[3, 0], F[3, 1], F[3, 2], F[3, 3] = -s * p, -s * q, -s * r, c
    F[4, 4] = F[5, 5] = F[6, 6] = math.exp(-decay * dt)


@njit(cache=True)
def fill_quaternion_noise(Q: Array, x: Array, P: Array, dt: float, s: EkfSettings) -> None:
    """Write Q, (7, 7), whose other elements are 0, from the last updated x and P [SG14, Eqs. 7, 11, 12]."""
    angle = (s.gyro_noise_sd * dt / 2) ** 2
    trace = 0.0
    for i in range(4):
        trace += x[i] * x[i] + P[i, i]
    for i in range(4):
        for j in range(4):
            Q[i, j] = -(x[i] * x[j] + P[i, j]) * angle
        Q[i, i] += trace * angle
    a = s.bias_decay
    time = -math.expm1(-2 * a * dt) / (2 * a) if a > 0 else dt
    Q[4, 4] = Q[5, 5] = Q[6, 6] = time * s.bias_walk_sd**2


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
def sine(u: float) -> float:
    """Return sin(a)/a of u = a²: by its series for a < 1/2, which leaves out a^14/15!, less than 5e-17."""
    if u < 1 / 4:
        return 1 - u / 6 * (1 - u / 20 * (1 - u / 42 * (1 - u / 72 * (1 - u / 110 * (1 - u / 156)))))
    return math.sin(math.sqrt(u)) / math.sqrt(u)


@inlined
def versine(u: float) -> float:
    """Return (1 - cos(a))/a² of u = a², without loss of digits; as `sine`."""
    if u < 1 / 4:
        return (1 - u / 12 * (1 - u / 30 * (1 - u / 56 * (1 - u / 90 * (1 - u / 132 * (1 - u / 182)))))) / 2
    return 2 * (math.sin(math.sqrt(u) / 2) / math.sqrt(u)) ** 2


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


@inlined
def times4(P: Vector, v: Vector) -> Vector:
    """Return P v for a symmetric P, 4 x 4."""
    return (
        P[0] * v[0] + P[1] * v[1] + P[2] * v[2] + P[3] * v[3],
        P[1] * v[0] + P[4] * v[1] + P[5] * v[2] + P[6] * v[3],
        P[2] * v[0] + P[5] * v[1] + P[7] * v[2] + P[8] * v[3],
        P[3] * v[0] + P[6] * v[1] + P[8] * v[2] + P[9] * v[3],
    )


@inlined
def plus_outer4(P: Vector, a: float, v: Vector) -> Vector:
    """Return P + a v v' for a symmetric P, 4 x 4."""
    a0, a1, a2, a3 = a * v[0], a * v[1], a * v[2], a * v[3]
    return (
        P[0] + a0 * v[0],
        P[1] + a0 * v[1],
        P[2] + a0 * v[2],
        P[3] + a0 * v[3],
        P[4] + a1 * v[1],
        P[5] + a1 * v[2],
        P[6] + a1 * v[3],
        P[7] + a2 * v[2],
        P[8] + a2 * v[3],
        P[9] + a3 * v[3],
    )


@inlined
def dot4(v: Vector, w: Vector) -> float:
    """Return v . w."""
    return (v[0] * w[0] + v[1] * w[1]) + (v[2] * w[2] + v[3] * w[3])


@inlined
def plus4(v: Vector, a: float, w: Vector) -> Vector:
    """Return v + a w."""
    return v[0] + a * w[0], v[1] + a * w[1], v[2] + a * w[2], v[3] + a * w[3]


@inlined
def scaled4(a: float, v: Vector) -> Vector:
    """Return a v."""
    return a * v[0], a * v[1], a * v[2], a * v[3]


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


@njit(cache=True)
def level_vertical(Z: Array, P: Array, accel: Array) -> bool:
    """Level Z by this specific force, with the covariance of levelling; return False in free fall."""
    if not has_vertical(accel):
        return False
    Z[:] = accel
    normalise(Z)
    fill_tilt_noise(P, Z, 1.0, LEVELLING_SD)
    return True


@njit(cache=True)
def fill_tilt_transition(F: Array, held: Array, dt: float, exponential: bool) -> None:
    """Write F = exp(-dt [omega x]), or its first two terms as Lee16 Eq. 3 prints; shape (3, 3)."""
    p, q, r = held[0], held[1], held[2]
    speed = math.sqrt(p * p + q * q + r * r)
    s, c = dt, 0.0
    if exponential and speed > 0:
        s = math.sin(speed * dt) / speed
        c = 2.0 * (math.sin(speed * dt / 2) / speed) ** 2
    F[0, 0], F[0, 1], F[0, 2] = 1 - c * (q * q + r * r), s * r + c * p * q, -s * q + c * p * r
    F[1, 0], F[1, 1], F[1, 2] = -s * r + c * p * q, 1 - c * (p * p + r * r), s * p + c * q * r
    F[2, 0], F[2, 1], F[2, 2] = s * q + c * p * r, -s * p + c * q * r, 1 - c * (p * p + q * q)


@njit(cache=True)
def fill_tilt_noise(Q: Array, Z: Array, dt: float, gyro_noise_sd: float) -> None:
    """Write Q = -dt² sd² [Z x][Z x] = dt² sd² (|Z|² I - Z Z') [Lee16, Eq. 6a]."""
    variance = (dt * gyro_noise_sd) ** 2
    square = Z[0] * Z[0] + Z[1] * Z[1] + Z[2] * Z[2]
    for i in range(3):
        for j in range(3):
            Q[i, j] = -variance * Z[i] * Z[j]
        Q[i, i] += variance * square


@njit(cache=True)
def tilt_measurement_variance(external: Vector, s: TiltSettings) -> float:
    """Return (c_a²/3)|a|² + sd_A², the diagonal of R [Lee16, Eq. 6b, corrected]."""
    square = external[0] ** 2 + external[1] ** 2 + external[2] ** 2
    return float(s.acceleration_memory**2 / 3 * square + s.accel_noise_sd**2)


class TiltBelief(NamedTuple):
    """State Z, its covariance and the external acceleration of `TiltKalman`."""

    Z: Vector
    P: Vector
    """3 x 3, six numbers."""
    external: Vector


@fused
def run_tilt_kalman(
    t: Array,
    before: float,
    accel: Array,
    gyro: Array,
    gyro_bias: Array,
    gravity: float,
    s: TiltSettings,
    x: Array,
    P: Array,
    held: Array,
    external: Array,
    ups: Array,
    vertical: Array,
    vertical_sd: Array,
) -> None:
    """Run Lee16's filter over all samples, the first of which comes at t[0] - `before`.

    x, P, held, external go on, the last three are filled.
    """
    belief = load_tilt(x, P, external)
    now: Vector = held[0], held[1], held[2], held[3]
    for k in range(len(t)):
        dt = t[k] - before
        before = t[k]
        f = accel[k]
        now = forget_rate(now, dt)
        belief = predict_tilt(belief, now, dt, s)
        new = is_sample(f)
        if new and is_lost(now):
            store_tilt(belief, x, P, external)
            if level_vertical(x, P, f):
                now = levelled(now)
            belief = load_tilt(x, P, external)
        elif new:
            belief = correct_tilt(belief, f, gravity, s)
        Z = scaled3(1 / math.sqrt(dot3(belief.Z, belief.Z)), belief.Z)
        a, vertical[k], vertical_sd[k] = belief.external, math.nan, math.nan
        if new:
            along = f[0] * Z[0] + f[1] * Z[1] + f[2] * Z[2]
            across = f[0] - along * Z[0], f[1] - along * Z[1], f[2] - along * Z[2]
            a = f[0] - gravity * Z[0], f[1] - gravity * Z[1], f[2] - gravity * Z[2]
            vertical[k] = along - gravity
            variance = dot3(across, times3(belief.P, across)) + s.accel_noise_sd**2
            vertical_sd[k] = math.sqrt(max(variance, 0.0))
        belief = TiltBelief(Z, belief.P, a)
        ups[k, 0], ups[k, 1], ups[k, 2] = Z
        now = take_rate(now, gyro[k], gyro_bias)
    store_tilt(belief, x, P, external)
    held[0], held[1], held[2], held[3] = now


@inlined
def predict_tilt(belief: TiltBelief, held: Vector, dt: float, s: TiltSettings) -> TiltBelief:
    """Let Z = F Z and P = F P F' + Q, Q = dt² sd² (|Z|² I - Z Z') [Lee16, Eqs. 3, 6a]."""
    p, q, r = held[0], held[1], held[2]
    u = (p * p + q * q + r * r) * (dt * dt)
    m, n = (sine(u) * dt, versine(u) * (dt * dt)) if s.exponential else (dt, 0.0)
    a = 1 - n * (q * q + r * r), m * r + n * p * q, -m * q + n * p * r
    b = -m * r + n * p * q, 1 - n * (p * p + r * r), m * p + n * q * r
    c = m * q + n * p * r, -m * p + n * q * r, 1 - n * (p * p + q * q)
    P, Z = belief.P, belief.Z
    A, B, C = times3(P, a), times3(P, b), times3(P, c)
    variance = (dt * s.gyro_noise_sd) ** 2
    square = variance * dot3(Z, Z)
    F_P_F = (
        dot3(a, A) + square,
        dot3(a, B),
        dot3(a, C),
        dot3(b, B) + square,
        dot3(b, C),
        dot3(c, C) + square,
    )
    return TiltBelief((dot3(a, Z), dot3(b, Z), dot3(c, Z)), plus_outer3(F_P_F, -variance, Z), belief.external)


@inlined
def correct_tilt(belief: TiltBelief, f: Array, gravity: float, s: TiltSettings) -> TiltBelief:
    """Take z = f - c_a a, one component after the other, with H = g I [Lee16, Eqs. 4-6b]."""
    a, r = belief.external, tilt_measurement_variance(belief.external, s)
    c_a = s.acceleration_memory
    belief = take_tilt(belief, 0, f[0] - c_a * a[0], gravity, r)
    belief = take_tilt(belief, 1, f[1] - c_a * a[1], gravity, r)
    return take_tilt(belief, 2, f[2] - c_a * a[2], gravity, r)


@inlined
def take_tilt(belief: TiltBelief, c: int, z: float, gravity: float, r: float) -> TiltBelief:
    """Take component c of z, of variance `r`.

    With m = P H = g P e_c and s = g m_c + r: Z = Z + m y/s, P = P - m m'/s.
    """
    P = belief.P
    column = (P[0], P[1], P[2]) if c == 0 else ((P[1], P[3], P[4]) if c == 1 else (P[2], P[4], P[5]))
    m = scaled3(gravity, column)
    share = 1 / (gravity * m[c] + r)
    Z = plus3(belief.Z, share * (z - gravity * belief.Z[c]), m)
    return TiltBelief(Z, plus_outer3(P, -share, m), belief.external)


@inlined
def times3(P: Vector, v: Vector) -> Vector:
    """Return P v for a symmetric P, 3 x 3."""
    return (
        P[0] * v[0] + P[1] * v[1] + P[2] * v[2],
        P[1] * v[0] + P[3] * v[1] + P[4] * v[2],
        P[2] * v[0] + P[4] * v[1] + P[5] * v[2],
    )


@inlined
def plus_outer3(P: Vector, a: float, v: Vector) -> Vector:
    """Return P + a v v' for a symmetric P, 3 x 3."""
    a0, a1, a2 = a * v[0], a * v[1], a * v[2]
    return (
        P[0] + a0 * v[0],
        P[1] + a0 * v[1],
        P[2] + a0 * v[2],
        P[3] + a1 * v[1],
        P[4] + a1 * v[2],
        P[5] + a2 * v[2],
    )


@inlined
def dot3(v: Vector, w: Vector) -> float:
    """Return v . w."""
    return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]


@inlined
def plus3(v: Vector, a: float, w: Vector) -> Vector:
    """Return v + a w."""
    return v[0] + a * w[0], v[1] + a * w[1], v[2] + a * w[2]


@inlined
def scaled3(a: float, v: Vector) -> Vector:
    """Return a v."""
    return a * v[0], a * v[1], a * v[2]


@fused
def load_tilt(x: Array, P: Array, external: Array) -> TiltBelief:
    """Take the numbers out of the arrays."""
    upper = P[0, 0], P[0, 1], P[0, 2], P[1, 1], P[1, 2], P[2, 2]
    return TiltBelief((x[0], x[1], x[2]), upper, (external[0], external[1], external[2]))


@fused
def store_tilt(belief: TiltBelief, x: Array, P: Array, external: Array) -> None:
    """Put the numbers back."""
    k = 0
    for i in range(3):
        x[i], external[i] = belief.Z[i], belief.external[i]
        for j in range(i, 3):
            P[i, j] = P[j, i] = belief.P[k]
            k += 1
