"""Does the IMU feel anything?  The claim of rest that a height estimator may weigh.

A quiet period has a reference: the mean specific force since it began, at most over `LONGEST_MEAN` s.  A
sample disturbs it when

* the sample itself lies far from the reference, or the rate far from 0: a knock, or
* their means over a tenth of a second do: a soft start or a slow turn, or
* the reference is not as long as gravity: free fall, an even acceleration.

A disturbance begins a new period; after `SETTLED` s without one the IMU is still.  How far is far follows
from the noise of the recording's own rest (`Alignment.accel_sd`, `gyro_sd`), and is never less than what
tables and hands do.  Being still is not being at rest: a lift at constant speed is still, too.

What shakes is still, but its accelerometer sees more than its own noise, and sampled slowly it looks like
white noise: `shaking` is its sd, from the differences of successive samples in the still periods so far.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import as_rows, njit
from baroarma.estimators.attitude.samples import MOST_FORCE, MOST_RATE
from baroarma.estimators.base import ROUNDING, Alignment, Signal

SETTLED: Final = 0.5
"""Seconds without a disturbance after which the IMU is still; all constants here are chosen by us."""
ALIGNED: Final = 1.0
"""How long the alignment has been still, s."""
LONGEST_MEAN: Final = 2.0
"""Length of the reference's mean, s."""
SHORT_MEAN: Final = 0.1
"""Time constant of the short means, s."""
LONGEST_SILENCE: Final = 0.5
"""Seconds without an IMU sample after which nothing is known."""
KNOCK: Final = 6.0
"""Standard deviations of one sample that are no noise."""
SHIFT: Final = 4.0
"""Standard deviations of a short mean that are no noise."""
LEAST_KNOCK: Final = (1.0, 0.3)
"""Smallest knock, m/s² and rad/s."""
LEAST_SHIFT: Final = (0.3, 0.15)
"""Smallest shift of a mean, m/s² and rad/s."""
GRAVITY_ERROR: Final = 0.3
"""By how much the reference may differ from gravity, m/s²: scale errors, and biases in another mounting."""
DEFAULT_SD: Final = (0.04, 0.003)
"""Noise where no rest tells it, m/s² and rad/s."""
LARGEST_SD: Final = (0.2, 0.05)
"""Noise beyond which the rest was none, m/s² and rad/s."""
SHAKING_TIME: Final = 10.0
"""Time constant of the mean of squared differences, s."""
SHAKEN: Final = 1.2
"""Times the accelerometer's own noise from which something shakes."""
_FORCE, _RATE, _AGE, _SILENCE, _SHAKING, _LAST = 3, 6, 9, 10, 11, 12
"""Places in the memory; the reference comes first."""


class StillnessRun(NamedTuple):
    """What an IMU feels, row by row."""

    still: NDArray[np.bool_]
    """Whether it feels no motion, (n,)."""
    shaking: Signal
    """White noise of one accelerometer sample where it shakes, m/s², (n,); NaN: no more than its own."""


class StillnessState(NamedTuple):
    """What an IMU feels in one row."""

    still: bool
    """Whether it feels no motion."""
    shaking: float
    """White noise of one accelerometer sample if it shakes, m/s²; NaN: no more than its own."""


class Limits(NamedTuple):
    """How far is far: noise of a sample, m/s² and rad/s."""

    accel_sd: float
    gyro_sd: float
    gravity: float


class Stillness:
    """Tell from row to row whether the IMU is still.

    Parameters
    ----------
    alignment : Alignment
        The recording's own rest.

    Examples
    --------
    >>> t, rest = np.arange(100) / 50, np.tile([0.0, 0.0, 9.81], (100, 1))
    >>> rest[50] += 2.0  # a knock
    >>> moved = ~Stillness(Alignment()).run(t, rest, np.zeros((100, 3))).still
    >>> float(t[moved][0]), float(t[moved][-1])
    (1.0, 1.5)
    """

    def __init__(self, alignment: Alignment) -> None:
        noise = zip((alignment.accel_sd, alignment.gyro_sd), DEFAULT_SD, LARGEST_SD, strict=True)
        accel_sd, gyro_sd = (min(sd, most) if math.isfinite(sd) else usual for sd, usual, most in noise)
        self._limits = Limits(accel_sd, gyro_sd, alignment.gravity)
        self._bias = np.array(alignment.gyro_bias)
        rest = alignment.gravity * np.array(alignment.up)  # the alignment's second has settled already
        settled = [ALIGNED, 0.0, accel_sd**2]
        self._memory = np.concatenate([rest, rest, np.zeros(3), settled, rest])

    def step(self, *, dt: float, accel: Signal, gyro: Signal) -> StillnessState:
        """Take one sample, as `AttitudeEstimator.step`."""
        return StillnessState(*_step(float(dt), accel, gyro, self._bias, *self._limits, self._memory))

    def run(self, t: Signal, accel: Signal, gyro: Signal, dt: float = 0.0) -> StillnessRun:
        """Take all samples: t (n,), accel (n, 3), gyro (n, 3); the first `dt` s after the last one taken."""
        n = len(t)
        found = StillnessRun(np.empty(n, np.bool_), np.empty(n))
        accel, gyro = as_rows(accel, 3), as_rows(gyro, 3)
        _run(np.diff(t, prepend=t[:1] - dt), accel, gyro, self._bias, *self._limits, self._memory, *found)
        return found


