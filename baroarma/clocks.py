"""Two clocks: by how much one recording is ahead of another, from the weather that both barometers saw.

The slow parts of both (means over half a second, less what takes a minute) are correlated at all lags; the
best one counts if the correlation is beyond chance.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.recording import Recording

Signal = NDArray[np.float64]
STEP: Final = 0.5
"""Both records are averaged over so many seconds before they are compared (chosen by us)."""
SLOW: Final = 60.0
"""What is slower than so many seconds is removed before clocks are aligned: a trend fits at any lag."""
LONGEST_LAG: Final = 30.0
"""Clocks further apart, s, are the user's to align."""
SHORTEST: Final = 120.0
"""A shorter overlap, s, says nothing about the clocks."""
CHANCE: Final = 4.0
"""A correlation below so many of its sds by chance is none: the best of some hundred lags reaches 3."""
ENOUGH_CORRELATION: Final = 0.5
"""Below it noise moves the best lag by more than its sd says (in simulation, from 0.3 downwards)."""


class Lag(NamedTuple):
    """By how much the reference's clock is ahead, its sd, s, and the correlation found there."""

    seconds: float
    sd: float
    correlation: float


def find_lag(recording: Recording, reference: Recording) -> Lag | None:
    """Find by how much the reference's clock is ahead, from the weather that both barometers saw.

    The sd follows from how differently blocks of the records pull at the lag.

    Parameters
    ----------
    recording, reference : Recording
        Of two barometers; the first may move as long as the weather shows.

    Returns
    -------
    Lag or None
        With an infinite sd when they do not correlate; None when they overlap for less than `SHORTEST` s.
    """
    (t1, x1), (t2, x2) = pressure_samples(recording), pressure_samples(reference)
    start, stop = max(t1[0], t2[0]), min(t1[-1], t2[-1])
    if stop - start < SHORTEST:
        return None
    a, b = (_slow_part(t, x, start, stop) for t, x in ((t1, x1), (t2, x2)))
    reach = round(LONGEST_LAG / STEP)
    scores = np.array([_correlation(*_shifted(a, b, k)) for k in range(-reach, reach + 1)])
    best = int(np.argmax(scores))
    k, fraction = best - reach, _top(scores[max(best - 1, 0) : best + 2])
    a, b = _shifted(a, b, k)
    correlated = scores[best] > max(ENOUGH_CORRELATION, CHANCE * _chance(a, b))
    sd = _lag_sd(a, b) if correlated and 0 < best < 2 * reach else math.inf
    return Lag(STEP * (k + fraction), sd, float(scores[best]))


def pressure_samples(recording: Recording) -> tuple[Signal, Signal]:
    """Return times, s, and heights, m, of the barometer's new samples.

    Raises
    ------
    ValueError
        If there are fewer than 2.
    """
    new = recording.is_new
    if int(new.sum()) < 2:
        raise ValueError(f"{recording.name or 'the recording'} has fewer than 2 pressure samples to compare")
    return recording.t[new], recording.height()[new]


def binned_means(t: Signal, x: Signal, start: float, stop: float, step: float) -> Signal:
    """Return means over bins of `step` s from start to stop, at the middle of each bin."""
    count = int((stop - start) / step)
    which = np.floor((t - start) / step).astype(int)
    inside = (which >= 0) & (which < count)
    sizes, times, sums = (
        np.bincount(which[inside], w, minlength=count) for w in (None, t[inside] - start, x[inside])
    )
    full = sizes > 0  # the samples of a bin may lie before its middle on average: interpolate
    middles = step * (np.arange(count) + 0.5)
    return np.asarray(np.interp(middles, times[full] / sizes[full], sums[full] / sizes[full]))


def _slow_part(t: Signal, x: Signal, start: float, stop: float) -> Signal:
    """Means over `STEP`, less their own mean over `SLOW` around."""
    m = binned_means(t, x, start, stop, STEP)
    window = np.ones(min(round(SLOW / STEP), len(m)))
    return np.asarray(m - np.convolve(m, window, "same") / np.convolve(np.ones(len(m)), window, "same"))


def _shifted(a: Signal, b: Signal, k: int) -> tuple[Signal, Signal]:
    """Return a[i] beside b[i + k]."""
    n = len(a) - abs(k)
    return a[max(-k, 0) :][:n], b[max(k, 0) :][:n]


def _correlation(a: Signal, b: Signal) -> float:
    a, b = a - a.mean(), b - b.mean()
    size = math.sqrt(float(a @ a) * float(b @ b))
    return float(a @ b) / size if size else 0.0


def _chance(a: Signal, b: Signal) -> float:
    """Sd of the correlation of unrelated signals as slow as these: sqrt(sum of r_a r_b / n) [Bartlett]."""
    n = len(a)
    spectra = [np.abs(np.fft.rfft(x - x.mean(), 2 * n)) ** 2 for x in (a, b)]
    r_a, r_b = (np.fft.irfft(s)[: n // 4] / max(np.fft.irfft(s)[0], 1e-300) for s in spectra)
    return math.sqrt(max(1 + 2 * float(r_a[1:] @ r_b[1:]), 1.0) / n)


def _top(values: Signal) -> float:
    """Where the parabola through three values has its top, in steps from the middle."""
    if len(values) < 3:
        return 0.0
    bend = values[0] - 2 * values[1] + values[2]
    return float((values[0] - values[2]) / (2 * bend)) if bend < 0 else 0.0


def _lag_sd(a: Signal, b: Signal) -> float:
    """Sd of the lag, s: blocks of 10 s pull by sum of x' (a - b), against the stiffness sum of a' b'."""
    slope_a, slope_b = np.gradient(a, STEP), np.gradient(b, STEP)
    stiffness = float(slope_a @ slope_b)
    pull = (slope_a + slope_b) / 2 * (a - b)
    block = round(10 / STEP)
    pulls = pull[: len(pull) // block * block].reshape(-1, block).sum(axis=1)
    return math.sqrt(float(pulls @ pulls)) / stiffness if stiffness > 0 else math.inf
