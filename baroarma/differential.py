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
from baroarma.clocks import SHORTEST, binned_means, find_lag, pressure_samples
from baroarma.finding import Finding
from baroarma.noise_model import NoiseModel
from baroarma.recording import Recording

Signal = NDArray[np.float64]
WORST_LAG_SD: Final = 1.0
"""A lag less certain than this, s, is not worth correcting for."""
LONGEST_SMOOTHING: Final = 60.0
"""Largest T, s."""


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
    own_t, own = pressure_samples(reference)
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

    Examples
    --------
    White noises add as squares; of the drifts 0.05 and 0.03 m/√s, 0.03 is the weather that both saw:

    >>> moving = NoiseModel(0, 0, white_sd=0.3, drift_rate=0.05, rate_hz=50)
    >>> still = NoiseModel(0, 0, white_sd=0.4, drift_rate=0.03, rate_hz=50)
    >>> difference_noise(moving, still)
    <NoiseModel at 50 Hz: white 0.5 m, no Gauss-Markov, drift 0.04 m/sqrt(s)>
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
    m = binned_means(t, x, t[0], t[-1], d)
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
