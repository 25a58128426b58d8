"""Compiled parts of the attitude filter `robust`; its equations stand there.

The strapdown runs at every row and sums up what a levelling needs to know of the interval since the last one;
the matrices are written and the covariance moves only then.  Nothing is allocated within the loop.  What runs
at every row takes the arrays one by one and is inlined: a tuple of arrays passed on would cost more than the
arithmetic.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import njit
from baroarma.estimators.attitude.samples import LEVELLING_SD, MOST_FORCE, MOST_RATE, is_rate, is_sample
from baroarma.estimators.attitude.vertical import fill_level
from baroarma.estimators.base import ROUNDING

Array = NDArray[np.float64]

STATES: Final = 10
"""Errors of tilt (2, world axes, rad), horizontal velocity (2), gyro bias (3) and gyro scale (3)."""


class RobustSettings(NamedTuple):
    """Settings of `RobustAttitude`, in its units, and the constants of other modules."""

    gyro_noise_sd: float
    accel_noise_sd: float
    accel_bias_sd: float
    bias_walk: float
    rate_error: float
    force_error: float
    velocity_sd: float
    velocity_time: float
    top_speed: float
    interval: float
    latency: float
    gravity: float
    longest_hold: float
    unseen_walk: float
    longest_repeat: float


class RobustState(NamedTuple):
    """What the filter remembers between rows; x and the matrices are those of the last levelling."""

    q: Array
    """Attitude, body to world, scalar last, (4,)."""
    estimate: Array
    """Horizontal velocity (2), gyro bias (3), gyro scale (3)."""
    held: Array
    """Last angular rate (3, body axes) and last specific force (3, world axes)."""
    age: Array
    """Seconds since the last gyro sample, accelerometer sample, levelling; 1 where the tilt is doubtful."""
    flow: Array
    """What bias and scale (6 columns) have done to tilt (2 rows), velocity (2) and its integral (2)."""
    sums: Array
    """Integrals since the last levelling, in the order of the constants `FORCE` to `START`."""
    x: Array
    P: Array
    F: Array
    Q: Array
    H: Array
    R: Array
    doubt: Array
    """Of forces and rates, (3, 4): how many may be passed over, and the last that was.  The third row: for
    how long all six numbers have been the same, s, and the force among them."""


FORCE, DOUBLE_FORCE, TILT_VARIANCE, VELOCITY_VARIANCE, WAY, START = 0, 1, 2, 3, 4, 6
"""Places in `RobustState.sums`: the vertical force's first and second integral, process noise of each tilt
and each velocity, the velocity's integral (2), the velocity at the start (2)."""
SUMS: Final = 8
TURN_BEND: Final = 3.0
"""How far a trapezoid misses a turn, over the cube of its interval, rad/s³ (chosen by us: a twelfth of the
second derivative of the rate, for 1 rad/s to and fro at 1 Hz)."""
PUSH_BEND: Final = 6.0
"""How far a trapezoid misses a change of velocity, likewise, m/s⁴ (chosen by us: 2 m/s² to and fro)."""
PERSISTENCE: Final = 1.0
"""How long the errors keep their sign that are a share of rate or acceleration, s (chosen by us)."""
FORCE_JUMP: Final = 30.0
"""A force that differs by more, m/s², from the last one has to be seen twice (chosen by us: 3 g);"""
RATE_JUMP: Final = 3.0
"""likewise of a rate, rad/s (chosen by us: at 50 Hz a single wrong one tilts by 3 degrees)."""
PATIENCE: Final = 4.0
"""So many samples may be passed over at a stretch,"""
REGAINED: Final = 0.1
"""and so much of one more with every sample that does not jump: what shakes is believed (chosen by us)."""
MOVING_FORCE: Final = 0.3
"""A force whose length differs from gravity by more, m/s², is not that of a rest (chosen by us);"""
MOVING_RATE: Final = 0.1
"""likewise of a rate, rad/s."""
UNUSUAL: Final = 3.0
"""From so many sds on a velocity counts as a ride (chosen by us)."""
LEVELLED_SD: Final = 0.05
"""The same of the tilt by a mean force, rad (chosen by us): who walks is hardly accelerated on average."""
BLIND_TURN: Final = 0.3
"""After so many seconds without gyro the tilt is as doubtful as one taken anew (chosen by us)."""
RIDE_SD: Final = 10.0
"""Velocity of which nothing is known, m/s (chosen by us)."""


