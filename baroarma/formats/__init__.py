"""File formats: files in, recordings out.

`read` turns the files of one recording into a `Recording`: values checked, streams on one clock, held
samples blanked, impossible units named.  `read_all` does so for many.  `write_csv` is the way back.
The columns of our own files are listed in `baroarma.formats.columns`; the logs of others, each told by its
suffix, in the modules `ulog`, `ardupilot`, `phone` and `rosbag`.
"""

from __future__ import annotations

import hashlib
import logging
import os
import stat
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from baroarma.atomic import replacing
from baroarma.formats.columns import COLUMNS, WRITTEN
from baroarma.formats.errors import UnreadableError
from baroarma.formats.held_samples import drop_held_samples
from baroarma.recording import Recording

if TYPE_CHECKING:
    from pandas import DataFrame

    from baroarma.formats.table import Table

__all__ = ["UnreadableError", "drop_held_samples", "read", "read_all", "write_csv"]

logger = logging.getLogger(__name__)
StrPath = str | os.PathLike[str]

LOG_READERS: Final = {
    ".ulg": ("baroarma.formats.ulog", "read_ulog"),
    ".bin": ("baroarma.formats.ardupilot", "read_ardupilot"),
    ".zip": ("baroarma.formats.phone", "read_phone"),
    **dict.fromkeys((".mcap", ".db3", ".bag"), ("baroarma.formats.rosbag", "read_rosbag")),
}
"""Suffix -> module and function that read such a log's streams."""


def read(*paths: StrPath, mapping: Mapping[str, str] | None = None, name: str | None = None) -> Recording:
    r"""Read the file, or the files, of one recording.

    Parameters
    ----------
    *paths : str or path
        CSV (`.csv`, `.csv.gz`) or Parquet (`.parquet`); a log of PX4 (`.ulg`) or ArduPilot (`.bin`); an
        export of phyphox or Sensor Logger (`.zip`, or its folder); a ROS bag (its folder, `.mcap`, `.db3`
        or `.bag`).  Several are streams of one recording on a common clock, of which one has the pressure.
    mapping : mapping of str to str, optional
        Our column name -> the file's, such as ``{"pressure_pa": "BaroPress"}``; for CSV and Parquet.
    name : str, optional
        What to call the recording; default: the first file's name without suffixes.

    Returns
    -------
    Recording
        Held samples are NaN; `notes` says what was noticed, `source` the files' names and SHA-256.

    Raises
    ------
    UnreadableError
        If a file can't be understood; one sentence with file, line, value and what to do.
    ValueError
        Without a file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "bench.csv"
    ...     _ = path.write_text("time_s,pressure_hpa\n0.0,1013.25\n0.1,1013.27\n0.2,\n")
    ...     read(path)
    <Recording 'bench': 3 rows, 0.2 s, pressure 2 samples at 10 Hz>
    """
    if not paths:
        raise ValueError("read() needs at least one file; it got none")
    files = [_file(os.fspath(path), mapping) for path in paths]
    refuse_unused(files, mapping)
    return recording_of(files, name)


def read_all(paths: Sequence[StrPath], *, mapping: Mapping[str, str] | None = None) -> list[Recording]:
    r"""Read many recordings: a file with pressure starts one, files without it belong to the one before.

    Parameters
    ----------
    paths : sequence of str or path
        The files in order.
    mapping : mapping of str to str, optional
        As for `read`; it applies to every file that has such a column.

    Raises
    ------
    UnreadableError
        As `read`; or if the first file has no pressure.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     files = [Path(folder) / name for name in ("night1.csv", "night2.csv")]
    ...     for file in files:
    ...         _ = file.write_text("time_s,pressure_pa\n0.0,101325\n0.1,101327\n0.2,101326\n")
    ...     [recording.name for recording in read_all(files)]
    ['night1', 'night2']
    """
    files = [_file(os.fspath(path), mapping) for path in paths]
    refuse_unused(files, mapping)
    groups: list[list[File]] = []
    for file in files:
        columns = [column for table in file.tables for column in table.values]
        if not groups or any(COLUMNS[column].field == "pressure" for column in columns):
            groups.append([])
        groups[-1].append(file)
    return [recording_of(group, None) for group in groups]


