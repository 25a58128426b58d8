"""What phones export: phyphox and Sensor Logger, each a zip of CSV files or the folder that was in it.

phyphox [phyphox.org; names of columns from its experiments] writes one file per sensor, on a common clock:

    Time (s)    Pressure (hPa)    Acceleration x (m/s^2) ...    Gyroscope x (rad/s) ...

or, in experiments made in the iOS app, ``X (hPa)``, ``X (m/s^2)`` ..., ``X (rad/s)`` ....  What is called
linear has lost gravity and is not read.  Shorter columns are filled up with NaN.

Sensor Logger [github.com/tszheichoi/awesome-sensor-logger: UNITS, COORDINATES, CROSSPLATFORM] names its files
after the sensor, each with ``seconds_elapsed`` and

    Barometer               pressure (hPa)
    Gyroscope               x, y, z (rad/s)
    TotalAcceleration       x, y, z (m/s2), with gravity
    AccelerometerUncalibrated   x, y, z, with gravity: m/s2, but g on iOS
    Accelerometer           x, y, z (m/s2), without gravity: read only together with Gravity, as their sum

the first of these accelerations that is there.  iOS counts acceleration and gravity downwards, against the
axes; unless "Standardise Units & Frames" was on, its signs are turned here, so that rest reads up.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.finding import Finding
from baroarma.formats.columns import COLUMNS, TIME
from baroarma.formats.csv import read_csv
from baroarma.formats.errors import UnreadableError, bomb_limit
from baroarma.formats.logs import parsing
from baroarma.formats.streams import onto
from baroarma.formats.table import Table

Signal = NDArray[np.float64]
Mapped = dict[str, str]

PHYPHOX_TIME: Final = "Time (s)"
PHYPHOX: Final = {
    r"(pressure|x) \(hPa\)": "pressure_hpa",
    r"(?:acceleration )?([xyz]) \(m/s(?:\^2|²)\)": "acc_{}_m_s2",
    r"(?:gyroscope )?([xyz]) \(rad/s\)": "gyr_{}_rad_s",
}
"""Our column for each of phyphox's that matches wholly, in either case."""
SENSOR_LOGGER: Final = {
    "Barometer": {"pressure_hpa": "pressure"},
    "Gyroscope": {f"gyr_{axis}_rad_s": axis for axis in "xyz"},
    "TotalAcceleration": {f"acc_{axis}_m_s2": axis for axis in "xyz"},
    "AccelerometerUncalibrated": {f"acc_{axis}_m_s2": axis for axis in "xyz"},
    "Accelerometer": {f"acc_{axis}_m_s2": axis for axis in "xyz"},
    "Gravity": {f"acc_{axis}_m_s2": axis for axis in "xyz"},
}

MOST_FILES: Final = 1000
"""CSV files in a zip; an export has one for each of a phone's sensors."""


def read_phone(path: str) -> tuple[Table, ...]:
    """Read one export.

    Parameters
    ----------
    path : str
        A zip file, or a folder with the files that were in it.

    Returns
    -------
    tuple of Table
        One for each sensor; not yet checked.

    Raises
    ------
    UnreadableError
        If it is neither app's export, or one without pressure.
    """
    with _folder(path) as folder:
        files = {file.stem: file for file in sorted(folder.glob("*.csv"))}
        headers = {stem: _header(file) for stem, file in files.items()}
        try:
            if any("seconds_elapsed" in header for header in headers.values()):
                tables = _sensor_logger(files)
            else:
                tables = _phyphox(files, headers)
        except UnreadableError as error:  # name what the user has, not what was unpacked
            raise UnreadableError(str(error).replace(str(folder), path)) from error
    tables = [table for table in tables if len(table.values[TIME])]  # a phone may lack a sensor
    if not any(COLUMNS[column].field == "pressure" for table in tables for column in table.values):
        what = "this is a folder" if os.path.isdir(path) else "this is a zip file"
        raise UnreadableError(
            f"{path}: {what} without pressure from phyphox or Sensor Logger; export the barometer too, "
            "or name a CSV file in it and map its columns"
        )
    return tuple(replace(table, path=table.path.replace(str(folder), path)) for table in tables)


@contextmanager
def _folder(path: str) -> Iterator[Path]:
    """Give the folder with the CSV files, unpacked if need be."""
    if os.path.isdir(path):
        yield Path(path)
        return
    with tempfile.TemporaryDirectory() as folder:
        damaged = "this is not a zip file, or it is damaged"
        with open(path, "rb") as file, parsing(path, damaged), zipfile.ZipFile(file) as archive:
            _unpack(path, archive, Path(folder))
        yield Path(folder)


