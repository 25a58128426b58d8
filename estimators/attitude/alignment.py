"""Rest alignment: what the first second says about tilt, gyro bias and gravity.

All papers start from a short rest [SG14, Sec. 2.3.4].  A resting accelerometer measures -g, which points up
whatever its axes are called; a resting gyro measures its bias.  The mean modulus of the specific force stands
for gravity, so that an accelerometer with a scale error still reads no vertical acceleration at rest.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.estimators.attitude.samples import MOST_FORCE, MOST_RATE
from baroarma.estimators.base import Alignment

ENOUGH: Final = 8
"""Samples from which a sd is told, to a quarter of it or so with three axes (chosen by us)."""

PARTS: Final = 4
"""Parts of equal length of the alignment, whose means are compared (chosen by us)."""


def align(t: ArrayLike, accel: ArrayLike, gyro: ArrayLike, *, duration: float = 1.0) -> Alignment:
    """Average the rest at the start of a recording.

    Parameters
    ----------
    t : array_like, shape (n,)
        Time in s.
    accel, gyro : array_like, shape (n, 3)
        Specific force in m/s² and angular rate in rad/s; rows with NaN are left out.
    duration : float
        The samples with t - t[0] < `duration` (s) are averaged.  Longer: less noise, but the sensor must
        really rest as long.

    Returns
    -------
    Alignment
        Tilt, gyro bias, gravity and the noise of accelerometer and gyro.

    Raises
    ------
    ValueError
        If there is no sample to average, or no gravity in it.

    Examples
    --------
    >>> start = align([0.0, 0.5, 1.0], [[0, 0, 9.7], [0, 0, 9.9], [5, 5, 5]], [[0.01, 0, 0]] * 3)
    >>> start.up, start.gyro_bias[0], round(start.gravity, 6)
    ((0.0, 0.0, 1.0), 0.01, 9.8)
    """
    t = np.asarray(t, float)
    early = t - t[:1] < duration
    part = np.floor((t[early] - t[:1]) / duration * PARTS + 1e-6)  # a clock's rounding decides nothing
    force, force_part = _samples("accelerometer", accel, MOST_FORCE, early, part, duration)
    rate, rate_part = _samples("gyro", gyro, MOST_RATE, early, part, duration)
    mean = force.mean(axis=0)
    modulus = float(np.linalg.norm(mean))
    if modulus < STANDARD_GRAVITY / 2:
        raise ValueError(
            f"the mean specific force of the first {duration:g} s is {modulus:.3g} m/s², where rest gives "
            "about 9.8; the accelerometer must be in m/s² and at rest, with gravity not removed"
        )
    return Alignment(
        up=_triple(mean / modulus),
        gyro_bias=_triple(rate.mean(axis=0)),
        gravity=float(np.linalg.norm(force, axis=1).mean()),
        accel_sd=_sample_sd(force),
        gyro_sd=_sample_sd(rate),
        gravity_sd=_mean_sd(np.linalg.norm(force, axis=1)[:, None], force_part),
        gyro_bias_sd=_mean_sd(rate, rate_part),
    )


def _mean_sd(rows: NDArray[np.float64], part: NDArray[np.float64]) -> float:
    """Return the sd of each column's mean, from how the means of parts differ; NaN if it can't be told."""
    means = np.array([rows[part == number].mean(axis=0) for number in np.unique(part)])
    if len(rows) < ENOUGH or len(means) < PARTS:
        return math.nan
    return float(np.sqrt(means.var(axis=0, ddof=1).mean() / PARTS))


def _sample_sd(rows: NDArray[np.float64]) -> float:
    """Return the sd of one sample and axis about the mean, NaN if it can't be told."""
    if len(rows) < ENOUGH:
        return math.nan
    return float(np.sqrt(rows.var(axis=0, ddof=1).mean()))


def _samples(
    sensor: str,
    values: ArrayLike,
    most: float,
    early: NDArray[np.bool_],
    part: NDArray[np.float64],
    duration: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the rows with a sample, and the part of the alignment that each lies in."""
    rows: NDArray[np.float64] = np.asarray(values, float)[early]
    with np.errstate(over="ignore", invalid="ignore"):
        there = np.sum(rows**2, axis=1) < most**2
    if not there.any():
        raise ValueError(
            f"there is no {sensor} sample in the first {duration:g} s; align over a longer duration or cut "
            "the recording to where the sensor starts"
        )
    return rows[there], part[there]


def _triple(v: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(v[0]), float(v[1]), float(v[2])