def write_csv(recording: Recording, path: StrPath) -> None:
    """Write a recording with the documented columns, complete or not at all.

    Parameters
    ----------
    recording : Recording
        What to write; name, notes and source are not part of the file.
    path : str or path
        ``.csv.gz`` is compressed, ``.parquet`` becomes Parquet, everything else CSV.  NaN is an empty cell;
        floats read back exactly.

    Examples
    --------
    >>> import tempfile
    >>> rest = Recording(t=[0.0, 0.1, 0.2], pressure=[101325.0, float("nan"), 101327.5])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "rest.csv"
    ...     write_csv(rest, path)
    ...     path.read_text().split()
    ['time_s,pressure_pa', '0.0,101325.0', '0.1,', '0.2,101327.5']
    """
    from baroarma.formats.csv import write_csv as write_text
    from baroarma.formats.parquet import write_parquet

    suffix = Path(path).suffix
    with replacing(path) as temporary:
        if suffix == ".parquet":
            write_parquet(_frame(recording), str(temporary))
        else:
            write_text(_frame(recording), str(temporary), compress=suffix == ".gz")


def _frame(recording: Recording) -> DataFrame:
    import pandas as pd

    columns = {}
    for column in WRITTEN:
        value = getattr(recording, COLUMNS[column].field)
        if value is not None:
            axis = COLUMNS[column].axis
            columns[column] = value if axis is None else value[:, axis]
    return pd.DataFrame(columns)


class File(NamedTuple):
    """A file, or a folder that is one export, and the streams in it."""

    path: str
    tables: Sequence[Table]


def _file(path: str, mapping: Mapping[str, str] | None) -> File:
    from baroarma.formats.table import checked

    try:
        _refuse_devices(path)
        return File(path, [checked(table) for table in _tables(path, mapping)])
    except FileNotFoundError as error:
        raise UnreadableError(f"{path}: there is no such file; check the name") from error
    except OSError as error:
        raise UnreadableError(
            f"{path}: the file can't be opened ({error.strerror}); check its permissions"
        ) from error


def _refuse_devices(path: str) -> None:
    """Refuse what has no end, or can't be read twice: long files are, and their hash is taken."""
    mode = os.stat(path).st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise UnreadableError(
            f"{path}: this is a pipe or a device, not a file; write what it gives into a file first"
        )


def _tables(path: str, mapping: Mapping[str, str] | None) -> Sequence[Table]:
    """Read a file by the reader that its name or its folder's content asks for."""
    kind = os.path.splitext(path)[1].lower()
    if os.path.isdir(path):
        kind = ".mcap" if os.path.isfile(os.path.join(path, "metadata.yaml")) else ".zip"
    module, reader = LOG_READERS.get(kind, ("", ""))
    if module:
        tables: Sequence[Table] = getattr(import_module(module), reader)(path)
        return tables
    if kind == ".parquet":
        from baroarma.formats.parquet import read_parquet

        return [read_parquet(path, mapping)]
    from baroarma.formats.csv import read_csv

    return [read_csv(path, mapping)]


def refuse_unused(files: Sequence[File], mapping: Mapping[str, str] | None) -> None:
    """Refuse a mapping of a column that no file has."""
    headers = {column for file in files for table in file.tables for column in table.header}
    for ours, theirs in (mapping or {}).items():
        if theirs not in headers:
            raise UnreadableError(
                f"{', '.join(file.path for file in files)}: no column is called {theirs!r}, the name "
                f"mapped to {ours}; check its spelling in the first line"
            )


def recording_of(files: Sequence[File], name: str | None) -> Recording:
    """Return the recording that the files are of; held samples and spikes are blanked, other faults named."""
    from baroarma.contents import examined
    from baroarma.formats.streams import merge

    recording = examined(drop_held_samples(merge([table for file in files for table in file.tables])))
    paths = [Path(file.path) for file in files]
    found = replace(
        recording,
        name=_stem(paths) if name is None else name,
        source={"name": " + ".join(_name(path) for path in paths), "sha256": _sha256(paths)},
    )
    logger.info("read %r; noticed: %s", found, ", ".join(note.code for note in found.notes) or "nothing")
    return found


def _name(path: Path) -> str:
    """Return a file's name as text that can be written anywhere: a name may hold any bytes."""
    return os.fsencode(path.name).decode("utf-8", "replace")


def _stem(paths: Sequence[Path]) -> str:
    stem = _name(paths[0])
    if not paths[0].is_dir():
        stem = stem.removesuffix(".gz")
        stem = stem.rpartition(".")[0] or stem
    return stem.removesuffix("_baro") if len(paths) > 1 else stem


def _sha256(paths: Sequence[Path]) -> str:
    """Return the hash of the files one after the other, those of a folder by name."""
    digest = hashlib.sha256()
    for path in paths:
        for part in sorted(path.iterdir()) if path.is_dir() else [path]:
            if part.is_file():
                with part.open("rb") as file:
                    while block := file.read(1 << 20):
                        digest.update(block)
    return digest.hexdigest()
