"""What a barometer's own temperature does to its height: metres per kelvin, from a rest in which it warms up.

A sensor that has just been switched on heats itself, and what its factory compensation leaves of that shows
as a height that creeps and settles.  The height of a motionless sensor is taken for

    height(t) = slope · T_lag(t) + jitter · (T(t) - T_slow(t)) + noise(t),

with the noise of `structural`: white + drift, and Gauss-Markov if BIC asks for it.  T_slow is the reported
temperature, smoothed over `SMOOTHED` s, T_lag the same behind a low-pass filter of the time constant `lag`
(the membrane warms later than the thermometer), 0 unless BIC asks for it.  `jitter` is another thing
altogether: each reading is compensated with the temperature measured just before it, and passes on that
measurement's own noise.  Left in T, it would drown the slope.

Without a temperature, or where BIC prefers it, the height settles as exp(-t/lag) after switching on, and
`slope` is by how many m it starts above the level where it settles.

Coefficients and noise are learned together (`baroarma.identification.regression`).  The interval of the slope
knows how far white noise and drift alone would lead.  It can't know the weather's plans: the regression is
repeated with a steady trend beside the temperature, and where the interval then reaches 0 or leaves the slope
out, the two can't be told apart in this log.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.identification.preprocessing import new_samples
from baroarma.identification.regression import (
    Course,
    Regression,
    choose_noise,
    regress,
    regress_with_lag,
    slow_columns,
)
from baroarma.identification.structural import StructuralFit
from baroarma.identification.temperature import lagged
from baroarma.identification.warmed import Cause, WarmUp
from baroarma.recording import Recording

Signal = NDArray[np.float64]
LEAST_SAMPLES: Final = 100
"""Fewer samples are no record of a warm-up."""
LEAST_DURATION: Final = 60.0
"""Neither are fewer s."""


def warm_up(rest: Recording) -> WarmUp:
    """Learn what a motionless barometer's temperature does to its height.

    Parameters
    ----------
    rest : Recording
        Of a barometer that warms up or cools down by itself; the more kelvin and the more often, the better.
        Without temperature: one that begins when the sensor is switched on.

    Returns
    -------
    WarmUp
        Metres per kelvin with their interval, whether that can be told from the weather, and the recording
        without it (`WarmUp.compensate`).

    Raises
    ------
    ValueError
        If there are too few samples, or they last too short.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from baroarma.atmosphere import altitude_pressure
    >>> from baroarma.simulation import simulate_rest
    >>> rest = simulate_rest(300, rate_hz=10, seed=1)
    >>> warmth = 40 - 15 * np.exp(-rest.t / 60)
    >>> pressure = altitude_pressure(rest.height() + 0.5 * warmth)
    >>> found = warm_up(replace(rest, pressure=pressure, temperature=warmth))
    >>> found
    <WarmUp of 'rest': +0.5... m/K [0.3..., 0.6...], -7... m at the start; effect>
    >>> found.compensate().notes[0].code
    'warm-up-compensated'
    """
    t, height = _samples(rest)
    noise = choose_noise(t, height)
    courses, quick, span = _regressors(rest, t)
    cause, lag, fit = _best_fit(t, height, courses, quick, noise)
    slow = slow_columns(courses[cause], lag)
    effect = np.stack(slow, axis=1) @ fit.coefficients[: len(slow)]
    jitter = fit.significant(len(slow), len(t)) if quick else 0.0
    return WarmUp(
        rest,
        cause,
        fit.slope,
        fit.interval,
        regress(t, height, [*slow, t - t[0]], quick, fit.noise).interval,
        lag,
        span,
        2 * (fit.noise.log_likelihood - noise.log_likelihood),
        jitter,
        abs(jitter) * float(np.std(quick)) if quick else 0.0,
        (float(noise.theta[1]), float(fit.noise.theta[1])),
        np.interp(rest.t, t, effect - effect[-1]),
    )


def _samples(rest: Recording) -> tuple[Signal, Signal]:
    """Return times and heights of new samples, if they are enough."""
    t, height = new_samples(rest.t, rest.height())
    if len(t) < LEAST_SAMPLES or t[-1] - t[0] < LEAST_DURATION:
        lasts = t[-1] - t[0] if len(t) else 0.0
        raise ValueError(
            f"{rest.name or 'the recording'} has {len(t)} pressure samples over {lasts:.3g} s; a warm-up "
            f"needs {LEAST_SAMPLES} or more over {LEAST_DURATION:g} s or more"
        )
    return t, height


def _regressors(rest: Recording, t: Signal) -> tuple[dict[Cause, Course], list[Signal], float]:
    """Return the slow courses by cause, the temperature's quick part if there is one, and its span in K."""
    settling: dict[Cause, Course] = {"settling": lambda lag: np.exp(-(t - t[0]) / lag)}
    known = np.isfinite(rest.temperature) if rest.temperature is not None else np.zeros(len(rest), bool)
    if rest.temperature is None or known.sum() < LEAST_SAMPLES:
        return settling, [], math.nan
    at, celsius = rest.t[known], rest.temperature[known]
    slow = lagged(at, celsius, 0.0, t)
    quick = np.interp(t, at, celsius) - slow
    courses: dict[Cause, Course] = {"temperature": lambda lag: lagged(at, celsius, lag, t), **settling}
    return courses, [quick] if np.any(quick) else [], float(np.ptp(slow))


def _best_fit(
    t: Signal, height: Signal, courses: dict[Cause, Course], quick: list[Signal], noise: StructuralFit
) -> tuple[Cause, float, Regression]:
    """Return the cause and the lag that BIC prefers, with their regression; the lag counts as a parameter."""
    fits: dict[tuple[Cause, float], Regression] = {}
    if "temperature" in courses:
        fits["temperature", 0.0] = regress(t, height, [courses["temperature"](0.0)], quick, noise)
    for cause, course_of in courses.items():
        lag, fit = regress_with_lag(t, height, course_of, quick, noise)
        if cause == "temperature" or not fits or fit.interval[0] * fit.interval[1] > 0:
            fits[cause, lag] = fit
    cause, lag = min(fits, key=lambda c: fits[c].noise.bic + (c[1] > 0) * math.log(len(t)))
    return cause, lag, fits[cause, lag]
