"""Tightly coupled: accelerometer, gyro and barometer in one extended Kalman filter (`inertial_model`).

Between samples the IMU, held from the previous sample, turns the vertical and moves height and velocity.  The
barometer measures height + baseline.  The accelerometer levels, too: across the vertical it should read
nothing but bias.  Only these two components are used, for a vertical motion doesn't disturb them; their noise
grows by ||f| - g|.

Which errors of the sensors are estimated is the user's choice.  Son and Oh estimate the accelerometer's bias
and scale, Zhang and others both biases and the barometer's baseline; we know their ideas from SG14 and Lee16,
not their equations, and all constants are chosen by us.
"""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter
from numpy.typing import NDArray

from baroarma.estimators.base import (
    LONGEST_HOLD,
    UNSEEN_WALK,
    Alignment,
    HeightEstimator,
    HeightRun,
    HeightState,
)
from baroarma.estimators.height import inertial_model as model
from baroarma.estimators.height.complementary import SG14_ALTITUDE_SD
from baroarma.estimators.height.drive import nominal_interval
from baroarma.estimators.height.inertial_model import HEIGHT, STATES, UP, VELOCITY
from baroarma.estimators.height.kalman import white_sd
from baroarma.noise_model import NoiseModel

Signal = NDArray[np.float64]


