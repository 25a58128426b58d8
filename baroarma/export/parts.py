"""The parts that firmware is put together from: for each estimator in Python its counterpart in C.

A part is a few files of `c_source`, in order, and the constants that they read, taken from the estimator
object itself.  Every attitude is a structure ``baroarma_attitude`` with the functions

    attitude_start(s, rest)      attitude_step(s, dt, accel, gyro, up) -> vertical acceleration; fills `up`,

every conditioning a ``baroarma_conditioning`` with ``conditioning_start(s)``, ``conditioning_step(s, z)`` and
``conditioning_shift(s, zero)``, every height a ``baroarma_height`` with

    height_start(s, rest)
    height_step(s, dt, altitude, acceleration, acceleration_sd, up, still)
    height_tell(s, result)                                   fills height, velocity and their sds,

where ``rest`` is what the alignment has told and ``still`` whether the IMU feels nothing.  With the
height come two structures that only a filter that listens to rests fills with life (`no_rest` for the
others): what the alignment remembers for it, ``baroarma_early``, and what the IMU feels,
``baroarma_stillness``, with

    early_start(s)      early_take(s, dt, altitude)      height_look_back(height, early, dt)
    stillness_start(s, rest)      stillness_step(s, dt, accel, gyro) -> acceleration sd or NaN
    is_still(s).

A new estimator is: its C, and its line in one of the tables below.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from baroarma.estimators.conditioning import AVERAGE
from baroarma.export import attitude_numbers, height_numbers
from baroarma.export.c_text import Number, Numbers


@dataclass(frozen=True)
class Part:
    """Hold what the exported source needs for one estimator.

    Parameters
    ----------
    files : tuple of str
        Names in `c_source`, without suffix; a header, a source or both exist for each.  One that several
        parts name is taken once.
    numbers : callable
        Returns the constants of an estimator object.
    lacks : callable
        Says which setting of an estimator object has no counterpart in C; empty: all have.
    """

    files: tuple[str, ...]
    numbers: Callable[[Any], Numbers]
    lacks: Callable[[Any], str] = lambda estimator: ""


def _nothing(conditioner: Any) -> Numbers:
    return ()


def _average(conditioner: Any) -> Numbers:
    return (Number("AVERAGE", AVERAGE, "points of the moving average"),)


def _whitening(conditioner: Any) -> Numbers:
    w = conditioner.whitening
    (b0, b1), (_, a1) = (*w.b, 0.0)[:2], (*w.a, 0.0)[:2]
    return (
        *_average(conditioner),
        Number("B0", float(b0), f"of the whitening filter at {w.rate_hz:g} Hz"),
        Number("B1", float(b1), "likewise"),
        Number("A1", float(a1), "likewise"),
        Number("DC_GAIN", float(w.dc_gain), "what it makes of a steady height change"),
    )


def _complementary_lacks(height: Any) -> str:
    return "slow_barometer='hold'" if height.slow_barometer == "hold" else ""


ATTITUDES: Final[Mapping[str, Part]] = {
    "tilt-kalman": Part(("imu", "tilt_kalman"), attitude_numbers.tilt_kalman),
    "quaternion-ekf": Part(("decay", "level", "imu", "quaternion_ekf"), attitude_numbers.quaternion_ekf),
    "robust": Part(("level", "robust"), attitude_numbers.robust),
}
"""Attitude estimators that have a counterpart in C."""
CONDITIONINGS: Final[Mapping[str, Part]] = {
    "none": Part(("no_conditioning",), _nothing),
    "average": Part(("average",), _average),
    "average+whitening": Part(("whitening",), _whitening),
}
"""Conditionings that have one."""
HEIGHTS: Final[Mapping[str, Part]] = {
    "complementary": Part(
        ("decay", "climb", "drive", "complementary", "no_rest"),
        height_numbers.complementary,
        _complementary_lacks,
    ),
    "kalman": Part(("climb", "drive", "linear", "kalman", "no_rest"), height_numbers.kalman),
    "coloured-kalman": Part(
        ("decay", "climb", "drive", "linear", "coloured_kalman", "bank", "look_back", "stillness"),
        height_numbers.coloured_kalman,
    ),
}
"""Height estimators that have one."""
