"""What an experiment returns: rows of published and reproduced numbers, with the assumptions behind ours."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from baroarma.experiments.significance import asterisks

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Row:
    """Hold a published and a reproduced number.

    Parameters
    ----------
    label, quantity : str
        Row of the table, and what it is with its unit; the pair is unique within an experiment.
    published, published_sd : float or None
        As printed; None: not printed.
    reproduced, reproduced_sd : float or None
        Mean over trials and SD as the paper's; None: there is none.
    trials : int
        Trials that had a value.
    verdict : str
        By the rule of `verdict.judge`; empty for a row that is only ours.

    Examples
    --------
    Two trials of something that nobody published; mean and SD of 0.4 and 0.6:

    >>> from baroarma.experiments import Experiment
    >>> from baroarma.experiments.trials import Measurement
    >>> tossed = [{("coin", "heads (1)"): Measurement(share)} for share in (0.4, 0.6)]
    >>> Experiment("tosses", "Tossing a coin", (), measure=len).result(tossed).rows[0]
    Row(label='coin', ..., published=None, ..., reproduced=0.5, reproduced_sd=0.1414..., trials=2, verdict='')
    """

    label: str
    quantity: str
    published: float | None
    published_sd: float | None
    reproduced: float | None
    reproduced_sd: float | None
    trials: int
    verdict: str


@dataclass(frozen=True, repr=False)
class Result:
    """Hold the table of one experiment.

    Parameters
    ----------
    experiment, title : str
        Its name and a line about it.
    assumptions : tuple of str
        What stands in for the paper's hardware, and how the paper was read.
    rows : tuple of Row
        The table.
    notes : tuple of str
        What is odd about the published numbers.

    Examples
    --------
    >>> height = Row("Method A", "height RMSE (m)", 0.40, 0.15, 0.33, 0.10, 10, "within 1 SD")
    >>> velocity = Row("Method A", "velocity RMSE (m/s)", 0.07, 0.01, 0.085, 0.02, 10, "within 2 SD")
    >>> found = Result("sg14-table-2", "At rest", (), (height, velocity))
    >>> found
    <Result of sg14-table-2: 2 published numbers: 1 within 1 SD, 1 within 2 SD, 0 differ>
    >>> found.to_frame()["published"].tolist()
    [0.4, 0.07]
    """

    experiment: str
    title: str
    assumptions: tuple[str, ...]
    rows: tuple[Row, ...]
    notes: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the documented JSON object."""
        return {
            "experiment": self.experiment,
            "assumptions": list(self.assumptions),
            "rows": [asdict(row) for row in self.rows],
        }

    def __repr__(self) -> str:
        return f"<Result of {self.experiment}: {self.tally()}>"

    def tally(self) -> str:
        """Count the verdicts in a sentence."""
        return tally([self])

    def to_frame(self) -> pd.DataFrame:
        """Return the table as a pandas DataFrame, a row per number; what there isn't is NaN."""
        import pandas as pd

        numbers = dict.fromkeys(("published", "published_sd", "reproduced", "reproduced_sd"), float)
        return pd.DataFrame([asdict(row) for row in self.rows]).astype(numbers)

    def _repr_html_(self) -> str:
        from baroarma.notebook import remarks, tables
        from baroarma.page import Table

        rows, reasons = self.cells()
        numbered = tuple((f"[{i}]", why) for i, why in enumerate(reasons, 1))
        return tables(
            Table(HEAD, tuple(rows), f"{self.experiment}: {self.title}. {self.tally()}"),
            *((Table(("", "why it differs"), numbered),) if numbered else ()),
            *remarks((*self.assumptions, *self.notes)),
        )

    def plot(self) -> Figure:
        """Draw published beside reproduced numbers; see `baroarma.plotting.plot_result`."""
        from baroarma.plotting import plot_result

        return plot_result(self)

    def cells(self) -> tuple[list[tuple[str, ...]], list[str]]:
        """Return the table's cells as text, and the reasons that its verdicts refer to by number."""
        reasons: list[str] = []
        rows: list[tuple[str, ...]] = [
            (r.label, r.quantity, _number(r.published, r.published_sd), _ours(r), _short(r.verdict, reasons))
            for r in self.rows
        ]
        return rows, reasons

    def summary(self, width: int = 110) -> str:
        """Return assumptions, table, reasons and notes as text.

        Parameters
        ----------
        width : int
            Where lines of prose are wrapped, characters.
        """
        rows, reasons = self.cells()
        widths = [max(map(len, column)) for column in zip(HEAD, *rows, strict=True)]
        lines = [f"{self.experiment}: {self.title}", f"  {self.tally()}"]
        lines += [_wrap(f"- {a}", width, 4) for a in self.assumptions]
        for cells in (HEAD, *rows):
            padded = (cell.ljust(w) for cell, w in zip(cells, widths, strict=True))
            lines.append(("  " + "  ".join(padded)).rstrip())
        lines += [_wrap(f"[{i}] {why}", width, 6) for i, why in enumerate(reasons, 1)]
        lines += [_wrap(f"* {note}", width, 4) for note in self.notes]
        return "\n".join(lines)


