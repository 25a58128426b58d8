"""Height and velocity drawn with characters, for a terminal.

A character holds 2 x 4 dots of Unicode's Braille patterns, or one ``*`` where the terminal's encoding has no
Braille.  Each column of dots shows all samples that fall into it, so that no peak is lost however long the
track; the band of one standard deviation to each side is dotted sparsely.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rich.text import Text

Signal = NDArray[np.float64]
Dots = NDArray[np.bool_]
BRAILLE: Final = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
"""Bit of each dot in a character from U+2800 on [Unicode, Braille patterns]."""
LINE, BAND, NOTHING = 2, 1, 0
STYLES: Final = {LINE: "default", BAND: "cyan", NOTHING: ""}
MARGIN: Final = 8
"""Columns left of a panel, for the scale."""
LEAST_WIDTH, LEAST_HEIGHT = 32, 9
"""A smaller terminal shows numbers only."""
LEAST_SPAN: Final = 0.2
"""Least span of a scale, in m and m/s, so that noise isn't drawn as if it were motion."""


class Rows(NamedTuple):
    """The rows of a track that are drawn: times in s, m and m/s, up, with standard deviations, each (n,)."""

    t: Signal
    height: Signal
    velocity: Signal
    height_sd: Signal
    velocity_sd: Signal


def rows_of(answers: Sequence[tuple[float, ...]]) -> Rows:
    """Turn rows of ``track.csv`` into columns."""
    return Rows(*np.array(answers).T)


def draw(rows: Rows, *, width: int, height: int, span: float | None = None, has_braille: bool = True) -> Text:
    """Draw height and velocity, one above the other.

    Parameters
    ----------
    rows : Rows
        What to draw; at least one row.
    width, height : int
        Columns and lines of characters there are.
    span : float, optional
        Seconds before the last row that the drawing begins with; default: the first row's time.
    has_braille : bool
        Whether the terminal's encoding has Braille patterns and lines; else ASCII is drawn.

    Returns
    -------
    Text
        At most `height` lines, none longer than `width`.
    """
    from rich.text import Text

    title = _numbers(rows)
    if width < LEAST_WIDTH or height < LEAST_HEIGHT:
        return Text("\n".join(part[:width] for part in title[:height]), no_wrap=True)
    first = float(rows.t[0] if span is None else rows.t[-1] - span)
    edges = np.linspace(first, max(float(rows.t[-1]), first + 1e-3), 2 * (width - MARGIN) + 1)
    lines = (height - 3) // 2
    parts: list[Text] = [Text(title[0][:width], "bold")]
    parts += _panel(rows.t, rows.height, rows.height_sd, edges, lines, has_braille)
    parts += [Text(title[1][:width], "bold")]
    parts += _panel(rows.t, rows.velocity, rows.velocity_sd, edges, lines, has_braille)
    parts += [Text(_times(edges, width))]
    return Text("\n", no_wrap=True).join(parts)


def _numbers(rows: Rows) -> tuple[str, str]:
    """Return the last row in words."""
    return (
        f"height {rows.height[-1]:+.2f} m, sd {rows.height_sd[-1]:.2f}, at {rows.t[-1]:.2f} s",
        f"velocity {rows.velocity[-1]:+.2f} m/s, sd {rows.velocity_sd[-1]:.2f}",
    )


def _panel(
    t: Signal, value: Signal, sd: Signal, edges: Signal, lines: int, has_braille: bool
) -> Iterator[Text]:
    """Yield the lines of one drawing, each with its scale."""
    from rich.text import Text

    per_line = 4 if has_braille else 1
    low, high = _limits(value, sd)
    edges = edges if has_braille else edges[::2]
    line, band = _dots(t, value, sd, edges, np.linspace(high, low, per_line * lines + 1))
    labels = _labels(low, high, lines)
    bar = "│" if has_braille else "|"
    marks = _characters(line, band) if has_braille else _ascii(line, band)
    for k, (characters, kinds) in enumerate(zip(*marks, strict=True)):
        text = Text(f"{labels.get(k, ''):>{MARGIN - 1}}{bar}")
        for kind, group in groupby(zip(kinds, characters, strict=True), key=lambda pair: pair[0]):
            text.append("".join(character for _, character in group), STYLES[kind])
        yield text


