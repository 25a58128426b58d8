"""The columns of a recording's file: their names, their units, and which of a header's columns to read.

A name ends in its unit; each quantity has one column (or one per axis) in one of its units:

    time_s                                       needed, strictly increasing; or else the first there is of
                                                 {time,timestamp}_{ms,us,ns}
    pressure_pa | pressure_hpa | altitude_m      needed in one file of a recording; altitude by the ISA
    acc_{x,y,z}_m_s2 | acc_{x,y,z}_g             specific force
    gyr_{x,y,z}_rad_s | gyr_{x,y,z}_deg_s        angular rate
    temperature_c
    ref_height_m, ref_velocity_m_s               a reference, positive up
    ref_q{x,y,z,w}                               a reference attitude, body to world

An empty cell (or `nan`) means "no sample".  Every other column is ignored.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY, altitude_pressure
from baroarma.formats.bad_lines import NUMBER
from baroarma.formats.errors import UnreadableError

Signal = NDArray[np.float64]


@dataclass(frozen=True)
class Column:
    """Say what a column holds.

    Parameters
    ----------
    field : str
        The field of `Recording` that it fills.
    axis : int, optional
        Which component, for a vector.
    lowest, highest : float
        Readable values, in the column's own unit; wide enough for a wrong unit, which is then named.
    to_si : callable, optional
        Conversion of the column's unit into that of the field; default: it is the same.
    """

    field: str
    axis: int | None = None
    lowest: float = -1e6
    highest: float = 1e6
    to_si: Callable[[Signal], Signal] | None = None


def _g_to_si(value: Signal) -> Signal:
    return value * STANDARD_GRAVITY


def _hpa_to_pa(value: Signal) -> Signal:
    return value * 100.0


def _per_second(count: float) -> Callable[[Signal], Signal]:
    return lambda value: value / count


TIME: Final = "time_s"
_TIMES: Final = {
    f"{name}_{unit}": Column("t", lowest=-1e19, highest=1e19, to_si=_per_second(count))
    for unit, count in (("ms", 1e3), ("us", 1e6), ("ns", 1e9))
    for name in ("time", "timestamp")
}
"""What is read where there is no `TIME`."""
_TINY: Final = float(np.finfo(float).tiny)
_AXES: Final = tuple(enumerate("xyz"))

COLUMNS: Final[Mapping[str, Column]] = {
    TIME: Column("t", lowest=-1e19, highest=1e19),  # nanoseconds since 1970 are 1.8e18
    **_TIMES,
    "pressure_pa": Column("pressure", lowest=_TINY, highest=1e9),
    "pressure_hpa": Column("pressure", lowest=_TINY, highest=1e7, to_si=_hpa_to_pa),
    "altitude_m": Column("pressure", lowest=-1e4, highest=44_000.0, to_si=altitude_pressure),
    **{f"acc_{x}_m_s2": Column("accel", axis) for axis, x in _AXES},
    **{f"acc_{x}_g": Column("accel", axis, to_si=_g_to_si) for axis, x in _AXES},
    **{f"gyr_{x}_rad_s": Column("gyro", axis) for axis, x in _AXES},
    **{f"gyr_{x}_deg_s": Column("gyro", axis, to_si=np.deg2rad) for axis, x in _AXES},
    "temperature_c": Column("temperature", lowest=-273.15),
    "ref_height_m": Column("reference", lowest=-1e9, highest=1e9),
    "ref_velocity_m_s": Column("reference_velocity"),
    **{f"ref_q{x}": Column("reference_attitude", axis) for axis, x in enumerate("xyzw")},
}
"""Every column that is read, by its name."""

WRITTEN: Final = tuple(name for name, column in COLUMNS.items() if column.to_si is None)
"""The columns that are written: those in the units of `Recording`."""


def choose_columns(
    path: str, header: Sequence[str], mapping: Mapping[str, str] | None = None
) -> dict[str, int]:
    """Find our columns in a header.

    Parameters
    ----------
    path : str
        The file, for messages.
    header : sequence of str
        Its column names in order.
    mapping : mapping of str to str, optional
        Our name -> the file's name.  It wins over a column that has our name, or another unit's.

    Returns
    -------
    dict of str to int
        Our name -> position in the header.

    Raises
    ------
    UnreadableError
        If a quantity is there twice, a vector lacks an axis, or there is no time.

    Examples
    --------
    >>> choose_columns("a.csv", ["time_s", "note", "BaroPress"], {"pressure_hpa": "BaroPress"})
    {'pressure_hpa': 2, 'time_s': 0}
    """
    mapped = {ours: theirs for ours, theirs in _checked(mapping).items() if theirs in header}
    fields = {COLUMNS[ours].field for ours in mapped}
    plain = {
        name: name
        for name in header
        if name in COLUMNS and COLUMNS[name].field not in fields and name not in mapped.values()
    }
    times = [name for name in COLUMNS if name in plain and COLUMNS[name].field == "t"]
    chosen = mapped | {name: theirs for name, theirs in plain.items() if name not in times[1:]}
    _refuse_doubles(path, header, chosen)
    _refuse_missing(path, header, chosen)
    return {ours: header.index(theirs) for ours, theirs in chosen.items()}


def only(chosen: dict[str, int], fields: Collection[str] | None) -> dict[str, int]:
    """Return the columns that fill the given fields of `Recording`, and the time; None: all.

    Examples
    --------
    >>> only({"time_s": 0, "pressure_pa": 1, "temperature_c": 2}, {"pressure"})
    {'time_s': 0, 'pressure_pa': 1}
    """
    wanted = {"t", *({column.field for column in COLUMNS.values()} if fields is None else fields)}
    return {name: position for name, position in chosen.items() if COLUMNS[name].field in wanted}


def _checked(mapping: Mapping[str, str] | None) -> Mapping[str, str]:
    for ours in mapping or {}:
        if ours not in COLUMNS:
            raise ValueError(
                f"{ours!r} is no column of ours and can't be mapped; there are {', '.join(COLUMNS)}"
            )
    return mapping or {}


def _refuse_doubles(path: str, header: Sequence[str], chosen: Mapping[str, str]) -> None:
    seen: dict[tuple[str, int | None], str] = {}
    for ours, theirs in chosen.items():
        if header.count(theirs) > 1:
            raise UnreadableError(
                f"{path}: the header names column {theirs!r} {header.count(theirs)} times; keep one"
            )
        column = COLUMNS[ours]
        other = seen.setdefault((column.field, column.axis), theirs)
        if other != theirs:
            raise UnreadableError(
                f"{path}: the columns {other!r} and {theirs!r} are the same quantity; rename one of them"
            )


def _refuse_missing(path: str, header: Sequence[str], chosen: Mapping[str, str]) -> None:
    if not any(COLUMNS[ours].field == "t" for ours in chosen):
        if all(NUMBER.fullmatch(name) for name in header):
            raise UnreadableError(
                f"{path}: the first line holds numbers, {_listed(header)}; put a line above it that names "
                "the columns"
            )
        raise UnreadableError(
            f"{path}: there is no column {TIME!r} among {_listed(header)} in the first line; map it: "
            f"{TIME}=NAME"
        )
    for field, count in (("accel", 3), ("gyro", 3), ("reference_attitude", 4)):
        found = [theirs for ours, theirs in chosen.items() if COLUMNS[ours].field == field]
        if 0 < len(found) < count:
            raise UnreadableError(
                f"{path}: of {count} {field} columns there are only {_listed(found)}; add the others"
            )


def _listed(names: Sequence[str], most: int = 12) -> str:
    shown = ", ".join(repr(name[:40]) for name in names[:most])
    return shown + (f" and {len(names) - most} more" if len(names) > most else "")
