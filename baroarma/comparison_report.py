"""The page of a bake-off: the table, traces over the reference, what to mind."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from baroarma.page import Drawing, Figures, Page, Section, Table, Text, Verdict, write_page
from baroarma.zoomable import SAMPLES, drawing

if TYPE_CHECKING:
    from baroarma.comparison import Comparison, Row


def write_comparison_report(comparisons: Sequence[Comparison], path: str | os.PathLike[str]) -> None:
    """Write a page about bake-offs, a section per recording.

    Parameters
    ----------
    comparisons : sequence of Comparison
        What `baroarma.compare` returned.
    path : path-like
        Where to write the HTML page; it replaces an older one only when it is complete.
    """
    if not comparisons:
        raise ValueError("there is nothing to report; give at least one comparison")
    many = len(comparisons) > 1
    sections = tuple(
        comparison_section(
            comparison,
            f"recording-{i}",
            f"{i}. {comparison.recording.name}" if many else "",
            samples=SAMPLES // len(comparisons),
        )
        for i, comparison in enumerate(comparisons, 1)
    )
    subject = f"{len(comparisons)} recordings" if many else comparisons[0].recording.name or "a recording"
    write_page(path, Page(f"Height and velocity: {subject}", sections))


def comparison_section(
    comparison: Comparison, anchor: str, title: str | None = None, *, samples: int = SAMPLES
) -> Section:
    """Return one recording's part of a page.

    Parameters
    ----------
    comparison : Comparison
        What `baroarma.compare` returned.
    anchor : str
        A name that no other part of the page has.
    title : str, optional
        Heading; default: the recording's name.
    samples : int
        Samples that the plots keep for zooming; see `zoomable.drawing`.
    """
    from baroarma.plotting import plot_errors, plot_traces
    from baroarma.plotting.canvas import svg

    recording = comparison.recording
    over = "" if recording.reference is None else ", over the reference"
    drawings = [
        drawing(
            partial(plot_traces, comparison, quantity=quantity),
            f"{anchor}-{quantity}",
            f"{quantity.capitalize()} by every preset{over}.",
            samples=samples // 2,
        )
        for quantity in ("height", "velocity")
    ]
    bars = svg(partial(plot_errors, comparison), f"{anchor}-errors")
    judged = any(row.errors and row.errors.height_rmse is not None for row in comparison.rows)
    drawings.append(Drawing(bars, _SHORTER if judged else _CLOSED))
    warnings = tuple(
        (row.preset, f.code, f.message) for row in comparison.rows for f in comparison.about(row)
    )
    blocks: list[Any] = [
        _verdict(comparison),
        Text("How well each preset does"),
        _table(comparison),
        Text("Tracks"),
        Figures(tuple(drawings)),
    ]
    if warnings:
        blocks += [Text("What to mind"), Table(("preset", "finding", "what it means"), warnings)]
    return Section(tuple(blocks), recording.name if title is None else title, anchor)


_SHORTER: Final = "Errors of every preset: shorter is better."
_CLOSED: Final = "Height at the end: on a ride that ends where it began, nearer to 0 is better."


def _verdict(comparison: Comparison) -> Verdict:
    findings = (*comparison.recording.notes, *comparison.findings)
    lost = not any(row.errors for row in comparison.rows)
    return Verdict(_sentence(comparison), findings, refused=lost, refusal="No track")


def _sentence(comparison: Comparison) -> str:
    rows = [row for row in comparison.rows if row.errors is not None]
    known = [row for row in rows if row.errors is not None and row.errors.velocity_rmse is not None]
    if not rows:
        return "No preset could track this recording."
    if not known:
        return f"{len(rows)} presets tracked this recording; it has no reference to judge them by."
    best = min(known, key=_velocity_rmse)
    return (
        f"{len(rows)} presets against the reference: {best.preset} has the least velocity error, "
        f"{_velocity_rmse(best):.3g} m/s rms."
    )


def _velocity_rmse(row: Row) -> float:
    assert row.errors is not None
    assert row.errors.velocity_rmse is not None
    return row.errors.velocity_rmse


def _table(comparison: Comparison) -> Table:
    """What is known of every preset; a column that nobody has a value for is left out."""
    errors = [row.errors for row in comparison.rows if row.errors is not None]
    columns = {
        head: name for head, name in _COLUMNS.items() if any(getattr(e, name) is not None for e in errors)
    }
    rows: list[tuple[str, ...]] = []
    for row in comparison.rows:
        values = [getattr(row.errors, name, None) for name in columns.values()]
        cells = ["–" if value is None else f"{value:.3f}" for value in values]
        rows.append((row.preset, *(cells if row.errors else [row.refusal, *[""] * (len(cells) - 1)])))
    what = "Heights are" if comparison.recording.reference is None else "Track and reference are both"
    return Table(("preset", *(columns or ("why not",))), tuple(rows), f"{what} zeroed over the first second.")


_COLUMNS: Final = {
    "height RMSE (m)": "height_rmse",
    "velocity RMSE (m/s)": "velocity_rmse",
    "height bias (m)": "height_bias",
    "height at the end (m)": "closure",
}