@njit(cache=True, error_model="numpy")
def turn(q: Array, x: float, y: float, z: float) -> None:
    """Let q = q exp((x, y, z) / 2), a turn by so many rad about body axes."""
    half = 0.5 * math.sqrt(x * x + y * y + z * z)
    s = 0.5 * math.sin(half) / half if half > 0 else 0.5
    x, y, z, w = s * x, s * y, s * z, math.cos(half)
    a = w * q[0] + x * q[3] + z * q[1] - y * q[2]
    b = w * q[1] + y * q[3] + x * q[2] - z * q[0]
    c = w * q[2] + z * q[3] + y * q[0] - x * q[1]
    d = w * q[3] - x * q[0] - y * q[1] - z * q[2]
    q[0], q[1], q[2], q[3] = a, b, c, d


@njit(cache=True, error_model="numpy")
def fill_rotation(C: Array, q: Array) -> None:
    """Write the matrix body to world; its last row is the vertical in body axes."""
    x, y, z, w = q[0], q[1], q[2], q[3]
    C[0, 0], C[0, 1], C[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
    C[1, 0], C[1, 1], C[1, 2] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    C[2, 0], C[2, 1], C[2, 2] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)


@njit(cache=True, error_model="numpy", inline="always")
def rotate(
    dt: float,
    gyro: Array,
    s: RobustSettings,
    q: Array,
    estimate: Array,
    held: Array,
    age: Array,
    flow: Array,
    sums: Array,
    C: Array,
) -> None:
    """Turn by the trapezoid of two corrected rates; sum up what bias, scale and noise do to the tilt.

    Between samples the last rate is held; the next sample makes up for it, so that the sum is the trapezoid
    over all the time from sample to sample.
    """
    late, gx, gy, gz = 0.0, held[0], held[1], held[2]
    if is_rate(gyro):
        late, gx, gy, gz = 0.5 * age[0], gyro[0], gyro[1], gyro[2]
        if age[0] > BLIND_TURN:
            age[3] = 1.0
        sums[TILT_VARIANCE] += (s.gyro_noise_sd * age[0]) ** 2 + (TURN_BEND * age[0] ** 3) ** 2
        age[0] = 0.0
    x = (1 - estimate[5]) * ((held[0] - estimate[2]) * dt + (gx - held[0]) * late)
    y = (1 - estimate[6]) * ((held[1] - estimate[3]) * dt + (gy - held[1]) * late)
    z = (1 - estimate[7]) * ((held[2] - estimate[4]) * dt + (gz - held[2]) * late)
    held[0], held[1], held[2] = gx, gy, gz
    turn(q, x, y, z)
    fill_rotation(C, q)
    for i in range(2):
        flow[i, 0] -= C[i, 0] * dt
        flow[i, 1] -= C[i, 1] * dt
        flow[i, 2] -= C[i, 2] * dt
        flow[i, 3] -= C[i, 0] * x
        flow[i, 4] -= C[i, 1] * y
        flow[i, 5] -= C[i, 2] * z
    if dt > 0:
        sums[TILT_VARIANCE] += s.rate_error**2 * PERSISTENCE * (x * x + y * y + z * z) / dt


@njit(cache=True, error_model="numpy", inline="always")
def accelerate(
    dt: float,
    fx: float,
    fy: float,
    fz: float,
    s: RobustSettings,
    estimate: Array,
    held: Array,
    age: Array,
    flow: Array,
    sums: Array,
) -> None:
    """Add the trapezoid of two world forces to the velocity; sum up what the tilt's error does to it.

    A missing sample (fx is NaN) is held as in `rotate`, but no longer than `longest_hold`: from then on no
    force is known, and the velocity wanders.
    """
    new, known = math.isfinite(fx), age[1] <= s.longest_hold
    if known:
        late = 0.5 * age[1] if new else 0.0
        x, y, z = held[3] * dt, held[4] * dt, held[5] * dt
        if new:
            x, y, z = x + (fx - held[3]) * late, y + (fy - held[4]) * late, z + (fz - held[5]) * late
        estimate[0] += x
        estimate[1] += y
        sums[FORCE] += z
        for j in range(6):
            flow[2, j] += z * flow[1, j]
            flow[3, j] -= z * flow[0, j]
        if new:
            sums[VELOCITY_VARIANCE] += (s.accel_noise_sd * age[1]) ** 2
            sums[VELOCITY_VARIANCE] += (PUSH_BEND * age[1] ** 3) ** 2
        if dt > 0:
            own = x * x + y * y + (z - s.gravity * dt) ** 2
            sums[VELOCITY_VARIANCE] += s.force_error**2 * PERSISTENCE * own / dt
    else:
        sums[VELOCITY_VARIANCE] += s.unseen_walk**2 * dt
    if new:
        held[3], held[4], held[5] = fx, fy, fz
        age[1] = 0.0


