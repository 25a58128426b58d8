"""A table: the columns of one file under our names, checked, and turned into the signals of a recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.finding import Finding
from baroarma.formats.columns import COLUMNS, TIME
from baroarma.formats.errors import UnreadableError

Signal = NDArray[np.float64]

MOST_REPEATED: Final = 0.01
"""Share of rows whose time stamp may repeat the one before: a coarse clock's rounding, not a broken one."""


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
    if not len(table.values[TIME]):
        raise UnreadableError(f"{table.path}: there is a header but no row of data; record something first")
    for name, value in table.values.items():
        _check_range(table, name, value)
    _check_time(table)
    return _without_repeated_times(table)


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


def _check_time(table: Table) -> None:
    t = table.values[TIME]
    missing = np.isnan(t)
    if missing.any():
        where = table.place(int(missing.argmax()))
        raise UnreadableError(f"{table.path}, {where}: the time is missing; every row needs one, in s")
    back = np.diff(t) < 0
    if back.any():
        _refuse_time(table, int(back.argmax()) + 1, "runs backwards; sort the rows or split the recording")


def _without_repeated_times(table: Table) -> Table:
    t = table.values[TIME]
    keep = np.diff(t, prepend=-np.inf) > 0
    repeated = np.count_nonzero(~keep)
    if repeated > MOST_REPEATED * len(t):
        row = int(np.argmin(keep))
        _refuse_time(table, row, "stands still; log it with more digits, or drop the repeated rows")
    if not repeated:
        return table
    text = f"{Path(table.path).name}: {repeated} of {len(t)} rows repeat the time before and were dropped."
    values = {name: value[keep] for name, value in table.values.items()}
    rows = np.flatnonzero(keep)
    return replace(
        table,
        values=values,
        place=lambda row: table.place(int(rows[row])),
        notes=(*table.notes, Finding("repeated-times", "info", text)),
    )


def _refuse_time(table: Table, row: int, what: str) -> None:
    t = table.values[TIME]
    raise UnreadableError(
        f"{table.path}, {table.place(row)}: the time is {t[row]:.10g} s after {t[row - 1]:.10g} s: it {what}"
    )
