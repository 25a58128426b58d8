"""The quaternion EKF of Sabatini and Genovese: attitude and accelerometer bias from a six-axis IMU [SG14].

State x = (q, b): the quaternion body -> world, scalar last, and the accelerometer bias in body axes.

    q_k = exp(T/2 Omega(omega_{k-1})) q_{k-1},   b_k = exp(-alpha T) b_{k-1} + w              (Eqs. 2-8)
    f_k = C^bn(q_k)(-g^n) + b_k + v                                                           (Eq. 16)

Components of the innovation beyond `gate` are not used (vector selection, Eq. 17).  The vertical acceleration
is the last component of C^nb f + g (Eq. 22); the paper does not subtract the estimated bias there, nor do we.
Its sd is sqrt(f_h' J P_q J' f_h + sigma_a²), with the horizontal specific force f_h and J = d up/d q.

As printed and as used:

* Eqs. 15, 23 have C^bn and C^nb swapped; with Eqs. 2-5, C^nb = I + 2 q4 [q x] + 2 [q x]² and C^bn is its
  transpose.  Eqs. 18 and 33 agree with that.
* Eq. 7 is 0/0 for alpha = 0, the value of Table 1; its limit T sigma² is used there.
* Eq. 12 wants the predicted covariance before it exists; the last updated q and P are used.
* Eq. 20 loses symmetry to rounding; filterpy takes the Joseph form, the compiled loop half of a symmetric P.
* Eq. 22 is positive down in the paper's NED frame; here z is up and g^n = (0, 0, -g).
* After half a second without gyro samples the tilt is lost, and the next specific force gives it anew: the
  gate would never readmit the accelerometer.

**Weakness.**  An acceleration inside the gate, as in a squat that tilts the trunk, is taken for accelerometer
bias because sigma_a = 10 mg is far too confident: with `initial_bias_sd` = 0.03 m/s² the tilt is off by about
7 degrees after one squat and by 10 to 30 after ten.  The small default keeps it below 2 degrees between
squats; during fast and deep ones it still swings by up to 5.
"""

from __future__ import annotations

import math

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.estimators.attitude.quaternion_kernel import run_quaternion_ekf
from baroarma.estimators.attitude.quaternion_matrices import (
    EkfSettings,
    fill_quaternion_noise,
    fill_quaternion_transition,
    fill_turn_covariance,
    fill_up,
    fill_up_jacobian,
    level_quaternion,
)
from baroarma.estimators.attitude.samples import is_sample
from baroarma.estimators.attitude.six_axis import SixAxisFilter
from baroarma.estimators.attitude.vertical import fill_level, normalise, vertical_acceleration
from baroarma.estimators.base import Alignment, AttitudeRun, AttitudeState, Signal


