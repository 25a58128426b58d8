"""The matrices of `QuaternionEkf`, written into arrays that exist already, for filterpy's predict and update.

Letters are the paper's; the equations stand in `quaternion_ekf`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import inlined, njit
from baroarma.estimators.attitude.samples import has_vertical
from baroarma.estimators.attitude.vertical import fill_level

Array = NDArray[np.float64]
Vector = tuple[float, ...] | Array


class EkfSettings(NamedTuple):
    """Settings of `QuaternionEkf`, in its units."""

    gyro_noise_sd: float
    accel_noise_sd: float
    bias_walk_sd: float
    bias_decay: float
    gate: float
    initial_quaternion_sd: float
    initial_bias_sd: float


@njit(cache=True)
def fill_up(up: Array, q: Vector) -> None:
    """Write the vertical in body axes: the last row of C^nb [SG14, Eq. 23, sign corrected]."""
    up[0], up[1], up[2] = upward(q)


@inlined
def upward(q: Vector) -> Vector:
    """Return what `fill_up` writes."""
    return (
        2.0 * (q[0] * q[2] - q[1] * q[3]),
        2.0 * (q[1] * q[2] + q[0] * q[3]),
        1.0 - 2.0 * (q[0] * q[0] + q[1] * q[1]),
    )


@njit(cache=True)
def fill_up_jacobian(J: Array, q: Array) -> None:
    """Write d up/d q, shape (3, 4): `fill_up` differentiated, SG14 Eq. 18 for g = (0, 0, -1)."""
    for c in range(3):
        for i in range(4):
            J[c, i] = up_gradient(q, c)[i]


@njit(cache=True)
def up_gradient(q: Vector, c: int) -> Vector:
    """Return row c of d up/d q."""
    if c == 0:
        return 2 * q[2], -2 * q[3], 2 * q[0], -2 * q[1]
    if c == 1:
        return 2 * q[3], 2 * q[2], 2 * q[1], 2 * q[0]
    return -4 * q[0], -4 * q[1], 0.0, 0.0


@njit(cache=True)
def fill_turn_covariance(P: Array, q: Array, sd: float) -> None:
    """Write sd² (I - q q') into q's block and 0 beside it: errors that turn q and do not stretch it."""
    P[:4, :] = 0.0
    P[:, :4] = 0.0
    for i in range(4):
        for j in range(4):
            P[i, j] = -sd * sd * q[i] * q[j]
        P[i, i] += sd * sd


@njit(cache=True)
def level_quaternion(x: Array, P: Array, accel: Array, sd: float) -> bool:
    """Level q by this specific force, with P0's `sd`; return False in free fall, which has no vertical.

    A wide covariance would be wrong here: a single component inside the gate could then turn the tilt away.
    """
    if not has_vertical(accel):
        return False
    fill_level(x[:4], accel)
    fill_turn_covariance(P, x[:4], sd)
    return True


@njit(cache=True)
def fill_quaternion_transition(F: Array, held: Array, dt: float, decay: float) -> None:
    """Write F, shape (7, 7), whose other elements are 0 [SG14, Eqs. 3, 5, 8]."""
    p, q, r = held[0], held[1], held[2]
    speed = math.sqrt(p * p + q * q + r * r)
    c = math.cos(speed * dt / 2)
    s = math.sin(speed * dt / 2) / speed if speed > 0 else dt / 2
    F[0, 0], F[0, 1], F[0, 2], F[0, 3] = c, s * r, -s * q, s * p
    F[1, 0], F[1, 1], F[1, 2], F[1, 3] = -s * r, c, s * p, s * q
    F[2, 0], F[2, 1], F[2, 2], F[2, 3] = s * q, -s * p, c, s * r
    F[3, 0], F[3, 1], F[3, 2], F[3, 3] = -s * p, -s * q, -s * r, c
    F[4, 4] = F[5, 5] = F[6, 6] = math.exp(-decay * dt)


@njit(cache=True)
def fill_quaternion_noise(Q: Array, x: Array, P: Array, dt: float, s: EkfSettings) -> None:
    """Write Q, (7, 7), whose other elements are 0, from the last updated x and P [SG14, Eqs. 7, 11, 12]."""
    angle = (s.gyro_noise_sd * dt / 2) ** 2
    trace = 0.0
    for i in range(4):
        trace += x[i] * x[i] + P[i, i]
    for i in range(4):
        for j in range(4):
            Q[i, j] = -(x[i] * x[j] + P[i, j]) * angle
        Q[i, i] += trace * angle
    a = s.bias_decay
    time = -math.expm1(-2 * a * dt) / (2 * a) if a > 0 else dt
    Q[4, 4] = Q[5, 5] = Q[6, 6] = time * s.bias_walk_sd**2
