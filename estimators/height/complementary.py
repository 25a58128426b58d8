"""The complementary filter of SG14 and Lee16: two constant gains, no covariance to choose them.

    x_k = [[1, T], [0, 1]] x_{k-1} + [[1, T/2], [0, 1]] K T (z_{k-1} - h_{k-1}) + [T/2, 1]' T a_{k-1}
                                                                                 [SG14, Eq. 24; Lee16, Eq. 11]
    K = [sqrt(2 sigma_w/sigma_v), sigma_w/sigma_v]                               [SG14, Eq. 25; Lee16, Eq. 13]

SG14 prints K with a minus (which diverges) and x-dot for the acceleration in Delta v; Lee16 is right.  The
filter follows the barometer below and the accelerometer above the time constant sqrt(sigma_v/sigma_w).

A barometer slower than the IMU: either its last sample is held, as the papers' formula would have it, or each
new sample is used once, weighted by the time since the one before (K T with that time for T).  The first lags
by up to a sample and counts every sample's noise many times over; the second is the default.

Gains that were not computed from the noise come with no sd.  Honest ones follow from the filter's own error,

    e_k = (A - g [1, 0]) e_{k-1} + g n_{k-1} + [T/2, 1]' T w_{k-1},

whose covariance is propagated together with the states of the noise n: Gauss-Markov, drift, the noise of the
sample that is held.  Without `noise` n is white with sigma_v.
"""

from __future__ import annotations

import math
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.compiled import as_rows
from baroarma.estimators.base import Alignment, HeightEstimator, HeightRun, HeightState
from baroarma.estimators.height.complementary_kernel import complementary_rows
from baroarma.estimators.height.drive import Drive, as_signal
from baroarma.noise_model import NoiseModel

Signal = NDArray[np.float64]

SG14_ACCELERATION_SD: Final = 15e-3 * STANDARD_GRAVITY
"""sigma_w of SG14 Table 1 (printed): 15 mg, in m/s²."""
SG14_ALTITUDE_SD: Final = 0.30
"""sigma_v of SG14 Table 1, Method A (printed), m."""
LONGEST_WEIGHT: Final = 0.5
"""Most that one sample weighs, in time constants: a sample after a gap must not overshoot (chosen by us)."""


