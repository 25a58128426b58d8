"""Plots of what trackers make: one track with its bands, and several beside each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from baroarma.metrics import ZEROED_OVER, reference_at
from baroarma.plotting.canvas import (
    BAND,
    DATA,
    MODEL,
    band,
    envelope,
    finish,
    ink,
    legend_text,
    new_figure,
    one_of_many,
    printable,
    truth,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from baroarma.comparison import Comparison, Row
    from baroarma.recording import Recording
    from baroarma.track import Track

Signal = NDArray[np.float64]
Quantity = Literal["height", "velocity"]
UNITS: Final = {"height": "m", "velocity": "m/s"}
PAINT: Final = {"height": DATA, "velocity": MODEL}


def plot_track(track: Track, ax: Axes | None = None, *, reference: Recording | None = None) -> Axes:
    """Draw the height over time with the band of two standard deviations.

    Parameters
    ----------
    track : Track
        Long ones are drawn by their envelope.
    ax : matplotlib.axes.Axes, optional
        Where to draw the height; default: a new figure, in which the velocity stands below it.
    reference : Recording, optional
        Whose reference to draw behind, at the track's level over its first second.

    Returns
    -------
    matplotlib.axes.Axes
        That of the height.

    Raises
    ------
    ValueError
        If the recording has no reference at the track's times.

    Examples
    --------
    >>> from baroarma.simulation import BMP085, simulate
    >>> from baroarma.tracker import Tracker
    >>> squats = simulate("squat", duration=10, seed=1)
    >>> plot_track(Tracker(noise=BMP085.noise).run(squats), reference=squats).get_ylabel()
    'height (m)'
    """
    title = f"{printable(track.name)}: height by {printable(track.preset)}".removeprefix(": ")
    if ax is not None:
        _draw_state(track, "height", ax, reference)
        return finish(ax, title, "time (s)", "height (m)", columns=3)
    ax, below = new_figure(8, 5.6).subplots(2, 1, sharex=True, height_ratios=(3, 2))
    _draw_state(track, "velocity", below, reference)
    finish(below, "Vertical velocity", "time (s)", "velocity (m/s)", columns=3)
    _draw_state(track, "height", ax, reference)
    return finish(ax, title, "", "height (m)", columns=3)


def _draw_state(track: Track, quantity: Quantity, ax: Axes, reference: Recording | None) -> None:
    values, sd = getattr(track, quantity), getattr(track, f"{quantity}_sd")
    if reference is not None:
        ax.plot(*_reference(track, quantity, reference), **truth())
    t, low, high = band(track.t, values - 2 * sd, values + 2 * sd)
    ax.fill_between(t, low, high, color=PAINT[quantity], label="± 2 sd", **BAND)
    ax.plot(*envelope(track.t, values), color=PAINT[quantity], linewidth=1.2, label=quantity)


def _reference(track: Track, quantity: Quantity, recording: Recording) -> tuple[Any, Any]:
    found = reference_at(recording, track.t, 0.0)
    known = np.isfinite(found[0]) if found else np.zeros(len(track), np.bool_)
    if found is None or not known.any():
        raise ValueError(
            f"{recording.name or 'the recording'} has no reference at the track's times; leave it out"
        )
    values = found[1]
    if quantity == "height":
        start = known & (track.t < track.t[known][0] + ZEROED_OVER)
        values = found[0] + np.mean((track.height - found[0])[start])
    there = np.isfinite(values)
    return envelope(track.t[there], values[there])


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

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> from baroarma import compare
    >>> from baroarma.simulation import BMP085, simulate
    >>> squats = simulate("squat", duration=10, seed=1)
    >>> figure = plot_comparison(compare(squats, presets=("sg14-a", "baroarma"), noise=BMP085.noise))
    >>> [ax.get_ylabel() or ax.get_xlabel() for ax in figure.axes]
    ['height (m)', 'velocity (m/s)', 'rms error (m, m/s)']
    >>> plt.close("all")
    """
    rows = len(comparison.rows)
    bars = 1.2 + 0.42 * rows
    figure = new_figure(9, 6.5 + bars)
    height, velocity, errors = figure.subplots(3, 1, height_ratios=(3.25, 3.25, bars))
    plot_traces(comparison, height, "height")
    plot_traces(comparison, velocity, "velocity")
    plot_errors(comparison, errors)
    return figure


