"""The verdict on a rest recording: what in it could make the noise model wrong, in codes and sentences.

`judge_recording` looks before anything is fitted; a finding of severity "error" means that the log can't
support a model.  `judge_model` looks at the fit.  Each check is one function that returns its findings, so
that reading the list below is reading the catalogue.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import metres_per_pascal
from baroarma.finding import Finding
from baroarma.noise_model import NoiseModel
from baroarma.recording import Recording

Signal = NDArray[np.float64]

LEAST_SAMPLES: Final = 100
LEAST_DURATION: Final = 10.0
"""Below so many samples or seconds no model is tried."""
WANTED_PRECISION: Final = 0.10
"""Relative half-width of the correlation time's interval that the advice on duration aims at."""
TOLERATED_PRECISION: Final = 0.35
"""Half-width beyond which the log counts as too short."""
SIGNIFICANT: Final = 0.01
"""p-value of a whiteness test below which the prediction errors count as not white."""
BLOCK: Final = 10.0
"""Length in s of the block means that tell motion from noise."""
REST_CHANGE: Final = 1.2
"""Largest change in m of neighbouring block means at rest: wind on a launch pad reaches 0.64, stairs 1.7."""


def judge_recording(recording: Recording) -> tuple[Finding, ...]:
    """Return what the recording itself says, before any fit.

    Parameters
    ----------
    recording : Recording
        A recording of a motionless barometer, or so one hopes.

    Returns
    -------
    tuple of Finding
        Notes of the reader first; "error" among them means that no model can be had.
    """
    new = recording.is_new
    t, pressure = recording.t[new], recording.pressure[new]
    found = list(recording.notes)
    if len(t) < LEAST_SAMPLES or t[-1] - t[0] < LEAST_DURATION:
        seconds = t[-1] - t[0] if len(t) else 0.0
        message = (
            f"{len(t)} samples over {seconds:.4g} s are too few for a noise model; log at least "
            f"{LEAST_SAMPLES} samples, better ten minutes to an hour."
        )
        return (*found, Finding("too-short", "error", message))
    if not any(f.code == "units" for f in found):
        found += _units(pressure)
    found += _dead(t, pressure)
    if any(f.severity == "error" for f in found):
        return tuple(found)
    height = recording.height()[new]
    moving = _moving_imu(recording) or _moving_pressure(t, height)
    found += moving + _gaps(t) + _coarse(pressure, height)
    if not moving:
        found += _warm_up(t, height)
    return tuple(found)


def judge_model(
    model: NoiseModel, whiteness_p: Mapping[str, float], *, duration: float, second_gm_gain: float
) -> tuple[Finding, ...]:
    """Return what the fitted model says about the recording.

    Parameters
    ----------
    model : NoiseModel
        The fitted model with its intervals.
    whiteness_p : mapping
        p-values of the tests on its prediction errors.
    duration : float
        Length of the recording, s.
    second_gm_gain : float
        By how much BIC falls with a second Gauss-Markov term; positive: it fits better.
    """
    found = []
    if not model.has_gauss_markov:
        message = (
            "The data do not call for a Gauss-Markov component: white noise"
            f"{' and drift explain' if model.drift_rate else ' explains'} them."
        )
        if model.ci95:
            message += f" One of up to {model.ci95['correlated_sd'][1]:.2g} m could hide in this log."
        found.append(Finding("no-gm", "info", message))
    else:
        found += _too_short(model, duration)
    if second_gm_gain > 0:
        message = (
            f"Two correlation times fit better than one (BIC lower by {second_gm_gain:.3g}); the model is "
            "the best with one, a compromise between them."
        )
        found.append(Finding("two-time-constants", "warning", message))
    rejected = {name: p for name, p in whiteness_p.items() if p < SIGNIFICANT}
    if rejected:
        tests = ", ".join(f"{_TESTS.get(name, name)} p = {p:.2g}" for name, p in rejected.items())
        message = (
            f"The prediction errors of this model are not white ({tests}): the noise has structure that "
            "white + Gauss-Markov + drift does not describe."
        )
        found.append(Finding("not-white", "warning", message))
    return tuple(found)