@njit(cache=True, error_model="numpy", inline="always")
def travel(dt: float, estimate: Array, flow: Array, sums: Array) -> None:
    """Integrate the velocity and its errors, for their means."""
    sums[DOUBLE_FORCE] += sums[FORCE] * dt
    sums[WAY] += estimate[0] * dt
    sums[WAY + 1] += estimate[1] * dt
    for j in range(6):
        flow[4, j] += flow[2, j] * dt
        flow[5, j] += flow[3, j] * dt


@njit(cache=True, error_model="numpy")
def begin(m: RobustState) -> None:
    """Begin a new interval."""
    m.flow[:] = 0.0
    m.sums[:] = 0.0
    m.sums[START], m.sums[START + 1] = m.estimate[0], m.estimate[1]
    m.age[2] = 0.0


@njit(cache=True, error_model="numpy")
def fill_matrices(s: RobustSettings, m: RobustState) -> None:
    """Write F, Q, H and R of the interval that ends now; their other elements are 0, of F the identity's."""
    F, Q, H, sums, T = m.F, m.Q, m.H, m.sums, m.age[2]
    F[2, 1], F[3, 0] = sums[FORCE], -sums[FORCE]
    H[0, 1], H[1, 0] = sums[DOUBLE_FORCE] / T, -sums[DOUBLE_FORCE] / T
    H[0, 2] = H[1, 3] = 1.0
    for j in range(6):
        for i in range(4):
            F[i, 4 + j] = m.flow[i, j]
        H[0, 4 + j] = m.flow[4, j] / T
        H[1, 4 + j] = m.flow[5, j] / T
    for i in range(2):
        Q[i, i] = sums[TILT_VARIANCE]
        Q[2 + i, 2 + i] = sums[VELOCITY_VARIANCE]
    for i in range(4, 7):
        Q[i, i] = s.bias_walk**2 * T
    m.R[0, 0] = m.R[1, 1] = velocity_variance(s, m)


@njit(cache=True, error_model="numpy")
def velocity_variance(s: RobustSettings, m: RobustState) -> float:
    """Return the variance of "the mean velocity was 0": 2 sd² time / T, in a ride more by its square."""
    T = m.age[2]
    speed = math.hypot(m.sums[WAY], m.sums[WAY + 1]) / T
    usual = UNUSUAL * math.sqrt(s.velocity_sd**2 + 0.5 * (m.P[2, 2] + m.P[3, 3]))
    return float(2 * s.velocity_sd**2 * s.velocity_time / T * max(1.0, speed / usual) ** 2)


@njit(cache=True, error_model="numpy")
def update(x: Array, P: Array, h: Array, z: float, r: float, work: Array) -> None:
    """Take one scalar measurement z, with the row `h` of H and the variance `r`."""
    row, s, y = work[0], r, z
    for i in range(STATES):
        row[i] = 0.0
        for j in range(STATES):
            row[i] += P[i, j] * h[j]
        s += h[i] * row[i]
        y -= h[i] * x[i]
    for i in range(STATES):
        x[i] += row[i] * y / s
        for j in range(STATES):
            P[i, j] -= row[i] * row[j] / s


@njit(cache=True, error_model="numpy")
def predict(x: Array, P: Array, F: Array, Q: Array, work: Array) -> None:
    """Let x = F x and P = F P F' + Q, whose rows from the fifth on are the identity's and the diagonal's."""
    for i in range(4):
        work[4, i] = 0.0
        for k in range(STATES):
            work[i, k] = 0.0
            for j in range(STATES):
                work[i, k] += F[i, j] * P[j, k]
            work[4, i] += F[i, k] * x[k]
    for i in range(4):
        x[i] = work[4, i]
        for j in range(4, STATES):
            P[i, j] = P[j, i] = work[i, j]
        for j in range(i + 1):
            total = 0.0
            for k in range(STATES):
                total += work[i, k] * F[j, k]
            P[i, j] = P[j, i] = total
    for i in range(STATES):
        P[i, i] += Q[i, i]