class Complementary(HeightEstimator):
    """Estimate height and velocity with Higgins' constant gains.

    Parameters
    ----------
    noise : NoiseModel, optional
        Noise of the altitude, for honest sds; it does not change the gains.
    dt : float, optional
        Without effect: the filter has no matrices of a nominal interval.
    acceleration_sd, altitude_sd : float
        sigma_w (m/s²) and sigma_v (m); defaults 15 mg and 0.30 m [SG14, Table 1, Method A].  Their ratio
        sets the gains: more sigma_w follows the barometer faster.
    midpoint : bool
        Integrate (a_{k-1} + a_k)/2 instead of a_{k-1}.
    slow_barometer : {"weight", "hold"}
        What to do between the samples of a barometer slower than the IMU (module docstring).
    zupt_steps, zupt_threshold : int, float
        Lee16's zero-velocity rule [Eq. 14]: v = 0 when |a| < threshold (m/s²) for so many steps (Lee16: 12,
        0.1); 0 steps: no rule.
    initial_height_sd, initial_velocity_sd : float
        Sds at the start, m and m/s.
    zeroed_over : float
        Seconds of altitude whose mean was subtracted, s; the error of that mean stays for the whole run and
        is in the sds when `noise` is given.
    rest_sd : float
        Sd of 'the velocity is 0' at rest, m/s.

    Examples
    --------
    >>> cf = Complementary()
    >>> cf.gain.round(3).tolist(), round(cf.time_constant, 2)
    ([0.99, 0.49], 1.43)
    >>> cf.step(dt=0.02, altitude=1.0).height, round(cf.step(dt=0.02, altitude=1.0).height, 4)
    (0.0, 0.0199)
    """

    def __init__(
        self,
        *,
        noise: NoiseModel | None = None,
        dt: float | None = None,
        acceleration_sd: float = SG14_ACCELERATION_SD,
        altitude_sd: float = SG14_ALTITUDE_SD,
        midpoint: bool = False,
        slow_barometer: Literal["weight", "hold"] = "weight",
        zupt_steps: int = 0,
        zupt_threshold: float = 0.1,
        initial_height_sd: float = 1e-3,
        initial_velocity_sd: float = 0.1,
        zeroed_over: float = 1.0,
        rest_sd: float = 0.01,
    ) -> None:
        if slow_barometer not in ("weight", "hold"):
            raise ValueError(f"slow_barometer {slow_barometer!r} is unknown; choose 'weight' or 'hold'")
        if not (acceleration_sd > 0 and altitude_sd > 0):
            raise ValueError(
                f"the gains need positive sds, but they are {acceleration_sd} m/s² and {altitude_sd} m"
            )
        self.noise, self.slow_barometer = noise, slow_barometer
        self.acceleration_sd, self.altitude_sd = acceleration_sd, altitude_sd
        self.initial_height_sd, self.initial_velocity_sd = initial_height_sd, initial_velocity_sd
        self.zeroed_over, self.rest_sd = zeroed_over, rest_sd
        self.drive = Drive(midpoint=midpoint, zupt_steps=zupt_steps, zupt_threshold=zupt_threshold)
        self.reset()

    @property
    def gain(self) -> Signal:
        """K = [sqrt(2 sigma_w/sigma_v), sigma_w/sigma_v], in 1/s and 1/s², (2,)."""
        ratio = self.acceleration_sd / self.altitude_sd
        return np.array([math.sqrt(2 * ratio), ratio])

    @property
    def time_constant(self) -> float:
        """sqrt(sigma_v/sigma_w), s [SG14, Eq. 26]."""
        return math.sqrt(self.altitude_sd / self.acceleration_sd)

    def reset(self, alignment: Alignment | None = None) -> None:
        """Start anew at height 0 and velocity 0; the alignment has no effect here."""
        self.drive.reset()
        self._x, self._started = np.zeros(2), False
        self._P, self._noise = self._initial_covariance(), self._noise_parameters()
        self._K, self._longest = tuple(self.gain.tolist()), LONGEST_WEIGHT * self.time_constant
        self._barometer = np.array([np.nan, 0.0, 0.0])  # last sample, whether it is unused, time since used

    def step(
        self,
        *,
        dt: float,
        altitude: float,
        acceleration: float = float("nan"),
        acceleration_sd: float = float("nan"),
        accel: Signal | None = None,
        gyro: Signal | None = None,
        at_rest: bool = False,
        up: Signal | None = None,
    ) -> HeightState:
        """Take one sample; see `HeightEstimator.step`."""
        t, z, a, a_sd = (np.array([value], float) for value in (dt, altitude, acceleration, acceleration_sd))
        row = self._take(t, 0.0 if self._started else float(dt), z, a, a_sd, np.array([at_rest]))
        return HeightState(*(float(column[0]) for column in row))

    def run(
        self,
        t: Signal,
        altitude: Signal,
        acceleration: Signal | None = None,
        acceleration_sd: Signal | None = None,
        accel: Signal | None = None,
        gyro: Signal | None = None,
        at_rest: NDArray[np.bool_] | None = None,
        up: Signal | None = None,
        *,
        dt: float = 0.0,
    ) -> HeightRun:
        """Take all samples, compiled; see `HeightEstimator.run`."""
        n = len(t)
        rest = np.zeros(n, np.bool_) if at_rest is None else np.asarray(at_rest, np.bool_)
        z, a, a_sd = (as_signal(values, n) for values in (altitude, acceleration, acceleration_sd))
        return self._take(t, float(t[0]) - dt if n else 0.0, z, a, a_sd, rest)

    def _take(
        self, t: Signal, before: float, z: Signal, a: Signal, a_sd: Signal, at_rest: NDArray[np.bool_]
    ) -> HeightRun:
        """Take rows, the first of them t[0] - before after what came before it."""
        u, _, quiet = self.drive.rows(a)
        t, out = as_rows(t), np.empty((4, len(t)))
        complementary_rows(
            self._x,
            self._P,
            self._barometer,
            before,
            (t, z, u, a_sd, quiet | at_rest),
            self._K,
            self.slow_barometer == "hold",
            self._longest,
            self._noise,
            self.acceleration_sd,
            self.rest_sd**2,
            out,
        )
        self._started = self._started or len(t) > 0
        return HeightRun(*out)

    def _noise_parameters(self) -> tuple[float, float, float, float]:
        """Variance and 1/tau of Gauss-Markov noise, white variance, growth of the drift's variance."""
        if self.noise is None:
            return 0.0, 0.0, self.altitude_sd**2, 0.0
        n = self.noise
        rate = 1 / n.correlation_time if n.has_gauss_markov else 0.0
        return n.correlated_sd**2, rate, n.white_sd**2, n.drift_rate**2

    def _initial_covariance(self) -> Signal:
        """Covariance of [height error, velocity error, Gauss-Markov, drift and zero offset, held noise]."""
        zero_variance = 0.0 if self.noise is None else mean_variance(self.noise, self.zeroed_over)
        correlated = self._noise_parameters()[0]
        variances = [self.initial_height_sd**2, self.initial_velocity_sd**2, correlated, zero_variance, 0.0]
        return np.diag(variances)


def mean_variance(noise: NoiseModel, duration: float) -> float:
    """Return the variance (m²) of the mean of the stationary noise over a duration in s.

    White noise leaves density/duration, Gauss-Markov noise 2 sigma_c² (r - 1 + e^-r)/r², r = duration/tau; a
    duration shorter than a sample is one sample.

    Examples
    --------
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> round(mean_variance(noise, 1.0) ** 0.5, 3)
    0.231
    """
    duration = max(duration, 1 / noise.rate_hz)
    variance = noise.white_density / duration
    if noise.has_gauss_markov:
        r = duration / noise.correlation_time
        variance += 2 * noise.correlated_sd**2 * (r + math.expm1(-r)) / r**2
    return variance
