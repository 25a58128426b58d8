"""The first line of a file: whether it is a CSV file's, what separates its cells, and the columns' names."""

from __future__ import annotations

import re
from typing import Final

from baroarma.formats.errors import UnreadableError

LONGEST_HEADER: Final = 1 << 16
"""Bytes; a longer first line is no header."""
OTHER_KINDS: Final = {
    b"\x1f\x8b": "gzip; let its name end in .csv.gz",
    b"PK\x03\x04": "a zip archive; let its name end in .zip",
    b"PAR1\x15": "Parquet; let its name end in .parquet",
    b"ULog\x01": "a PX4 log; let its name end in .ulg",
    b"\xa3\x95": "an ArduPilot log; let its name end in .bin",
    b"#ROSBAG V": "a ROS bag; let its name end in .bag",
    b"\x89MCAP": "a ROS bag; let its name end in .mcap",
    b"SQLite format 3\0": "a database, maybe a ROS bag; then let its name end in .db3",
    b"\xff\xfe": "UTF-16 text; save it as UTF-8",
    b"\xfe\xff": "UTF-16 text; save it as UTF-8",
}
"""How files begin that are no CSV -> what they are, and what to do."""


def first_line(path: str, line: bytes, *, packed: bool = False) -> tuple[str, tuple[str, ...]]:
    r"""Return what separates the cells, and the columns' names.

    Parameters
    ----------
    path : str
        The file, for messages.
    line : bytes
        Its beginning, up to the first line feed, at most `LONGEST_HEADER` bytes.
    packed : bool
        Whether that was unpacked; then a message says so.

    Raises
    ------
    UnreadableError
        If no CSV file begins like this; the message says what it is instead.

    Examples
    --------
    >>> first_line("a.csv", b'\xef\xbb\xbf"time_s"; pressure_pa\r\n')
    (';', ('time_s', 'pressure_pa'))
    """
    _refuse_others(path, line, packed=packed)
    try:
        text = line.decode("utf-8-sig").rstrip("\r\n")
    except UnicodeDecodeError:
        text = line.decode("latin-1").rstrip("\r\n")
    if "\r" in text:
        raise UnreadableError(
            f"{path}: lines end in a carriage return alone; save the file with line feeds (\\n or \\r\\n)"
        )
    if any(character < " " and character != "\t" for character in text):
        raise UnreadableError(f"{path}: this is a binary file, not text; convert it to CSV first")
    separator = max(",;\t", key=text.count)
    if separator not in text and re.search(r"\S[ |]+\S", text):
        raise UnreadableError(
            f"{path}: the first line {text[:60]!r} has neither comma, semicolon nor tab; separate the cells "
            "of all lines by one of them"
        )
    return separator, tuple(name.strip().strip('"') for name in text.split(separator))


def _refuse_others(path: str, line: bytes, *, packed: bool) -> None:
    """Refuse what can't be the first line of a CSV file."""
    for magic, what in OTHER_KINDS.items():
        if line.startswith(magic):
            subject = "what is packed in it" if packed else "this"
            raise UnreadableError(f"{path}: {subject} is no plain text but {what}")
    if not line.strip():
        raise UnreadableError(
            f"{path}: the file is empty, or its first line is; line 1 must name the columns"
        )
    if line.startswith(b"#"):
        raise UnreadableError(
            f"{path}: the first line is a comment; delete what stands before the names of the columns"
        )
    if len(line) == LONGEST_HEADER:
        raise UnreadableError(
            f"{path}: the first line is longer than {LONGEST_HEADER} bytes; this is no table"
        )