class QuaternionEkf(SixAxisFilter, ExtendedKalmanFilter):
    """Estimate attitude and accelerometer bias; a `filterpy.kalman.ExtendedKalmanFilter` of 7 states.

    Parameters
    ----------
    gyro_noise_sd : float
        sigma_g, rad/s per sample.  Default 1 °/s (printed, Table 1).  Larger: tilt follows the accelerometer
        faster.
    accel_noise_sd : float
        sigma_a, m/s².  Default 10 mg (printed).  Larger: tilt relies longer on the gyro, and less of an
        acceleration is taken for bias.
    bias_walk_sd : float
        Sigma of the bias's driving noise.  Default 5e-4 (printed, as m/s³; Eq. 7 makes it m/s² per root s).
        0: the bias has no noise of its own.
    bias_decay : float
        alpha, 1/s.  Default 0 (printed): the bias is a random walk.
    gate : float
        lambda_g, m/s².  Default 150 mg (printed).  Smaller: less acceleration is taken for tilt, but a large
        error of tilt is never corrected.
    initial_quaternion_sd : float
        Root of P0 for q across q, P0 = sd² (I - q q').  Default 0.01, about 1° of tilt (chosen by us; the
        paper gives none).  Along q there is nothing to be uncertain about: with P0 = sd² I the tilt would
        depend on the mounting, by up to half a degree.
    initial_bias_sd : float
        Root of the diagonal of P0 for b, m/s².  Default 0.001 (chosen by us): see *Weakness* above.

    Examples
    --------
    >>> ekf = QuaternionEkf()
    >>> state = ekf.step(dt=0.02, accel=np.array([0.0, 0.0, 9.9]), gyro=np.zeros(3))
    >>> round(state.acceleration, 3), round(state.acceleration_sd, 3)
    (0.093, 0.098)
    """

    def __init__(
        self,
        *,
        gyro_noise_sd: float = math.radians(1.0),
        accel_noise_sd: float = 0.010 * STANDARD_GRAVITY,
        bias_walk_sd: float = 5e-4,
        bias_decay: float = 0.0,
        gate: float = 0.150 * STANDARD_GRAVITY,
        initial_quaternion_sd: float = 0.01,
        initial_bias_sd: float = 0.001,
    ) -> None:
        ExtendedKalmanFilter.__init__(self, dim_x=7, dim_z=3)
        noise = gyro_noise_sd, accel_noise_sd, bias_walk_sd, bias_decay
        self.settings = EkfSettings(*noise, gate, initial_quaternion_sd, initial_bias_sd)
        self.reset()

    def reset(self, alignment: Alignment | None = None) -> None:
        """Level the quaternion by the alignment; no bias; P0."""
        self._start(alignment)
        self.x = np.zeros(7)
        fill_level(self.x[:4], np.array(self.alignment.up))
        s = self.settings
        self.P = s.initial_bias_sd**2 * np.eye(7)
        fill_turn_covariance(self.P, self.x[:4], s.initial_quaternion_sd)
        self.F, self.Q = np.eye(7), np.zeros((7, 7))
        self.R = s.accel_noise_sd**2 * np.eye(3)
        self.z, self.y, self.K = np.full(3, np.nan), np.zeros(3), np.zeros((7, 3))

    def _loop(self, t: Signal, before: float, accel: Signal, gyro: Signal, out: AttitudeRun) -> None:
        bias, gravity, state = self._gyro_bias, self.alignment.gravity, (self.x, self.P, self.held)
        run_quaternion_ekf(t, before, accel, gyro, bias, gravity, self.settings, *state, *out)

    def _fill(self, dt: float) -> None:
        fill_quaternion_transition(self.F, self.held, dt, self.settings.bias_decay)
        fill_quaternion_noise(self.Q, self.x, self.P, dt, self.settings)

    def _level(self, accel: Signal) -> bool:
        return level_quaternion(self.x, self.P, accel, self.settings.initial_quaternion_sd)

    def _correct(self, accel: Signal) -> None:
        self.update(accel, self._selected_jacobian, self._force, args=(accel,))
        normalise(self.x[:4])

    def _force(self, x: Signal) -> Signal:
        return expected_force(x, self.alignment.gravity)

    def _selected_jacobian(self, x: Signal, accel: Signal) -> Signal:
        """H_a: the rows of H whose innovation stays within the gate, the others 0 [Eqs. 17, 18]."""
        selected = np.abs(accel - self._force(x)) <= self.settings.gate
        return np.where(selected[:, None], measurement_jacobian(x, self.alignment.gravity), 0.0)

    def _state(self, accel: Signal) -> AttitudeState:
        up, J = np.empty(3), np.empty((3, 4))
        fill_up(up, self.x)
        if not is_sample(accel):
            return AttitudeState(up, math.nan, math.nan)
        fill_up_jacobian(J, self.x)
        gravity, noise = self.alignment.gravity, self.settings.accel_noise_sd
        return AttitudeState(up, *vertical_acceleration(accel, up, J, self.P, gravity, noise))


def expected_force(x: Signal, gravity: float) -> Signal:
    """Return h(x) = C^bn(q)(-g^n) + b, the specific force of a body at rest [SG14, Eq. 16].

    Parameters
    ----------
    x : ndarray, shape (7,)
        Quaternion, scalar last, and accelerometer bias in m/s².
    gravity : float
        m/s².

    Returns
    -------
    ndarray, shape (3,)
        m/s², body axes.

    Examples
    --------
    >>> expected_force(np.array([0.0, 0.0, 0.0, 1.0, 0.1, 0.0, 0.0]), 9.8)
    array([0.1, 0. , 9.8])
    """
    up = np.empty(3)
    fill_up(up, x)
    return gravity * up + x[4:]


def measurement_jacobian(x: Signal, gravity: float) -> Signal:
    """Return H = d h/d x, shape (3, 7) [SG14, Eq. 18]; parameters as in `expected_force`.

    Examples
    --------
    >>> measurement_jacobian(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), 10.0)[0]
    array([  0., -20.,   0.,  -0.,   1.,   0.,   0.])
    """
    J = np.empty((3, 4))
    fill_up_jacobian(J, x)
    return np.hstack([gravity * J, np.eye(3)])
