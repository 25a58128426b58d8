"""What the plots share: colours, axes, thinning of long signals.

The colours are those of Okabe and Ito, told apart by colour-blind readers, with two changes for thin lines on
white paper: sky blue is darker, and a violet stands for orange and yellow, which are too pale.  All have a
contrast of 3:1 or more (WCAG 2.2, 1.4.11) to white and to the reports' dark paper.  Colour is never the only
sign: terms and tracks differ in their dashes, quantities in their hatching.
"""

from __future__ import annotations

import io
import re
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Signal = NDArray[np.float64]

DATA: Final = "#0072B2"
"""What was measured, and what is said about height."""
MODEL: Final = "#D55E00"
"""What a noise model says, and what is said about velocity."""
WHITE: Final = "#2E9BD6"
GAUSS_MARKOV: Final = "#009E73"
DRIFT: Final = "#CC79A7"
MARK: Final = "#7733FF"
"""What is pointed out."""
COLOURS: Final = (DATA, MODEL, GAUSS_MARKOV, DRIFT, WHITE, MARK)
"""Those of several things of one kind, in their order."""
STYLES: Final = ("-", "--", "-.", ":")
BAND: Final[dict[str, Any]] = {"alpha": 0.25, "linewidth": 0}
"""How confidence bands are filled."""


def axes_or_new(ax: Axes | None) -> Axes:
    """Return the given axes, or those of a new pyplot figure."""
    return new_figure(6.4, 4.4).subplots() if ax is None else ax


def new_figure(width: float, height: float) -> Figure:
    """Make a pyplot figure (inches) on opaque paper, on which text can't vanish in a dark notebook."""
    import matplotlib as mpl
    import matplotlib.pyplot as plt
    from matplotlib.colors import to_rgba

    paper = mpl.rcParams["figure.facecolor"]
    if to_rgba(paper)[3] < 1:
        paper = mpl.rcParams["axes.facecolor"]
    return plt.figure(figsize=(width, height), layout="constrained", facecolor=paper)


def ink() -> str:
    """Return the colour that the user's style gives to axes: dark on light, light on dark."""
    import matplotlib as mpl

    return str(mpl.rcParams["axes.edgecolor"])


def truth() -> dict[str, Any]:
    """Return how a reference is drawn: broad, in the colour of the axes, behind what is judged by it."""
    return {"color": ink(), "linewidth": 2.2, "alpha": 0.5, "zorder": 1.9, "label": "reference"}


def one_of_many(i: int) -> dict[str, Any]:
    """Return colour and dashes of the i-th of several lines; the first 24 differ."""
    return {"color": COLOURS[i % len(COLOURS)], "linestyle": STYLES[i // len(COLOURS) % len(STYLES)]}


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


def logarithmic(ax: Axes, which: Literal["x", "y", "both"] = "both") -> None:
    """Make one axis or both logarithmic, with plain numbers; on a short axis also at 2 and 5.

    To be called when the limits stand.  An axis on which nothing is positive stays as it is.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    for name, axis in (("x", ax.xaxis), ("y", ax.yaxis)):
        if which not in (name, "both") or axis.get_data_interval()[1] <= 0:
            continue
        ax.set(**{f"{name}scale": "log"})
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


def legend_text(text: str, most: int = 40) -> str:
    r"""Return a text for a legend or a tick, where matplotlib reads $ as mathematics and hides a first _.

    Examples
    --------
    >>> legend_text("_cost_$x$")
    ' _cost_\\$x\\$'
    """
    text = printable(text, most).replace("$", r"\$")
    return f" {text}" if text.startswith("_") else text


def envelope(t: Signal, y: Signal, bins: int | None = None) -> tuple[Signal, Signal]:
    """Thin a long signal for drawing: least and greatest value of each of `bins` groups of samples.

    Nothing that sticks out is lost, and a signal of millions draws like one of a thousand.  Where the
    time jumps by much more than a group, NaN interrupts the line.

    Parameters
    ----------
    t, y : ndarray, shape (n,)
        Times and finite values.
    bins : int, optional
        Number of groups; up to twice as many samples are left as they are.  Default: `STILL`, or as
        `detailed` has it.

    Returns
    -------
    t, y : ndarray, shape (at most about 2 bins + gaps,)

    Examples
    --------
    >>> envelope(np.arange(6.0), np.array([0.0, 5.0, 1.0, 1.0, 2.0, -3.0]), bins=2)[1].tolist()
    [0.0, 5.0, -3.0, 2.0]
    """
    bins = bins or _DETAIL.get()
    if len(t) > 2 * bins:
        t, low, high = band(t, y, y, bins)
        t = np.repeat(t, 2)
        y = np.stack((low, high), axis=1).ravel()
    step = np.diff(t)
    if not len(step):
        return t, y
    gaps = np.flatnonzero(step > max(5 * float(np.median(step[step > 0])), (t[-1] - t[0]) / 200)) + 1
    return np.insert(t, gaps, t[gaps]), np.insert(y, gaps, np.nan)


STILL: Final = 700
"""Groups of samples that a picture on a screen can show."""
_DETAIL: Final = ContextVar("detail", default=STILL)


@contextmanager
def detailed(bins: int) -> Iterator[None]:
    """Let the plots drawn within thin their lines to so many groups, for a picture that can be enlarged.

    Examples
    --------
    >>> with detailed(5000):
    ...     len(envelope(np.arange(9000.0), np.arange(9000.0))[0])
    9000
    """
    token = _DETAIL.set(bins)
    try:
        yield
    finally:
        _DETAIL.reset(token)


def band(t: Signal, low: Signal, high: Signal, bins: int = STILL) -> tuple[Signal, Signal, Signal]:
    """Thin a long band for drawing: the least of `low` and the greatest of `high` of each group of samples.

    Examples
    --------
    >>> t, low, high = band(np.arange(6.0), np.arange(6.0), np.arange(6.0) + 1, bins=2)
    >>> low.tolist(), high.tolist()
    ([0.0, 3.0], [3.0, 6.0])
    """
    if len(t) <= 2 * bins:
        return t, low, high
    first = np.linspace(0, len(t), bins, endpoint=False).astype(int)
    return t[first], np.minimum.reduceat(low, first), np.maximum.reduceat(high, first)


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