class InertialEkf(ExtendedKalmanFilter, HeightEstimator):
    """Estimate tilt, height and velocity from the IMU and the barometer together.

    As a filterpy filter: `predict(u)` with u = [accel, gyro] (6,) over the nominal interval (without u: no
    acceleration, no rotation), `update(z)` with an altitude.  F and Q are those of the last `predict`.

    Parameters
    ----------
    noise : NoiseModel, optional
        Noise of the altitude, from which `altitude_sd` follows unless given, its samples taken as independent
        (`note`).
    dt : float
        Nominal interval, s.
    altitude_sd : float, optional
        m.  Default: from `noise`, without it 0.30 m.
    accel_noise_sd, gyro_noise_sd : float
        White noise of a sample, m/s² and rad/s; defaults 4 mg and 0.05 °/s, an MPU-6050.
    motion_sd : float
        How far a moving accelerometer is from gravity across the vertical, m/s².  Larger: the tilt relies
        longer on the gyro.
    accel_bias_sd, accel_scale_sd, gyro_bias_sd, baseline_sd : float
        Prior sds, m/s², 1, rad/s and m.  0: not estimated but taken as 0.
    accel_bias_walk, gyro_bias_walk, baseline_walk : float
        Random walks of what is estimated, the same units per sqrt(s).
    initial_tilt_sd, initial_height_sd, initial_velocity_sd : float
        Sds at the start, rad, m and m/s.
    rest_sd : float
        Sd of 'the velocity is 0' at rest, m/s.

    Examples
    --------
    Son and Oh's states, lifted by 1 m/s² for 0.02 s:

    >>> kf = InertialEkf(dt=0.02, accel_bias_sd=0.1, accel_scale_sd=0.01)
    >>> kf.predict(np.array([0.0, 0.0, 10.80665, 0.0, 0.0, 0.0]))
    >>> round(float(kf.x[4, 0]), 6)
    0.02
    """

    input: ClassVar[Literal["acceleration", "imu"]] = "imu"

    def __init__(
        self,
        *,
        noise: NoiseModel | None = None,
        dt: float | None = None,
        altitude_sd: float | None = None,
        accel_noise_sd: float = 0.04,
        gyro_noise_sd: float = 9e-4,
        motion_sd: float = 0.3,
        accel_bias_sd: float = 0.0,
        accel_scale_sd: float = 0.0,
        gyro_bias_sd: float = 0.0,
        baseline_sd: float = 0.0,
        accel_bias_walk: float = 1e-3,
        gyro_bias_walk: float = 1e-5,
        baseline_walk: float = 0.01,
        initial_tilt_sd: float = 0.02,
        initial_height_sd: float = 1e-3,
        initial_velocity_sd: float = 0.1,
        rest_sd: float = 0.01,
    ) -> None:
        ExtendedKalmanFilter.__init__(self, dim_x=STATES, dim_z=1)
        self.dt, self.initial_tilt_sd, self.rest_sd = nominal_interval(dt), initial_tilt_sd, rest_sd
        self.accel_noise_sd, self.gyro_noise_sd, self.motion_sd = accel_noise_sd, gyro_noise_sd, motion_sd
        errors = [accel_bias_sd, accel_scale_sd, gyro_bias_sd]
        walks = np.repeat([accel_bias_walk, 0.0, gyro_bias_walk, baseline_walk], [3, 3, 3, 1])
        self.prior_sds = np.array(
            [0.0] * 3 + [initial_height_sd, initial_velocity_sd, *np.repeat(errors, 3), baseline_sd]
        )
        self.walks = np.concatenate([np.zeros(5), np.where(self.prior_sds[5:] > 0, walks, 0.0)])
        if altitude_sd is None:
            altitude_sd = SG14_ALTITUDE_SD if noise is None else white_sd(noise, self.dt, "ignore")
        self.R, self.H = np.array([[altitude_sd**2]]), np.zeros((1, STATES))
        self.H[0, [HEIGHT, model.BASELINE]] = 1.0
        self.note = ""
        if noise is not None and noise.has_gauss_markov:
            self.note = f"The altimeter's correlated noise is treated as white with sd {altitude_sd:.3g} m."
        self.reset()

    def reset(self, alignment: Alignment | None = None) -> None:
        """Start anew at height 0 and velocity 0, with the alignment's tilt, gyro bias and gravity."""
        self.alignment = alignment or Alignment()
        up = np.array(self.alignment.up)
        self.x, self.P = np.zeros((STATES, 1)), np.diag(self.prior_sds**2)
        self.x[UP, 0] = up
        self.P[UP, UP] = self.initial_tilt_sd**2 * (np.eye(3) - np.outer(up, up))
        self._imu = self._resting()
        self._interval, self._started, self._age = self.dt, False, np.zeros(2)
        self.F, self.Q = self.transition(self._imu, self.dt)
        self.x_prior, self.P_prior = self.x.copy(), self.P.copy()
        self._settle()

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
        """Take one sample of the IMU and the barometer; see `HeightEstimator.step`.

        Raises
        ------
        ValueError
            Without accelerometer and gyro.
        """
        if accel is None or gyro is None:
            raise ValueError("'inertial-ekf' needs the IMU itself: pass accel= in m/s² and gyro= in rad/s")
        if self._started:
            self._age += dt
            self._interval = dt
            self._replace_stale()
            self.predict(self._imu)
            self._interval = self.dt
            self._doubt(dt)
        self._started = True
        self._age[[np.isfinite(accel).all(), np.isfinite(gyro).all()]] = 0.0
        if np.isfinite(gyro).all():
            self._imu[3:] = gyro
        if np.isfinite(accel).all():
            self._imu[:3] = accel
            self._level()
        if at_rest:
            self._measure(np.eye(1, STATES, VELOCITY), 0.0, self.rest_sd**2)
        if not np.isnan(altitude):
            self.update(altitude)
        x, sds = self.x[:, 0], np.sqrt(np.diag(self.P))
        return HeightState(*(float(value) for value in (x[HEIGHT], x[VELOCITY], sds[HEIGHT], sds[VELOCITY])))

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
        """Take all samples one by one; see `HeightEstimator.run`."""
        out = np.empty((4, len(t)))
        for k, step in enumerate(np.diff(t, prepend=t[:1] - dt)):
            out[:, k] = self.step(
                dt=float(step),
                altitude=float(altitude[k]),
                accel=None if accel is None else accel[k],
                gyro=None if gyro is None else gyro[k],
                at_rest=at_rest is not None and bool(at_rest[k]),
            )
        return HeightRun(*out)

    def predict(self, u: Any = None) -> None:
        """Predict with u = [accel, gyro], (6,); None or 0: no acceleration and no rotation."""
        imu = self._resting() if u is None or np.ndim(u) == 0 else np.asarray(u, float).ravel()
        self.F, self.Q = self.transition(imu, self._interval)
        super().predict(imu)

    def predict_x(self, u: Any = 0) -> None:
        """Move the state by the equations themselves, not by their Jacobian (filterpy calls this)."""
        x, gyro = self.x[:, 0], self._rate(u)
        self.x = model.move(x, u[:3], gyro, self.alignment.gravity, self._interval)[:, None]

    def update(self, z: Any, HJacobian: Any = None, Hx: Any = None, R: Any = None, **more: Any) -> None:
        """Update with an altitude in m; with HJacobian and Hx, with any measurement, as filterpy does."""
        HJacobian = HJacobian or (lambda x: self.H)
        Hx = Hx or (lambda x: self.H @ x)
        super().update(z, HJacobian, Hx, R=R, **more)
        self._settle()

    def transition(self, imu: Signal, dt: float) -> tuple[Signal, Signal]:
        """Return F and Q, both (15, 15), at the present state for imu = [accel, gyro], (6,).

        Parameters
        ----------
        imu : ndarray, shape (6,)
            Specific force in m/s², angular rate in rad/s.
        dt : float
            Interval, s.
        """
        F, of_acceleration, of_rate = model.jacobian(self.x[:, 0], imu[:3], self._rate(imu), dt)
        Q = np.diag(self.walks**2 * dt) + self.gyro_noise_sd**2 * of_rate @ of_rate.T
        return F, Q + self.accel_noise_sd**2 * np.outer(of_acceleration, of_acceleration)

    def _level(self) -> None:
        """Update with the two components of the accelerometer across the vertical."""
        x = self.x[:, 0]
        force = model.specific_force(x, self._imu[:3])
        size = math.sqrt(force @ force)
        excess = size - self.alignment.gravity
        variance = self.accel_noise_sd**2 + self.motion_sd**2 + excess**2
        across = np.linalg.svd(x[UP][None])[2][1:]
        for direction in across:
            H = np.zeros((1, STATES))
            H[0, UP], H[0, model.ACCEL_BIAS] = size * direction, direction
            self._measure(H, float(direction @ force + (H @ x)[0]), variance)

    def _replace_stale(self) -> None:
        """Take rest for what hasn't been heard of accelerometer or gyro for too long."""
        for sensor, axes in ((0, slice(0, 3)), (1, slice(3, 6))):
            if self._age[sensor] > LONGEST_HOLD:
                self._imu[axes] = self._resting()[axes]

    def _doubt(self, dt: float) -> None:
        """Add what a stale sensor may have missed: people's motion, any turn up to a radian."""
        if self._age[0] > LONGEST_HOLD:
            missed = np.zeros(STATES)
            missed[[HEIGHT, VELOCITY]] = UNSEEN_WALK * dt**1.5 / 2, UNSEEN_WALK * dt**0.5
            self.P = self.P + np.outer(missed, missed)
        if self._age[1] > LONGEST_HOLD:
            up = self.x[UP, 0]
            self.P[UP, UP] += min(dt, 1.0) ** 2 * (np.eye(3) - np.outer(up, up))

    def _measure(self, H: Signal, z: float, variance: float) -> None:
        self.update(np.array([[z]]), lambda x: H, lambda x: H @ x, R=variance)

    def _settle(self) -> None:
        """Give the vertical its unit length again."""
        up = self.x[UP, 0]
        size = math.sqrt(up @ up)
        J = np.eye(STATES)
        J[UP, UP] = (np.eye(3) - np.outer(up, up) / size**2) / size
        self.x[UP, 0] = up / size
        self.P = J @ self.P @ J.T
        self.x_post, self.P_post = self.x.copy(), self.P.copy()

    def _rate(self, imu: Signal) -> Signal:
        """Angular rate without the alignment's bias, rad/s."""
        return np.asarray(imu[3:] - np.array(self.alignment.gyro_bias))

    def _resting(self) -> Signal:
        """What the IMU reads at rest in the present state, (6,)."""
        x = self.x[:, 0]
        accel = model.resting_accel(x, self.alignment.gravity)
        return np.concatenate([accel, np.array(self.alignment.gyro_bias) + x[model.GYRO_BIAS]])
