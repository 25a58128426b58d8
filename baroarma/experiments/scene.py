"""A figure of the papers, redrawn: time functions over the reference, the raw pressure altitude behind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from baroarma.plotting.canvas import DATA, DRIFT, GAUSS_MARKOV, MODEL, WHITE, envelope, finish, ink

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes

Signal = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Scene:
    """Hold what one figure shows.

    Parameters
    ----------
    title, caption : str
        Above and below it.
    x, y : str
        Labels of the axes, with units.
    t : ndarray, shape (n,)
        Abscissa.
    lines : mapping of str to ndarray, shape (n,)
        What is compared, by legend.
    reference, raw : ndarray, shape (n,), optional
        The truth over them; the raw pressure altitude behind them.
    points : bool
        Whether t are a few abscissae to be marked, on logarithmic axes.
    against : str
        What the legend calls the reference.
    """

    title: str
    caption: str
    x: str
    y: str
    t: Signal
    lines: Mapping[str, Signal]
    reference: Signal | None = None
    raw: Signal | None = None
    points: bool = False
    against: str = "reference"

    def draw(self, ax: Axes) -> Axes:
        """Draw it."""
        if self.raw is not None:
            known = np.isfinite(self.raw)
            ax.plot(*envelope(self.t[known], self.raw[known]), color=ink(), alpha=0.25, lw=0.6, label="raw")
        colours = (DATA, MODEL, GAUSS_MARKOV, DRIFT, WHITE)
        marks = "o^sdv"
        for i, (label, values) in enumerate(self.lines.items()):
            style: dict[str, Any] = {"color": colours[i % 5], "label": label}
            if self.points:
                ax.plot(self.t, values, marks[i % 5], **style)
            else:
                ax.plot(*envelope(self.t, values), linewidth=1.1, linestyle=("-", "--", "-.")[i % 3], **style)
        if self.reference is not None:
            xy = (self.t, self.reference) if self.points else envelope(self.t, self.reference)
            ax.plot(*xy, color=ink(), lw=1.6, alpha=0.6, label=self.against)
        if self.points:
            ax.set_xscale("log", base=2)
            ax.set_yscale("log")
        return finish(ax, self.title, self.x, self.y, columns=5)


def cut(t: Signal, start: float, stop: float) -> slice:
    """Return the rows with start <= t < stop."""
    first, last = np.searchsorted(t, (start, stop))
    return slice(int(first), int(last))
