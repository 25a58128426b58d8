"""The preprocessing of the windows method: from raw heights at rest to windows ready for an ARMA fit.

SG13, Sec. 2.5 and Fig. 3: piecewise-constant detrend (1 min) -> M-point moving average (4) -> every D-th
sample (5, T = 0.1 s) -> non-overlapping windows (300) -> one ARMA(1,1) per window -> trimmed mean and SD.

An ARMA model lives on a regular grid and nothing is interpolated here.  An interval between new samples that
differs from the median interval by the tolerated fraction or more is a *gap*; it ends one stretch and
begins the next.  Every stretch is detrended, averaged, decimated and cut on its own, so that no window
contains a gap; what the gaps cost is counted.  Smaller jitter is tolerated, measured and said.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Signal = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class WindowSettings:
    """Hold the settings of the windows method; the defaults are SG13's, for 50 Hz.

    Parameters
    ----------
    detrend_s : float
        Length in s of the blocks whose mean is removed; ``inf`` removes one mean per stretch.  Shorter
        removes more drift, and with it more of the correlated noise.
    average : int
        Points M of the moving average.  More points lower the white noise, but an average longer than the
        decimation leaves its own shape in the ARMA model, which then doesn't fit.
    decimate : int
        Keep every D-th averaged sample.
    window : int
        Samples per window after decimation.  Longer windows give sharper estimates of less stationary data.
    trim : float
        Fraction of the windows left out of the mean, half of it at either end, as MATLAB's ``trimmean``.
    jitter : float
        Deviation of a sampling interval from the median one that makes it a gap, as a fraction of it.
        At one half, the default, a missing or an extra sample is nearer than jitter.

    Raises
    ------
    ValueError
        If a setting cannot work; the message says which and why.

    Examples
    --------
    >>> WindowSettings.for_rate(80).decimate
    8
    """

    detrend_s: float = 60.0
    average: int = 4
    decimate: int = 5
    window: int = 300
    trim: float = 0.10
    jitter: float = 0.5

    def __post_init__(self) -> None:
        if not self.detrend_s > 0:
            raise ValueError(f"detrend_s must be positive, but it is {self.detrend_s} s; inf is one block")
        if min(self.average, self.decimate) < 1:
            raise ValueError(f"average {self.average} and decimate {self.decimate} must be at least 1")
        if self.window < 30:
            raise ValueError(
                f"a window of {self.window} samples is too short for ARMA(1, 1); use at least 30"
            )
        if not 0 <= self.trim < 1:
            raise ValueError(f"trim must be a fraction from 0 to below 1, but it is {self.trim}")
        if not 0 < self.jitter < 1:
            raise ValueError(f"jitter must be a fraction between 0 and 1, but it is {self.jitter}")

    @classmethod
    def for_rate(cls, rate_hz: float, **changes: Any) -> WindowSettings:
        """Return the settings for another sampling rate.

        Decimation goes towards T = 0.1 s, and below 12 Hz nothing is averaged or decimated.  The average
        spans four fifths of the decimation, as 4 does of 5, and is always shorter than it.

        Parameters
        ----------
        rate_hz : float
            Rate of the new samples, Hz.
        **changes
            Settings that shall differ from the defaults so found.
        """
        decimate = 1 if rate_hz < 12 else max(round(rate_hz / 10), 1)
        average = max(min(round(0.8 * decimate), decimate - 1), 1)
        return replace(cls(average=average, decimate=decimate), **changes)


@dataclass(frozen=True, eq=False)
class Conditioned:
    """Hold windows ready for an ARMA fit, and what it took to get them.

    Parameters
    ----------
    windows : ndarray, shape (m, N)
        Detrended, averaged, decimated heights, m.
    start : ndarray, shape (m,)
        Time of each window's first sample, s.
    dt : float
        Interval of the windows' samples, s.
    rate_hz : float
        Rate of the raw samples within the stretches, Hz.
    gaps : int
        Intervals outside the tolerated jitter.
    jitter : float
        RMS deviation of the other intervals from their mean, as a fraction of it.
    skipped : int
        Windows that a gap-free recording of the same duration would have given in addition.
    """

    windows: Signal
    start: Signal
    dt: float
    rate_hz: float
    gaps: int
    jitter: float
    skipped: int


def condition(
    t: ArrayLike,
    height: ArrayLike,
    settings: WindowSettings | None = None,
    *,
    whitening: Callable[[Signal], Signal] | None = None,
) -> Conditioned:
    """Cut a recording at rest into windows for ARMA fits.

    Parameters
    ----------
    t, height : array_like, shape (n,)
        Times in s and heights in m of *new* samples; rows whose height is NaN are left out.
    settings : WindowSettings, optional
        Default: `WindowSettings.for_rate` of the median interval.
    whitening : callable, optional
        A filter for the detrended raw samples, as for whitened surrogates; it starts anew after a gap.

    Raises
    ------
    ValueError
        If the shapes differ, time does not increase or fewer than 2 samples are left.

    Examples
    --------
    >>> t = np.arange(3000) / 50
    >>> cut = condition(t, 0.01 * np.sin(t))
    >>> cut.windows.shape, round(cut.dt, 3), cut.gaps
    ((2, 300), 0.1, 0)
    """
    t, height = new_samples(t, height)
    settings = settings or WindowSettings.for_rate(1 / float(np.median(np.diff(t))))
    interval, jitter = _regular_interval(t, settings.jitter)
    pieces, starts = [np.empty((0, settings.window))], [np.empty(0)]
    parts = stretches(t, settings.jitter)
    for part in parts:
        x = detrend(t[part], height[part], settings.detrend_s)
        x = moving_average(x if whitening is None else whitening(x), settings.average)
        pieces.append(cut(x[:: settings.decimate], settings.window))
        times = t[part][settings.average - 1 :: settings.decimate]
        starts.append(cut(times, settings.window)[:, 0])
    windows = np.concatenate(pieces)
    possible = round((t[-1] - t[0]) / interval) + 2 - settings.average
    possible = -(-possible // settings.decimate) // settings.window
    return Conditioned(
        windows=windows,
        start=np.concatenate(starts),
        dt=interval * settings.decimate,
        rate_hz=1 / interval,
        gaps=len(parts) - 1,
        jitter=jitter,
        skipped=max(possible - len(windows), 0),
    )


def _regular_interval(t: Signal, tolerance: float) -> tuple[float, float]:
    """Mean of the intervals that are no gaps, s, and their RMS deviation from it as a fraction."""
    dt = np.diff(t)
    regular = dt[~_is_gap(dt, tolerance)]
    if not len(regular):
        return float(np.median(dt)), 0.0
    mean = float(regular.mean())
    return mean, float(np.sqrt(np.mean((regular / mean - 1) ** 2)))


def new_samples(t: ArrayLike, height: ArrayLike) -> tuple[Signal, Signal]:
    """Return times and heights without the rows that carry no new sample, checked."""
    times, heights = np.asarray(t, float), np.asarray(height, float)
    if times.ndim != 1 or times.shape != heights.shape:
        raise ValueError(f"t has shape {times.shape} and height {heights.shape}; both must be (n,)")
    new = np.isfinite(heights)
    times, heights = times[new], heights[new]
    if len(times) < 2:
        raise ValueError(f"{len(times)} height samples have no sampling interval; at least 2 are needed")
    if not (np.diff(times) > 0).all():
        raise ValueError("time must increase from sample to sample; sort the samples or drop repeated ones")
    return times, heights


def stretches(t: Signal, jitter: float = 0.5) -> list[slice]:
    """Return the gap-free stretches: runs of intervals nearer to the median one than `jitter`.

    Examples
    --------
    >>> stretches(np.array([0.0, 1.0, 2.1, 5.0, 6.0]))
    [slice(0, 3, None), slice(3, 5, None)]
    """
    edges = np.flatnonzero(_is_gap(np.diff(t), jitter)) + 1
    bounds = [0, *edges.tolist(), len(t)]
    return [slice(a, b) for a, b in pairwise(bounds)]


def _is_gap(dt: Signal, jitter: float) -> NDArray[np.bool_]:
    """True where an interval is off by `jitter` or more; half an interval counts, whatever its rounding."""
    return np.abs(dt / np.median(dt) - 1) > jitter - 1e-9


def detrend(t: Signal, height: Signal, length_s: float = 60.0) -> Signal:
    """Remove the mean of every block of `length_s` seconds, counted from the first sample.

    Examples
    --------
    >>> detrend(np.arange(4.0), np.array([1.0, 3.0, 10.0, 20.0]), 2.0).tolist()
    [-1.0, 1.0, -5.0, 5.0]
    """
    # A sample at a block's edge belongs to the new block, also when its time lost a bit to rounding.
    _, block = np.unique(np.floor((t - t[0]) / length_s + 1e-9), return_inverse=True)
    mean = np.bincount(block, weights=height - height[0]) / np.bincount(block)
    return np.asarray(height - height[0] - mean[block])


def moving_average(x: Signal, points: int) -> Signal:
    """Average each sample with the `points` - 1 before it; (n,) becomes (n - points + 1,).

    Examples
    --------
    >>> moving_average(np.array([1.0, 2.0, 6.0]), 2).tolist()
    [1.5, 4.0]
    """
    if len(x) < points:
        return np.empty(0)
    return np.convolve(x, np.full(points, 1 / points), mode="valid")


def cut(x: Signal, length: int) -> Signal:
    """Cut (n,) into consecutive rows of `length`; an incomplete last row is dropped."""
    rows = len(x) // length
    return x[: rows * length].reshape(rows, length)


class Trimmed(NamedTuple):
    """A trimmed mean over windows and how well it is known."""

    mean: float
    """Mean without the extreme values; NaN without values."""
    sd: float | None
    """SD of the values that were kept [SG13, Tables 1-4]; None with fewer than 3 of them."""
    ci95: tuple[float, float] | None
    """95 % interval of the mean from the scatter over windows; None with fewer than 3 kept values."""
    n: int
    """Number of values, the trimmed ones included."""


def trimmed_mean(values: ArrayLike, trim: float = 0.10) -> Trimmed:
    """Average the finite values without the most extreme ones, as MATLAB's ``trimmean``.

    MATLAB's 10 % leaves out 5 % per end (SciPy's `trim_mean(x, 0.1)` 10 % per end).  The SD is that of the
    kept values, about 0.79 of the plain one.  It would make too short an interval, so the interval uses the
    Winsorised SD: s_w / ((1 - 2k/n) sqrt(n)) is the standard error of a trimmed mean, with Student's t of
    n - 2k - 1 degrees of freedom (Tukey & McLaughlin 1963).

    Examples
    --------
    >>> trimmed_mean([*range(19), 1000.0]).mean
    9.5
    """
    x = np.sort(np.asarray(values, float).ravel())
    x = x[np.isfinite(x)]
    n = len(x)
    if n == 0:
        return Trimmed(math.nan, None, None, 0)
    k = math.ceil(n * trim / 2 - 0.5)  # nearest integer, a half downwards, as MATLAB
    kept = x[k : n - k]
    mean = float(kept.mean())
    if len(kept) < 3:
        return Trimmed(mean, None, None, n)
    from scipy.special import stdtrit

    winsorised = np.clip(x, kept[0], kept[-1]).std(ddof=1)
    half = float(stdtrit(n - 2 * k - 1, 0.975) * winsorised / ((1 - 2 * k / n) * math.sqrt(n)))
    return Trimmed(mean, float(kept.std(ddof=1)), (mean - half, mean + half), n)
