"""A glance at a long recording: some of its rows for a level, its busiest part for what only motion shows.

Checks that run on every log must not cost what the log costs.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.recording import Recording

Signal = NDArray[np.float64]

ENOUGH_ROWS: Final = 1 << 14
"""Rows from which a median is known well enough."""
CHUNK: Final = 256
"""Rows that are taken together, so that no pattern of NaN is met again and again at the same phase."""
BUSIEST_ROWS: Final = 1 << 15
"""Rows of the busiest part: eleven minutes at 50 Hz."""
STRIDE: Final = 64
"""Rows that are taken together where all are looked at."""


def some_rows(n: int) -> NDArray[np.intp]:
    """Return which of n rows to look at: all of them, or evenly spread chunks.

    Examples
    --------
    >>> some_rows(3)
    array([0, 1, 2])
    >>> len(some_rows(10**9))
    16384
    """
    if n <= ENOUGH_ROWS:
        return np.arange(n)
    starts = np.linspace(0, n - CHUNK, ENOUGH_ROWS // CHUNK).astype(np.intp)
    return (starts[:, None] + np.arange(CHUNK)).ravel()


def some_values(signal: NDArray[Any]) -> Signal:
    """Return some of a signal's rows, (n,) or (n, 3), those with NaN left out."""
    some = signal[some_rows(len(signal))]
    good = np.isfinite(some) if some.ndim == 1 else np.isfinite(some).all(axis=1)
    return np.asarray(some[good])


def usual_interval(t: Signal) -> float:
    """Return the median interval of times t, s; 0 for fewer than two."""
    rows = some_rows(len(t) - 1) if len(t) > 1 else np.empty(0, int)
    return float(np.median(t[rows + 1] - t[rows])) if len(rows) else 0.0


def greatest(signal: Signal) -> float:
    """Return the greatest absolute value of a signal, NaN left out; 0 without any."""
    if not signal.size:
        return 0.0
    high, low = (float(extreme.reduce(signal, axis=None)) for extreme in (np.fmax, np.fmin))
    return 0.0 if np.isnan(high) else max(high, -low)


def column_ranges(signal: Signal) -> Signal:
    """Return the greatest and the least value of each column of an (n, 3) signal, (2, 3); NaN left out.

    Examples
    --------
    >>> column_ranges(np.array([[0.0, 5.0, np.nan], [2.0, 3.0, 1.0]])).tolist()
    [[2.0, 5.0, 1.0], [0.0, 3.0, 1.0]]
    """
    whole = len(signal) // STRIDE * STRIDE
    wide = signal[:whole].reshape(-1, STRIDE * 3)  # reducing long rows is ten times as fast as short ones
    ends = []
    for extreme in (np.fmax, np.fmin):
        own = extreme.reduce(wide, axis=0).reshape(STRIDE, 3) if whole else np.empty((0, 3))
        ends.append(extreme.reduce(np.concatenate((own, signal[whole:])), axis=0))
    return np.array(ends)


def busiest_part(recording: Recording) -> Recording:
    """Return the `BUSIEST_ROWS` rows over which the specific force changes most; a short log is all of it.

    The change is that of means over `STRIDE` rows: tilts and rides count, vibration doesn't.
    """
    if recording.accel is None or len(recording) <= BUSIEST_ROWS:
        return recording
    means = np.add.reduceat(recording.accel, np.arange(0, len(recording), STRIDE))[:-1]  # the last is shorter
    change = np.nan_to_num(np.abs(np.diff(means, axis=0)).sum(axis=1))
    total = np.concatenate(([0.0], np.cumsum(change)))
    width = min(BUSIEST_ROWS // STRIDE, len(total) - 1)
    start = int(np.argmax(total[width:] - total[:-width])) * STRIDE
    return recording.rows(slice(start, start + BUSIEST_ROWS))
