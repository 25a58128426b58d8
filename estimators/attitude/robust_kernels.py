"""Compiled matrices and loop of the attitude filter `robust`; its equations stand there.

The strapdown runs at every row, the covariance only at a levelling, after `interval` s.  Until then F and Q
grow row by row, so that a levelling after n rows is the product of n short ones.  Nothing is allocated within
the loop.  Everything compiled is in this one file, because numba's cache watches no other; for the same
reason even constants from elsewhere come in as settings.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

STATES: Final = 10
"""Errors of tilt (2, world axes), horizontal velocity (2), gyro bias (3) and gyro scale (3, body axes)."""
ROUNDING: Final = 1e-6
"""Intervals that add up to a levelling's but for so much do so, s: a clock's rounding decides nothing."""


class RobustSettings(NamedTuple):
    """Settings of `RobustAttitude`, in its units, and what else the loop needs to know."""

    gyro_noise_sd: float
    accel_noise_sd: float
    bias_walk: float
    scale_walk: float
    rate_error: float
    force_error: float
    velocity_sd: float
    velocity_time: float
    limit: float
    interval: float
    longest_hold: float
    unseen_walk: float
    unseen_turn: float
    unseen_push: float
    levelling_sd: float
    lost_velocity_sd: float


@njit(cache=True)
def is_sample(v: Array) -> bool:
    """Return whether all three components are there."""
    return math.isfinite(v[0]) and math.isfinite(v[1]) and math.isfinite(v[2])


@njit(cache=True)
def turn(q: Array, x: float, y: float, z: float) -> None:
    """Let q = q exp(angle / 2) for a turn by (x, y, z) rad in body axes, and give it unit length."""
    square = x * x + y * y + z * z
    half = 0.5 * math.sqrt(square)
    c = math.cos(half)
    s = 0.5 * math.sin(half) / half if half > 0 else 0.5
    x, y, z = s * x, s * y, s * z
    i, j, k, w = q[0], q[1], q[2], q[3]
    a = c * i + w * x + j * z - k * y
    b = c * j + w * y + k * x - i * z
    d = c * k + w * z + i * y - j * x
    e = c * w - i * x - j * y - k * z
    scale = 1.0 / math.sqrt(a * a + b * b + d * d + e * e)
    q[0], q[1], q[2], q[3] = a * scale, b * scale, d * scale, e * scale


@njit(cache=True)
def fill_rotation(C: Array, q: Array) -> None:
    """Write the matrix body -> world; its last row is the vertical in body axes."""
    x, y, z, w = q[0], q[1], q[2], q[3]
    C[0, 0], C[0, 1], C[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
    C[1, 0], C[1, 1], C[1, 2] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    C[2, 0], C[2, 1], C[2, 2] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)


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
def advance(
    dt: float, gyro: Array, s: RobustSettings, q: Array, estimate: Array, held: Array, age: Array,
    C: Array, F: Array, Q: Array,
) -> None:
    """Turn by the trapezoid of the corrected rates since the last gyro sample; grow rows 0, 1 of F and Q."""
    new = is_sample(gyro)
    square = 0.0
    angle0, angle1, angle2 = 0.0, 0.0, 0.0
    for i in range(3):
        gain = 1.0 - estimate[5 + i]
        angle = gain * (held[i] - estimate[2 + i]) * dt
        if new:
            angle += 0.5 * gain * (gyro[i] - held[i]) * age[0]
            held[i] = gyro[i]
        square += angle * angle
        if i == 0:
            angle0 = angle
        elif i == 1:
            angle1 = angle
        else:
            angle2 = angle
    turn(q, angle0, angle1, angle2)
    fill_rotation(C, q)
    for i in range(2):
        F[i, 4] -= C[i, 0] * dt
        F[i, 5] -= C[i, 1] * dt
        F[i, 6] -= C[i, 2] * dt
        F[i, 7] -= C[i, 0] * angle0
        F[i, 8] -= C[i, 1] * angle1
        F[i, 9] -= C[i, 2] * angle2
    if dt > 0:
        Q[0] += s.rate_error**2 * square / dt
    if new:
        Q[0] += (s.gyro_noise_sd * age[0]) ** 2 + (s.unseen_turn * age[0] ** 3 / 12) ** 2
        age[0] = 0.0


@njit(cache=True)
def push(
    dt: float, accel: Array, gravity: float, s: RobustSettings, estimate: Array, held: Array, age: Array,
    C: Array, F: Array, Q: Array,
) -> None:
    """Integrate the trapezoid of the world's specific forces since the last sample; rows 2, 3 of F and Q."""
    new = is_sample(accel)
    if age[1] > s.longest_hold:
        Q[2] += s.unseen_walk**2 * dt
    fx, fy, fz = held[3], held[4], held[5]
    gx, gy, gz = fx * dt, fy * dt, fz * dt
    if new:
        held[3] = C[0, 0] * accel[0] + C[0, 1] * accel[1] + C[0, 2] * accel[2]
        held[4] = C[1, 0] * accel[0] + C[1, 1] * accel[1] + C[1, 2] * accel[2]
        held[5] = C[2, 0] * accel[0] + C[2, 1] * accel[1] + C[2, 2] * accel[2]
        half = 0.5 * age[1]
        gx += half * (held[3] - fx)
        gy += half * (held[4] - fy)
        gz += half * (held[5] - fz)
    if age[1] <= s.longest_hold:
        estimate[0] += gx
        estimate[1] += gy
        for j in range(STATES):
            F[2, j] += gz * F[1, j]
            F[3, j] -= gz * F[0, j]
        if dt > 0:
            rest = gz - gravity * dt
            Q[2] += s.force_error**2 * (gx * gx + gy * gy + rest * rest) / dt
        if new:
            Q[2] += (s.accel_noise_sd * age[1]) ** 2 + (s.unseen_push * age[1] ** 3 / 12) ** 2
    if new:
        age[1] = 0.0