@njit(cache=True, error_model="numpy")
def level(s: RobustSettings, m: RobustState, C: Array, work: Array) -> None:
    """Take "the mean velocity was 0" and fold the errors found into the estimates."""
    fill_matrices(s, m)
    m.x[:] = 0.0
    for c in range(2):
        update(m.x, m.P, m.H[c], -m.sums[WAY + c] / m.age[2], m.R[c, c], work)
    predict(m.x, m.P, m.F, m.Q, work)
    for i in range(8):
        m.estimate[i] += m.x[2 + i]
    a, b = m.x[0], m.x[1]
    turn(m.q, C[0, 0] * a + C[1, 0] * b, C[0, 1] * a + C[1, 1] * b, C[0, 2] * a + C[1, 2] * b)
    m.q[:] /= math.sqrt(m.q[0] ** 2 + m.q[1] ** 2 + m.q[2] ** 2 + m.q[3] ** 2)
    fill_rotation(C, m.q)
    begin(m)


@njit(cache=True, error_model="numpy")
def is_lost(s: RobustSettings, m: RobustState) -> bool:
    """Return whether the tilt must be wrong: nobody is that fast, or the mean force points down."""
    return math.hypot(m.estimate[0], m.estimate[1]) > s.top_speed or m.sums[FORCE] < 0


@njit(cache=True, error_model="numpy")
def level_anew(
    fx: float, fy: float, fz: float, sd: float, s: RobustSettings, m: RobustState, C: Array
) -> bool:
    """Take the tilt from a specific force, body axes; return False in free fall, which has no vertical."""
    if math.sqrt(fx * fx + fy * fy + fz * fz) < 0.5 * s.gravity:
        return False
    fill_level(m.q, (fx, fy, fz))
    fill_rotation(C, m.q)
    m.P[:4, :] = 0.0
    m.P[:, :4] = 0.0
    for i in range(2):
        m.P[i, i], m.P[2 + i, 2 + i] = sd**2, RIDE_SD**2
    m.estimate[0] = m.estimate[1] = 0.0
    begin(m)
    return True


@njit(cache=True, error_model="numpy")
def level_by_mean(s: RobustSettings, m: RobustState, C: Array) -> bool:
    """Take the tilt from the mean specific force since the last levelling."""
    T = m.age[2]
    x, y = (m.estimate[0] - m.sums[START]) / T, (m.estimate[1] - m.sums[START + 1]) / T
    z = m.sums[FORCE] / T
    return level_anew(
        C[0, 0] * x + C[1, 0] * y + C[2, 0] * z,
        C[0, 1] * x + C[1, 1] * y + C[2, 1] * z,
        C[0, 2] * x + C[1, 2] * y + C[2, 2] * z,
        LEVELLED_SD, s, m, C,
    )  # fmt: skip


@njit(cache=True, error_model="numpy")
def restart(accel: Array, gyro: Array, s: RobustSettings, m: RobustState, C: Array) -> None:
    """Go on from a tilt taken anew with this row's samples; without one, as if at rest."""
    m.age[0] = m.age[1] = 0.0
    for i in range(3):
        m.held[i] = gyro[i] if is_rate(gyro) else m.estimate[2 + i]
        m.held[3 + i] = s.gravity if i == 2 else 0.0
        if is_sample(accel):
            m.held[3 + i] = C[i, 0] * accel[0] + C[i, 1] * accel[1] + C[i, 2] * accel[2]


@njit(cache=True, error_model="numpy")
def recover(accel: Array, gyro: Array, s: RobustSettings, m: RobustState, C: Array) -> None:
    """Take a lost tilt anew from this row's specific force, if there is one; until a mean force gives it."""
    if is_sample(accel) and level_anew(accel[0], accel[1], accel[2], LEVELLING_SD, s, m, C):
        restart(accel, gyro, s, m, C)
        m.age[3] = 1.0


