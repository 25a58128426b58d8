"""Figures to look closer at: a drawing for a page, and what the page's script needs to zoom into it.

The figure is `plotting.canvas.svg`'s, complete without any script.  With it goes its view: where the axes are
and what they measure, so that a pointer reads values and ticks can be drawn anew, and the samples of long
lines, of which a still picture shows the envelope only.

A curve is coded as places between the corners of the axes, from 0 to 1: of each sample the step in x in units
of 2^-24 (4 bytes) and y in units of 1 / 30 000 (2 bytes), deflated, as base64.  A 50 Hz record takes two to
three bytes a sample so.
"""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.page import Drawing
from baroarma.plotting.canvas import STILL, detailed, envelope, svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Signal = NDArray[np.float64]

SAMPLES: Final = 200_000
"""Samples that the lines of one figure keep together, by default: an hour at 50 Hz, some 0.5 MB."""
SIZE: Final = (4.6, 3.5)
"""Width and height in inches: in a telephone's 343 pixels text is then as large as in print, 10 pixels."""
STEPS_X: Final = 2**24
STEPS_Y: Final = 30_000
NO_SAMPLE: Final = -(2**15)
"""Interrupts a coded line."""
TICKS: Final = {"x": "#010204", "y": "#010205"}
"""Colours that no plot uses: what has them in the drawing is a tick, its label or its grid line."""


def drawing(draw: Callable[[Axes], object], name: str, caption: str, *, samples: int = SAMPLES) -> Drawing:
    """Draw a figure that a reader can zoom into.

    Parameters
    ----------
    draw : callable
        A plot with everything but the axes bound, on linear or logarithmic axes.
    name : str
        An identifier that no other figure of the page has.
    caption : str
        What stands below.
    samples : int
        How many samples the figure's long lines keep for zooming, all together; more show finer detail and
        make the page larger by two to three bytes each.  Longer lines keep least and greatest values.

    Returns
    -------
    Drawing

    Examples
    --------
    >>> t = np.arange(180_000) / 50
    >>> figure = drawing(lambda ax: ax.plot(t, np.sin(t)), "sine", "A sine for an hour.")
    >>> len(figure.svg) < 60_000, len(figure.view) < 1_000_000
    (True, True)
    """
    drawn: list[tuple[Axes, list[Signal]]] = []

    def remember(ax: Axes) -> None:
        with detailed(samples // 2):
            draw(ax)
        for axis, colour in TICKS.items():
            ax.tick_params(axis=axis, which="both", colors=colour, grid_color=colour)  # type: ignore[arg-type]
        for line in ax.lines:
            line.set_clip_on(True)  # what hangs over the edge would stay when the rest moves
        drawn.append((ax, _thin(ax, samples)))
        _fit(ax)

    image = _marked(svg(remember, name))
    return Drawing(image, caption, _view(image, *drawn[0]))


def _fit(ax: Axes) -> None:
    """Make the figure as small as a telephone wants it, but as wide as its legend."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    figure.set_size_inches(*SIZE)
    legend = ax.get_legend()
    if legend is not None:
        figure.draw_without_rendering()
        over = max(legend.get_window_extent().x1 / figure.bbox.width - 1, 0.0)
        figure.set_size_inches(SIZE[0] * (1 + over), SIZE[1] * (1 + over))


def _thin(ax: Axes, samples: int) -> list[Signal]:
    """Reduce long lines to what a still picture can show; return what they were, shape (n, 2) each."""
    lines = [line for line in ax.lines if len(line.get_xdata()) > 2 * STILL]  # type: ignore[arg-type]
    curves: list[Signal] = []
    for line in lines:
        curve = np.asarray(line.get_xydata(), dtype=np.float64)
        curve = curve[np.isfinite(curve).all(axis=1)]
        if len(curve) and (np.diff(curve[:, 0]) >= 0).all():
            x, y = curve.T
            line.set_data(*envelope(x, y, STILL))
            line.set_url(f"#{_CURVE}{len(curves)}")
            curves.append(np.stack(envelope(x, y, samples // 2 // len(lines)), axis=1))
    return curves


_CURVE: Final = "curve-"


def _marked(image: str) -> str:
    """Turn the colours of ticks and the links around curves into marks that the page's script finds."""
    for axis, colour in TICKS.items():
        image = re.sub(rf'style="(?=[^"]*{colour})', f'class="tick-{axis}" style="', image)
        image = image.replace(colour, "currentColor")
    image = re.sub(rf'<a href="#{_CURVE}(\d+)"', r'<g data-curve="\1"', image)
    return image.replace("</a>", "</g>")


def _view(image: str, ax: Axes, curves: list[Signal]) -> str:
    """Return as JSON where the axes are in the drawing, what they measure, and the coded curves."""
    size = re.search(r'viewBox="0 0 (\S+) (\S+)"', image)
    assert size is not None
    width, height = map(float, size.groups())
    left, low, right, top = ax.get_position().extents
    box = [left * width, (1 - top) * height, (right - left) * width, (top - low) * height]
    places = [(ax.transData - ax.transAxes).transform(curve) for curve in curves]
    return json.dumps(
        {
            "box": [round(float(value), 3) for value in box],
            "x": _axis(ax.get_xlabel(), ax.get_xlim(), ax.get_xscale()),
            "y": _axis(ax.get_ylabel(), ax.get_ylim(), ax.get_yscale()),
            "curves": [code(place) for place in places],
        }
    )


def _axis(label: str, limits: tuple[float, float], scale: str) -> dict[str, Any]:
    return {"label": label, "limits": [float(limit) for limit in limits], "log": scale == "log"}


def code(places: Signal) -> str:
    """Code a line for the page's script.

    Parameters
    ----------
    places : ndarray, shape (n, 2)
        Its points in axes from 0 to 1; x does not decrease, NaN in y interrupts.

    Returns
    -------
    str
        Base64 of the deflated steps in x, then y; see the module's docstring.

    Examples
    --------
    >>> raw = zlib.decompress(base64.b64decode(code(np.array([[0.0, 0.5], [0.5, 1.0]]))))
    >>> np.frombuffer(raw, "<i4", 2).tolist(), np.frombuffer(raw, "<i2", offset=8).tolist()
    ([0, 8388608], [15000, 30000])
    """
    x = np.rint(places[:, 0] * STEPS_X).astype("<i4")
    y = np.nan_to_num(np.rint(np.clip(places[:, 1], -1, 1) * STEPS_Y), nan=NO_SAMPLE).astype("<i2")
    raw = np.diff(x, prepend=np.int32(0)).astype("<i4").tobytes() + y.tobytes()
    return base64.b64encode(zlib.compress(raw, 9)).decode()
