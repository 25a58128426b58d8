"""Differential barometry: a second barometer that stays where it is tells the weather from the motion.

Both barometers see the weather w, each has its own noise n; the first one moves:

    h_1(t) = h(t) + w(t) + n_1(t),   h_2(t) = w(t) + n_2(t),   h_1 - h_2 = h + n_1 - n_2.

The clocks are aligned first: the lag at which the slow parts of both correlate best.  The difference would
have the noise of both, so the reference is smoothed by the kernel exp(-|s|/T)/(2T) with T = sqrt(S)/q, where
S is the density of its noise and q the weather's drift: Wiener's smoother of a random walk in white noise.
What it adds to the difference has the variance S/(4T) + q² T/4, of noise and of weather smoothed away.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import altitude_pressure
from baroarma.finding import Finding
from baroarma.noise_model import NoiseModel
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
WORST_LAG_SD: Final = 1.0
"""A lag less certain than this, s, is not worth correcting for."""
LONGEST_SMOOTHING: Final = 60.0
"""Largest T, s."""


class Lag(NamedTuple):
    """By how much the reference's clock is ahead, its sd, s, and the correlation found there."""

    seconds: float
    sd: float
    correlation: float


def relative_to(recording: Recording, reference: Recording, *, lag: float | None = None) -> Recording:
    """Subtract what a stationary barometer saw meanwhile, as heights.

    Parameters
    ----------
    recording : Recording
        Of the barometer that moves.
    reference : Recording
        Of the one that does not.
    lag : float, optional
        How much the reference's clock is ahead, s: what the recording calls t, it calls t + lag.  Default:
        by correlation, or 0 if the records do not tell.

    Returns
    -------
    Recording
        At the level it had, with the pressure that it would have read in constant weather; NaN where the
        reference has no sample.  `notes` gain "clocks" and "difference-noise".

    Raises
    ------
    ValueError
        If the recordings do not overlap.

    Examples
    --------
    >>> t = np.arange(0, 300, 0.1)
    >>> weather = altitude_pressure(100 + np.cumsum(np.random.default_rng(1).normal(0, 0.02, 3000)))
    >>> moving, still = Recording(t=t, pressure=weather), Recording(t=t, pressure=weather)
    >>> float(np.ptp(moving.height())) > 1, float(np.ptp(moving.relative_to(still).height())) < 0.05
    (True, True)
    """
    clock, how = _clock(recording, reference, lag)
    own_t, own = _samples(reference)
    noise = _weather(own_t, own)
    slow = _smoothed(own_t, own, noise.smoothing)
    change = np.interp(recording.t + clock, own_t, slow - slow[0], left=np.nan, right=np.nan)
    if not np.isfinite(change[recording.is_new]).any():
        raise ValueError(
            f"{recording.name or 'the recording'} ({recording.t[0]:.6g} to {recording.t[-1]:.6g} s) and "
            f"{reference.name or 'the reference'} ({own_t[0]:.6g} to {own_t[-1]:.6g} s) do not overlap; put "
            "both on one clock"
        )
    height = recording.height()
    both = np.isfinite(height) & np.isfinite(change)
    height -= change - change[both][0]
    return replace(
        recording,
        pressure=altitude_pressure(height),
        notes=(*recording.notes, how, _about_noise(recording, noise)),
    )


def find_lag(recording: Recording, reference: Recording) -> Lag | None:
    """Find by how much the reference's clock is ahead, from the weather that both barometers saw.

    The sd follows from how differently blocks of the records pull at the lag.

    Returns
    -------
    Lag or None
        With an infinite sd when they do not correlate; None when they overlap for less than `SHORTEST` s.
    """
    (t1, x1), (t2, x2) = _samples(recording), _samples(reference)
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


def difference_noise(noise: NoiseModel, reference: NoiseModel, *, smoothing: float = 0.0) -> NoiseModel:
    """Return the noise of the difference of two barometers that see the same weather.

    Parameters
    ----------
    noise, reference : NoiseModel
        Of the barometer that moves and of the other one, each identified at rest.
    smoothing : float
        T of the reference's smoother, s (the note "difference-noise" says it); 0: none.

    Returns
    -------
    NoiseModel
        At the first one's rate.  Correlated parts become one Gauss-Markov component of the same variance and
        the same density at frequency 0.  Of the two drifts only the excess of one over the other stays: what
        they share is taken for weather.
    """
    white = noise.white_density
    parts = [(noise.correlated_sd**2, noise.correlation_time)]
    if smoothing:
        parts.append((reference.white_density / (4 * smoothing), 2 * smoothing))
        parts.append((min(noise.drift_rate, reference.drift_rate) ** 2 * smoothing / 4, smoothing))
    else:
        white += reference.white_density
    if reference.has_gauss_markov:
        variance, tau = reference.correlated_sd**2, reference.correlation_time
        left = variance * tau * (2 * tau + smoothing) / (2 * (tau + smoothing) ** 2)
        parts.append((left, variance * tau / left))
    variance = sum(part for part, _ in parts)
    tau = sum(part * time for part, time in parts) / variance if variance else 0.0
    drift = math.sqrt(abs(noise.drift_rate**2 - reference.drift_rate**2))
    white_sd = math.sqrt(white * noise.rate_hz)
    return NoiseModel(math.sqrt(variance), tau, white_sd, drift, rate_hz=noise.rate_hz)


