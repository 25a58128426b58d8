"""What the readers of logs share: optional libraries, streams as tables, what is noted about them.

A log holds several streams, each with its own clock readings: a reader gives one table per stream, with the
pressure in the first, and `baroarma.formats.streams` merges them as it does several CSV files.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from baroarma.finding import Finding
from baroarma.formats.columns import TIME
from baroarma.formats.errors import UnreadableError
from baroarma.formats.table import Table

Signal = NDArray[np.float64]


def optional_module(name: str, path: str, extra: str) -> ModuleType:
    """Import a library that an extra brings, or say how to get it.

    Parameters
    ----------
    name : str
        The module, such as ``"rosbags.highlevel"``.
    path : str
        The file that needs it, for the message.
    extra : str
        The extra that brings it.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise UnreadableError(
            f"{path}: reading it needs {name.partition('.')[0]}; pip install 'baroarma[{extra}]'"
        ) from error


@contextmanager
def parsing(path: str, reason: str) -> Iterator[io.StringIO]:
    """Turn whatever a library's parser raises into one sentence, and swallow what it prints.

    Parsers of binary formats do not say which errors a damaged file may raise, and some print to stdout,
    where our results go.  Numbers that can't be are found later, by their range, not by NumPy's warnings.

    Parameters
    ----------
    path : str
        The file.
    reason : str
        What it means for the user if the parser fails.

    Yields
    ------
    io.StringIO
        What was printed to stderr.
    """
    said = io.StringIO()
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(said), np.errstate(all="ignore"):
            yield said
    except UnreadableError:
        raise
    except Exception as error:
        detail = " ".join(str(error).split())[:200].rstrip(".") or type(error).__name__
        raise UnreadableError(f"{path}: {reason} ({detail}); copy the file again") from error


def stream(path: str, name: str, t: Signal, columns: Mapping[str, Signal]) -> Table:
    """Return one stream of a log as a table, its samples in the order of their time stamps.

    Parameters
    ----------
    path : str
        The log.
    name : str
        What the log calls the stream.
    t : ndarray, shape (n,)
        Time stamps, s, in the order they were logged.
    columns : mapping of str to ndarray
        Our column names -> values, (n,), or (n, 3) for the three columns that ``acc_{}_m_s2`` stands for.

    Examples
    --------
    >>> table = stream("a.ulg", "imu", np.array([1.0, 0.0]), {"gyr_{}_rad_s": np.eye(3)[:2]})
    >>> table.header, table.values["gyr_x_rad_s"].tolist(), table.place(1)
    (('time_s', 'gyr_x_rad_s', 'gyr_y_rad_s', 'gyr_z_rad_s'), [0.0, 1.0], 'imu 2')
    """
    order = np.argsort(t, kind="stable")
    values = {TIME: t[order]}
    for column, value in columns.items():
        parts = zip("xyz", value.T, strict=True) if value.ndim == 2 else [("", value)]
        values |= {column.format(axis): np.asarray(part[order], float) for axis, part in parts}
    return Table(path, tuple(values), values, place=lambda row: f"{name} {row + 1}")


def several_note(path: str, what: str, taken: str, others: Sequence[str]) -> tuple[Finding, ...]:
    """Note which of several sensors was taken; nothing if there was no choice."""
    if not others:
        return ()
    text = (
        f"{Path(path).name} has {1 + len(others)} {what}: {taken} was taken and {', '.join(others)} left out."
    )
    return (Finding("several-sensors", "info", text),)


def damaged_note(path: str) -> tuple[Finding, ...]:
    """Note that a log is damaged though readable."""
    text = f"{Path(path).name} is damaged: what could be read was used; look for gaps and outliers."
    return (Finding("damaged", "warning", text),)
