"""Long recordings: one file part by part, in bounded memory, with the numbers of `read`.

Whether readings were held, and which unit the pressure has, are questions to the whole recording.  So the
file is read twice: first its time and pressure (of which 16 bytes a row stay), cleaned as `read` cleans them;
then everything, part by part, with the cleaned pressure in its place.  No border of a part shows.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np

from baroarma.contents import imu_findings
from baroarma.finding import Finding
from baroarma.formats import File, StrPath, recording_of, refuse_unused
from baroarma.formats.columns import COLUMNS, TIME, choose_columns
from baroarma.formats.errors import UnreadableError
from baroarma.formats.table import Check, Table, joined
from baroarma.recording import Recording
from baroarma.spikes import drop_imu_spikes

LONG: Final = 1 << 25
"""Bytes from which a file is worth reading part by part: about half a million rows with an IMU."""
SUFFIXES: Final = (".parquet", ".csv", ".csv.gz")
"""Files that can be read part by part."""


def is_long(path: StrPath, mapping: Mapping[str, str] | None = None) -> bool:
    r"""Return True for a file with pressure that can be read part by part, and is worth it.

    Parameters
    ----------
    path : str or path
        Whatever `read` takes.
    mapping : mapping of str to str, optional
        As for `read`.

    Raises
    ------
    UnreadableError
        If a large file has no header that can be read.

    Examples
    --------
    Worth it are files of 32 MiB or more:

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "log.csv")
    ...     for rows in (3, 3_000_000):
    ...         with open(path, "w") as file:
    ...             print("time_s,pressure_pa", *["0.02,101325"] * rows, sep="\n", file=file)
    ...         is_long(path)
    False
    True
    """
    path = os.fspath(path)
    if not (path.lower().endswith(SUFFIXES) and os.path.isfile(path) and os.path.getsize(path) >= LONG):
        return False
    header = next(_tables(path, mapping, ())).header
    columns = choose_columns(path, header, mapping)
    return any(COLUMNS[name].field == "pressure" for name in columns)


class LongRecording:
    """Read a recording that may be larger than memory.

    Parameters
    ----------
    path : str or path
        A file of `SUFFIXES`.
    mapping : mapping of str to str, optional
        As for `read`.
    start, stop : float
        Leave out rows before and from these times on, s; what was held is judged on the whole file.
    visit : callable, optional
        Is shown every part on the first reading: its rows as logged, before held samples are blanked.

    Raises
    ------
    UnreadableError
        As `read`.

    Examples
    --------
    >>> import tempfile
    >>> from baroarma.formats import write_csv
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "log.csv")
    ...     write_csv(Recording(t=np.arange(500) / 50, pressure=101325 + np.arange(500) % 7), path)
    ...     log = LongRecording(path)
    ...     sum(len(part) for part in log.parts())
    500
    """

    def __init__(
        self,
        path: StrPath,
        *,
        mapping: Mapping[str, str] | None = None,
        start: float = -math.inf,
        stop: float = math.inf,
        visit: Callable[[Recording], None] | None = None,
    ) -> None:
        self.path, self.mapping, self.start, self.stop = os.fspath(path), mapping, start, stop
        self.barometer = self._first_reading(visit)
        """Time and cleaned pressure of all rows, name, source, and what reading noticed."""

    def __repr__(self) -> str:
        return f"<LongRecording of {self.path}: {self.barometer!r}>"

    def parts(self) -> Iterator[Recording]:
        """Yield the rows part by part, as `read` would have them, with the notes known so far."""
        check, row = Check(), 0
        for table in _tables(self.path, self.mapping, None):
            signals = self._cut(check.take(table))
            n = len(signals["t"])
            if n:
                signals["pressure"] = self.barometer.pressure[row : row + n]
                row += n
                part = Recording(**signals, name=self.barometer.name, source=self.barometer.source)
                part = drop_imu_spikes(part)
                yield replace(part, notes=(*self.barometer.notes, *part.notes, *imu_findings(part)))

    def _first_reading(self, visit: Callable[[Recording], None] | None) -> Recording:
        check, found, noticed = Check(), list[Table](), tuple[Finding, ...]()
        for table in _tables(self.path, self.mapping, None if visit else ("pressure",)):
            refuse_unused([File(self.path, [table])], self.mapping)
            table = check.take(table)
            found.append(_barometer_of(table))
            signals = self._cut(table)
            if visit and len(signals["t"]):
                part = Recording(**{"pressure": np.full(len(signals["t"]), np.nan), **signals})
                visit(part)
                part = drop_imu_spikes(part)
                noticed = noticed or (*part.notes, *imu_findings(part))
        whole = joined(found)
        if not len(whole.values[TIME]):
            raise UnreadableError(
                f"{self.path}: there is a header but no row of data; record something first"
            )
        found.clear()
        whole = replace(whole, notes=(*whole.notes, *check.notes(self.path)))
        recording = recording_of([File(self.path, [whole])], None)
        recording = recording.between(self.start, self.stop)
        return replace(recording, notes=(*recording.notes, *noticed))

    def _cut(self, table: Table) -> dict[str, Any]:
        signals = table.signals()
        inside = slice(*np.searchsorted(signals["t"], (self.start, self.stop)).tolist())
        return {field: value[inside] for field, value in signals.items()}


def _tables(path: str, mapping: Mapping[str, str] | None, fields: Collection[str] | None) -> Iterator[Table]:
    if path.lower().endswith(".parquet"):
        from baroarma.formats.parquet import parquet_tables

        return parquet_tables(path, mapping, fields=fields)
    from baroarma.formats.csv import csv_tables

    return csv_tables(path, mapping, fields=fields)


def _barometer_of(table: Table) -> Table:
    """Return time and pressure alone, copied so that the other columns can go."""
    values = {
        name: value.copy() for name, value in table.values.items() if COLUMNS[name].field in ("t", "pressure")
    }
    return replace(table, values=values)