def minutes_wanting(model: NoiseModel, duration: float, precision: float = WANTED_PRECISION) -> float | None:
    """Return how many more minutes would bring the correlation time's 95 % half-width to `precision`.

    The half-width falls with the square root of the duration.  None without a Gauss-Markov component or
    an interval; 0 when the log is long enough.
    """
    half_width = _half_width(model)
    if half_width is None:
        return None
    return max(0.0, duration * ((half_width / precision) ** 2 - 1) / 60)


_TESTS = {
    "ljung_box_10": "Ljung-Box over 10 lags",
    "ljung_box_40": "Ljung-Box over 40 lags",
    "bartlett": "Bartlett's cumulative periodogram",
}


def _half_width(model: NoiseModel) -> float | None:
    if not model.has_gauss_markov or model.ci95 is None:
        return None
    low, high = model.ci95["correlation_time"]
    return 0.5 * (high - low) / model.correlation_time


def _too_short(model: NoiseModel, duration: float) -> list[Finding]:
    half_width = _half_width(model)
    if half_width is None or half_width <= TOLERATED_PRECISION:
        return []
    more = minutes_wanting(model, duration)
    message = (
        f"{duration:.4g} s determine the correlation time of {model.correlation_time:.3g} s only to "
        f"±{100 * half_width:.0f} %; about {more:.0f} minutes more would make it ±10 %."
    )
    return [Finding("too-short", "warning", message)]


def _units(pressure: Signal) -> list[Finding]:
    level = float(np.median(pressure))
    if 1_000 <= level <= 200_000:
        return []
    hint = (
        "it looks like hPa, so rename the column to pressure_hpa"
        if 300 <= level <= 1_100
        else "check the unit"
    )
    return [Finding("units", "error", f"A median pressure of {level:.6g} Pa is no air pressure; {hint}.")]


def _dead(t: Signal, pressure: Signal) -> list[Finding]:
    changes = np.flatnonzero(np.diff(pressure))
    if not len(changes):
        message = (
            f"The pressure never changes from {pressure[0]:.6g} Pa; a live barometer is never that quiet."
        )
        return [Finding("dead", "error", message)]
    edges = np.concatenate(([0], changes + 1, [len(pressure) - 1]))
    runs = np.diff(t[edges])
    longest = int(np.argmax(runs))
    usual = float(np.median(np.diff(t[changes]))) if len(changes) > 1 else 0.0
    if runs[longest] > max(10.0, 50 * usual):
        message = (
            f"The pressure stands still for {runs[longest]:.4g} s from {t[edges[longest]]:.4g} s on, but "
            f"it otherwise changes every {usual:.2g} s: the sensor or the logger hung; use the rest of it."
        )
        return [Finding("dead", "error", message)]
    return []


def _moving_imu(recording: Recording) -> list[Finding]:
    """Compare one-second windows of gyro and accelerometer with the recording's own median."""
    signs = []
    second = np.floor(recording.t - recording.t[0]).astype(int)
    for signal, limit in ((recording.gyro, 0.1), (recording.accel, 0.3)):
        if signal is None:
            continue
        good = np.isfinite(signal).all(axis=1)
        if good.sum() < 2:
            continue
        off = signal[good] - np.median(signal[good], axis=0)
        count = np.maximum(np.bincount(second[good]), 1)
        if signal is recording.gyro:  # rms rate
            size = np.sqrt(np.bincount(second[good], np.sum(off**2, axis=1)) / count)
        else:  # mean specific force: noise and vibration average out, tilt and acceleration stay
            means = [np.bincount(second[good], off[:, i]) / count for i in range(3)]
            size = np.linalg.norm(means, axis=0)
        signs.append(np.flatnonzero(size > limit))
    seconds = np.unique(np.concatenate(signs)) if signs else np.empty(0, int)
    if not len(seconds):
        return []
    share = len(seconds) / (second[-1] + 1)
    where = f"the IMU moves in {len(seconds)} of {second[-1] + 1} seconds, first at {seconds[0]} s"
    if len(seconds) < 3 or share < 0.01:
        return [Finding("moving", "warning", f"The recording is nearly at rest: {where}.")]
    message = (
        f"This is no rest recording: {where}; log the sensor where nothing moves it, or cut the rest out."
    )
    return [Finding("moving", "error", message)]