@njit(cache=True, error_model="numpy")
def _step(
    dt: float,
    f: Signal,
    w: Signal,
    bias: Signal,
    accel_sd: float,
    gyro_sd: float,
    gravity: float,
    memory: Signal,
) -> tuple[bool, float]:
    """Take one sample; return whether all is still, and the sd of shaking or NaN."""
    steps, force, rate = np.full(1, dt), np.empty((1, 3)), np.empty((1, 3))
    still, shaking = np.empty(1, np.bool_), np.empty(1)
    force[0], rate[0] = f, w
    _run(steps, force, rate, bias, accel_sd, gyro_sd, gravity, memory, still, shaking)
    return still[0], shaking[0]


@njit(cache=True, error_model="numpy")
def _run(
    dt: Signal,
    f: Signal,
    w: Signal,
    bias: Signal,
    accel_sd: float,
    gyro_sd: float,
    gravity: float,
    memory: Signal,
    still: NDArray[np.bool_],
    shaking: Signal,
) -> None:
    """Fill the last two: whether all is still, and the sd of shaking or NaN.

    The memory goes on: reference, short means of force and rate, age and so on, last force.
    """
    knock = max(LEAST_KNOCK[0], KNOCK * accel_sd) ** 2, max(LEAST_KNOCK[1], KNOCK * gyro_sd) ** 2
    shakes = (SHAKEN * accel_sd) ** 2
    for k in range(len(dt)):
        age, silence = memory[_AGE] + dt[k], memory[_SILENCE] + dt[k]
        force = f[k, 0] * f[k, 0] + f[k, 1] * f[k, 1] + f[k, 2] * f[k, 2]
        rate = w[k, 0] * w[k, 0] + w[k, 1] * w[k, 1] + w[k, 2] * w[k, 2]
        if force < MOST_FORCE**2 and rate < MOST_RATE**2:
            goes_on = silence <= LONGEST_SILENCE + ROUNDING
            if goes_on:
                share = dt[k] / (SHORT_MEAN + dt[k])
                part = dt[k] / min(age, LONGEST_MEAN) if age > 0.0 else 0.0
                for i in range(3):
                    memory[_FORCE + i] += share * (f[k, i] - memory[_FORCE + i])
                    memory[_RATE + i] += share * (w[k, i] - bias[i] - memory[_RATE + i])
                # noise of the short mean, and of the reference, in samples
                spread = math.sqrt(share / (2.0 - share) + part)
                goes_on = not _disturbs(k, f, w, bias, memory, spread, accel_sd, gyro_sd, gravity, knock)
                for i in range(3):
                    memory[i] += part * (f[k, i] - memory[i])
            if not goes_on:
                for i in range(3):
                    memory[i] = memory[_FORCE + i] = f[k, i]
                    memory[_RATE + i] = w[k, i] - bias[i]
                age = 0.0
            if age >= SETTLED - ROUNDING:
                square = 0.0
                for i in range(3):
                    square += (f[k, i] - memory[_LAST + i]) ** 2
                memory[_SHAKING] += silence / SHAKING_TIME * (square / 6.0 - memory[_SHAKING])
            silence = 0.0
            for i in range(3):
                memory[_LAST + i] = f[k, i]
        memory[_AGE], memory[_SILENCE] = age, silence
        still[k] = age >= SETTLED - ROUNDING and silence <= LONGEST_SILENCE + ROUNDING
        shaking[k] = math.sqrt(memory[_SHAKING]) if memory[_SHAKING] > shakes else math.nan


@njit(cache=True, error_model="numpy", inline="always")
def _disturbs(
    k: int,
    f: Signal,
    w: Signal,
    bias: Signal,
    memory: Signal,
    spread: float,
    accel_sd: float,
    gyro_sd: float,
    gravity: float,
    largest_knock: tuple[float, float],
) -> bool:
    knock = shift = turn = swing = length = 0.0
    for i in range(3):
        knock += (f[k, i] - memory[i]) ** 2
        shift += (memory[_FORCE + i] - memory[i]) ** 2
        turn += (w[k, i] - bias[i]) ** 2
        swing += memory[_RATE + i] ** 2
        length += memory[i] ** 2
    least, most = max(gravity - GRAVITY_ERROR, 0.0), gravity + GRAVITY_ERROR
    return (
        knock > largest_knock[0]
        or shift > max(LEAST_SHIFT[0], SHIFT * spread * accel_sd) ** 2
        or turn > largest_knock[1]
        or swing > max(LEAST_SHIFT[1], SHIFT * spread * gyro_sd) ** 2
        or length < least * least
        or length > most * most
    )
