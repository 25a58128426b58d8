"""The page of a bake-off: the table, traces over the reference, what to mind."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from baroarma.page import Drawing, Figures, Page, Section, Table, Text, Verdict, write_page

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
    sections = tuple(comparison_section(c, f"recording-{i + 1}") for i, c in enumerate(comparisons))
    names = ", ".join(c.recording.name for c in comparisons)
    write_page(path, Page(f"Height and velocity: {names}", sections))


def comparison_section(comparison: Comparison, anchor: str) -> Section:
    """Return one recording's part of a page; `anchor` makes its figures' names unique."""
    from baroarma.plotting import plot_errors, plot_traces
    from baroarma.plotting.canvas import svg

    recording = comparison.recording
    findings = (*recording.notes, *comparison.findings)
    over = "" if recording.reference is None else ", over the reference"
    drawings = [
        Drawing(
            svg(partial(_draw, plot_traces, comparison, quantity=quantity), f"{anchor}-{quantity}"),
            f"{quantity.capitalize()} by every preset{over}.",
        )
        for quantity in ("height", "velocity")
    ]
    bars = svg(partial(_draw, plot_errors, comparison), f"{anchor}-errors")
    drawings.append(Drawing(bars, "Shorter is better."))
    warnings = tuple(
        (row.preset, f.code, f.message) for row in comparison.rows for f in comparison.about(row)
    )
    blocks: list[Any] = [
        Verdict(_sentence(comparison), findings),
        _table(comparison),
        Figures(tuple(drawings)),
    ]
    if warnings:
        blocks += [Text("What to mind"), Table(("preset", "finding", "what it means"), warnings)]
    return Section(tuple(blocks), recording.name, anchor)


def _draw(plot: Any, comparison: Comparison, ax: Any, **options: Any) -> None:
    plot(comparison, ax, **options)


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
    head = ("preset", "height RMSE (m)", "velocity RMSE (m/s)", "height bias (m)", "height at the end (m)")
    rows: list[tuple[str, ...]] = []
    for row in comparison.rows:
        if row.errors is None:
            rows.append((row.preset, row.refusal, "", "", ""))
            continue
        e = row.errors
        values = (e.height_rmse, e.velocity_rmse, e.height_bias, e.closure)
        rows.append((row.preset, *("–" if value is None else f"{value:.3f}" for value in values)))
    return Table(head, tuple(rows), "Track and reference are both zeroed over the first second.")