def _moving_pressure(t: Signal, height: Signal) -> list[Finding]:
    """Look for height changes between neighbouring ten-second means that air at rest does not make."""
    block = np.floor((t - t[0]) / BLOCK).astype(int)
    count = np.bincount(block)
    full = np.flatnonzero(count >= 3)
    means = np.bincount(block, height)[full] / count[full]
    if len(means) < 2:
        return []
    sample_sd = 1.4826 * float(np.median(np.abs(np.diff(height)))) / np.sqrt(2)
    limit = max(REST_CHANGE, 8 * sample_sd / np.sqrt(np.median(count[full])))
    change = np.abs(np.diff(means))
    if change.max() <= limit:
        return []
    at = float(full[int(np.argmax(change))] * BLOCK + BLOCK)
    message = (
        f"This is no rest recording: the height changes by {change.max():.3g} m within {BLOCK:.0f} s near "
        f"{at:.0f} s; log the sensor where nothing moves it, or cut the rest out."
    )
    return [Finding("moving", "error", message)]


def _gaps(t: Signal) -> list[Finding]:
    dt = np.diff(t)
    usual = float(np.median(dt))
    gaps = dt[dt > 3.5 * usual]
    if not len(gaps):
        return []
    lost = float(gaps.sum() - len(gaps) * usual)
    severity = "warning" if lost > 0.05 * (t[-1] - t[0]) else "info"
    plural = "s" if len(gaps) > 1 else ""
    message = (
        f"{len(gaps)} gap{plural}, the longest {gaps.max():.3g} s, {lost:.3g} s lost in all; "
        "the structural method takes them into account."
    )
    return [Finding("gaps", severity, message)]


def _coarse(pressure: Signal, height: Signal) -> list[Finding]:
    """Compare the quantum with the noise that is not drift: the sd of first differences over sqrt(2)."""
    steps = np.diff(np.unique(pressure))
    steps = steps[steps > 1e-9 * abs(pressure[0])]
    quantum = float(steps.min()) * metres_per_pascal(float(np.median(pressure)))
    noise = float(np.std(np.diff(height))) / np.sqrt(2)
    if quantum <= noise:
        return []
    message = (
        f"The quantum of {quantum:.2g} m is coarser than the noise of {noise:.2g} m: the white sd is mostly "
        "rounding, and a Gaussian model describes it poorly; log with finer resolution if the sensor can."
    )
    return [Finding("coarse-quantisation", "warning", message)]


def _warm_up(t: Signal, height: Signal) -> list[Finding]:
    """Compare the first tenths of the log with the spread of its second half."""
    tenth = np.minimum(((t - t[0]) / (t[-1] - t[0]) * 10).astype(int), 9)
    count = np.bincount(tenth, minlength=10)
    if count.min() == 0:
        return []
    means = np.bincount(tenth, height, minlength=10) / count
    late = means[5:]
    spread = max(float(np.ptp(late)), 1e-9)
    start = float(means[0] - np.median(late))
    sample_sd = float(np.std(np.diff(height))) / np.sqrt(2)
    same_way = np.all(np.sign(np.diff(means[:3])) == -np.sign(start))
    if abs(start) < 5 * spread or abs(start) < sample_sd or not same_way:
        return []
    message = (
        f"The first {0.1 * (t[-1] - t[0]):.3g} s lie {abs(start):.2g} m "
        f"{'above' if start > 0 else 'below'} the second half, which stays within {spread:.2g} m: the sensor "
        "was warming up; drop the beginning."
    )
    return [Finding("warm-up", "warning", message)]
