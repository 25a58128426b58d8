"""Plots of what trackers make: one track with its band, and several beside each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from baroarma.metrics import ZEROED_OVER, reference_at
from baroarma.plotting.canvas import (
    BAND,
    DATA,
    DRIFT,
    GAUSS_MARKOV,
    MARK,
    MODEL,
    WHITE,
    axes_or_new,
    envelope,
    finish,
    ink,
    printable,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from baroarma.comparison import Comparison
    from baroarma.track import Track

COLOURS: Final = (DATA, MODEL, GAUSS_MARKOV, DRIFT, WHITE, MARK)
STYLES: Final = ("-", "--", "-.", ":")


def plot_track(track: Track, ax: Axes | None = None) -> Axes:
    """Draw the height over time with the band of two standard deviations.

    Parameters
    ----------
    track : Track
        Long ones are drawn by their envelope.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Examples
    --------
    >>> from baroarma.simulation import BMP085, simulate
    >>> from baroarma.tracker import Tracker
    >>> plot_track(Tracker(noise=BMP085.noise).run(simulate("squat", duration=10, seed=1))).get_ylabel()
    'height (m)'
    """
    ax = axes_or_new(ax)
    every = max(1, len(track) // 2000)
    t, height, sd = track.t[::every], track.height[::every], track.height_sd[::every]
    ax.fill_between(t, height - 2 * sd, height + 2 * sd, color=DATA, label="± 2 sd", **BAND)
    ax.plot(*envelope(track.t, track.height), color=DATA, linewidth=1.2, label="height")
    title = f"{printable(track.name)}: height by {printable(track.preset)}".removeprefix(": ")
    return finish(ax, title, "time (s)", "height (m)", columns=2)


def plot_comparison(comparison: Comparison) -> Figure:
    """Draw heights and velocities of all presets over the reference, and their errors as bars.

    Parameters
    ----------
    comparison : Comparison
        What `baroarma.compare` returned.

    Returns
    -------
    matplotlib.figure.Figure
        Three axes: height, velocity, rms errors (or the closure where there is no reference).
    """
    import matplotlib.pyplot as plt

    figure, (height, velocity, bars) = plt.subplots(
        3, 1, figsize=(9, 10), layout="constrained", height_ratios=(3, 3, 2)
    )
    plot_traces(comparison, height, "height")
    plot_traces(comparison, velocity, "velocity")
    plot_errors(comparison, bars)
    return figure


def plot_traces(comparison: Comparison, ax: Axes, quantity: str) -> Axes:
    """Draw one quantity, "height" or "velocity", of every track over the reference."""
    recording = comparison.recording
    rows = [row for row in comparison.rows if row.track is not None]
    for i, row in enumerate(rows):
        values = getattr(row.track, quantity)
        if quantity == "height":
            values = values - values[recording.t < recording.t[0] + ZEROED_OVER].mean()
        style: dict[str, Any] = {
            "color": COLOURS[i % len(COLOURS)],
            "linestyle": STYLES[i // len(COLOURS) % len(STYLES)],
        }
        ax.plot(*envelope(recording.t, values), linewidth=1.0, label=row.preset, **style)
    found = reference_at(recording, recording.t, comparison.reference_lag)
    if found is not None:
        values = found[0] if quantity == "height" else found[1]
        known = np.isfinite(values)
        if quantity == "height":
            values = values - values[known & (recording.t < recording.t[0] + ZEROED_OVER)].mean()
        ax.plot(
            *envelope(recording.t[known], values[known]),
            color=ink(),
            linewidth=1.8,
            alpha=0.6,
            label="reference",
        )
    unit = "m" if quantity == "height" else "m/s"
    title = f"{printable(recording.name)}: {quantity}".removeprefix(": ")
    return finish(ax, title, "time (s)", f"{quantity} ({unit})", columns=4)


def plot_errors(comparison: Comparison, ax: Axes) -> Axes:
    """Draw rms errors of height and velocity per preset, or where the ride closes without a reference."""
    rows = [row for row in comparison.rows if row.errors is not None]
    at = np.arange(len(rows))
    known = all(row.errors is not None and row.errors.height_rmse is not None for row in rows)
    if rows and known:
        heights = [row.errors.height_rmse or 0.0 for row in rows if row.errors]
        velocities = [row.errors.velocity_rmse or 0.0 for row in rows if row.errors]
        ax.bar(at - 0.2, heights, 0.4, color=DATA, label="height (m)")
        ax.bar(at + 0.2, velocities, 0.4, color=MODEL, hatch="//", label="velocity (m/s)")
        title, y = "Errors against the reference", "rms error"
    else:
        closures = [row.errors.closure for row in rows if row.errors]
        ax.bar(at, closures, 0.6, color=DATA, label="height at the end (m)")
        title, y = "Where the ride ends", "height (m)"
    ax.set_xticks(at, [row.preset for row in rows], rotation=20, ha="right")
    return finish(ax, title, "", y, columns=2)