def _unpack(path: str, archive: zipfile.ZipFile, folder: Path) -> None:
    """Unpack the CSV files, whatever folder they are in, into one folder."""
    members = dict[str, zipfile.ZipInfo]()
    for member in archive.infolist():
        inner = Path(member.filename)
        if inner.suffix != ".csv" or inner.parent.name == "meta":
            continue
        if members.setdefault(inner.name, member) is not member:
            raise UnreadableError(
                f"{path}: there are two files {inner.name!r} in it; unpack it and name one export's folder"
            )
    if len(members) > MOST_FILES:
        raise UnreadableError(f"{path}: {len(members)} CSV files are in it, more than a phone's export has")
    if sum(member.file_size for member in members.values()) > bomb_limit(os.path.getsize(path)):
        raise UnreadableError(
            f"{path}: unpacked it would be more than {bomb_limit(os.path.getsize(path)) / 1e6:.0f} MB, more "
            "than an export's would; unpack the file and look at it"
        )
    for name, member in members.items():
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise NotImplementedError(f"{name!r} is packed by method {member.compress_type}")
        with archive.open(member) as packed, (folder / name).open("wb") as file:
            shutil.copyfileobj(packed, file)


def _header(file: Path) -> list[str]:
    with file.open(encoding="utf-8-sig", errors="replace") as lines:
        return [
            name.strip().strip('"') for name in re.split("[,;\t]", lines.readline(1 << 16).rstrip("\r\n"))
        ]


def _phyphox(files: Mapping[str, Path], headers: Mapping[str, list[str]]) -> list[Table]:
    tables = []
    for stem, file in files.items():
        mapping = {} if stem.lower().startswith("linear") else _phyphox_columns(headers[stem])
        if mapping and PHYPHOX_TIME in headers[stem]:
            tables.append(_without_padding(read_csv(str(file), {TIME: PHYPHOX_TIME, **mapping})))
    return tables


def _phyphox_columns(header: list[str]) -> Mapped:
    columns = {}
    for theirs in header:
        for pattern, ours in PHYPHOX.items():
            if found := re.fullmatch(pattern, theirs, re.IGNORECASE):
                columns[ours.format(found.group(1).lower())] = theirs
    return columns


def _without_padding(table: Table) -> Table:
    """Leave out the rows after the last time stamp: another column of the file was longer."""
    timed = np.flatnonzero(np.isfinite(table.values[TIME]))
    end = timed[-1] + 1 if len(timed) else 0
    return replace(table, values={name: value[:end] for name, value in table.values.items()})


def _sensor_logger(files: Mapping[str, Path]) -> list[Table]:
    def read(stem: str) -> Table:
        return read_csv(str(files[stem]), {TIME: "seconds_elapsed", **SENSOR_LOGGER[stem]})

    points_down = _points_down(files)
    tables = [read(stem) for stem in ("Barometer", "Gyroscope") if stem in files]
    sign = -1.0 if points_down else 1.0
    if "TotalAcceleration" in files:
        tables.append(_scaled(read("TotalAcceleration"), sign))
    elif "AccelerometerUncalibrated" in files:
        unit = STANDARD_GRAVITY if points_down else 1.0
        tables.append(_scaled(read("AccelerometerUncalibrated"), sign * unit))
    elif "Accelerometer" in files and "Gravity" in files:
        tables.append(_scaled(_sum(read("Accelerometer"), read("Gravity")), sign))
    elif "Accelerometer" in files and tables:
        text = (
            "Accelerometer.csv is without gravity and was left out; record TotalAcceleration, "
            "AccelerometerUncalibrated or Gravity too."
        )
        tables[0] = replace(tables[0], notes=(Finding("no-gravity", "warning", text),))
    return tables


def _points_down(files: Mapping[str, Path]) -> bool:
    """Return True if the signs (and the raw unit) are those of iOS."""
    if "Metadata" not in files:
        return False
    lines = files["Metadata"].read_text(encoding="utf-8-sig", errors="replace").splitlines()
    names, values = (line.lower().split(",") for line in (*lines, "", "")[:2])
    said = dict(zip(names, values, strict=False))
    return said.get("platform") == "ios" and said.get("standardisation") != "true"


def _scaled(table: Table, factor: float) -> Table:
    scaled = {name: value if name == TIME else value * factor for name, value in table.values.items()}
    return replace(table, values=scaled)


def _sum(linear: Table, gravity: Table) -> Table:
    """Add gravity to each sample of the acceleration without it."""
    t, own_t = linear.values[TIME], gravity.values[TIME]
    added = {
        name: value if name == TIME else value + onto(t, own_t, gravity.values[name])
        for name, value in linear.values.items()
    }
    return replace(linear, values=added)
