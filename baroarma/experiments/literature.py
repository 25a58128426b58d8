"""The published numbers, as data files beside this module: what the papers print, in their own units.

A line of ``published/*.csv`` is one number: experiment, paper, table, row label, quantity, unit, value, sd
and a note on what is odd about it.  A number that is printed with neither SD nor repetition may carry a
`tolerance` (the note says why); a claim without a number, such as "p < 0.01", is a `bound`.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import lru_cache
from importlib.resources import files
from typing import Final

PAPERS: Final = ("sg13", "sg14", "lee16")
"""Short names of the papers, and the files' names."""


@dataclass(frozen=True)
class Published:
    """Hold one published number.

    Parameters
    ----------
    experiment, paper, table, label : str
        Where it stands: the experiment that repeats it, the paper, its table or section, the table's row.
    quantity : str
        What it is, with its unit in brackets.
    value, sd : float or None
        As printed; None: not printed.
    rounding : float
        Half a unit of the last printed digit of the value.
    tolerance : float or None
        What stands for an SD where the number has neither SD nor repetition.
    bound : str
        "<0.01" or ">0.05": a claim instead of a number.
    note : str
        What is odd about it.
    """

    experiment: str
    paper: str
    table: str
    label: str
    quantity: str
    value: float | None
    sd: float | None
    rounding: float
    tolerance: float | None
    bound: str
    note: str

    @property
    def key(self) -> tuple[str, str]:
        """Label and quantity: unique within an experiment."""
        return self.label, self.quantity


@lru_cache(maxsize=1)
def published() -> tuple[Published, ...]:
    """Return all published numbers, in the order of papers and tables.

    Examples
    --------
    >>> published()[0].label, published()[0].quantity, published()[0].value
    ('indoors 1', 'correlation time (s)', 0.71)
    """
    return tuple(_published(line) for paper in PAPERS for line in _table(f"{paper}.csv"))


def published_in(experiment: str) -> dict[tuple[str, str], Published]:
    """Return an experiment's published numbers by label and quantity."""
    return {number.key: number for number in published() if number.experiment == experiment}


def reason(experiment: str, label: str, quantity: str) -> str:
    """Return why a number does not reproduce, by someone who looked; empty if nobody knows.

    Examples
    --------
    >>> reason("sg13-table-3", "whitening filter", "DC gain")[:23]
    'the recipe with a = -0.'
    """
    for line in _table("reasons.csv"):
        patterns = line["experiment"], line["label"], line["quantity"]
        names = (experiment, label, quantity)
        if all(fnmatchcase(name, pattern) for name, pattern in zip(names, patterns, strict=True)):
            return line["why"]
    return ""


def _published(line: dict[str, str]) -> Published:
    return Published(
        experiment=line["experiment"],
        paper=line["paper"],
        table=line["table"],
        label=line["label"],
        quantity=line["quantity"] + (f" ({line['unit']})" if line["unit"] else ""),
        value=_number(line["value"]),
        sd=_number(line["sd"]),
        rounding=0.5 * 10.0 ** -len(line["value"].partition(".")[2]),
        tolerance=_number(line["tolerance"]),
        bound=line["bound"],
        note=line["note"],
    )


def _number(text: str) -> float | None:
    return float(text) if text else None


@lru_cache(maxsize=8)
def _table(name: str) -> tuple[dict[str, str], ...]:
    text = files("baroarma.experiments").joinpath("published", name).read_text(encoding="utf-8")
    return tuple(csv.DictReader(text.splitlines()))
