"""Say what is wrong with a line of CSV: the slow way, once the fast one has failed."""

from __future__ import annotations

import csv
import re
from typing import Final, NamedTuple, NoReturn

from baroarma.formats.errors import UnreadableError

NO_SAMPLE: Final = ("", "nan", "NaN", "NAN")
"""What a cell without a sample may hold."""
NUMBER: Final = re.compile(
    r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?inf(inity)?", re.IGNORECASE | re.ASCII
)


class Dialect(NamedTuple):
    """How a CSV file is written, and which of its columns are ours."""

    path: str
    separator: str
    decimal: str
    header: tuple[str, ...]
    chosen: dict[str, int]
    """Our name -> position in a line."""


def refuse_ragged(line: bytes, number: int, dialect: Dialect) -> None:
    """Raise if a line has too many or too few fields or anything open; return if quotes explain it all."""
    shown = _shown(line.decode("utf-8", "replace"))
    if line.count(b'"') % 2:
        raise UnreadableError(
            f"{dialect.path}, line {number}: a quote isn't closed in {shown}; close or delete it"
        )
    if b"\r" in line.rstrip(b"\r"):
        raise UnreadableError(
            f"{dialect.path}, line {number}: there is a carriage return within {shown}; delete it"
        )
    count = len(_fields(line, dialect))
    if count != len(dialect.header):
        raise UnreadableError(
            f"{dialect.path}, line {number}: there are {count} fields where the header names "
            f"{len(dialect.header)}: {shown}; complete or delete the line"
        )


def refuse_text(text: bytes, first: int, dialect: Dialect, error: Exception) -> NoReturn:
    """Raise for the first cell of our columns that is no number.

    Parameters
    ----------
    text : bytes
        Whole lines that could not be parsed.
    first : int
        The number of the first of them in the file.
    dialect : Dialect
        How they are written.
    error : Exception
        What the parser said; the cause, should no cell be found.
    """
    for number, line in enumerate(text.split(b"\n"), first):
        cells = _fields(line, dialect) if line.strip() else []
        for ours, position in dialect.chosen.items():
            if cells and not _is_number(cells[position], dialect.decimal):
                raise UnreadableError(
                    f"{dialect.path}, line {number}: {ours} is {_shown(cells[position])}, no number; "
                    "correct it, or leave the cell empty where there is no sample"
                ) from error
    raise UnreadableError(
        f"{dialect.path}, after line {first - 1}: the numbers can't be read ({str(error).splitlines()[0]}); "
        "write them plainly, without quotes"
    ) from error


def _fields(line: bytes, dialect: Dialect) -> list[str]:
    text = line.decode("utf-8", errors="replace").rstrip("\r")
    try:
        return next(csv.reader([text], delimiter=dialect.separator, skipinitialspace=True), [])
    except csv.Error:  # a cell of more than 128 kB
        return []


def _is_number(cell: str, decimal: str) -> bool:
    cell = cell.strip()
    return cell in NO_SAMPLE or NUMBER.fullmatch(cell.replace(decimal, ".")) is not None


def _shown(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:60] + "…")
