"""Rows as they come: CSV lines from a stream, one sample each, for on-line use."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.formats.columns import COLUMNS, choose_columns
from baroarma.formats.errors import UnreadableError

SOURCE = "standard input"


class Sample(NamedTuple):
    """One row: time (s), specific force (3,) (m/s²), angular rate (3,) (rad/s), pressure (Pa); NaN: none."""

    t: float
    accel: NDArray[np.float64]
    gyro: NDArray[np.float64]
    pressure: float


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
    numbered = ((i, line.strip()) for i, line in enumerate(lines, start=1))
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


def _sample(i: int, cells: list[str], count: int, places: dict[str, int]) -> Sample:
    if len(cells) != count:
        raise UnreadableError(f"{SOURCE}, line {i}: {len(cells)} cells, but the header has {count} columns")
    t, pressure, accel, gyro = math.nan, math.nan, np.full(3, math.nan), np.full(3, math.nan)
    for name, place in places.items():
        column, value = COLUMNS[name], _number(i, cells[place], name)
        if column.to_si is not None:
            value = float(column.to_si(np.asarray(value)))
        if column.field == "t":
            t = value
        elif column.field == "pressure":
            pressure = value
        elif column.axis is not None and column.field in ("accel", "gyro"):
            (accel if column.field == "accel" else gyro)[column.axis] = value
    return Sample(t, accel, gyro, pressure)


def _number(i: int, cell: str, name: str) -> float:
    cell = cell.strip()
    if not cell or cell.lower() == "nan":
        return math.nan
    column = COLUMNS[name]
    try:
        value = float(cell)
    except ValueError:
        raise UnreadableError(f"{SOURCE}, line {i}: {cell[:40]!r} in column {name} is no number") from None
    if not column.lowest <= value <= column.highest:
        raise UnreadableError(
            f"{SOURCE}, line {i}: {name} of {cell[:40]} can't be; "
            f"it must lie between {column.lowest:g} and {column.highest:g}"
        )
    return value
