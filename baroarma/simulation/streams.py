"""How a sensor's samples get into a log: its clock, its rate, its low-pass filter, the logger that asks it.

A log has one column of times.  A sensor samples by its own clock and rate, and at each row the logger takes
what it finds: a new sample, or the one that it already had, which is then repeated ("held") or left out
(NaN).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil
from typing import Final

import numpy as np
from numpy.typing import NDArray

Signal = NDArray[np.float64]
OVERSAMPLING: Final = 10
"""The truth before a low-pass filter is computed this often per sample and per cycle of the cut-off."""
SAME_TIME: Final = 1e-9
"""Times closer than this, s, are the same: rows and samples at commensurable rates differ by rounding."""


@dataclass(frozen=True)
class Clock:
    """Describe a sensor's clock against the log's.

    Parameters
    ----------
    offset : float
        A sample that the log dates t was really taken at ``t (1 + skew) + offset``; s.
    skew : float
        How much faster true time runs than the stamps, 1 (50e-6: 50 ppm).

    Examples
    --------
    >>> float(Clock(offset=0.5, skew=0.25).true_time(100.0))
    125.5
    """

    offset: float = 0.0
    skew: float = 0.0

    def true_time(self, stamp: Signal | float) -> Signal:
        """Return the true time of what the log dates `stamp`, s."""
        return np.asarray(stamp, float) * (1 + self.skew) + self.offset


def sample_times(t: Signal, rate_hz: float | None) -> Signal:
    """Return when a sensor samples during a log with rows at t (n,), log's stamps in s; None: at each row."""
    if rate_hz is None:
        return t
    if not (np.isfinite(rate_hz) and rate_hz > 0):
        raise ValueError(
            f"a sensor's rate_hz must be above 0, but it is {rate_hz}; None means the log's rate"
        )
    return np.asarray(t[0] + np.arange(int((t[-1] - t[0] + SAME_TIME) * rate_hz) + 1) / rate_hz)


def poll(t: Signal, stamps: Signal, values: Signal, held: bool) -> Signal:
    """Return what a logger writes at rows t (n,) of samples taken at `stamps` (m,).

    Parameters
    ----------
    t, stamps : ndarray, shape (n,) and (m,)
        Rows and samples, s; the first sample is not later than the first row.
    values : ndarray, shape (m,) or (m, k)
        The samples.
    held : bool
        Whether a row without a new sample repeats the last one; else it is NaN.

    Examples
    --------
    >>> poll(np.arange(4.0), np.array([0.0, 2.0]), np.array([7.0, 9.0]), held=False)
    array([ 7., nan,  9., nan])
    """
    latest = np.searchsorted(stamps, t + SAME_TIME, side="right") - 1
    logged = values[latest]
    if not held:
        logged[np.flatnonzero(np.diff(latest, prepend=-1) == 0)] = np.nan
    return logged


def low_passed(
    at: Callable[[Signal], Signal], stamps: Signal, clock: Clock, bandwidth_hz: float | None, order: int
) -> Signal:
    """Return a true signal at a sensor's samples, through its Butterworth low-pass filter.

    The truth is computed at `OVERSAMPLING` times the sensor's rate or its cut-off, whichever is more,
    filtered there by the bilinear transform (exact at the cut-off), and thinned out.

    Parameters
    ----------
    at : callable
        The truth, (m,) or (m, k), at true times (m,).
    stamps : ndarray, shape (n,)
        Evenly spaced times of the samples, by the log's stamps.
    clock : Clock
        From stamps to true times.
    bandwidth_hz : float or None
        Frequency where the filter has lost 3 dB; None: no filter.
    order : int
        1 or 2.
    """
    if bandwidth_hz is None or len(stamps) < 2:
        return at(clock.true_time(stamps))
    from scipy.signal import butter, sosfilt, sosfilt_zi

    step = float(stamps[-1] - stamps[0]) / (len(stamps) - 1)
    times = max(OVERSAMPLING, ceil(OVERSAMPLING * bandwidth_hz * step))
    fine = stamps[0] + np.arange((len(stamps) - 1) * times + 1) * (step / times)
    truth = at(clock.true_time(fine))
    sections = butter(order, bandwidth_hz, fs=times / step, output="sos")
    rest = np.multiply.outer(sosfilt_zi(sections), truth[0])
    return np.asarray(sosfilt(sections, truth, axis=0, zi=rest)[0][::times])
