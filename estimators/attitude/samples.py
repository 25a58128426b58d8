"""What is a sample of an IMU, and what to do until the next one comes.

A missing gyro sample is replaced by the last one, for `LONGEST_HOLD` s; then the tilt is lost until the next
specific force gives it anew.  The rate in use and the time since its sample, (4,), are called `held`.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import inlined, njit
from baroarma.estimators.base import LONGEST_HOLD

Array = NDArray[np.float64]
Vector = tuple[float, ...] | Array
MOST_FORCE: Final = 1000.0
"""Specific force, m/s², that is no sample but a broken transfer (chosen by us): 100 g, where such sensors end
at 32."""
LEAST_FORCE: Final = 1.0
"""Specific force, m/s², below which a body falls freely and none points up (chosen by us)."""
LEVELLING_SD: Final = 0.1
"""Error of a tilt that one specific force gives anew, rad (chosen by us): the body may be accelerated by
1 m/s² sideways."""
MOST_RATE: Final = 100.0
"""Angular rate, rad/s, likewise: 5700 °/s, where gyros end at 4000."""


@njit(cache=True)
def is_sample(v: Array) -> bool:
    """Return whether all three components of a specific force are there, and can be."""
    return bool(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] < MOST_FORCE**2)


@njit(cache=True)
def has_vertical(force: Array) -> bool:
    """Return whether a specific force is no free fall's."""
    return bool(force[0] ** 2 + force[1] ** 2 + force[2] ** 2 > LEAST_FORCE**2)


@njit(cache=True)
def is_rate(v: Array) -> bool:
    """Return whether all three components of an angular rate are there, and can be."""
    return bool(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] < MOST_RATE**2)


@njit(cache=True)
def hold_last(rows: Array, last: Array) -> None:
    """Replace rows without a sample, (n, 3), by the row before, the first by `last`; update `last`."""
    for k in range(len(rows)):
        if is_sample(rows[k]):
            last[:] = rows[k]
        else:
            rows[k] = last


@inlined
def forget_rate(held: Vector, dt: float) -> Vector:
    """Return `held`, the rate in use and the time since its sample, `dt` later: too old, it is forgotten."""
    if held[3] + dt <= LONGEST_HOLD:
        return held[0], held[1], held[2], held[3] + dt
    return 0.0, 0.0, 0.0, held[3] + dt


@inlined
def is_lost(held: Vector) -> bool:
    """Return whether the tilt is lost, because the last gyro sample was too old."""
    return held[3] > LONGEST_HOLD


@inlined
def take_rate(held: Vector, gyro: Array, bias: Array) -> Vector:
    """Return `held` with gyro - bias for the next interval, if there is a sample.  A lost tilt stays lost."""
    if not is_rate(gyro):
        return held[0], held[1], held[2], held[3]
    return gyro[0] - bias[0], gyro[1] - bias[1], gyro[2] - bias[2], held[3] if is_lost(held) else 0.0


@inlined
def levelled(held: Vector) -> Vector:
    """Return `held` when the tilt has been found again."""
    return held[0], held[1], held[2], 0.0
