"""A reported temperature without its reading's noise, and as late as what it warms."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

Signal = NDArray[np.float64]
SMOOTHED: Final = 21
"""Seconds over which the temperature is smoothed, by parabolas; chips warm up in minutes (chosen by us)."""


def lagged(at: Signal, celsius: Signal, lag: float, t: Signal) -> Signal:
    """Return a temperature at other times, smoothed and behind a low-pass filter.

    Parameters
    ----------
    at, celsius : ndarray, shape (n,)
        Times in s and readings in °C.
    lag : float
        Time constant of the filter, s; 0: none.
    t : ndarray, shape (m,)
        Times at which the temperature is wanted, s.

    Examples
    --------
    >>> at = np.arange(0.0, 60.0, 0.5)
    >>> lagged(at, 20 + 0.1 * at, 0.0, np.array([10.0, 30.0])).round(6).tolist()
    [21.0, 23.0]
    """
    from scipy.signal import lfilter, savgol_filter

    seconds, smooth = _each_second(at, celsius)
    # parabolas, so that warming doesn't leak into the quick part: means would leave 0.6 K of 0.25 K/s
    smooth = savgol_filter(smooth, min(SMOOTHED, (len(smooth) - 1) // 2 * 2 + 1), 2)
    if lag:
        share = -math.expm1(-1 / lag)
        smooth = lfilter([share], [1, share - 1], smooth, zi=[(1 - share) * smooth[0]])[0]
    first, last = 1.5 * smooth[0] - 0.5 * smooth[1], 1.5 * smooth[-1] - 0.5 * smooth[-2]
    ends = np.concatenate(([seconds[0] - 0.5], seconds, [seconds[-1] + 0.5]))
    return np.asarray(np.interp(t, ends, np.concatenate(([first], smooth, [last]))))


def _each_second(at: Signal, celsius: Signal) -> tuple[Signal, Signal]:
    """Return the middles of the log's seconds and their mean temperatures, interpolated over gaps."""
    second = np.floor(at - at[0]).astype(int)
    count = np.bincount(second)
    some, middle = np.flatnonzero(count), at[0] + 0.5 + np.arange(len(count))
    time, mean = np.bincount(second, at)[some] / count[some], np.bincount(second, celsius)[some] / count[some]
    return middle, np.interp(middle, time, mean)
