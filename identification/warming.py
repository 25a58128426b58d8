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
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import altitude_pressure, metres_per_pascal, pressure_altitude
from baroarma.finding import Finding
from baroarma.identification.preprocessing import new_samples
from baroarma.identification.regression import (
    Course,
    Regression,
    choose_noise,
    regress,
    regress_with_lag,
    slow_columns,
)
from baroarma.noise_model import Interval
from baroarma.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Signal = NDArray[np.float64]
SMOOTHED: Final = 21
"""Seconds over which the temperature is smoothed, by parabolas; chips warm up in minutes (chosen by us)."""
LEAST_SAMPLES: Final = 100
"""Fewer samples are no record of a warm-up."""
LEAST_DURATION: Final = 60.0
"""Neither are fewer s."""
LEAST_SPAN: Final = 1.0
"""Kelvin by which the temperature must change: below, what changes is the reading's own noise."""


Cause = Literal["temperature", "settling"]
Status = Literal["effect", "none", "hardly-warmed", "not-separable"]


@dataclass(frozen=True, eq=False, repr=False)
class WarmUp:
    """Hold what the temperature, or time since switching on, does to the height.

    Parameters
    ----------
    recording : Recording
        What was looked at.
    cause : {"temperature", "settling"}
        What explains the height best.
    slope : float
        m/K; for "settling", by how many m the height starts above its settled level.
    ci95 : tuple of float
        Its 95 % interval.
    ci95_beside_trend : tuple of float
        The interval when a steady trend of the weather may explain as much as it can.
    lag : float
        Time constant in s by which the effect follows the temperature (0: at once), or of the settling.
    span : float
        By how many kelvin the temperature changes; NaN without one.
    gain : float
        Twice the log-likelihood that temperature and jitter gain on noise alone.
    jitter, jitter_sd : float
        What each reading passes on of its own temperature's noise, m/K, and the part of the white sd that
        this makes, m; 0 where BIC sees none.
    drift_rates : tuple of float
        Drift of the noise in m/√s, without the effect and with it.
    effect : ndarray, shape (n,)
        The effect at each row of the recording, m, 0 at the end.

    Examples
    --------
    A sensor that reads half a metre higher per kelvin, warming up by 13 K; at sea level a metre is 12 Pa:

    >>> from dataclasses import replace
    >>> from baroarma.simulation import simulate_rest
    >>> rest = simulate_rest(200, rate_hz=5, seed=1)
    >>> warmth = 40 - 13 * np.exp(-rest.t / 60)
    >>> warm = replace(rest, pressure=altitude_pressure(rest.height() + 0.5 * warmth), temperature=warmth)
    >>> found = warm_up(warm)
    >>> found.status, found.unit, found.ci95[0] < 0.5 < found.ci95[1]
    ('effect', 'm/K', True)
    >>> round(found.pascal_per_kelvin / found.slope, 1)
    -11.9
    >>> height = found.compensate().height()
    >>> bool(abs(height[:100].mean() - height[-100:].mean()) < 1)  # it was more than 5 m
    True
    """

    recording: Recording
    cause: Cause
    slope: float
    ci95: Interval
    ci95_beside_trend: Interval
    lag: float
    span: float
    gain: float
    jitter: float
    jitter_sd: float
    drift_rates: tuple[float, float]
    effect: Signal

    def __repr__(self) -> str:
        low, high = self.ci95
        return (
            f"<WarmUp of {self.recording.name!r}: {self.slope:+.3g} {self.unit} [{low:.3g}, {high:.3g}], "
            f"{self.effect[0]:+.3g} m at the start; {self.status}>"
        )

    @property
    def unit(self) -> str:
        """Unit of the slope."""
        return "m/K" if self.cause == "temperature" else "m"

    @property
    def status(self) -> Status:
        """Whether there is an effect that this log can tell from noise and weather."""
        if self.cause == "temperature" and self.span < LEAST_SPAN:
            return "hardly-warmed"
        if self.ci95[0] <= 0 <= self.ci95[1]:
            return "none"
        low, high = self.ci95_beside_trend
        return "effect" if low * high > 0 and low <= self.slope <= high else "not-separable"

    @property
    def pascal_per_kelvin(self) -> float:
        """The slope as a data sheet's temperature coefficient of the offset; NaN for "settling"."""
        if self.cause == "settling":
            return math.nan
        return -self.slope / metres_per_pascal(float(np.nanmedian(self.recording.pressure)))

    def verdict(self) -> str:
        """Return what to think of it and what to do, in a sentence."""
        return {
            "effect": "Take it out with compensate(), or let the sensor warm up before it is identified.",
            "none": "This log shows no such effect; the interval says how large one could hide.",
            "hardly-warmed": (
                f"The temperature changes by {self.span:.2g} K only, too little to learn from; log from the "
                "moment of switching on, or beside a heater."
            ),
            "not-separable": (
                "A steady trend of the weather would explain as much; log a second warm-up after cooling "
                "down, or beside a barometer that stays warm (Recording.relative_to)."
            ),
        }[self.status]

    def summary(self) -> str:
        """Return the result as text."""
        (low, high), (t_low, t_high) = self.ci95, self.ci95_beside_trend
        what = "height by temperature" if self.cause == "temperature" else "height above the settled level"
        lines = [
            f"{self.recording.name}: {what} {self.slope:+.4g} {self.unit}  [{low:.4g}, {high:.4g}], that is "
            f"{self.effect[0]:+.3g} m at the start",
            f"  beside a steady trend of the weather [{t_low:.4g}, {t_high:.4g}] {self.unit}",
            f"  drift of the noise {self.drift_rates[0]:.3g} m/sqrt(s) without it, {self.drift_rates[1]:.3g} "
            "with it",
        ]
        if self.cause == "temperature":
            lines.append(f"  temperature coefficient of the offset {self.pascal_per_kelvin:+.3g} Pa/K")
        if self.lag:
            lines.append(f"  time constant {self.lag:.3g} s")
        if self.jitter_sd:
            lines.append(
                f"  {self.jitter_sd:.2g} m of the white noise is the temperature reading's own noise "
                f"({self.jitter:+.3g} m/K): average the temperature before compensating with it"
            )
        return "\n".join([*lines, f"  {self.status}: {self.verdict()}"])

    def to_dict(self) -> dict[str, Any]:
        """Return the result for JSON."""
        return {
            "cause": self.cause,
            "slope": self.slope,
            "unit": self.unit,
            "ci95": list(self.ci95),
            "ci95_beside_trend": list(self.ci95_beside_trend),
            "lag_s": self.lag,
            "span_k": None if math.isnan(self.span) else self.span,
            "status": self.status,
            "message": self.verdict(),
            "jitter_m_per_k": self.jitter,
            "jitter_sd_m": self.jitter_sd,
            "drift_rates_m_per_sqrt_s": list(self.drift_rates),
        }

    def compensate(self) -> Recording:
        """Return the recording with the effect taken out of its pressure, as if warm from the start.

        The jitter stays: it is part of the noise that the filter will see.  What `identify` then finds does
        not know how uncertain the slope is.
        """
        new = self.recording.is_new
        pressure = np.array(self.recording.pressure)
        pressure[new] = altitude_pressure(pressure_altitude(pressure[new]) - self.effect[new])
        message = (
            f"A warm-up of {self.effect[0]:+.3g} m at the start was taken out "
            f"({self.slope:+.3g} {self.unit}, status {self.status})."
        )
        note = Finding("warm-up-compensated", "info", message)
        return replace(self.recording, pressure=pressure, notes=(*self.recording.notes, note))

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw height and effect over time; see `baroarma.plotting.warm_up.plot_warm_up`."""
        from baroarma.plotting.warm_up import plot_warm_up

        return plot_warm_up(self, ax)


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
    t, height = new_samples(rest.t, rest.height())
    if len(t) < LEAST_SAMPLES or t[-1] - t[0] < LEAST_DURATION:
        lasts = t[-1] - t[0] if len(t) else 0.0
        raise ValueError(
            f"{rest.name or 'the recording'} has {len(t)} pressure samples over {lasts:.3g} s; a warm-up "
            f"needs {LEAST_SAMPLES} or more over {LEAST_DURATION:g} s or more"
        )
    noise = choose_noise(t, height)
    courses, quick, span = _regressors(rest, t)
    fits: dict[tuple[Cause, float], Regression] = {}
    if "temperature" in courses:
        fits["temperature", 0.0] = regress(t, height, [courses["temperature"](0.0)], quick, noise)
    for cause, course_of in courses.items():
        lag, fit = regress_with_lag(t, height, course_of, quick, noise)
        if cause == "temperature" or not fits or fit.interval[0] * fit.interval[1] > 0:
            fits[cause, lag] = fit
    cause, lag = min(
        fits, key=lambda c: fits[c].noise.bic + (c[1] > 0) * math.log(len(t))
    )  # lag: a parameter
    fit, slow = fits[cause, lag], slow_columns(courses[cause], lag)
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


def _regressors(rest: Recording, t: Signal) -> tuple[dict[Cause, Course], list[Signal], float]:
    """Return the slow courses by cause, the temperature's quick part if there is one, and its span in K."""
    settling: dict[Cause, Course] = {"settling": lambda lag: np.exp(-(t - t[0]) / lag)}
    known = np.isfinite(rest.temperature) if rest.temperature is not None else np.zeros(len(rest), bool)
    if rest.temperature is None or known.sum() < LEAST_SAMPLES:
        return settling, [], math.nan
    at, celsius = rest.t[known], rest.temperature[known]
    slow = _lagged(at, celsius, 0.0, t)
    quick = np.interp(t, at, celsius) - slow
    courses: dict[Cause, Course] = {"temperature": lambda lag: _lagged(at, celsius, lag, t), **settling}
    return courses, [quick] if np.any(quick) else [], float(np.ptp(slow))


