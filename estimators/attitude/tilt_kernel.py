"""The matrices of `TiltKalman`, for filterpy's predict and update, and the loop that gives the same.

The loop is written as `quaternion_kernel` is.  Letters are the paper's; the equations stand in `tilt_kalman`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import fused, inlined, njit
from baroarma.estimators.attitude.registers import dot3, plus3, plus_outer3, scaled3, sine, times3, versine
from baroarma.estimators.attitude.samples import (
    LEVELLING_SD,
    forget_rate,
    has_vertical,
    is_lost,
    is_sample,
    levelled,
    take_rate,
)
from baroarma.estimators.attitude.vertical import normalise

Array = NDArray[np.float64]
Vector = tuple[float, ...] | Array


class TiltSettings(NamedTuple):
    """Settings of `TiltKalman`, in its units."""

    gyro_noise_sd: float
    accel_noise_sd: float
    acceleration_memory: float
    exponential: bool


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
