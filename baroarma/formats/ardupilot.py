"""ArduPilot's dataflash logs, `.bin`; needs pymavlink (LGPL, used as a library).

Messages, fields and units are those of ArduPilot's list of log messages [ardupilot.org, logmessages]:

    BARO   TimeUS (us since boot), I (instance), Press (Pa), Temp (0.01 C, as an integer)
    IMU    TimeUS, I, GyrX GyrY GyrZ (rad/s), AccX AccY AccZ (m/s2)

Older logs have no instance but further messages, BAR2, BAR3 and IMU2, IMU3.  The first instance is taken.
Axes are forward, right, down, and the acceleration is the specific force: a level vehicle at rest reads
AccZ = -9.8, which points up.

The library finds the messages; their bytes are then unpacked all at once, because it takes 20 us for each of
a long log's millions.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from types import ModuleType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.formats.errors import UnreadableError
from baroarma.formats.logs import damaged_note, optional_module, parsing, several_note, stream
from baroarma.formats.table import Table

Signal = NDArray[np.float64]
Message = dict[str, Signal]

HEAD: Final = 3
"""Bytes before a message's fields: two that mark its beginning, and its type."""


def read_ardupilot(path: str) -> tuple[Table, ...]:
    """Read one dataflash log; parameters, result and errors as `baroarma.formats.ulog.read_ulog`."""
    reader = optional_module("pymavlink.DFReader", path, "ardupilot")
    _refuse_other_files(path)
    damaged = "the dataflash log is damaged"
    with parsing(path, damaged) as said, _stderr() as said_in_c, _indexed(reader, path) as log:
        baro, others = _first_instance(_message(reader, log, "BARO"))
        imu, other_imus = _first_instance(_message(reader, log, "IMU"))
        others += _logged(log, "BAR2", "BAR3")
        other_imus += _logged(log, "IMU2", "IMU3")
    if not baro:
        raise UnreadableError(
            f"{path}: the log has no pressure (no BARO message); set LOG_BITMASK to log the barometer"
        )
    notes = several_note(path, "barometers", "the first", others)
    notes += several_note(path, "IMUs", "the first", other_imus)
    notes += damaged_note(path) if said.getvalue() or said_in_c else ()
    return (replace(_barometer(path, baro), notes=notes), *_imu(path, imu))


def _indexed(reader: ModuleType, path: str) -> Any:
    """Open a log without the search for GPS time, which unpacks every message of a log that has none."""
    index_only: Any = type("Index", (reader.DFReader_binary,), {"init_clock": lambda log: None})
    log = index_only.__new__(index_only)
    try:
        log.__init__(path)
    except Exception:  # the library forgets to close a log that it can't index
        log.filehandle.close()
        raise
    return log


def _refuse_other_files(path: str) -> None:
    with open(path, "rb") as file:
        if file.read(2) != b"\xa3\x95":
            raise UnreadableError(
                f"{path}: this is not a dataflash log: it does not begin with A3 95; name another file"
            )


@contextmanager
def _stderr() -> Iterator[list[bytes]]:
    """Collect what the library's C code says on stderr, past Python: it does so about damage only."""
    said: list[bytes] = []
    with tempfile.TemporaryFile() as file:
        saved = os.dup(2)
        os.dup2(file.fileno(), 2)
        try:
            yield said
        finally:
            os.dup2(saved, 2)
            os.close(saved)
        file.seek(0)
        said += file.readlines(1000)


def _message(reader: ModuleType, log: Any, name: str) -> Message:
    """Return the fields of all messages of a name, in the unit that the documentation says; {} for none."""
    if not _logged(log, name):
        return {}
    number = log.name_to_id[name]
    fmt = log.formats[number]
    layout = np.dtype([(c, _dtype(reader, f)) for c, f in zip(fmt.columns, fmt.format, strict=True)])
    starts = np.array(log.offsets[number], np.int64) + HEAD
    starts = starts[starts + layout.itemsize <= log.data_len]  # the last one may be cut off
    windows = np.lib.stride_tricks.sliding_window_view(np.frombuffer(log.data_map, np.uint8), layout.itemsize)
    rows = np.ascontiguousarray(windows[starts]).view(layout)[:, 0]
    factors = zip(fmt.columns, fmt.msg_mults, strict=True)
    return {c: rows[c] * (factor or 1.0) for c, factor in factors if layout[c].kind in "iuf"}


def _logged(log: Any, *names: str) -> list[str]:
    """Return those of the names of which there are messages."""
    return [name for name in names if name in log.name_to_id and log.counts[log.name_to_id[name]]]


def _dtype(reader: ModuleType, letter: str) -> str:
    code: str = reader.FORMAT_TO_STRUCT[letter][0]
    return f"S{code[:-1]}" if code.endswith("s") else "<" + code


def _first_instance(message: Message) -> tuple[Message, list[str]]:
    """Return the messages of the first instance, and the names of the others."""
    if "I" not in message:
        return message, []
    first, *others = np.unique(message["I"])
    chosen = message["I"] == first
    return {c: value[chosen] for c, value in message.items()}, [f"number {k:g}" for k in others]


def _barometer(path: str, baro: Message) -> Table:
    columns = {"pressure_pa": "Press", "temperature_c": "Temp"}
    with parsing(path, "BARO is not as ArduPilot writes it"):
        return stream(path, "BARO", baro["TimeUS"] / 1e6, {ours: baro[c] for ours, c in columns.items()})


def _imu(path: str, imu: Message) -> tuple[Table, ...]:
    if not imu:
        return ()
    columns = {"acc_{}_m_s2": "Acc", "gyr_{}_rad_s": "Gyr"}
    with parsing(path, "IMU is not as ArduPilot writes it"):
        vectors = {ours: np.column_stack([imu[c + axis] for axis in "XYZ"]) for ours, c in columns.items()}
        return (stream(path, "IMU", imu["TimeUS"] / 1e6, vectors),)
