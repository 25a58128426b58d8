"""The verdict on a rest recording: what in it could make the noise model wrong, in codes and sentences.

`judge_recording` looks before anything is fitted; a finding of severity "error" means that the log can't
support a model.  `judge_model` looks at the fit.  Each check is one function that returns its findings, so
that reading the list below is reading the catalogue.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import metres_per_pascal, pressure_altitude
from baroarma.finding import Finding, Severity
from baroarma.identification.stillness import judge_stillness
from baroarma.noise_model import TEST_NAMES, NoiseModel
from baroarma.recording import Recording
from baroarma.spikes import pressure_spikes, spike_note
from baroarma.standstill import dead_barometer, noise_of, quantum_of

Signal = NDArray[np.float64]

LEAST_SAMPLES: Final = 100
LEAST_DURATION: Final = 10.0
"""Below so many samples, or seconds, no model is tried."""
WANTED_PRECISION: Final = 0.10
"""Relative half-width of the correlation time's interval that the advice on duration aims at."""
TOLERATED_PRECISION: Final = 0.35
"""Half-width beyond which the log counts as too short."""
SIGNIFICANT: Final = 0.01
"""p-value of a whiteness test below which the prediction errors count as not white."""
WARMING: Final = 4.0
"""A start so many standard deviations off what the second half's random walk would do is warm-up."""


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
    known = [note for note in recording.notes if note.code == "moving"]  # by who saw the IMU pass by
    found = [note for note in recording.notes if note not in known and note.code != "dead"]
    if len(t) < LEAST_SAMPLES or t[-1] - t[0] < LEAST_DURATION:
        seconds = t[-1] - t[0] if len(t) else 0.0
        message = (
            f"{len(t)} samples over {seconds:.4g} s are too few for a noise model; log at least "
            f"{LEAST_SAMPLES} samples over {LEAST_DURATION:g} s, better ten minutes to an hour."
        )
        return (*found, Finding("too-short", "error", message))
    if not any(f.code == "units" for f in found):
        found += _units(pressure)
    found += dead_barometer(t, pressure) + _spikes(t, pressure)
    if any(f.severity == "error" for f in found):
        return tuple(found)
    moving = known or judge_stillness(recording)
    found += moving + _gaps(t) + _coarse(pressure)
    if not moving:
        found += _warm_up(t, pressure_altitude(pressure))
    return tuple(found)


def judge_model(
    model: NoiseModel, *, duration: float, second_gm_gain: float = 0.0, gm_tried: bool = True
) -> tuple[Finding, ...]:
    """Return what the fitted model says about the recording.

    Parameters
    ----------
    model : NoiseModel
        The fitted model with its intervals and the p-values of its prediction errors.
    duration : float
        Length of the recording, s.
    second_gm_gain : float
        By how much BIC falls with a second Gauss-Markov term; positive: it fits better.
    gm_tried : bool
        Whether a Gauss-Markov term was among those that the model was chosen from.
    """
    found = _too_short(model, duration) if model.has_gauss_markov else [_no_gm(model, gm_tried)]
    if second_gm_gain > 0:
        message = (
            f"Two correlation times fit better than one (BIC lower by {second_gm_gain:.3g}); the model is "
            "the best with one, a compromise between them."
        )
        found.append(Finding("two-time-constants", "warning", message))
    rejected = {name: p for name, p in (model.whiteness_p or {}).items() if p < SIGNIFICANT}
    if rejected:
        tests = ", ".join(f"{TEST_NAMES.get(name, name)} p = {p:.2g}" for name, p in rejected.items())
        message = (
            f"The prediction errors of this model are not white ({tests}): the noise has structure that "
            "white + Gauss-Markov + drift does not describe."
        )
        found.append(Finding("not-white", "warning", message))
    return tuple(found)


def minutes_wanting(model: NoiseModel, duration: float, precision: float = WANTED_PRECISION) -> float | None:
    """Return how many more minutes would bring the correlation time's 95 % half-width to `precision`.

    The half-width of the interval of log(tau) falls with the square root of the duration; that of tau,
    relative, is its hyperbolic sine.  None without a Gauss-Markov component or an interval that excludes 0;
    0 when the log is long enough.
    """
    half_width = _half_width(model)
    if half_width is None:
        return None
    ratio = math.asinh(half_width) / math.asinh(precision)
    return max(0.0, duration * (ratio**2 - 1) / 60)


def _half_width(model: NoiseModel) -> float | None:
    if not model.has_gauss_markov or model.ci95 is None:
        return None
    low, high = model.ci95["correlation_time"]
    if low == 0:  # not determined at all, as by less than three windows
        return None
    return 0.5 * (high - low) / model.correlation_time