@njit(cache=True, error_model="numpy")
def end_interval(accel: Array, gyro: Array, s: RobustSettings, m: RobustState, C: Array, work: Array) -> None:
    """Level; a tilt that is doubtful or must be wrong is taken anew from the interval's mean force."""
    if (m.age[3] > 0.0 or is_lost(s, m)) and level_by_mean(s, m, C):
        restart(accel, gyro, s, m, C)
        m.age[3] = 0.0
    else:
        level(s, m, C, work)


@njit(cache=True, error_model="numpy", inline="always")
def project(
    accel: Array,
    s: RobustSettings,
    estimate: Array,
    held: Array,
    sums: Array,
    P: Array,
    C: Array,
    k: int,
    ups: Array,
) -> tuple[float, float]:
    """Write row k's vertical `latency` ahead; return the vertical acceleration and sd, NaN without sample.

    What the accelerometer feels beside gravity is projected on the vertical ahead: gravity itself arrives as
    late as the rate that turned the vertical.
    """
    x, y, z = C[2, 0], C[2, 1], C[2, 2]
    ux, uy, uz = x, y, z
    if s.latency > 0:
        a = s.latency * (held[0] - estimate[2])
        b = s.latency * (held[1] - estimate[3])
        c = s.latency * (held[2] - estimate[4])
        px, py, pz = x - b * z + c * y, y - c * x + a * z, z - a * y + b * x
        n = 1.0 / math.sqrt(px * px + py * py + pz * pz)
        ux, uy, uz = n * px, n * py, n * pz
    ups[k, 0], ups[k, 1], ups[k, 2] = ux, uy, uz
    if not is_sample(accel):
        return math.nan, math.nan
    g = s.gravity
    vertical = ux * (accel[0] - g * x) + uy * (accel[1] - g * y) + uz * (accel[2] - g * z)
    fx = C[0, 0] * accel[0] + C[0, 1] * accel[1] + C[0, 2] * accel[2]
    fy = C[1, 0] * accel[0] + C[1, 1] * accel[1] + C[1, 2] * accel[2]
    own = sums[TILT_VARIANCE] + (s.accel_bias_sd / g) ** 2
    variance = fy * fy * (P[0, 0] + own) + fx * fx * (P[1, 1] + own) - 2 * fx * fy * P[0, 1]
    return vertical, math.sqrt(max(variance, 0.0) + s.accel_noise_sd**2)


@njit(cache=True, error_model="numpy", inline="always")
def is_usual(force: Array, rate: Array, held: Array, doubt: Array, C: Array) -> bool:
    """Return whether `screen` would leave this row as it is, and change no doubt: nearly always.

    Samples that repeat themselves are `screen`'s; others end a repetition.
    """
    jump = turning = size = speed = 0.0
    if rate[0] == held[0] and force[0] == doubt[2, 1]:
        return False
    doubt[2, 0], doubt[2, 1], doubt[2, 2], doubt[2, 3] = 0.0, force[0], force[1], force[2]
    for i in range(3):
        jump += (C[i, 0] * force[0] + C[i, 1] * force[1] + C[i, 2] * force[2] - held[3 + i]) ** 2
        turning += (rate[i] - held[i]) ** 2
        size += force[i] * force[i]
        speed += rate[i] * rate[i]
    calm = doubt[0, 0] == PATIENCE and doubt[1, 0] == PATIENCE
    small = size < MOST_FORCE**2 and speed < MOST_RATE**2 and size > 0.0
    return calm and small and jump <= FORCE_JUMP**2 and turning <= RATE_JUMP**2


@njit(cache=True, error_model="numpy")
def screen(dt: float, force: Array, rate: Array, s: RobustSettings, m: RobustState, C: Array) -> float:
    """Leave of this row's force and rate what is believed, and NaN of what is not.

    A transfer breaks, and a sample is wild; a knock is wild, too.  So what jumps is believed when it is seen
    again.  All six exactly 0 is a sensor that restarts; all six the same for long, while it moves, is one
    that is stuck.  Returns by how much a doubted force jumped, m/s².
    """
    held, doubt = m.held, m.doubt
    lost = (is_zero(force) and is_zero(rate)) or is_stuck(dt, force, rate, s, m)
    there, turns = is_sample(force) and not lost, is_rate(rate) and not lost
    jump, turning, doubted = 0.0, 0.0, False
    for i in range(3):
        jump += (C[i, 0] * force[0] + C[i, 1] * force[1] + C[i, 2] * force[2] - held[3 + i]) ** 2
        turning += (rate[i] - held[i]) ** 2
    if turns:
        turns = not is_doubted(1, rate, turning, RATE_JUMP, doubt)
    if there:
        doubted = is_doubted(0, force, jump, FORCE_JUMP, doubt)
    for i in range(3):
        rate[i] = rate[i] if turns else math.nan
        force[i] = force[i] if there else math.nan
    return math.sqrt(jump) if doubted else 0.0


