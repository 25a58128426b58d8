"""The tilt Kalman filter of Lee: the vertical in sensor axes from a six-axis IMU [Lee16, Sec. 2.1].

The state Z is the world's z axis in sensor axes; a is the external acceleration, modelled as c_a times its
previous value plus an error.

    Z_t = exp(-dt [s_G x]) Z_{t-1} + w,   Q = -dt² [Z x] Sigma_G [Z x]                     (Eqs. 3, 6a)
    s_A - c_a a+_{t-1} = g Z_t - a_eps + n_A                                               (Eq. 4)
    R = (c_a²/3) |a+_{t-1}|² I + sigma_A² I                                                (Eq. 6b)
    a+ = s_A - g Z,   a_z = a+ . Z                                                         (Eq. 7)

The sd of a_z is sqrt(f_h' P f_h + sigma_A²), with the horizontal specific force f_h.

As printed and as used:

* Eq. 3 takes the first two terms of the exponential; each step then falls short by (omega dt)³/3, which grows
  to tens of degrees at one turn per second and 50 Hz.  ``transition="first-order"`` is the paper's.
* Eq. 4 lost the minus before a_eps; Eq. 5b needs x_t; Sigma_A is sigma_A² I, Sigma_acc has |a+|²: the units
  demand it.  The draft lost the minus of Q.
* Z is renormalised after each step.  Without an accelerometer sample a+ stays what it was; after half a
  second without gyro samples the next specific force gives the tilt anew.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from filterpy.kalman import KalmanFilter

from baroarma.estimators.attitude.samples import is_sample
from baroarma.estimators.attitude.six_axis import SixAxisFilter
from baroarma.estimators.attitude.tilt_kernel import (
    TiltSettings,
    fill_tilt_noise,
    fill_tilt_transition,
    level_vertical,
    run_tilt_kalman,
    tilt_measurement_variance,
)
from baroarma.estimators.attitude.vertical import normalise, vertical_acceleration
from baroarma.estimators.base import Alignment, AttitudeRun, AttitudeState, Signal


class TiltKalman(SixAxisFilter, KalmanFilter):
    """Estimate the vertical in sensor axes; a `filterpy.kalman.KalmanFilter` of 3 states.

    The paper prints none of these values.

    Parameters
    ----------
    gyro_noise_sd : float
        sigma_G, rad/s per sample.  Default 0.1 °/s (chosen by us): twice the total RMS noise in the
        MPU-6050's data sheet, for the bias that stays after its capture and a scale good to 3 %.  Larger:
        tilt follows the accelerometer faster.
    accel_noise_sd : float
        sigma_A, m/s².  Default 0.04 (chosen by us): the MPU-6050's 400 ug/rtHz over 100 Hz, 4 mg.  Larger:
        tilt relies longer on the gyro.
    acceleration_memory : float
        c_a, between 0 and 1.  Default 0.1 (chosen by us).  Larger: more of an acceleration is expected to
        last until the next sample, and moving samples count less.
    transition : {"exponential", "first-order"}
        Default ``"exponential"`` (chosen by us); ``"first-order"`` is the printed one, which drifts.
    initial_tilt_sd : float
        Uncertainty of the alignment, rad.  Default 1° (chosen by us): 17 mg of accelerometer bias, within
        the MPU-6050's zero-g tolerance.

    Raises
    ------
    ValueError
        If `transition` is neither of the two.

    Examples
    --------
    >>> tilt = TiltKalman()
    >>> state = tilt.step(dt=0.02, accel=np.array([0.0, 0.0, 9.9]), gyro=np.zeros(3))
    >>> round(state.acceleration, 3), round(state.acceleration_sd, 3)
    (0.093, 0.04)
    """

    def __init__(
        self,
        *,
        gyro_noise_sd: float = math.radians(0.1),
        accel_noise_sd: float = 0.04,
        acceleration_memory: float = 0.1,
        transition: Literal["exponential", "first-order"] = "exponential",
        initial_tilt_sd: float = math.radians(1.0),
    ) -> None:
        if transition not in ("exponential", "first-order"):
            raise ValueError(f"transition {transition!r} is unknown; choose 'exponential' or 'first-order'")
        KalmanFilter.__init__(self, dim_x=3, dim_z=3)
        exponential = transition == "exponential"
        self.settings = TiltSettings(gyro_noise_sd, accel_noise_sd, acceleration_memory, exponential)
        self.initial_tilt_sd = initial_tilt_sd
        self.reset()

    def reset(self, alignment: Alignment | None = None) -> None:
        """Start from the alignment's vertical, uncertain across but not along it; no acceleration."""
        self._start(alignment)
        self.x = np.array(self.alignment.up)
        self.P = self.initial_tilt_sd**2 * (np.eye(3) - np.outer(self.x, self.x))
        self.F, self.Q = np.eye(3), np.zeros((3, 3))
        self.H = self.alignment.gravity * np.eye(3)
        self.z, self.y = np.full(3, np.nan), np.zeros(3)
        self.external = np.zeros(3)

    def _loop(self, t: Signal, before: float, accel: Signal, gyro: Signal, out: AttitudeRun) -> None:
        bias, gravity, state = self._gyro_bias, self.alignment.gravity, (self.x, self.P, self.held)
        run_tilt_kalman(t, before, accel, gyro, bias, gravity, self.settings, *state, self.external, *out)

    def _fill(self, dt: float) -> None:
        fill_tilt_transition(self.F, self.held, dt, self.settings.exponential)
        fill_tilt_noise(self.Q, self.x, dt, self.settings.gyro_noise_sd)

    def _level(self, accel: Signal) -> bool:
        return level_vertical(self.x, self.P, accel)

    def _correct(self, accel: Signal) -> None:
        self.R = tilt_measurement_variance(self.external, self.settings) * np.eye(3)
        self.update(accel - self.settings.acceleration_memory * self.external)

    def _state(self, accel: Signal) -> AttitudeState:
        normalise(self.x)
        up = self.x.copy()
        if not is_sample(accel):
            return AttitudeState(up, math.nan, math.nan)
        gravity, noise = self.alignment.gravity, self.settings.accel_noise_sd
        self.external = accel - gravity * up
        vertical = vertical_acceleration(accel, up, np.eye(3), self.P, gravity, noise)
        return AttitudeState(up, *vertical)
