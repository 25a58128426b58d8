"""What the plots share: colours, axes, thinning of long signals.

The colours are those of Okabe and Ito, told apart by colour-blind readers; its black is left out, so that
nothing vanishes on a dark background.  Lines that stand for terms differ in their dashes, too.
"""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes

Signal = NDArray[np.float64]

DATA: Final = "#0072B2"
MODEL: Final = "#D55E00"
WHITE: Final = "#56B4E9"
GAUSS_MARKOV: Final = "#009E73"
DRIFT: Final = "#CC79A7"
MARK: Final = "#E69F00"
BAND: Final[dict[str, Any]] = {"alpha": 0.25, "linewidth": 0}
"""How confidence bands are filled."""


def axes_or_new(ax: Axes | None) -> Axes:
    """Return the given axes, or those of a new pyplot figure."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots(layout="constrained")[1]


def ink() -> str:
    """Return the colour that the user's style gives to axes: dark on light, light on dark."""
    import matplotlib as mpl

    return str(mpl.rcParams["axes.edgecolor"])


def finish(ax: Axes, title: str, x: str, y: str, *, columns: int = 0) -> Axes:
    """Put title, axis labels and, in `columns` columns between title and axes, the legend (0: none).

    There it can hide no data, however they run.
    """
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.grid(alpha=0.25, linewidth=0.6)
    rows = 0
    if columns:
        rows = -(-len(ax.get_legend_handles_labels()[1]) // columns)
        legend = ax.legend(
            loc="lower left",
            bbox_to_anchor=(0, 1),
            ncols=columns,
            frameon=False,
            fontsize="small",
            borderaxespad=0,
            handlelength=1.8,
            columnspacing=1.2,
        )
        legend.set_in_layout(False)  # the title's padding makes the room
    ax.set_title(title, loc="left", fontsize="medium", pad=6 + 13 * rows, parse_math=False)
    return ax


def logarithmic(ax: Axes, which: Literal["x", "both"] = "both") -> None:
    """Make the x axis or both logarithmic, with plain numbers; on a short axis also at 2 and 5.

    To be called when the limits stand.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    ax.set_xscale("log")
    if which == "both":
        ax.set_yscale("log")
    for axis in (ax.xaxis, ax.yaxis)[: 1 if which == "x" else 2]:
        low, high = axis.get_view_interval()
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 100 * low else (1,)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def printable(text: str, most: int = 60) -> str:
    """Return a text that can be drawn, whatever a file name contains, shortened to `most` characters.

    Examples
    --------
    >>> printable("rest" + chr(10) + ".csv")
    'rest�.csv'
    """
    text = text.encode("utf-8", "replace").decode()
    text = "".join(c if c.isprintable() else "\ufffd" for c in text)
    return text if len(text) <= most else text[: most - 1] + "…"


def envelope(t: Signal, y: Signal, bins: int = 700) -> tuple[Signal, Signal]:
    """Thin a long signal for drawing: least and greatest value of each of `bins` groups of samples.

    Nothing that sticks out is lost, and a signal of millions draws like one of a thousand.  Where the
    time jumps by much more than a group, NaN interrupts the line.

    Parameters
    ----------
    t, y : ndarray, shape (n,)
        Times and finite values.
    bins : int
        Number of groups; up to twice as many samples are left as they are.

    Returns
    -------
    t, y : ndarray, shape (at most about 2 bins + gaps,)

    Examples
    --------
    >>> envelope(np.arange(6.0), np.array([0.0, 5.0, 1.0, 1.0, 2.0, -3.0]), bins=2)[1].tolist()
    [0.0, 5.0, -3.0, 2.0]
    """
    if len(t) > 2 * bins:
        first = np.linspace(0, len(t), bins, endpoint=False).astype(int)
        low, high = np.minimum.reduceat(y, first), np.maximum.reduceat(y, first)
        t = np.repeat(t[first], 2)
        y = np.stack((low, high), axis=1).ravel()
    step = np.diff(t)
    if not len(step):
        return t, y
    gaps = np.flatnonzero(step > max(5 * float(np.median(step[step > 0])), (t[-1] - t[0]) / 200)) + 1
    return np.insert(t, gaps, t[gaps]), np.insert(y, gaps, np.nan)


def svg(draw: Callable[[Axes], object], name: str) -> str:
    """Draw a figure as an SVG element to stand inside an HTML page.

    It has no background and takes the page's text colour; it refers to nothing outside itself, and its ids
    don't meet those of other figures on the page.

    Parameters
    ----------
    draw : callable
        A plot with everything but the axes bound.
    name : str
        An identifier that no other figure of the page has.

    Returns
    -------
    str
        Well-formed SVG; the texts in it are escaped.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    style: Any = {"svg.fonttype": "none", "svg.hashsalt": name, "text.usetex": False}
    style |= dict.fromkeys(("text.color", "axes.labelcolor", "axes.edgecolor", "grid.color"), _PAGE_INK)
    style |= dict.fromkeys(("xtick.color", "ytick.color"), _PAGE_INK)
    buffer = io.StringIO()
    with mpl.rc_context(style):
        figure = Figure(figsize=(5.4, 3.7), layout="constrained")
        draw(figure.subplots())
        figure.savefig(buffer, format="svg", transparent=True, metadata=dict.fromkeys(_METADATA))
    return _inline(buffer.getvalue())


_PAGE_INK = "#010203"
"""A colour that no plot uses, to be replaced by the page's own."""
_METADATA = ("Creator", "Date", "Format", "Type")


def _inline(document: str) -> str:
    """Reduce an SVG document to what HTML needs: no prologue, no name spaces, no id that nothing uses."""
    body = document[document.index("<svg") :].replace(_PAGE_INK, "currentColor")
    body = re.sub(r' xmlns(:\w+)?="[^"]*"', "", body).replace("xlink:href=", "href=")
    used = set(re.findall(r'(?:url\(|href=")#([^")]+)', body))
    return re.sub(r' id="([^"]*)"', lambda m: m.group() if m.group(1) in used else "", body)
