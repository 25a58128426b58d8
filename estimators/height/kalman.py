"""The two-state Kalman filter of Tanigawa 2008, Zihajehzadeh 2015 and Lee16: height and velocity.

It takes the altimeter's noise for white.  In the steady state its gain divided by dt tends to the
complementary filter's K = [sqrt(2 sigma_w/sigma_v), sigma_w/sigma_v] as dt -> 0 [SG14, Eq. 25; Higgins 1975].

Lee16 sets the complementary filter's velocity to 0 at rest [Eq. 14].  A Kalman filter is told so instead: by
a measurement of the velocity, 0 with `rest_sd`, which also tells it how sure the height is.
"""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from baroarma.estimators.height.complementary import SG14_ACCELERATION_SD, SG14_ALTITUDE_SD
from baroarma.estimators.height.linear import LinearHeight, motion_transition
from baroarma.noise_model import NoiseModel

Signal = NDArray[np.float64]


class Kalman(LinearHeight):
    """Estimate height and velocity, taking the altimeter's noise for white.

    Parameters
    ----------
    noise : NoiseModel, optional
        Noise of the altitude, from which `altitude_sd` follows unless given.
    dt : float
        Nominal interval, s.
    acceleration_sd : float
        sigma_w, white noise of one acceleration sample, m/s².  Default: 15 mg [SG14, Table 1].
    altitude_sd : float, optional
        sigma_v, m.  Default: from `noise`, without it 0.30 m [SG14, Table 1].  Larger: smoother, slower.
    correlation : {"ignore", "inflate"}
        How sigma_v follows from `noise`: the sd of its samples, as if they were independent, or the sd of
        white noise with the same density at frequency 0, sigma_u² + 2 sigma_c² tau/dt.
    **settings
        See `LinearHeight`.

    Examples
    --------
    Tanigawa's printed tuning:

    >>> kf = Kalman(dt=0.02, acceleration_sd=0.8e-3 * 9.80665, altitude_sd=1.0)
    >>> kf.R.tolist(), kf.note
    ([[1.0]], '')
    """

    def __init__(
        self,
        *,
        noise: NoiseModel | None = None,
        dt: float | None = None,
        acceleration_sd: float = SG14_ACCELERATION_SD,
        altitude_sd: float | None = None,
        correlation: Literal["ignore", "inflate"] = "ignore",
        **settings: Any,
    ) -> None:
        super().__init__(("height", "velocity"), dt=dt, acceleration_sd=acceleration_sd, **settings)
        if altitude_sd is None:
            altitude_sd = SG14_ALTITUDE_SD if noise is None else white_sd(noise, self.dt, correlation)
        self.H, self.R = np.array([[1.0, 0.0]]), np.array([[altitude_sd**2]])
        if noise is not None and (noise.has_gauss_markov or noise.drift_rate):
            self.note = f"The altimeter's correlated noise is treated as white with sd {altitude_sd:.3g} m."

    def transition(self, dt: float | Signal) -> Signal:
        """Return F for an interval in s."""
        return motion_transition(dt)

    def wander(self, dt: float | Signal) -> Signal:
        """Return zero: only the acceleration is noisy."""
        return np.zeros((*np.shape(dt), 2, 2))

    def initial_covariance(self) -> Signal:
        """Return P at the start."""
        return np.diag([self.initial_height_sd, self.initial_velocity_sd]) ** 2


def white_sd(noise: NoiseModel, dt: float, correlation: Literal["ignore", "inflate"]) -> float:
    """Return the sd in m of the white noise that stands for a model; the drift is left out.

    Examples
    --------
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> round(white_sd(noise, 0.02, "ignore"), 3), round(white_sd(noise, 0.02, "inflate"), 3)
    (0.533, 2.383)
    """
    if correlation not in ("ignore", "inflate"):
        raise ValueError(f"correlation {correlation!r} is unknown; choose 'ignore' or 'inflate'")
    if correlation == "ignore":
        return math.hypot(noise.white_sd, noise.correlated_sd)
    return math.sqrt(noise.white_sd**2 + 2 * noise.correlated_sd**2 * noise.correlation_time / dt)
