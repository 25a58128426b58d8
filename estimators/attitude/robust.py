"""Our attitude filter: the tilt that keeps people's velocity near zero.

Sample by sample an acceleration looks like a tilt; this is why filters that take it for noise around gravity
fail in a squat or on a turning rod.  Its integral does not: whoever moves to and fro has a velocity near 0,
while a wrong tilt makes the integral run away.  So the accelerometer is never compared with gravity.  A
strapdown computer turns the attitude and integrates the specific force f at every row k (C turns body into
world),

    C_k = C_{k-1} exp[(omega_{k-1} + omega_k)/2 dt x],   omega = (1 - s)(gyro - b),
    v_k = v_{k-1} + (C_{k-1} f_{k-1} + C_k f_k)/2 dt      (horizontal components),

and every `interval` of T seconds an extended Kalman filter of the errors x = (tilt, v, b, s) hears that the
mean velocity of the interval was 0.  With the vertical force f_z and the horizontal rows C_h of C,

    tilt' = -C_h (db + diag(omega) ds),   v_x' = f_z tilt_y,   v_y' = -f_z tilt_x,      F: start to end,
    0 = mean(v) + H x + n,   var(n) = 2 sd² tau / T,                                    H: start to mean.

n is the true velocity, of standard deviation `velocity_sd` and correlation time `velocity_time`.  The mean
over seconds hears next to nothing of a step or of a turn of the rod.  The errors found are folded into C, v,
b and s, and x is 0 again.  Heading is left out: nothing here observes it.

* A gyro whose scale is off by 1 % walks away by 4 degrees in a turn; the scale s takes that up.
* In a ride (|v| beyond three sds) var(n) grows by (|v| / 3 sd)², and the tilt holds on to the gyro.
* Faster than `top_speed`, or with a mean force that points down, the tilt must be wrong: the mean force of
  the interval gives it anew, as does the next specific force after half a second without gyro.
* A single wild sample, between samples that agree, is passed over: at 50 Hz one wrong rate of 2000 °/s would
  tilt by 40 degrees.  So is what no sensor of motion reads (100 g, 5700 °/s), and six zeros.
* All six numbers the same for longer than a tenth of a second, while it moves: a sensor that showed noise at
  rest is stuck, and its samples are none.
* Without accelerometer the velocity wanders by `UNSEEN_WALK`; free fall has no vertical and needs none.

The sd of a_z is sqrt(f_h' P f_h + noise²), with the horizontal specific force f_h and the tilt's covariance
now.  All constants are chosen by us.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from filterpy.kalman import KalmanFilter

from baroarma.compiled import as_array
from baroarma.estimators.attitude import robust_kernels
from baroarma.estimators.attitude.robust_kernels import STATES, SUMS, RobustSettings, RobustState
from baroarma.estimators.attitude.vertical import fill_level
from baroarma.estimators.base import (
    LONGEST_HOLD,
    UNFELT,
    UNSEEN_WALK,
    Alignment,
    AttitudeEstimator,
    AttitudeRun,
    AttitudeState,
    Signal,
)

GYRO_NOISE_SD: Final = math.radians(0.1)
"""Noise of one gyro sample where the alignment does not tell, rad/s."""
ACCEL_NOISE_SD: Final = 0.04
"""Noise of one accelerometer sample where the alignment does not tell, m/s²."""
BIAS_SD: Final = math.radians(0.05)
"""What an alignment leaves of a gyro's bias beside its own uncertainty, rad/s."""
LEAST_NOISE: Final = 1e-6
"""An ideal sensor's samples have less, m/s² and rad/s, and may repeat themselves."""
INITIAL_VELOCITY_SD: Final = 0.1
"""Horizontal velocity at the end of the alignment, m/s: a hand at rest."""