HEAD = ("row", "quantity", "published", "ours", "verdict")
"""Head of the table as people see it."""


def tally(results: Sequence[Result]) -> str:
    """Count the verdicts of several experiments in a sentence.

    Parameters
    ----------
    results : sequence of Result
        Of any experiments.

    Returns
    -------
    str
        Numbers by their distance from the published ones, and claims (p < ...) that are met.

    Examples
    --------
    >>> rows = [
    ...     Row("A", "height RMSE (m)", 0.40, 0.15, 0.33, 0.10, 10, "within 1 SD"),
    ...     Row("A", "velocity RMSE (m/s)", 0.07, 0.01, 0.20, 0.02, 10, "differs: of a reason"),
    ...     Row("A against B", "height RMSE (p)", None, None, 0.002, None, 10, "agrees: published <0.01"),
    ... ]
    >>> tally([Result("mine", "Mine", (), tuple(rows))])
    '2 published numbers: 1 within 1 SD, 0 within 2 SD, 1 differ; 1 of 1 claims met'
    """
    judged = [row for result in results for row in result.rows if row.published is not None]
    claims = [row.verdict for result in results for row in result.rows if row.published is None]
    count = Counter("differ" if r.verdict.startswith("differs") else r.verdict for r in judged)
    parts = [f"{count.pop(kind, 0)} {kind}" for kind in ("within 1 SD", "within 2 SD", "differ")]
    parts += [f"{sum(count.values())} not judged"] if count else []
    agreeing, differing = (sum(v.startswith(w) for v in claims) for w in ("agrees", "differs"))
    text = f"{len(judged)} published numbers: {', '.join(parts)}"
    return text + (f"; {agreeing} of {agreeing + differing} claims met" if agreeing + differing else "")


def _ours(row: Row) -> str:
    text = _number(row.reproduced, row.reproduced_sd)
    stars = asterisks(row.reproduced) if row.reproduced is not None and "(p)" in row.quantity else ""
    return f"{text} {stars}".strip()


def _number(value: float | None, sd: float | None) -> str:
    if value is None:
        return "–"
    digits = next(d for d, least in enumerate((100.0, 10.0, 1.0, 0.0)) if abs(value) >= least)
    return f"{value:.{digits}f}" + ("" if sd is None else f" ± {sd:.{digits}f}")


def _short(verdict: str, reasons: list[str]) -> str:
    """Put a long reason among the others and return its number."""
    if not verdict.startswith("differs: "):
        return verdict
    why, _, claim = verdict.removeprefix("differs: ").partition(" (published ")
    if why not in reasons:
        reasons.append(why)
    return f"differs [{reasons.index(why) + 1}]" + (f" (published {claim}" if claim else "")


def _wrap(text: str, width: int, indent: int) -> str:
    return textwrap.fill(text, width, initial_indent="  ", subsequent_indent=" " * indent)
