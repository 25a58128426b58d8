"""The page of the experiments: tables, reasons, assumptions, and the papers' figures redrawn."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence

from baroarma.experiments.result import HEAD, Result, tally
from baroarma.experiments.scene import Scene
from baroarma.page import Block, Figures, Page, Section, Table, write_page
from baroarma.zoomable import SAMPLES, drawing


def write_report(
    results: Sequence[Result], scenes: Mapping[str, Iterable[Scene]], path: str | os.PathLike[str]
) -> None:
    """Write the page.

    Parameters
    ----------
    results : sequence of Result
        Tables, one section each.
    scenes : mapping of str to scenes
        Figures by experiment.
    path : path-like
        Where to write; an older page stays until the new one is complete.
    """
    figures = {result.experiment: tuple(scenes.get(result.experiment, ())) for result in results}
    samples = SAMPLES // max(sum(map(len, figures.values())), 1)
    sections = tuple(_section(result, figures[result.experiment], samples) for result in results)
    lead = (
        f"{tally(results)}. 'Within 1 SD' means |ours - published| within the published SD, or, where "
        "none is published, within the SD of our trials."
    )
    contents = (_contents(results),) if len(results) > 1 else ()
    write_page(path, Page("What the papers say, what we measured", (*contents, *sections), lead))


def _contents(results: Sequence[Result]) -> Section:
    head = ("experiment", "what", "verdicts")
    rows = tuple((r.experiment, r.title, r.tally()) for r in results)
    return Section((Table(head, rows, anchors=tuple(r.experiment for r in results)),), "Experiments")


def _section(result: Result, scenes: Iterable[Scene], samples: int) -> Section:
    rows, reasons = result.cells()
    blocks: list[Block] = [Table(HEAD, tuple(rows), result.tally())]
    if reasons:
        numbered = tuple((f"[{i}]", why) for i, why in enumerate(reasons, 1))
        blocks.append(Table(("", "why"), numbered))
    drawings = tuple(
        drawing(scene.draw, f"{result.experiment}-{i}", f"{scene.title}. {scene.caption}", samples=samples)
        for i, scene in enumerate(scenes)
    )
    if drawings:
        blocks.append(Figures(drawings))
    for head, texts in (
        ("assumption", result.assumptions),
        ("oddity of the published numbers", result.notes),
    ):
        if texts:
            blocks.append(Table(("", head), tuple((str(i), text) for i, text in enumerate(texts, 1))))
    return Section(tuple(blocks), f"{result.experiment}: {result.title}", result.experiment)
