"""A table: the columns of one file under our names, checked, and turned into the signals of a recording."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.finding import Finding
from baroarma.formats.columns import COLUMNS, TIME
from baroarma.formats.errors import UnreadableError
from baroarma.formats.seconds import Seconds

Signal = NDArray[np.float64]

MOST_REPEATED: Final = 0.01
"""Share of rows whose time stamp may repeat the one before: a coarse clock's rounding, not a broken one."""
LONGEST_GAP: Final = 1e7
"""In s, 116 days: a longer gap, and one of more than a thousand usual intervals, is a clock that was set."""


@dataclass(frozen=True, eq=False)
class Table:
    """Hold what one file said, in the file's units.

    Parameters
    ----------
    path : str
        The file, for messages.
    header : tuple of str
        All column names of the file.
    values : mapping of str to ndarray
        The columns that we read, by our names, each (n,).
    place : callable
        Row index (from 0) -> where that is in the file, such as ``"line 2"``.
    notes : tuple of Finding
        What was noticed.
    """

    path: str
    header: tuple[str, ...]
    values: Mapping[str, Signal]
    place: Callable[[int], str]
    notes: tuple[Finding, ...] = ()

    def __len__(self) -> int:
        return len(next(iter(self.values.values())))

    def signals(self) -> dict[str, Signal]:
        """Return the signals by the names of `Recording`'s fields, in its units: (n,) or (n, axes)."""
        parts: dict[str, dict[int, Signal]] = {}
        for name, value in self.values.items():
            column = COLUMNS[name]
            si = value if column.to_si is None else column.to_si(value)
            parts.setdefault(column.field, {})[column.axis or 0] = si
        return {
            field: axes[0] if len(axes) == 1 else np.column_stack([axes[k] for k in sorted(axes)])
            for field, axes in parts.items()
        }


def checked(table: Table) -> Table:
    """Return the table with its values checked, without the few rows whose time merely repeats.

    Raises
    ------
    UnreadableError
        At the first value that can't be, or where time doesn't increase.
    """
    if not len(table):
        raise UnreadableError(f"{table.path}: there is a header but no row of data; record something first")
    check = Check()
    good = check.take(table)
    return replace(good, notes=(*table.notes, *check.notes(table.path)))


class Check:
    """Check the tables of one file, one after the other, as if they were one."""

    def __init__(self) -> None:
        self._last, self._rows, self._repeated = -math.inf, 0, 0
        self._standstill: UnreadableError | None = None
        self._seconds = Seconds()

    def take(self, table: Table) -> Table:
        """Return the next table, its time in s, without the rows whose time merely repeats.

        Raises
        ------
        UnreadableError
            At the first value that can't be, or where time runs backwards.
        """
        for name, value in table.values.items():
            _check_range(table, name, value)
        table = replace(table, values=self._seconds.take(table.values))
        steps = self._steps(table)
        self._rows += len(steps)
        keep = steps > 0
        if keep.all():
            return table
        self._repeated += int(np.count_nonzero(~keep))
        self._standstill = self._standstill or _stands_still(table, int(np.argmin(keep)))
        values, rows = {name: value[keep] for name, value in table.values.items()}, np.flatnonzero(keep)
        return replace(table, values=values, place=lambda row: table.place(int(rows[row])))

    def notes(self, path: str) -> tuple[Finding, ...]:
        """Return what was noticed in all tables of the file.

        Raises
        ------
        UnreadableError
            If more rows repeat the time before than a coarse clock makes.
        """
        counted_on = self._seconds.notes(path)
        if self._standstill is None:
            return counted_on
        if self._repeated > MOST_REPEATED * self._rows:
            raise self._standstill
        many = f"{self._repeated} of {self._rows}"
        text = f"{Path(path).name}: {many} rows repeat the time before and were dropped."
        return (*counted_on, Finding("repeated-times", "info", text))

    def _steps(self, table: Table) -> Signal:
        """Return the time before each row; the last time of the table before counts."""
        t = table.values[TIME]
        missing = np.isnan(t)
        if missing.any():
            where = table.place(int(missing.argmax()))
            raise UnreadableError(f"{table.path}, {where}: the time is missing; every row needs one, in s")
        steps = np.diff(t, prepend=self._last)
        if (steps < 0).any():
            row = int((steps < 0).argmax())
            before = t[row - 1] if row else self._last
            raise _bad_time(table, row, before, "runs backwards; sort the rows or split the recording")
        gaps = np.where(steps < math.inf, steps, 0.0)
        if gaps.max(initial=0.0) > LONGEST_GAP and gaps.max() > 1000 * np.median(gaps):
            row = int(gaps.argmax())
            before = t[row - 1] if row else self._last
            raise _bad_time(table, row, before, "jumps as if the clock was set; split the recording there")
        self._last = float(t[-1]) if len(t) else self._last
        return steps


def joined(tables: Sequence[Table]) -> Table:
    """Return the tables of one file as one."""
    starts = list(accumulate((len(table) for table in tables), initial=0))
    places = [table.place for table in tables]

    def place(row: int) -> str:
        which = bisect_right(starts, row, hi=len(places)) - 1
        return places[which](row - starts[which])

    values = {name: np.concatenate([table.values[name] for table in tables]) for name in tables[0].values}
    notes = tuple(note for table in tables for note in table.notes)
    return replace(tables[0], values=values, place=place, notes=notes)


def _check_range(table: Table, name: str, value: Signal) -> None:
    column = COLUMNS[name]
    bad = ~(np.isnan(value) | ((value >= column.lowest) & (value <= column.highest)))
    if bad.any():
        row = int(bad.argmax())
        least = "above 0" if 0 < column.lowest < 1e-300 else f"from {column.lowest:g}"
        raise UnreadableError(
            f"{table.path}, {table.place(row)}: {name} is {value[row]:g}, readable is {least} to "
            f"{column.highest:g}; correct it, or leave the cell empty where there is no sample"
        )


def _stands_still(table: Table, row: int) -> UnreadableError:
    t = float(table.values[TIME][row])
    return _bad_time(table, row, t, "stands still; log it with more digits, or drop the repeated rows")


def _bad_time(table: Table, row: int, before: float, what: str) -> UnreadableError:
    where, t = table.place(row), table.values[TIME][row]
    return UnreadableError(f"{table.path}, {where}: the time is {t:.10g} s after {before:.10g} s: it {what}")
