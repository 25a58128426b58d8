"""Rows as they come: CSV lines from a stream, one sample each, for on-line use."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Final, NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from baroarma.formats.bad_lines import NO_SAMPLE, NUMBER
from baroarma.formats.columns import COLUMNS, choose_columns
from baroarma.formats.errors import UnreadableError

SOURCE: Final = "standard input"
LONGEST_LINE: Final = 1 << 16
"""Characters; a longer line is no row."""


class Sample(NamedTuple):
    """One row: time (s), pressure (Pa), specific force (m/s²) and angular rate (rad/s), each (3,); NaN: none.

    The last two are None when the stream has no such columns.
    """

    t: float
    pressure: float
    accel: NDArray[np.float64] | None
    gyro: NDArray[np.float64] | None


def refuse(error: UnreadableError) -> NoReturn:
    """Let the first row that can't be read end the stream."""
    raise error


def sample_reader(
    lines: Iterable[str], bad_row: Callable[[UnreadableError], object] = refuse
) -> Iterator[Sample]:
    """Turn CSV lines, the header first, into samples, each as soon as its line is there.

    Parameters
    ----------
    lines : iterable of str
        Lines with the columns of a recording file; empty lines are passed over.
    bad_row : callable
        Takes what is wrong with a row that can't be read, which names the line.  If it returns, the row is
        skipped, as if it had never been sent; by default it raises.

    Yields
    ------
    Sample
        In SI units.

    Raises
    ------
    UnreadableError
        If the header lacks time or pressure, not one of the rows can be read, time does not increase, or a
        line is endless; and what `bad_row` raises for a row with another number of cells, without a time, or
        with a cell that is no number or can't be.  The message names the line.

    Examples
    --------
    >>> next(sample_reader(["time_s,pressure_hpa", "0.5,1013.25"])).pressure
    101325.0
    >>> lines = ["time_s,pressure_pa", "0.00,101325", "0.02,", "0.04;101326", "0.06,101327"]
    >>> [sample.t for sample in sample_reader(lines, print)]
    standard input, line 4: 1 cells, but the header has 2 columns
    [0.0, 0.02, 0.06]
    """
    numbered = _numbered(lines)
    count, places = _header(next((line for _, line in numbered if line), ""))
    last, first_bad = -math.inf, None
    for i, line in numbered:
        if not line:
            continue
        try:
            sample = _sample(i, line.split(","), count, places)
        except UnreadableError as error:
            first_bad = first_bad or error
            bad_row(error)
            continue
        if not sample.t > last:
            raise UnreadableError(
                f"{SOURCE}, line {i}: time must increase, but {sample.t:g} s follows {last:g} s"
            )
        last = sample.t
        yield sample
    if first_bad and last == -math.inf:
        raise UnreadableError(f"not one row could be read; {first_bad}")


def _header(line: str) -> tuple[int, Mapping[str, int]]:
    """Return how many columns there are, and where ours are."""
    names = [name.strip() for name in line.lstrip("\ufeff").split(",")]
    places = choose_columns(SOURCE, names)
    if not any(COLUMNS[name].field == "pressure" for name in places):
        raise UnreadableError(f"{SOURCE}: there is no pressure among the columns {line!r}; add pressure_pa")
    return len(names), places


def _numbered(lines: Iterable[str]) -> Iterator[tuple[int, str]]:
    if isinstance(lines, io.TextIOBase):  # whose own iterator reads a line however long
        lines = iter(partial(lines.readline, LONGEST_LINE), "")
    try:
        for i, line in enumerate(lines, start=1):
            if len(line) >= LONGEST_LINE:
                raise UnreadableError(
                    f"{SOURCE}, line {i}: it is longer than {LONGEST_LINE} characters; write rows of CSV"
                )
            yield i, line.strip()
    except UnicodeDecodeError as error:
        raise UnreadableError(f"{SOURCE}: this is no text ({error.reason}); write rows of CSV") from error


def _sample(i: int, cells: list[str], count: int, places: Mapping[str, int]) -> Sample:
    if len(cells) != count:
        raise UnreadableError(f"{SOURCE}, line {i}: {len(cells)} cells, but the header has {count} columns")
    vectors = {COLUMNS[name].field for name in places} & {"accel", "gyro"}
    values = {field: np.full(3, math.nan) for field in vectors}
    scalars = {}
    for name, place in places.items():
        column, value = COLUMNS[name], _number(i, cells[place].strip(), name)
        if column.to_si is not None:
            value = float(column.to_si(np.asarray(value)))
        if column.field in vectors:
            values[column.field][column.axis] = value
        else:
            scalars[column.field] = value
    if math.isnan(scalars["t"]):
        raise UnreadableError(f"{SOURCE}, line {i}: the time is missing; every row needs one, in s")
    return Sample(scalars["t"], scalars["pressure"], values.get("accel"), values.get("gyro"))


def _number(i: int, cell: str, name: str) -> float:
    if cell in NO_SAMPLE:
        return math.nan
    column = COLUMNS[name]
    if not NUMBER.fullmatch(cell):
        raise UnreadableError(
            f"{SOURCE}, line {i}: {cell[:40]!r} in column {name} is no number; leave the cell empty where "
            "there is no sample"
        )
    if not column.lowest <= float(cell) <= column.highest:
        raise UnreadableError(
            f"{SOURCE}, line {i}: {name} of {cell[:40]} can't be; "
            f"it must lie between {column.lowest:g} and {column.highest:g}"
        )
    return float(cell)
