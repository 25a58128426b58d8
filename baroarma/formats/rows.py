"""Rows as they come: CSV lines from a stream, one sample each, for on-line use."""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import Final, NamedTuple

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


def sample_reader(lines: Iterable[str]) -> Iterator[Sample]:
    """Turn CSV lines, the header first, into samples, each as soon as its line is there.

    Parameters
    ----------
    lines : iterable of str
        Lines with the columns of a recording file; empty lines are passed over.

    Yields
    ------
    Sample
        In SI units.

    Raises
    ------
    UnreadableError
        If the header lacks time or pressure, a row has another number of cells, a cell is no number, or time
        does not increase; the message names the line.

    Examples
    --------
    >>> next(sample_reader(["time_s,pressure_hpa", "0.5,1013.25"])).pressure
    101325.0
    """
    numbered = _numbered(lines)
    header = next((line for _, line in numbered if line), "")
    names = [name.strip() for name in header.lstrip("\ufeff").split(",")]
    places = choose_columns(SOURCE, names)
    fields = {COLUMNS[name].field for name in places}
    if "pressure" not in fields:
        raise UnreadableError(f"{SOURCE}: there is no pressure among the columns {header!r}; add pressure_pa")
    last = -math.inf
    for i, line in numbered:
        if not line:
            continue
        sample = _sample(i, line.split(","), len(names), places)
        if not sample.t > last:
            raise UnreadableError(
                f"{SOURCE}, line {i}: time must increase, but {sample.t:g} s follows {last:g} s"
            )
        last = sample.t
        yield sample


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
