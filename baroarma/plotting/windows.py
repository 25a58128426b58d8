"""Plots of the windows method: what each window says, and what averages of growing length do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from baroarma.plotting.canvas import (
    BAND,
    GAUSS_MARKOV,
    MODEL,
    STYLES,
    WHITE,
    axes_or_new,
    finish,
    ink,
    logarithmic,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from baroarma.identification.averaging import AveragingStudy
    from baroarma.identification.windows import WindowsResult

SHOWN: Final = {
    "white_sd": ("White noise", "sd (m)", WHITE),
    "correlated_sd": ("Gauss-Markov noise", "sd (m)", GAUSS_MARKOV),
    "correlation_time": ("Its correlation time", "time (s)", GAUSS_MARKOV),
}
"""What is drawn of each window: title, axis, colour."""


def plot_windows(windows: WindowsResult, figure: Figure | None = None) -> Figure:
    """Draw the components of every window over time, their trimmed means and SDs.

    A window whose coefficients no Gauss-Markov plus white noise can have is a cross at the bottom.

    Parameters
    ----------
    windows : WindowsResult
        What the windows method found.
    figure : matplotlib.figure.Figure, optional
        Where to draw; default: a new pyplot figure.

    Returns
    -------
    matplotlib.figure.Figure
        Three axes: white sd, Gauss-Markov sd, correlation time.

    Examples
    --------
    >>> from baroarma import NoiseModel
    >>> from baroarma.identification.windows import identify_windows
    >>> noise = NoiseModel(0.27, 0.75, 0.46, rate_hz=50)
    >>> len(plot_windows(identify_windows(np.arange(15000) / 50, noise.simulate(15000, 1))).axes)
    3
    """
    figure = figure or new_figure(8, 6.4)
    axes = figure.subplots(3, 1, sharex=True)
    for ax, (name, (title, y, colour)) in zip(axes, SHOWN.items(), strict=True):
        values, table = getattr(windows.fits, name), windows.table[name]
        inside = np.isfinite(values)
        ax.plot(windows.start[inside], values[inside], "o", color=colour, markersize=4, label="windows")
        if table.n:
            ax.axhline(table.mean, color=MODEL, linewidth=1.2, label=f"trimmed mean {table.mean:.3g}")
        if table.sd is not None:
            ax.axhspan(
                table.mean - table.sd,
                table.mean + table.sd,
                color=MODEL,
                label=f"± SD {table.sd:.2g}",
                **BAND,
            )
        outside = windows.start[~inside]
        if len(outside):
            bottom = ax.get_xaxis_transform()
            label = f"{len(outside)} outside"
            ax.plot(outside, np.full(len(outside), 0.05), "x", color=ink(), transform=bottom, label=label)
        ax.margins(y=0.15)
        last = ax is axes[-1]
        finish(ax, title, "start of the window (s)" if last else "", y, columns=4)
    return figure


def plot_averaging(study: AveragingStudy, ax: Axes | None = None) -> Axes:
    """Draw the sds that are left after averages of growing length [SG13, Fig. 5].

    Parameters
    ----------
    study : AveragingStudy
        One row per length.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    Averages of four halve the white noise, and the dashed theory with it:

    >>> import matplotlib.pyplot as plt
    >>> from baroarma import NoiseModel
    >>> from baroarma.identification.averaging import averaging_study
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> study = averaging_study(np.arange(15000) / 50, noise.simulate(15000, 1), averages=(1, 4))
    >>> theory = plot_averaging(study).get_lines()[3]
    >>> theory.get_label(), round(float(theory.get_ydata()[0] / theory.get_ydata()[1]), 9)
    ('white by 1/√M', 2.0)
    >>> plt.close("all")
    """
    ax = axes_or_new(ax)
    length = [row.average for row in study.rows]
    for label, sds, colour, marker, dashes in (
        ("total", [row.total_sd.mean for row in study.rows], MODEL, "s", "-"),
        ("Gauss-Markov", [row.correlated_sd.mean for row in study.rows], GAUSS_MARKOV, "^", "-."),
        ("white", [row.white_sd.mean for row in study.rows], WHITE, "o", "--"),
    ):
        ax.plot(length, sds, marker, color=colour, linestyle=dashes, linewidth=1.2, label=label)
    theory = [row.theory_white_sd for row in study.rows]
    ax.plot(length, theory, color=ink(), linestyle=STYLES[3], label="white by 1/√M")
    logarithmic(ax)
    ax.set_xticks(length, [str(m) for m in length])
    title = "Averaging: it lowers the white noise only"
    return finish(ax, title, "length of the average M (samples)", "sd (m)", columns=4)