class _Weather(NamedTuple):
    """The reference's own noise and the weather: density S, m²/Hz, drift q, m/sqrt(s), smoothing T, s."""

    density: float
    drift: float
    smoothing: float

    @property
    def added_sd(self) -> float:
        """Sd of what the smoothed reference adds to the difference, m."""
        if self.smoothing == 0:
            return 0.0
        return math.sqrt(self.density / (4 * self.smoothing) + self.drift**2 * self.smoothing / 4)


def _weather(t: Signal, x: Signal) -> _Weather:
    """Measure S and q: the means m over d = 1 s have E(m_{i+k} - m_i)² = 2 S/d + q² d (k - 1/3)."""
    d, far = 1.0, 8
    m = _means(t, x, t[0], t[-1], d)
    if len(m) <= far + 1:
        return _Weather(0.0, 0.0, 0.0)
    near_change, far_change = (float(np.mean((m[k:] - m[:-k]) ** 2)) for k in (1, far))
    drift = max(far_change - near_change, 0.0) / (d * (far - 1))
    density = max(near_change - drift * d * 2 / 3, 0.0) * d / 2
    smoothing = min(math.sqrt(density / drift), LONGEST_SMOOTHING) if drift else LONGEST_SMOOTHING
    return _Weather(density, math.sqrt(drift), smoothing if density else 0.0)


def _smoothed(t: Signal, x: Signal, smoothing: float) -> Signal:
    """Average with the weights exp(-|s|/T), at the samples' own times: once forward, once backward."""
    if smoothing == 0:
        return x
    keep = np.exp(-np.diff(t) / smoothing)
    ahead, weights = _decaying_sums(x, keep)
    behind, more = (sums[::-1] for sums in _decaying_sums(x[::-1], keep[::-1]))
    return np.asarray((ahead + behind - x) / (weights + more - 1))


def _decaying_sums(x: Signal, keep: Signal) -> tuple[Signal, Signal]:
    sums, weights = np.empty(len(x)), np.empty(len(x))
    total, weight = 0.0, 0.0
    for i, (value, k) in enumerate(zip(x.tolist(), [0.0, *keep.tolist()], strict=True)):
        total, weight = k * total + value, k * weight + 1.0
        sums[i], weights[i] = total, weight
    return sums, weights


def _clock(recording: Recording, reference: Recording, lag: float | None) -> tuple[float, Finding]:
    """Return the lag to use, and a sentence about it."""
    if lag is not None:
        return lag, Finding("clocks", "info", f"The reference's clock was taken to be {lag:+.3g} s ahead.")
    found = find_lag(recording, reference)
    if found is not None and found.sd < WORST_LAG_SD:
        message = (
            f"The reference's clock is {found.seconds:+.2f} s ahead (sd {found.sd:.2g} s, correlation "
            f"{found.correlation:.2f}); that was corrected."
        )
        return found.seconds, Finding("clocks", "info", message)
    why = f"overlap for less than {SHORTEST:g} s" if found is None else "do not correlate clearly enough"
    message = f"The recordings {why} to align their clocks, which were taken as they are; give lag if known."
    return 0.0, Finding("clocks", "warning", message)


def _about_noise(recording: Recording, noise: _Weather) -> Finding:
    message = (
        f"The reference was smoothed over T = {noise.smoothing:.3g} s (its noise has {noise.density:.2g} "
        f"m²/Hz, the weather drifts {noise.drift:.2g} m/sqrt(s)); it adds {noise.added_sd:.2g} m of noise to "
        f"the {_sample_sd(recording.height()):.2g} m of each sample."
    )
    return Finding("difference-noise", "info", message)


def _sample_sd(height: Signal) -> float:
    """Sd of a sample's white noise, from second differences, which no steady motion is in."""
    new = height[np.isfinite(height)]
    return float(np.sqrt(np.mean(np.diff(new, 2) ** 2) / 6)) if len(new) > 2 else 0.0


def _samples(recording: Recording) -> tuple[Signal, Signal]:
    new = recording.is_new
    if int(new.sum()) < 2:
        raise ValueError(f"{recording.name or 'the recording'} has fewer than 2 pressure samples to compare")
    return recording.t[new], recording.height()[new]


def _means(t: Signal, x: Signal, start: float, stop: float, step: float) -> Signal:
    """Means over bins of `step` s from start to stop, at the middle of each bin."""
    count = int((stop - start) / step)
    which = np.floor((t - start) / step).astype(int)
    inside = (which >= 0) & (which < count)
    sizes, times, sums = (
        np.bincount(which[inside], w, minlength=count) for w in (None, t[inside] - start, x[inside])
    )
    full = sizes > 0  # the samples of a bin may lie before its middle on average: interpolate
    middles = step * (np.arange(count) + 0.5)
    return np.interp(middles, times[full] / sizes[full], sums[full] / sizes[full])


def _slow_part(t: Signal, x: Signal, start: float, stop: float) -> Signal:
    """Means over `STEP`, less their own mean over `SLOW` around."""
    m = _means(t, x, start, stop, STEP)
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
