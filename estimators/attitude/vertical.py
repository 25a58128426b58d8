"""A rotation with a given vertical; the acceleration along it, and how well that is known."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import njit
from baroarma.estimators.attitude.samples import is_sample

Array = NDArray[np.float64]
Vector = tuple[float, ...] | Array


@njit(cache=True)
def vertical_acceleration(
    accel: Array, up: Array, jacobian: Array, P: Array, gravity: float, noise_sd: float
) -> tuple[float, float]:
    """Project the specific force on the vertical, without gravity; return it with its sd, m/s².

    a_z = up . f - gravity.  An error of the vertical, d_up = J dx with cov(dx) = P, turns the horizontal
    force f_h = f - (up . f) up into the vertical (it cannot stretch the unit vector), hence

        var(a_z) = f_h' J P J' f_h + noise_sd².

    `jacobian` is (3, m); the leading m x m block of `P` is used.
    """
    along = accel[0] * up[0] + accel[1] * up[1] + accel[2] * up[2]
    m = jacobian.shape[1]
    variance = noise_sd * noise_sd
    for i in range(m):
        for j in range(m):
            variance += (
                _lever(i, accel, along, up, jacobian) * P[i, j] * _lever(j, accel, along, up, jacobian)
            )
    return along - gravity, math.sqrt(max(variance, 0.0))


@njit(cache=True)
def _lever(i: int, accel: Array, along: float, up: Array, jacobian: Array) -> float:
    """Component i of J' f_h."""
    total = 0.0
    for c in range(3):
        total += jacobian[c, i] * (accel[c] - along * up[c])
    return total


@njit(cache=True)
def project(
    accel: Array, ups: Array, P: Array, gravity: float, noise_sd: float, vertical: Array, vertical_sd: Array
) -> None:
    """Fill the last two from given verticals, (n, 3), that have the covariance `P`, (3, 3)."""
    J = np.eye(3)
    for k in range(len(ups)):
        vertical[k] = vertical_sd[k] = math.nan
        if is_sample(accel[k]):
            vertical[k], vertical_sd[k] = vertical_acceleration(accel[k], ups[k], J, P, gravity, noise_sd)


@njit(cache=True)
def normalise(v: Array) -> None:
    """Give the vector unit length, in place [SG14, Eq. 21]."""
    square = 0.0
    for c in v:
        square += c * c
    norm = math.sqrt(square)
    for i in range(len(v)):
        v[i] /= norm


@njit(cache=True)
def fill_level(q: Array, up: Vector) -> None:
    """Write the shortest rotation that has this vertical, of any length; upside down it is a turn about x."""
    horizontal = math.hypot(up[0], up[1])
    half = math.atan2(horizontal, up[2]) / 2
    q[:] = 0.0
    q[3] = math.cos(half)
    if horizontal > 0:
        q[0] = math.sin(half) * up[1] / horizontal
        q[1] = -math.sin(half) * up[0] / horizontal
    else:
        q[0] = math.sin(half)
