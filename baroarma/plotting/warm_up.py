"""The plot of a warm-up: the height over time with what temperature explains of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from baroarma.plotting.canvas import BAND, DATA, MARK, MODEL, axes_or_new, envelope, finish, printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from baroarma.identification.warmed import WarmUp


def plot_warm_up(found: WarmUp, ax: Axes | None = None) -> Axes:
    """Draw the height, the effect with the band of its interval, and the temperature on an axis of its own.

    Parameters
    ----------
    found : WarmUp
        What `baroarma.warm_up` returned.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> from baroarma import warm_up
    >>> from baroarma.simulation import simulate_rest
    >>> plot_warm_up(warm_up(simulate_rest(120, rate_hz=10, seed=1))).get_ylabel()
    'height above the warm level (m)'
    """
    ax = axes_or_new(ax)
    rest, effect = found.recording, found.effect
    new = rest.is_new
    height = rest.height()
    level = np.nanmean(height - effect)
    ax.plot(*envelope(rest.t[new], height[new] - level), color=DATA, linewidth=0.8, label="barometer")
    half = np.abs(effect / found.slope) * (found.ci95[1] - found.ci95[0]) / 2 if found.slope else 0 * effect
    ax.fill_between(rest.t, effect - half, effect + half, color=MODEL, label="95 %", **BAND)
    slope = f"{found.slope:+.3g} {found.unit}"
    by = "temperature" if found.cause == "temperature" else "settling"
    ax.plot(rest.t, effect, color=MODEL, linewidth=2, label=f"{by}, {slope}")
    if rest.temperature is not None:
        known = np.isfinite(rest.temperature)
        beside = ax.twinx()
        beside.plot(rest.t[known], rest.temperature[known], color=MARK, linestyle="--", linewidth=1.2)
        beside.set_ylabel("temperature (°C), dashed")
    side = "above" if effect[0] > 0 else "below"
    title = f"{printable(rest.name)}: starts {abs(effect[0]):.2g} m {side} its warm level".removeprefix(": ")
    return finish(ax, title, "time (s)", "height above the warm level (m)", columns=3)