@njit(cache=True)
def clear(F: Array, Q: Array) -> None:
    """Let no time have passed."""
    for i in range(4):
        for j in range(STATES):
            F[i, j] = 0.0
        F[i, i] = 1.0
    Q[0] = Q[2] = 0.0


@njit(cache=True)
def predict(x: Array, P: Array, F: Array, Q: Array, T: float, s: RobustSettings, work: Array) -> None:
    """Let x = F x and P = F P F' + Q; only the first four rows of F differ from the identity's."""
    for i in range(4):
        for j in range(STATES):
            total = 0.0
            for k in range(STATES):
                total += F[i, k] * P[k, j]
            work[i, j] = total
        total = 0.0
        for k in range(STATES):
            total += F[i, k] * x[k]
        work[4, i] = total
    for i in range(4):
        x[i] = work[4, i]
        for j in range(i + 1):
            total = 0.0
            for k in range(STATES):
                total += work[i, k] * F[j, k]
            P[i, j] = P[j, i] = total
        for j in range(4, STATES):
            P[i, j] = P[j, i] = work[i, j]
    P[0, 0] += Q[0]
    P[1, 1] += Q[0]
    P[2, 2] += Q[2]
    P[3, 3] += Q[2]
    for i in range(4, 7):
        P[i, i] += s.bias_walk**2 * T
        P[i + 3, i + 3] += s.scale_walk**2 * T


@njit(cache=True)
def update(x: Array, P: Array, h: Array, z: float, r: float, work: Array) -> None:
    """Take z = h x with variance r."""
    row = work[0]
    v, y = r, z
    for i in range(STATES):
        total = 0.0
        for j in range(STATES):
            total += P[i, j] * h[j]
        row[i] = total
        v += total * h[i]
        y -= h[i] * x[i]
    gain = y / v
    for i in range(STATES):
        x[i] += gain * row[i]
        share = row[i] / v
        for j in range(STATES):
            P[i, j] -= share * row[j]


