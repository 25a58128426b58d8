"""What a height filter is fed with at rest: the altimeter's noise as conditioned, the acceleration's error.

All of it is one linear system, s_k = A s_{k-1} + noise of covariance Q, whose states are, in this order,

    Gauss-Markov noise c, drift d, the altitude's zero (mean of c + d + u over the alignment, or its first
    sample), the conditioned sample before and now, the error of the acceleration before and now; of its parts
    the constant one, the wandering one and the two by tilt; the samples that the average remembers, the
    delay of the whitening filter.

A tilt error theta brings the horizontal acceleration into the vertical one: a_h · theta, a product of two
independent processes.  With exponential autocorrelations, sds and times (A, T) and (B, U), the product has
the sd A B and the rate 1/T + 1/U.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.estimators.base import Alignment
from baroarma.imu_noise import WANDER_TIME, ImuNoise
from baroarma.noise_model import NoiseModel
from baroarma.whitening import WhiteningFilter

Signal = NDArray[np.float64]

CORRELATED, DRIFT, ZERO, BEFORE, SAMPLE, ACCEL_BEFORE, ACCEL, BIAS, WANDER, LEVEL, SWAY, MEMORY = range(12)
"""Where the states are."""
LEVELLING: Final = 3.0
"""Time in s over which an attitude filter levels by the accelerometer (chosen by us: the tilt filter's own
settings give it 2.3 s at rest)."""
SAME_RATE: Final = 0.02
"""Relative difference of two rates that is an error of measuring them (chosen by us)."""
MOTION: Final = 1.0
"""Correlation time in s of people's horizontal accelerations (chosen by us)."""


class Step(NamedTuple):
    """A step of the whole system: s = A s + noise of covariance Q."""

    A: Signal
    Q: Signal

    def spread(self, S: Signal) -> Signal:
        """Return the covariance after the step."""
        return np.asarray(self.A @ S @ self.A.T + self.Q)

    def then(self, later: Step) -> Step:
        """Return this step and a later one as one."""
        return Step(later.A @ self.A, later.spread(self.Q))


@dataclass(frozen=True)
class Errors:
    """Say what a height filter is fed with at rest.

    Parameters
    ----------
    noise : NoiseModel
        Of the barometer's samples.
    imu : ImuNoise
        Of the IMU; its rate is that of the rows.
    average : int
        Points M of the moving average; 1: none.
    whitening : WhiteningFilter or None
        W behind it.
    captured : bool
        Whether the zero is the alignment's mean; else its first sample.
    alignment : float
        Seconds at the start over which zero and gravity are averaged.
    horizontal_acceleration : float
        Rms of the horizontal acceleration, m/s², which brings the tilt's error into the vertical one.
    rest : Alignment
        What the alignment tells the height filter.
    """

    noise: NoiseModel
    imu: ImuNoise
    average: int
    whitening: WhiteningFilter | None
    captured: bool
    alignment: float
    horizontal_acceleration: float
    rest: Alignment = field(default=Alignment())

    @property
    def dt(self) -> float:
        """Interval of the rows, s."""
        return 1 / self.imu.rate_hz

    @property
    def size(self) -> int:
        """Number of noise states."""
        return MEMORY + self.average - 1 + (self.whitening is not None)

    @property
    def dc_gain(self) -> float:
        """What is left of a constant after conditioning."""
        return self.whitening.dc_gain if self.whitening else 1.0

    @property
    def aligned_rows(self) -> int:
        """Number of rows of the alignment."""
        return math.ceil(self.alignment * self.imu.rate_hz - 1e-6)

    @property
    def rows_per_sample(self) -> float:
        """How many rows come to one altitude; rates that hardly differ from a whole ratio have one."""
        ratio = max(1.0, self.imu.rate_hz / self.noise.rate_hz)
        return round(ratio) if abs(ratio / round(ratio) - 1) < SAME_RATE else ratio

    def new_samples(self, rows: int) -> NDArray[np.bool_]:
        """Return at which of so many rows the barometer has a new sample, (rows,)."""
        count = np.floor(np.arange(rows) / self.rows_per_sample + 1e-9)
        return np.asarray(np.diff(count, prepend=-1.0) > 0)


def aligned_covariance(errors: Errors, new: NDArray[np.bool_]) -> Signal:
    """Return the covariance of the noise states after the alignment's rows.

    The mean modulus of the specific force stands for gravity, so that of the accelerometer's bias only the
    mean of its white noise is left, and what it wanders from there.
    """
    imu, tilt = errors.imu, errors.horizontal_acceleration
    S = np.zeros((errors.size, errors.size))
    S[CORRELATED, CORRELATED] = errors.noise.correlated_sd**2
    rest, swayed = tilt_variances(imu, errors.alignment)
    S[LEVEL, LEVEL], S[SWAY, SWAY] = tilt**2 * rest, tilt**2 * swayed
    taken = 0
    for k, fresh in enumerate(new):
        share = (1 / new.sum() if errors.captured else float(taken == 0)) if fresh else 0.0
        S = noise_step(errors, still=k == 0, samples=taken + fresh, fresh=bool(fresh), share=share).spread(S)
        taken += int(fresh)
    wander = imu.accel_wander_sd**2
    S[BIAS, BIAS], S[WANDER, WANDER] = imu.accel_sd**2 / len(new) + wander, wander
    S[BIAS, WANDER] = S[WANDER, BIAS] = -wander
    return S