class RobustAttitude(AttitudeEstimator, KalmanFilter):
    """Estimate tilt by a velocity that stays near zero; a `filterpy.kalman.KalmanFilter` of 10 errors.

    x, P, F, Q, H, R are those of the last levelling: an `update` by the mean velocity, then a `predict`.  The
    estimates themselves stand in `q` (attitude) and `estimate` (velocity, gyro bias, gyro scale).

    Parameters
    ----------
    gyro_noise_sd, accel_noise_sd : float, optional
        White noise of one sample, rad/s and m/s².  Default: what the alignment says, else 0.1 °/s and 0.04.
        Larger gyro noise: tilt follows the velocity faster.
    accel_bias_sd : float
        Bias of the accelerometer, m/s²: no tilt is known better than this over gravity.  Default 0.02, 2 mg.
        Larger: larger sds, nothing else.
    bias_walk : float
        How far the gyro's bias wanders in a second, rad/s per sqrt(s).  Default 5e-5: 0.02 °/s in a minute.
        Larger: the bias is followed faster, and rides disturb it more.
    rate_error : float
        Share of a rate that neither bias nor scale explains (misaligned axes).  Default 0.003.  Larger: tilt
        follows the velocity faster after turns.
    force_error : float
        Share of an acceleration that the sensor tells wrongly (scale, clipping).  Default 0.01.  Larger:
        shocks leave the velocity less certain.
    velocity_sd, velocity_time : float
        Standard deviation (m/s) and correlation time (s) of a horizontal velocity.  Default 1 and 4: a walk.
        Larger: velocities disturb less, and a wrong tilt is found later.
    top_speed : float
        Faster than this, in m/s, nobody is.  Default 80, a fast train.  Smaller: a lost tilt is found sooner.
    interval : float
        Time between levellings, s.  Default 2.  Smaller: a wrong rate is found sooner, but to and fro slower
        than this time disturbs.
    latency : float
        How much later than the motion the samples of both sensors come, s.  Default 0, for the samples cannot
        tell.  A low-pass filter of 20 Hz and second order takes 0.011: a turning device's vertical and
        acceleration are then right in time.
    tilt_sd : float
        Uncertainty of the alignment, rad.  Default 1°: 17 mg of accelerometer bias.
    bias_sd : float, optional
        Uncertainty of the alignment's gyro bias, rad/s.  Default: what the alignment says, and 0.05 °/s.
    scale_sd : float
        Error of the gyro's scale.  Default 0.01.  Larger: an unknown scale is learnt faster, but rides and
        swings are mistaken for it.

    Raises
    ------
    ValueError
        If `interval`, `velocity_sd` or `velocity_time` is not positive.

    Examples
    --------
    >>> tilt = RobustAttitude()
    >>> state = tilt.step(dt=0.02, accel=np.array([0.0, 0.0, 9.9]), gyro=np.zeros(3))
    >>> round(state.acceleration, 3), round(state.acceleration_sd, 3)
    (0.093, 0.04)
    """

    def __init__(
        self,
        *,
        gyro_noise_sd: float | None = None,
        accel_noise_sd: float | None = None,
        accel_bias_sd: float = 0.02,
        bias_walk: float = 5e-5,
        rate_error: float = 0.003,
        force_error: float = 0.01,
        velocity_sd: float = 1.0,
        velocity_time: float = 4.0,
        top_speed: float = 80.0,
        interval: float = 2.0,
        latency: float = 0.0,
        tilt_sd: float = math.radians(1.0),
        bias_sd: float | None = None,
        scale_sd: float = 0.01,
    ) -> None:
        prior = {"interval": interval, "velocity_sd": velocity_sd, "velocity_time": velocity_time}
        for name, value in prior.items():
            if not value > 0:
                raise ValueError(f"{name} must be positive, but it is {value}; leave it out for the default")
        KalmanFilter.__init__(self, dim_x=STATES, dim_z=2)
        self._chosen = RobustSettings(
            gyro_noise_sd=math.nan if gyro_noise_sd is None else gyro_noise_sd,
            accel_noise_sd=math.nan if accel_noise_sd is None else accel_noise_sd,
            accel_bias_sd=accel_bias_sd,
            bias_walk=bias_walk,
            rate_error=rate_error,
            force_error=force_error,
            velocity_sd=velocity_sd,
            velocity_time=velocity_time,
            top_speed=top_speed,
            interval=interval,
            latency=latency,
            gravity=math.nan,
            longest_hold=LONGEST_HOLD,
            unseen_walk=UNSEEN_WALK,
            longest_repeat=math.inf,
        )
        self._initial = tilt_sd, bias_sd, scale_sd
        self.reset()

    def reset(self, alignment: Alignment | None = None) -> None:
        """Start from the alignment's vertical, gyro bias, gravity and, unless given, noise; at rest."""
        self.alignment = start = alignment or Alignment()
        noisy = start.accel_sd > LEAST_NOISE and start.gyro_sd > LEAST_NOISE
        self.settings = self._chosen._replace(
            gyro_noise_sd=_first(self._chosen.gyro_noise_sd, start.gyro_sd, GYRO_NOISE_SD),
            accel_noise_sd=_first(self._chosen.accel_noise_sd, start.accel_sd, ACCEL_NOISE_SD),
            gravity=start.gravity,
            longest_repeat=UNFELT if noisy else math.inf,
        )
        tilt_sd, bias_sd, scale_sd = self._initial
        if bias_sd is None:
            bias_sd = math.hypot(BIAS_SD, np.nan_to_num(start.gyro_bias_sd))
        self.initial_sd = np.repeat([tilt_sd, INITIAL_VELOCITY_SD, bias_sd, scale_sd], [2, 2, 3, 3])
        self.q = np.empty(4)
        fill_level(self.q, start.up)
        self.estimate = np.array([0.0, 0.0, *start.gyro_bias, 0.0, 0.0, 0.0])
        self.held = np.array([*start.gyro_bias, 0.0, 0.0, start.gravity])
        self.age, self.flow, self.sums = np.zeros(4), np.zeros((6, 6)), np.zeros(SUMS)
        self.doubt = np.full((3, 4), np.nan)
        self.doubt[:, 0] = robust_kernels.PATIENCE, robust_kernels.PATIENCE, 0.0
        self.x, self.P = np.zeros(STATES), np.diag(self.initial_sd**2)
        self.F, self.Q = np.eye(STATES), np.zeros((STATES, STATES))
        self.H, self.R = np.zeros((2, STATES)), np.zeros((2, 2))
        self._started = False

    def step(
        self, *, dt: float, accel: Signal, gyro: Signal, attitude: Signal | None = None
    ) -> AttitudeState:
        """Take one sample by the compiled kernel; see `AttitudeEstimator.step`."""
        out = self._take(np.array([dt if self._started else 0.0]), accel[None], gyro[None])
        return AttitudeState(out.up[0], float(out.acceleration[0]), float(out.acceleration_sd[0]))

    def run(
        self, t: Signal, accel: Signal, gyro: Signal, attitude: Signal | None = None, *, dt: float = 0.0
    ) -> AttitudeRun:
        """Take all samples, going on from where the filter stands."""
        return self._take(np.diff(t, prepend=t[:1] - dt), accel, gyro)

    @property
    def chosen(self) -> RobustSettings:
        """The settings as they were given; NaN: the alignment is asked, as `settings` is filled from it."""
        return self._chosen

    @property
    def bias_sd(self) -> float | None:
        """The uncertainty of the alignment's gyro bias as given, rad/s; None: the alignment is asked."""
        return self._initial[1]

    def memory(self) -> RobustState:
        """Return what the filter remembers, by name; the arrays themselves, not copies."""
        matrices = self.x, self.P, self.F, self.Q, self.H, self.R
        motion = self.q, self.estimate, self.held, self.age, self.flow, self.sums
        return RobustState(*motion, *matrices, self.doubt)

    def _take(self, dt: Signal, accel: Signal, gyro: Signal) -> AttitudeRun:
        n = len(dt)
        out = AttitudeRun(np.empty((n, 3)), np.empty(n), np.empty(n))
        accel, gyro = as_array(accel), as_array(gyro)
        robust_kernels.run_robust(dt, accel, gyro, self.settings, self.memory(), *out)
        self._started = self._started or n > 0
        return out


def _first(*candidates: float) -> float:
    """Return the first that is a positive number; an ideal sensor's noise of 0 tells nothing."""
    return next(value for value in candidates if value > 0)