@njit(cache=True)
def level(
    T: float, s: RobustSettings, q: Array, estimate: Array, x: Array, P: Array, F: Array, Q: Array, H: Array,
    R: Array, C: Array, work: Array,
) -> None:
    vx, vy = -Q[3] / T, -Q[4] / T
    for j in range(STATES):
        H[0, j] /= T
        H[1, j] /= T
    speed = math.hypot(vx, vy)
    usual = s.limit * math.sqrt(s.velocity_sd**2 + 0.5 * (P[2, 2] + P[3, 3]))
    r = 2 * s.velocity_sd**2 * s.velocity_time / T
    if speed > usual:
        r *= speed / usual
    R[0] = r
    x[:] = 0.0
    update(x, P, H[0], vx, r, work)
    update(x, P, H[1], vy, r, work)
    predict(x, P, F, Q, T, s, work)
    for i in range(8):
        estimate[i] += x[2 + i]
    # world tilt -> body
    turn(q, C[0, 0] * x[0] + C[1, 0] * x[1], C[0, 1] * x[0] + C[1, 1] * x[1], C[0, 2] * x[0] + C[1, 2] * x[1])
    fill_rotation(C, q)
    H[:] = 0.0
    Q[3] = Q[4] = 0.0
    clear(F, Q)


@njit(cache=True)
def relevel(
    accel: Array, s: RobustSettings, q: Array, estimate: Array, held: Array, age: Array,
    P: Array, F: Array, Q: Array, H: Array, C: Array,
) -> None:
    fill_level(q, accel)
    fill_rotation(C, q)
    for i in range(4):
        for j in range(STATES):
            P[i, j] = P[j, i] = 0.0
        P[i, i] = (s.levelling_sd if i < 2 else s.lost_velocity_sd) ** 2
    estimate[:2] = 0.0
    for i in range(3):
        held[i] = estimate[2 + i]
        held[3 + i] = C[i, 0] * accel[0] + C[i, 1] * accel[1] + C[i, 2] * accel[2]
    age[:] = 0.0
    H[:] = 0.0
    Q[3] = Q[4] = 0.0
    clear(F, Q)


@njit(cache=True)
def run_robust(
    dt: Array, accel: Array, gyro: Array, gravity: float, s: RobustSettings,
    q: Array, estimate: Array, x: Array, P: Array, F: Array, Q: Array, H: Array, R: Array, held: Array, age: Array,
    ups: Array, vertical: Array, vertical_sd: Array,
) -> None:
    C, work = np.zeros((3, 3)), np.zeros((5, STATES))
    fill_rotation(C, q)
    for k in range(len(dt)):
        f = accel[k]
        for i in range(3):
            age[i] += dt[k]
        new = is_sample(f)
        if age[0] > s.longest_hold:
            if new and f[0] * f[0] + f[1] * f[1] + f[2] * f[2] > 0.25 * gravity * gravity:
                relevel(f, s, q, estimate, held, age, P, F, Q, H, C)
                if is_sample(gyro[k]):
                    for i in range(3):
                        held[i] = gyro[k, i]
        else:
            advance(dt[k], gyro[k], s, q, estimate, held, age, C, F, Q)
            push(dt[k], f, gravity, s, estimate, held, age, C, F, Q)
            for j in range(STATES):
                H[0, j] += F[2, j] * dt[k]
                H[1, j] += F[3, j] * dt[k]
            Q[3] += estimate[0] * dt[k]
            Q[4] += estimate[1] * dt[k]
            if age[2] > s.interval - ROUNDING:
                level(age[2], s, q, estimate, x, P, F, Q, H, R, C, work)
                age[2] = 0.0
        for i in range(3):
            ups[k, i] = C[2, i]
        vertical[k] = vertical_sd[k] = math.nan
        if new:
            fx = C[0, 0] * f[0] + C[0, 1] * f[1] + C[0, 2] * f[2]
            fy = C[1, 0] * f[0] + C[1, 1] * f[1] + C[1, 2] * f[2]
            vertical[k] = C[2, 0] * f[0] + C[2, 1] * f[1] + C[2, 2] * f[2] - gravity
            var = fy * fy * P[0, 0] + fx * fx * P[1, 1] - 2 * fx * fy * P[0, 1] + (fx * fx + fy * fy) * Q[0]
            vertical_sd[k] = math.sqrt(max(var, 0.0) + s.accel_noise_sd**2)