def _limits(value: Signal, sd: Signal) -> tuple[float, float]:
    """Return the scale's ends: all of the line, and of the band as much as the line spans."""
    least, most = float(value.min()), float(value.max())
    reach = max(most - least, LEAST_SPAN)
    low = max(float((value - sd).min()), least - reach)
    high = min(float((value + sd).max()), most + reach)
    missing = max(0.0, LEAST_SPAN - (high - low)) / 2
    return low - missing, high + missing


def _dots(t: Signal, value: Signal, sd: Signal, edges: Signal, levels: Signal) -> tuple[Dots, Dots]:
    """Return which dots are of the line and which of the band, row after row from the top."""
    low, high = _extremes(t, value, edges)
    bottoms, tops = levels[1:, None], levels[:-1, None]
    line = (low <= tops) & (high >= bottoms)
    middle = (edges[:-1] + edges[1:]) / 2
    centre, width = (np.interp(middle, t, signal, left=math.nan, right=math.nan) for signal in (value, sd))
    band = (centre - width <= tops) & (centre + width >= bottoms)
    return line, band


def _extremes(t: Signal, value: Signal, edges: Signal) -> tuple[Signal, Signal]:
    """Return the least and the greatest value of each column, at its edges too; NaN where there is none."""
    at_edges = np.interp(edges, t, value, left=math.nan, right=math.nan)
    times, first = np.unique(np.concatenate((edges, t)), return_index=True)
    values = np.concatenate((at_edges, value))[first]
    starts = np.searchsorted(times, edges[:-1])
    low = np.fmin(np.fmin.reduceat(values, starts), at_edges[1:])
    high = np.fmax(np.fmax.reduceat(values, starts), at_edges[1:])
    return low, high


def _characters(line: Dots, band: Dots) -> tuple[list[list[str]], list[list[int]]]:
    """Return Braille patterns, and what each one is; a quarter of the band's dots are set."""
    lines, columns = line.shape[0] // 4, line.shape[1] // 2
    row, column = np.indices(band.shape)

    def cells(dots: Dots) -> NDArray[np.int64]:
        bits = dots.reshape(lines, 4, columns, 2) * BRAILLE[:, None, :]
        return np.asarray(bits.sum(axis=(1, 3)))

    of_line, of_band = cells(line), cells(band & ((row + 2 * column) % 4 == 0))
    kinds = np.where(of_line > 0, LINE, np.where(of_band > 0, BAND, NOTHING))
    codes = np.where(of_line > 0, of_line, of_band)
    return [[chr(0x2800 + code) if code else " " for code in row] for row in codes.tolist()], kinds.tolist()


def _ascii(line: Dots, band: Dots) -> tuple[list[list[str]], list[list[int]]]:
    kinds = np.where(line, LINE, np.where(band, BAND, NOTHING))
    return np.choose(kinds, [" ", ".", "*"]).tolist(), kinds.tolist()


def _labels(low: float, high: float, lines: int) -> dict[int, str]:
    """Return line -> number of a panel's scale."""
    step = _step((high - low) / max(2, lines // 2))
    labels: dict[int, str] = {}
    for k in range(math.ceil(low / step), math.floor(high / step) + 1):
        line = min(lines - 1, int((high - k * step) / (high - low) * lines))
        labels.setdefault(line, f"{k * step:.6g}")
    return labels


def _times(edges: Signal, width: int) -> str:
    """Return the line with the times."""
    first, last, columns = float(edges[0]), float(edges[-1]), width - MARGIN
    step, line = _step((last - first) / max(1, columns // 12)), " " * width
    for k in range(math.ceil(first / step), math.floor(last / step) + 1):
        label = f"{k * step:.12g} s"
        at = MARGIN + int((k * step - first) / (last - first) * columns)
        if at + len(label) <= width:
            line = line[:at] + label + line[at + len(label) :]
    return line


def _step(span: float) -> float:
    """Return the next round number: 1, 2 or 5 times a power of ten.

    Examples
    --------
    >>> _step(0.3), _step(7.0)
    (0.5, 10.0)
    """
    power = 10.0 ** math.floor(math.log10(span))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= span * (1 - 1e-9))