def plot_traces(comparison: Comparison, ax: Axes, quantity: Quantity) -> Axes:
    """Draw one quantity, "height" or "velocity", of every track over the reference.

    Heights are zeroed as for the errors: over the reference's first second, or the recording's without one.

    Parameters
    ----------
    comparison : Comparison
        What `baroarma.compare` returned; a preset that refused has no trace.
    ax : matplotlib.axes.Axes
        Where to draw.
    quantity : {"height", "velocity"}
        In m, or in m/s.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> from baroarma.comparison import compare
    >>> from baroarma.simulation import simulate
    >>> table = compare(simulate("squat", duration=20, seed=1), presets=("sg14-a", "lee16"))
    >>> plot_traces(table, plt.figure().subplots(), "height").get_ylabel()
    'height (m)'
    >>> plt.close("all")
    """
    recording = comparison.recording
    found = reference_at(recording, recording.t, comparison.reference_lag)
    known = np.isfinite(found[0]) if found else np.zeros(len(recording), np.bool_)
    since = float(recording.t[known][0] if known.any() else recording.t[0])
    lines = [
        (row.track.t, getattr(row.track, quantity), {"label": legend_text(row.preset), **one_of_many(i)})
        for i, row in enumerate(comparison.rows)
        if row.track is not None
    ]
    if found is not None and known.any():
        lines.append((recording.t, found[0] if quantity == "height" else found[1], truth()))
    for t, values, style in lines:
        there = np.isfinite(values)
        t, values = t[there], values[there]
        if quantity == "height":
            values = values - _level(t, values, max(since, float(t[0])))
        ax.plot(*envelope(t, values), **{"linewidth": 1.0, **style})
    title = f"{printable(recording.name)}: {quantity}".removeprefix(": ")
    return finish(ax, title, "time (s)", f"{quantity} ({UNITS[quantity]})", columns=4)


def _level(t: Signal, values: Signal, since: float) -> float:
    """Return the mean of the second from `since` on; 0 if the values end before."""
    start = (t >= since) & (t < since + ZEROED_OVER)
    return float(values[start].mean()) if start.any() else 0.0


def plot_errors(comparison: Comparison, ax: Axes) -> Axes:
    """Draw rms errors of height and velocity per preset, or where the ride closes without a reference.

    A preset has the colour of its trace.

    Parameters
    ----------
    comparison : Comparison
        What `baroarma.compare` returned; a preset that refused has no bar.
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    The bars are as long as the errors:

    >>> import matplotlib.pyplot as plt
    >>> from baroarma import compare
    >>> from baroarma.simulation import BMP085, simulate
    >>> squats = simulate("squat", duration=10, seed=1)
    >>> table = compare(squats, presets=("sg14-a", "baroarma"), noise=BMP085.noise)
    >>> ax = plot_errors(table, plt.figure().subplots())
    >>> [bar.get_width() for bar in ax.patches[:2]] == [row.errors.height_rmse for row in table.rows]
    True
    >>> plt.close("all")
    """
    rows = [(row, one_of_many(i)["color"]) for i, row in enumerate(comparison.rows) if row.errors is not None]
    known = bool(rows) and all(row.errors.height_rmse is not None for row, _ in rows if row.errors)
    if known:
        _bars(ax, rows, "height_rmse", -0.2, "height (m)")
        _bars(ax, rows, "velocity_rmse", 0.2, "velocity (m/s)", hollow=True)
        title, x = "Errors against the reference", "rms error (m, m/s)"
    else:
        _bars(ax, rows, "closure", 0.0, "height at the end (m)")
        title, x = "Where the ride ends", "height (m)"
    ax.set_yticks(range(len(rows)), [legend_text(row.preset) for row, _ in rows])
    ax.invert_yaxis()
    ax.margins(x=0.12)  # room for the numbers
    finish(ax, title, x, "", columns=2)
    ax.grid(visible=False, axis="y")
    return ax


def _bars(
    ax: Axes, rows: list[tuple[Row, str]], error: str, offset: float, label: str, *, hollow: bool = False
) -> None:
    values = [getattr(row.errors, error) or 0.0 for row, _ in rows]
    colours = [colour for _, colour in rows]
    hatched: dict[str, Any] = {"facecolor": "none", "hatch": "////"}
    at = np.arange(len(rows)) + offset
    style = hatched if hollow else {"facecolor": colours}
    drawn = ax.barh(at, values, 0.36 if offset else 0.6, edgecolor=colours, **style)
    numbers = [f"{value:#.3g}".rstrip(".") for value in values]
    ax.bar_label(drawn, numbers, padding=3, fontsize="x-small")
    # the legend shows the filling, whatever the colour
    ax.barh(0, 0, 0, edgecolor=ink(), label=label, **(hatched if hollow else {"facecolor": ink()}))