def _lagged(at: Signal, celsius: Signal, lag: float, t: Signal) -> Signal:
    """Return the temperature at times t, smoothed and behind a low-pass filter."""
    from scipy.signal import lfilter, savgol_filter

    seconds, smooth = _each_second(at, celsius)
    # parabolas, so that warming doesn't leak into the quick part: means would leave 0.6 K of 0.25 K/s
    smooth = savgol_filter(smooth, min(SMOOTHED, (len(smooth) - 1) // 2 * 2 + 1), 2)
    if lag:
        share = -math.expm1(-1 / lag)
        smooth = lfilter([share], [1, share - 1], smooth, zi=[(1 - share) * smooth[0]])[0]
    first, last = 1.5 * smooth[0] - 0.5 * smooth[1], 1.5 * smooth[-1] - 0.5 * smooth[-2]
    ends = np.concatenate(([seconds[0] - 0.5], seconds, [seconds[-1] + 0.5]))
    return np.asarray(np.interp(t, ends, np.concatenate(([first], smooth, [last]))))


def _each_second(at: Signal, celsius: Signal) -> tuple[Signal, Signal]:
    """Return the middles of the log's seconds and their mean temperatures, interpolated over gaps."""
    second = np.floor(at - at[0]).astype(int)
    count = np.bincount(second)
    some, middle = np.flatnonzero(count), at[0] + 0.5 + np.arange(len(count))
    time, mean = np.bincount(second, at)[some] / count[some], np.bincount(second, celsius)[some] / count[some]
    return middle, np.interp(middle, time, mean)