def tilt_variances(imu: ImuNoise, alignment: float) -> tuple[float, float]:
    """Return the variances in rad² of the tilt about a horizontal axis, what stays of it and what sways.

    The level follows the accelerometer within `LEVELLING` s: an accelerometer bias tilts it by bias/g, a gyro
    bias (what the mean of the alignment missed, and what moved since) by bias · `LEVELLING`, and white gyro
    noise of density d lets it sway by d²·`LEVELLING`/2.

    Examples
    --------
    >>> [round(math.degrees(v**0.5), 3) for v in tilt_variances(ImuNoise.of_device("simple"), 1.0)]
    [0.131, 0.026]
    """
    gyro_bias = math.hypot(imu.gyro_bias_sd, imu.gyro_density / math.sqrt(alignment))
    level = math.hypot(imu.accel_bias_sd / STANDARD_GRAVITY, gyro_bias * LEVELLING)
    return level**2, imu.gyro_density**2 * LEVELLING / 2


def noise_step(errors: Errors, *, still: bool, samples: int, fresh: bool, share: float) -> Step:
    """Return a row's step of the noise states: time goes by (unless `still`), then the altimeter samples.

    `samples` counts those so far, this one included; `share` is this one's in the zero.
    """
    step = Step(np.eye(errors.size), np.zeros((errors.size, errors.size)))
    if not still:
        step = step.then(_time_step(errors))
    return step.then(_sample_step(errors, samples, share)) if fresh else step


def _time_step(errors: Errors) -> Step:
    noise, dt = errors.noise, errors.dt
    A, q = np.eye(errors.size), np.zeros(errors.size)
    A[BEFORE], A[ACCEL_BEFORE], A[ACCEL] = A[SAMPLE], A[ACCEL], 0.0
    q[DRIFT] = noise.drift_rate**2 * dt
    rest, swayed = tilt_variances(errors.imu, errors.alignment)
    fading = 1 / MOTION + 1 / LEVELLING  # of the product of two processes that fade independently
    for state, variance, rate in (
        (CORRELATED, noise.correlated_sd**2, 1 / noise.correlation_time if noise.has_gauss_markov else 0.0),
        (WANDER, errors.imu.accel_wander_sd**2, 1 / WANDER_TIME),
        (LEVEL, errors.horizontal_acceleration**2 * rest, 1 / MOTION),
        (SWAY, errors.horizontal_acceleration**2 * swayed, fading),
    ):
        A[state, state], q[state] = math.exp(-rate * dt), -variance * math.expm1(-2 * rate * dt)
    return Step(A, np.diag(q)).then(_acceleration_step(errors))


def _acceleration_step(errors: Errors) -> Step:
    """Add up the error of the acceleration sample."""
    A, Q = np.eye(errors.size), np.zeros((errors.size, errors.size))
    A[ACCEL, [BIAS, WANDER, LEVEL, SWAY]] = 1.0
    Q[ACCEL, ACCEL] = errors.imu.accel_sd**2
    return Step(A, Q)


def _sample_step(errors: Errors, samples: int, share: float) -> Step:
    """Average, whiten and zero a sample: linear forms of the states and, in the last place, of u."""
    unit = np.eye(errors.size + 1)
    A = unit[:-1].copy()
    sample = unit[CORRELATED] + unit[DRIFT] + unit[-1]
    memory = slice(MEMORY, MEMORY + errors.average - 1)
    points = min(samples, errors.average)
    conditioned = (sample + A[memory][: points - 1].sum(axis=0)) / points
    A[memory] = np.vstack([sample, A[memory]])[: errors.average - 1]
    if errors.whitening is not None:
        conditioned, A[-1] = _whitened(errors.whitening, conditioned, None if samples == 1 else A[-1])
    A[SAMPLE], A[ZERO] = conditioned, A[ZERO] + share * sample
    return Step(A[:, :-1], errors.noise.white_sd**2 * np.outer(A[:, -1], A[:, -1]))


def _whitened(whitening: WhiteningFilter, x: Signal, delay: Signal | None) -> tuple[Signal, Signal]:
    """Return a filtered form and the next delay; without a delay the filter starts in its steady state."""
    if len(whitening.b) == 1:
        return whitening.b[0] * x, 0.0 * x
    (b_0, b_1), (_, a_1) = whitening.b, whitening.a
    y = whitening.dc_gain * x if delay is None else b_0 * x + delay
    return y, b_1 * x - a_1 * y
