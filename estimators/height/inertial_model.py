"""The mechanics of `inertial_ekf`, as plain functions of the state.

    state (15,) [up (3), h, v, accelerometer bias (3), its scale error (3), gyro bias (3), baseline]

    up+ = exp(-dt [omega x]) up,  a = f . up - g,  h+ = h + dt v + dt²/2 a,  v+ = v + dt a,
    omega = gyro - bias,  f = (1 + scale)(accel - bias)

`up` is the vertical in body axes: the tilt without the heading, which height doesn't need.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.rotation import skew

Signal = NDArray[np.float64]

STATES: Final = 15
UP: Final = slice(0, 3)
HEIGHT: Final = 3
VELOCITY: Final = 4
ACCEL_BIAS: Final = slice(5, 8)
ACCEL_SCALE: Final = slice(8, 11)
GYRO_BIAS: Final = slice(11, 14)
BASELINE: Final = 14


def specific_force(x: Signal, accel: Signal) -> Signal:
    """Return the specific force in m/s² without the errors in the state, (3,)."""
    return (1 + x[ACCEL_SCALE]) * (accel - x[ACCEL_BIAS])


def resting_accel(x: Signal, gravity: float) -> Signal:
    """Return what the accelerometer reads at rest in this state, m/s², (3,)."""
    return gravity * x[UP] / (1 + x[ACCEL_SCALE]) + x[ACCEL_BIAS]


def move(x: Signal, accel: Signal, gyro: Signal, gravity: float, dt: float) -> Signal:
    """Return the state an interval later.

    Parameters
    ----------
    x : ndarray, shape (15,)
        State.
    accel, gyro : ndarray, shape (3,)
        Samples held over the interval, m/s² and rad/s.
    gravity : float
        m/s².
    dt : float
        Interval, s.
    """
    a = specific_force(x, accel) @ x[UP] - gravity
    new = x.copy()
    new[UP] = rotation(-dt * (gyro - x[GYRO_BIAS])) @ x[UP]
    new[HEIGHT] += dt * x[VELOCITY] + dt**2 / 2 * a
    new[VELOCITY] += dt * a
    return new


def jacobian(x: Signal, accel: Signal, gyro: Signal, dt: float) -> tuple[Signal, Signal, Signal]:
    """Return how `move` depends on the state (15, 15), on the acceleration (15,), on the rate (15, 3)."""
    up, scale = x[UP], 1 + x[ACCEL_SCALE]
    of_acceleration, of_rate = np.zeros(STATES), np.zeros((STATES, 3))
    of_acceleration[[HEIGHT, VELOCITY]] = dt**2 / 2, dt
    phi = -dt * (gyro - x[GYRO_BIAS])
    R = rotation(phi)
    of_rate[UP] = dt * skew(R @ up) @ rotation_jacobian(phi)
    acceleration = np.zeros(STATES)  # how a depends on the state
    acceleration[UP] = specific_force(x, accel)
    acceleration[ACCEL_BIAS] = -scale * up
    acceleration[ACCEL_SCALE] = (accel - x[ACCEL_BIAS]) * up
    F = np.eye(STATES) + np.outer(of_acceleration, acceleration)
    F[HEIGHT, VELOCITY] += dt
    F[UP, UP] = R
    F[UP, GYRO_BIAS] = -of_rate[UP]
    return F, of_acceleration, of_rate


def rotation(phi: Signal) -> Signal:
    """Return exp([phi x]) for a rotation vector in rad (3,), by Rodrigues.

    Examples
    --------
    >>> (rotation(np.array([0.0, 0.0, np.pi / 2])) @ [1.0, 0.0, 0.0]).round(6).tolist()
    [0.0, 1.0, 0.0]
    """
    angle, cross = math.sqrt(phi @ phi), skew(phi)
    return np.eye(3) + np.sinc(angle / np.pi) * cross + np.sinc(angle / 2 / np.pi) ** 2 / 2 * cross @ cross


def rotation_jacobian(phi: Signal) -> Signal:
    """Return the left Jacobian J (3, 3): exp([(phi + d) x]) = exp([(J d) x]) exp([phi x]) for small d."""
    angle, cross = math.sqrt(phi @ phi), skew(phi)
    # (angle - sin angle)/angle³ loses its digits near 0, where its series serves
    cubic = (angle - math.sin(angle)) / angle**3 if angle > 1e-2 else (1 - angle**2 / 20) / 6
    return np.eye(3) + np.sinc(angle / 2 / np.pi) ** 2 / 2 * cross + cubic * cross @ cross
