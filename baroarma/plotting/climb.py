"""The plot of a climb: its swings between turning points."""

from __future__ import annotations

from typing import TYPE_CHECKING

from baroarma.plotting.canvas import GAUSS_MARKOV, MODEL, axes_or_new, finish, printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from baroarma.climbed import Climb


def plot_climb(climb: Climb, ax: Axes | None = None) -> Axes:
    """Draw the swings that were counted, up and down in two colours and dashes; a track fits beneath.

    Parameters
    ----------
    climb : Climb
        What `baroarma.climb` returned.
    ax : matplotlib.axes.Axes, optional
        Where to draw, such as the axes of ``track.plot()``; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> import numpy as np
    >>> from baroarma.climbed import Climb
    >>> t, height = np.array([0.0, 9.0, 12.0]), np.array([0.0, 3.0, 2.0])
    >>> ax = plot_climb(Climb(3.0, 1.0, 0.1, 0.1, 1, 0, t, height))
    >>> ax.get_legend_handles_labels()[1]
    ['up 3.00 ± 0.10 m', 'down 1.00 ± 0.10 m']
    """
    ax = axes_or_new(ax)
    up = f"up {climb.ascent:.2f} ± {climb.ascent_sd:.2f} m"
    down = f"down {climb.descent:.2f} ± {climb.descent_sd:.2f} m"
    for label, colour, style, upwards in ((up, MODEL, "-", True), (down, GAUSS_MARKOV, "--", False)):
        ax.plot([], [], style, color=colour, linewidth=2, marker="o", markersize=4, label=label)
        for k in range(len(climb.t) - 1):
            if (climb.height[k + 1] > climb.height[k]) == upwards:
                ends = slice(k, k + 2)
                ax.plot(
                    climb.t[ends],
                    climb.height[ends],
                    style,
                    color=colour,
                    linewidth=2,
                    marker="o",
                    markersize=4,
                )
    title = f"{printable(climb.name)}: {climb.floors_up} floors up, {climb.floors_down} down"
    return finish(ax, title.removeprefix(": "), "time (s)", "height (m)", columns=2)
