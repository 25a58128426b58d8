"""The numbers behind the plots: autocovariance, spectrum and cumulative periodogram of a height record.

They are for looking, not for fitting; a plot applies each to the data and, where it needs a band, to
simulations of the model at the same times, so that both are treated alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Signal = NDArray[np.float64]

ENOUGH: Final = 1000
"""Samples of a regular stretch that suffice for a spectrum."""
HANN_NEIGHBOURS: Final = (4 / 9, 1 / 36)
"""Squared correlation of periodogram ordinates that lie one and two apart, after a Hann taper."""


def without_levels(t: Signal, height: Signal, length_s: float) -> Signal:
    """Remove the mean of each of equal blocks of about `length_s` seconds.

    Examples
    --------
    >>> without_levels(np.arange(4.0), np.array([1.0, 3.0, 10.0, 20.0]), 2.0).tolist()
    [-1.0, 1.0, -5.0, 5.0]
    """
    duration = t[-1] - t[0]
    count = max(1, round(duration / length_s))
    first = np.unique(np.searchsorted(t, t[0] + duration * np.arange(count) / count))
    sizes = np.diff(first, append=len(t))
    means = np.add.reduceat(height - height[0], first) / sizes
    return np.asarray(height - height[0] - np.repeat(means, sizes))


def autocovariance(t: Signal, x: Signal, dt: float, lags: int) -> Signal:
    """Estimate the autocovariance at 0 ... `lags` times `dt`: mean product of the pairs that far apart.

    Each sample goes to the nearest point of a grid of step `dt`; points without a sample take no part, so
    that gaps cost pairs and nothing else.

    Parameters
    ----------
    t, x : ndarray, shape (n,)
        Times in s and values in m without level.
    dt : float
        Step of the grid, s.
    lags : int
        Largest lag in steps.

    Returns
    -------
    ndarray, shape (lags + 1,)
        Autocovariance in m²; NaN at a lag that no pair has.

    Examples
    --------
    >>> autocovariance(np.array([0.0, 1.0, 3.0]), np.array([1.0, 2.0, -1.0]), 1.0, 2).round(9).tolist()
    [2.0, 2.0, -2.0]
    """
    cell = np.rint((t - t[0]) / dt).astype(int)
    size = 1 << int(cell[-1] + lags).bit_length()
    grid, present = np.zeros((2, size))
    grid[cell], present[cell] = x, 1.0
    products, pairs = (np.fft.irfft(np.abs(np.fft.rfft(v)) ** 2)[: lags + 1] for v in (grid, present))
    pairs = np.rint(pairs)
    return np.asarray(np.where(pairs > 0, products, np.nan) / np.maximum(pairs, 1))


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Hold a spectrum averaged over logarithmic bins, with its 95 % band; arrays of shape (k,).

    Parameters
    ----------
    frequency : ndarray
        Geometric mean frequency of each bin, Hz.
    density, low, high : ndarray
        One-sided power spectral density and the ends of its band, m²/Hz.
    rate_hz : float
        Mean rate of the samples used, Hz.
    duration : float
        Their length, s.
    regular : bool
        Whether they are a gap-free stretch of regular samples (else: all, at the times they have).
    """

    frequency: Signal
    density: Signal
    low: Signal
    high: Signal
    rate_hz: float
    duration: float
    regular: bool


def spectrum(t: Signal, height: Signal, *, per_decade: int = 10) -> Spectrum:
    """Estimate the spectrum of a height record from one Hann-tapered periodogram.

    The taper (and a straight line removed before) keeps drift from leaking into high frequencies.  A log
    whose longest gap-free stretch has fewer than `ENOUGH` samples, and not half of all, is taken as a whole:
    the Fourier sums are then evaluated at the times as they are, at up to 8 frequencies per bin.  Uneven
    times spread some power of slow noise evenly over all frequencies; the fast end then lies a little high.

    Parameters
    ----------
    t, height : ndarray, shape (n,)
        Times in s and heights in m.
    per_decade : int
        Bins per decade; fewer are smoother.

    Returns
    -------
    Spectrum
        From two cycles per record to half the mean rate.
    """
    from baroarma.identification.preprocessing import stretches

    longest = max(stretches(t), key=lambda s: s.stop - s.start)
    size = longest.stop - longest.start
    regular = size >= min(ENOUGH, len(t) / 2)
    if regular:
        t, height = t[longest], height[longest]
    x = (height - np.polyval(np.polyfit(t - t[0], height, 1), t - t[0])) * _hann(t)
    n, duration = len(t), float(t[-1] - t[0])
    rate = (n - 1) / duration
    scale = 2 / (rate * float(np.sum(_hann(t) ** 2)))
    if regular:
        frequency = np.arange(2, n // 2) * rate / n
        density = scale * np.abs(np.fft.rfft(x)[2 : n // 2]) ** 2
    else:
        frequency = _some_of_each(np.arange(2, n // 2, 2) / duration, per_decade)
        sums = [np.sum(x * np.exp(-2j * np.pi * f * (t - t[0]))) for f in frequency]
        density = scale * np.abs(np.array(sums)) ** 2
    bands = _binned(frequency, density, per_decade, regular)
    return Spectrum(bands[0], bands[1], bands[2], bands[3], rate, duration, regular)


def cumulative_periodogram(x: Signal) -> tuple[Signal, Signal]:
    """Return frequencies (cycles per sample) and how far the cumulative periodogram lies off the diagonal.

    The largest distance is the statistic of Bartlett's test (`cumulative_periodogram_test`).
    """
    q = (len(x) - 1) // 2
    cumulated = np.cumsum(np.abs(np.fft.rfft(x - x.mean())[1 : q + 1]) ** 2)
    line = np.arange(1, q + 1) / q
    return np.arange(1, q + 1) / len(x), cumulated / cumulated[-1] - line


def _hann(t: Signal) -> Signal:
    return np.asarray(np.sin(np.pi * (t - t[0]) / (t[-1] - t[0])) ** 2)


def _bin_starts(frequency: Signal, per_decade: int) -> NDArray[np.intp]:
    """Indices at which a new logarithmic bin begins."""
    return np.unique(np.floor(per_decade * np.log10(frequency)), return_index=True)[1]


def _some_of_each(frequency: Signal, per_decade: int, most: int = 8) -> Signal:
    parts = np.split(frequency, _bin_starts(frequency, per_decade)[1:])
    return np.concatenate([part[:: -(-len(part) // most)] for part in parts])


def _binned(frequency: Signal, density: Signal, per_decade: int, neighbours: bool) -> tuple[Signal, ...]:
    """Average over bins; the band is chi-square's, with the freedom that neighbouring ordinates leave."""
    from scipy.special import chdtri

    first = _bin_starts(frequency, per_decade)
    m = np.diff(first, append=len(frequency))
    mean = np.add.reduceat(density, first) / m
    centre = np.exp(np.add.reduceat(np.log(frequency), first) / m)
    excess = sum(2 * r * np.maximum(1 - k / m, 0) for k, r in enumerate(HANN_NEIGHBOURS, 1))
    freedom = 2 * m / (1 + excess * neighbours)
    return (
        centre,
        mean,
        mean * freedom / chdtri(freedom, 0.025),
        mean * freedom / chdtri(freedom, 0.975),
    )
