"""What a warm-up has taught: metres per kelvin with their interval, and the recording without the effect."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import altitude_pressure, metres_per_pascal, pressure_altitude
from baroarma.finding import Finding
from baroarma.noise_model import Interval
from baroarma.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Signal = NDArray[np.float64]
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
    >>> from baroarma.identification import warm_up
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