def _too_short(model: NoiseModel, duration: float) -> list[Finding]:
    half_width, more = _half_width(model), minutes_wanting(model, duration)
    if half_width is None and model.ci95 is not None:
        message = (
            f"{duration:.4g} s do not determine the correlation time: its interval reaches from 0 to "
            f"{model.ci95['correlation_time'][1]:.3g} s; log for longer."
        )
        return [Finding("too-short", "warning", message)]
    if half_width is None or more is None or half_width <= TOLERATED_PRECISION:
        return []
    message = (
        f"{duration:.4g} s determine the correlation time of {model.correlation_time:.3g} s only to "
        f"±{100 * half_width:.0f} %; about {more:.0f} minutes more would make it ±10 %."
    )
    return [Finding("too-short", "warning", message)]


def _no_gm(model: NoiseModel, tried: bool) -> Finding:
    if not tried:
        message = "The model was asked for without a Gauss-Markov component."
    else:
        terms = [
            name for name, size in (("white noise", model.white_sd), ("drift", model.drift_rate)) if size
        ]
        message = (
            "The data do not call for a Gauss-Markov component: "
            f"{' and '.join(terms)} {'explain' if len(terms) > 1 else 'explains'} them."
        )
    if model.ci95:
        message += f" One of up to {model.ci95['correlated_sd'][1]:.2g} m could hide in this log."
    return Finding("no-gm", "info", message)


def _units(pressure: Signal) -> list[Finding]:
    """Check what was built by hand; `read` has noted the units of a file."""
    level = float(np.median(pressure))
    if 1_200 <= level <= 200_000:
        return []
    hint = "it looks like hPa: multiply by 100" if 300 <= level < 1_200 else "check the unit"
    return [Finding("units", "error", f"A median pressure of {level:.6g} Pa is no air pressure; {hint}.")]


def _spikes(t: Signal, pressure: Signal) -> list[Finding]:
    """Check what was built by hand; `read` has dropped the spikes of a file."""
    spike, count = pressure_spikes(t, pressure)
    return [spike_note(t, pressure, spike, count, dropped=False)] if count else []


def _gaps(t: Signal) -> list[Finding]:
    dt = np.diff(t)
    usual = float(np.median(dt))
    gaps = dt[dt > 3.5 * usual]
    if not len(gaps):
        return []
    lost = float(gaps.sum() - len(gaps) * usual)
    severity: Severity = "warning" if lost > 0.05 * (t[-1] - t[0]) else "info"
    plural = "s" if len(gaps) > 1 else ""
    message = (
        f"{len(gaps)} gap{plural}, the longest {gaps.max():.3g} s, {lost:.3g} s lost in all; "
        "the structural method takes them into account."
    )
    return [Finding("gaps", severity, message)]


def _coarse(pressure: Signal) -> list[Finding]:
    scale = metres_per_pascal(float(np.median(pressure)))
    quantum, noise = quantum_of(pressure) * scale, noise_of(np.diff(pressure)) * scale
    if quantum <= noise:
        return []
    message = (
        f"The quantum of {quantum:.2g} m is coarser than the noise of {noise:.2g} m: the white sd is mostly "
        "rounding, and a Gaussian model describes it poorly; log with finer resolution if the sensor can."
    )
    return [Finding("coarse-quantisation", "warning", message)]


def _warm_up(t: Signal, height: Signal) -> list[Finding]:
    """Compare the beginning with the drift in the second half, in means over twentieths of the log."""
    part = np.minimum(((t - t[0]) / (t[-1] - t[0]) * 20).astype(int), 19)
    count = np.bincount(part, minlength=20)
    if count.min() == 0:
        return []
    means = np.bincount(part, height, minlength=20) / count
    step = float(np.sqrt(np.mean(np.diff(means[10:]) ** 2)))
    off = means - np.median(means[10:])
    # from the first part to the middle of the second half a random walk goes sqrt(15) steps, and the steps of
    # its means are sqrt(2/3) of its own
    limit = max(WARMING * step * np.sqrt(15 * 3 / 2), noise_of(np.diff(height)))
    settling = np.all(np.diff(means[:4]) * off[0] < 0)
    if abs(off[0]) < limit or not settling:
        return []
    warm = int(np.flatnonzero(np.abs(off) <= WARMING * step)[0])
    message = (
        f"The height starts {abs(off[0]):.2g} m {'above' if off[0] > 0 else 'below'} its level in the second "
        f"half and settles: the sensor was warming up; drop the first {warm / 20 * (t[-1] - t[0]):.0f} s, or "
        "take it out with baroarma.warm_up(rest).compensate()."
    )
    return [Finding("warm-up", "warning", message)]
