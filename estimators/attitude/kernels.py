"""Compiled matrices and loops of the attitude filters.

The functions `fill_*` write the matrices of the two filters, each once, into arrays that exist already; the
filterpy classes call them for one step, the loops `run_*` for a whole recording.  The loops follow
`filterpy.kalman`'s predict and update to rounding: with a diagonal R the measurement vector may be taken one
component after the other, so that no matrix is inverted and a rejected component is merely passed over.

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

LONGEST_HOLD: Final = 0.5
"""A missing gyro sample is replaced by the last one for so many seconds (chosen by us: about the time in
which a limb's turn comes to its end).  After a longer gap the next specific force gives the tilt anew."""
LEVELLING_SD: Final = 0.1
"""Error of that tilt in `TiltKalman`, rad (chosen by us): the body may be accelerated by 1 m/s² sideways."""


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
    """Return whether all three components are there."""
    return math.isfinite(v[0]) and math.isfinite(v[1]) and math.isfinite(v[2])


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


@njit(cache=True)
def forget_rate(held: Array, dt: float) -> bool:
    """Grow older by `dt`; return whether the last gyro sample is too old to be held, and then forget it.

    `held`, shape (4,), is the rate in use and the time since its sample.
    """
    held[3] += dt
    if held[3] <= LONGEST_HOLD:
        return False
    held[:3] = 0.0
    return True


@njit(cache=True)
def take_rate(held: Array, gyro: Array, bias: Array) -> None:
    """Take gyro - bias for the next interval; without a sample, hold.  A lost tilt stays lost."""
    if is_sample(gyro):
        for i in range(3):
            held[i] = gyro[i] - bias[i]
        if held[3] <= LONGEST_HOLD:
            held[3] = 0.0


@njit(cache=True)
def predict(x: Array, P: Array, F: Array, Q: Array, work: Array) -> None:
    """Let x = F x and P = F P F' + Q, in place; zeros of F are skipped."""
    n = len(x)
    for i in range(n):
        work[i, :] = 0.0
        for k in range(n):
            if F[i, k] != 0.0:
                for j in range(n):
                    work[i, j] += F[i, k] * P[k, j]
    P[:, :] = Q
    for j in range(n):
        for k in range(n):
            if F[j, k] != 0.0:
                for i in range(n):
                    P[i, j] += work[i, k] * F[j, k]
    work[0, :] = x
    for i in range(n):
        x[i] = 0.0
        for k in range(n):
            x[i] += F[i, k] * work[0, k]


@njit(cache=True)
def update(x: Array, P: Array, h: Array, y: float, r: float, work: Array) -> None:
    """Take one scalar measurement with innovation `y`, row `h` of H, variance `r`; Joseph form, in place."""
    n = len(x)
    gain, row = work[0], work[1]
    s = r
    for i in range(n):
        row[i] = 0.0
        for j in range(n):
            row[i] += P[i, j] * h[j]
        s += h[i] * row[i]
    for i in range(n):
        gain[i] = row[i] / s
        x[i] += gain[i] * y
    for i in range(n):  # (I - k h') P
        for j in range(n):
            P[i, j] -= gain[i] * row[j]
    for i in range(n):  # ... (I - k h')' + k r k'
        row[i] = -r * gain[i]
        for j in range(n):
            row[i] += P[i, j] * h[j]
    for i in range(n):
        for j in range(n):
            P[i, j] -= row[i] * gain[j]


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
def fill_up(up: Array, q: Array) -> None:
    """Write the vertical in body axes: the last row of C^nb [SG14, Eq. 23, sign corrected]."""
    up[0] = 2.0 * (q[0] * q[2] - q[1] * q[3])
    up[1] = 2.0 * (q[1] * q[2] + q[0] * q[3])
    up[2] = 1.0 - 2.0 * (q[0] * q[0] + q[1] * q[1])


@njit(cache=True)
def fill_up_jacobian(J: Array, q: Array) -> None:
    """Write d up/d q, shape (3, 4): `fill_up` differentiated, SG14 Eq. 18 for g = (0, 0, -1)."""
    J[0, 0], J[0, 1], J[0, 2], J[0, 3] = 2 * q[2], -2 * q[3], 2 * q[0], -2 * q[1]
    J[1, 0], J[1, 1], J[1, 2], J[1, 3] = 2 * q[3], 2 * q[2], 2 * q[1], 2 * q[0]
    J[2, 0], J[2, 1], J[2, 2], J[2, 3] = -4 * q[0], -4 * q[1], 0.0, 0.0


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
def level_quaternion(x: Array, P: Array, held: Array, accel: Array, sd: float) -> None:
    """Level q by this specific force, with P0's `sd`; free fall has no vertical.

    A wide covariance would be wrong here: a single component inside the gate could then turn the tilt away.
    """
    if accel.any():
        fill_level(x[:4], accel)
        fill_turn_covariance(P, x[:4], sd)
        held[3] = 0.0


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


@njit(cache=True)
def run_quaternion_ekf(
    dt: Array,
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
    """Run SG14's filter over all samples; x, P, held go on, the last three are filled."""
    F, Q, work = np.zeros((7, 7)), np.zeros((7, 7)), np.zeros((7, 7))
    J, h, predicted = np.zeros((3, 4)), np.zeros(7), np.zeros(7)
    for k in range(len(dt)):
        up, f = ups[k], accel[k]
        lost = forget_rate(held, dt[k])
        fill_quaternion_transition(F, held, dt[k], s.bias_decay)
        fill_quaternion_noise(Q, x, P, dt[k], s)
        predict(x, P, F, Q, work)
        vertical[k] = vertical_sd[k] = math.nan
        new = is_sample(f)
        if new and lost:
            level_quaternion(x, P, held, f, s.initial_quaternion_sd)
        elif new:
            fill_up(up, x)
            fill_up_jacobian(J, x)
            predicted[:] = x
            for c in range(3):
                y = f[c] - gravity * up[c] - predicted[4 + c]
                if abs(y) > s.gate:
                    continue
                h[:] = 0.0
                h[4 + c] = 1.0
                y += predicted[4 + c] - x[4 + c]
                for i in range(4):
                    h[i] = gravity * J[c, i]
                    y += h[i] * (predicted[i] - x[i])
                update(x, P, h, y, s.accel_noise_sd**2, work)
            normalise(x[:4])
        fill_up(up, x)
        if new:
            fill_up_jacobian(J, x)
            vertical[k], vertical_sd[k] = vertical_acceleration(f, up, J, P, gravity, s.accel_noise_sd)
        take_rate(held, gyro[k], gyro_bias)


@njit(cache=True)
def level_vertical(Z: Array, P: Array, held: Array, accel: Array) -> None:
    """Level Z by this specific force, with the covariance of levelling; free fall has no vertical."""
    if accel.any():
        Z[:] = accel
        normalise(Z)
        fill_tilt_noise(P, Z, 1.0, LEVELLING_SD)
        held[3] = 0.0


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
def tilt_measurement_variance(external: Array, s: TiltSettings) -> float:
    """Return (c_a²/3)|a|² + sd_A², the diagonal of R [Lee16, Eq. 6b, corrected]."""
    square = external[0] ** 2 + external[1] ** 2 + external[2] ** 2
    return float(s.acceleration_memory**2 / 3 * square + s.accel_noise_sd**2)


@njit(cache=True)
def run_tilt_kalman(
    dt: Array,
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
    """Run Lee16's filter over all samples; x, P, held, external go on, the last three are filled."""
    F, Q, work, J = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.eye(3)
    h, z = np.zeros(3), np.zeros(3)
    for k in range(len(dt)):
        f = accel[k]
        lost = forget_rate(held, dt[k])
        fill_tilt_transition(F, held, dt[k], s.exponential)
        fill_tilt_noise(Q, x, dt[k], s.gyro_noise_sd)
        predict(x, P, F, Q, work)
        vertical[k] = vertical_sd[k] = math.nan
        new = is_sample(f)
        if new and lost:
            level_vertical(x, P, held, f)
        elif new:
            r = tilt_measurement_variance(external, s)
            for c in range(3):
                z[c] = f[c] - s.acceleration_memory * external[c]
            for c in range(3):
                h[:] = 0.0
                h[c] = gravity
                update(x, P, h, z[c] - gravity * x[c], r, work)
        normalise(x)
        if new:
            for c in range(3):
                external[c] = f[c] - gravity * x[c]
            vertical[k], vertical_sd[k] = vertical_acceleration(f, x, J, P, gravity, s.accel_noise_sd)
        ups[k] = x
        take_rate(held, gyro[k], gyro_bias)