@njit(cache=True, error_model="numpy")
def is_stuck(dt: float, force: Array, rate: Array, s: RobustSettings, m: RobustState) -> bool:
    """Return whether a sensor with noise repeats itself for longer than it should, and not as one at rest.

    From then on its last samples count as being as old as they are.
    """
    same, repeat = m.doubt[2], True
    speed = size = 0.0
    for i in range(3):
        repeat = repeat and rate[i] == m.held[i] and force[i] == same[1 + i]
        same[1 + i] = force[i]
        speed += (rate[i] - m.estimate[2 + i]) ** 2
        size += force[i] * force[i]
    same[0] = same[0] + dt if repeat else 0.0
    moving = speed > MOVING_RATE**2 or abs(math.sqrt(size) - s.gravity) > MOVING_FORCE
    if not (moving and same[0] > s.longest_repeat + ROUNDING):
        return False
    m.age[0], m.age[1] = max(m.age[0], same[0]), max(m.age[1], same[0])
    return True


@njit(cache=True, error_model="numpy", inline="always")
def is_zero(v: Array) -> bool:
    """Return whether all three components are exactly 0."""
    return bool(v[0] == 0.0 and v[1] == 0.0 and v[2] == 0.0)


@njit(cache=True, error_model="numpy", inline="always")
def is_doubted(sensor: int, v: Array, jump: float, most: float, doubt: Array) -> bool:
    """Return whether a sample whose jump has this square is to be seen again first."""
    jumps, doubted = jump > most * most, False
    if jumps and doubt[sensor, 0] >= 1.0:
        again = 0.0
        for i in range(3):
            again += (v[i] - doubt[sensor, 1 + i]) ** 2
        doubted = not again < most * most
    if doubted:
        doubt[sensor, 0] -= 1.0
        for i in range(3):
            doubt[sensor, 1 + i] = v[i]
    else:
        if not jumps:
            doubt[sensor, 0] = min(doubt[sensor, 0] + REGAINED, PATIENCE)
        doubt[sensor, 1] = math.nan
    return doubted


@njit(cache=True, error_model="numpy")
def run_robust(
    dt: Array,
    accel: Array,
    gyro: Array,
    s: RobustSettings,
    m: RobustState,
    ups: Array,
    vertical: Array,
    vertical_sd: Array,
) -> None:
    """Run the filter over all samples; its memory `m` goes on, the last three are filled."""
    C, work, f, w = np.empty((3, 3)), np.empty((5, STATES)), np.empty(3), np.empty(3)
    q, estimate, held, age, flow, sums = m[:6]
    P, doubt = m.P, m.doubt
    fill_rotation(C, q)
    for k in range(len(dt)):
        T = dt[k]
        for i in range(3):
            age[i] += T
            f[i], w[i] = accel[k, i], gyro[k, i]
        jump = 0.0 if is_usual(f, w, held, doubt, C) else screen(T, f, w, s, m, C)
        if age[0] <= s.longest_hold:
            rotate(T, w, s, q, estimate, held, age, flow, sums, C)
            fx = C[0, 0] * f[0] + C[0, 1] * f[1] + C[0, 2] * f[2]
            fy = C[1, 0] * f[0] + C[1, 1] * f[1] + C[1, 2] * f[2]
            fz = C[2, 0] * f[0] + C[2, 1] * f[1] + C[2, 2] * f[2]
            if jump > 0.0:  # passed over, but it may have been true
                fx = math.nan
                sums[VELOCITY_VARIANCE] += (jump * T) ** 2
            accelerate(T, fx, fy, fz, s, estimate, held, age, flow, sums)
            travel(T, estimate, flow, sums)
            interval = s.interval if age[3] == 0.0 else 0.5 * s.interval
            if age[2] > 0 and age[2] > interval - ROUNDING:
                end_interval(f, w, s, m, C, work)
        else:
            recover(f, w, s, m, C)
        vertical[k], vertical_sd[k] = project(f, s, estimate, held, sums, P, C, k, ups)
