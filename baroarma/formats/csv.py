"""CSV in and out: `.csv`, `.csv.gz`, with comma, semicolon (then also decimal comma) or tab.

The file is read in blocks of whole lines, so that a log of several GB is never held as text.  Of each block
the separators are counted, then pandas parses the columns we need; only where that fails `bad_lines`
searches line by line, for the message.  Floats are written in the shortest form that reads back exactly.
"""

from __future__ import annotations

import gzip
import io
import zlib
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, BinaryIO, Final, cast

import numpy as np
from numpy.typing import NDArray

from baroarma.formats.bad_lines import NO_SAMPLE, Dialect, refuse_ragged, refuse_text
from baroarma.formats.columns import choose_columns, only
from baroarma.formats.errors import UnreadableError
from baroarma.formats.table import Table, joined

if TYPE_CHECKING:
    from pandas import DataFrame

Signal = NDArray[np.float64]

BLOCK: Final = 1 << 24
"""Bytes of text that are parsed at a time."""
SMALL: Final = 1 << 20
"""Bytes of text that NumPy parses before pandas would be imported."""
LONGEST_HEADER: Final = 1 << 16
"""Bytes; a longer first line is no header."""
NEWLINE: Final = ord("\n")


def read_csv(path: str, mapping: Mapping[str, str] | None = None) -> Table:
    """Read one CSV file; parameters and errors as `csv_tables`.

    Returns
    -------
    Table
        Its values are not yet checked.
    """
    return joined(list(csv_tables(path, mapping)))


def csv_tables(
    path: str, mapping: Mapping[str, str] | None = None, *, fields: Collection[str] | None = None
) -> Iterator[Table]:
    """Read one CSV file block by block.

    Parameters
    ----------
    path : str
        The file; one whose name ends in ``.gz`` is decompressed.
    mapping : mapping of str to str, optional
        Our column name -> the file's.
    fields : collection of str, optional
        The fields of `Recording` to read; default: all.

    Yields
    ------
    Table
        At least one; its values are not yet checked.

    Raises
    ------
    UnreadableError
        If it is no such file; the message says where and why.
    """
    try:
        with gzip.open(path, "rb") if path.endswith(".gz") else open(path, "rb") as file:
            yield from _read(path, cast(BinaryIO, file), mapping, fields)
    except gzip.BadGzipFile as error:
        raise UnreadableError(
            f"{path}: this is not gzip; drop the .gz from its name if it is plain text"
        ) from error
    except (EOFError, zlib.error) as error:
        raise UnreadableError(f"{path}: the gzip data are cut off or damaged; copy the file again") from error


def write_csv(frame: DataFrame, path: str, *, compress: bool) -> None:
    """Write columns as CSV, or as CSV in gzip without time stamp: equal columns give equal files."""
    if not compress:
        frame.to_csv(path, index=False, lineterminator="\n")
        return
    with open(path, "wb") as raw, gzip.GzipFile("", "wb", compresslevel=6, fileobj=raw, mtime=0) as packed:
        frame.to_csv(packed, index=False, lineterminator="\n")


def _read(
    path: str, file: BinaryIO, mapping: Mapping[str, str] | None, fields: Collection[str] | None
) -> Iterator[Table]:
    separator, header = _header(path, file.readline(LONGEST_HEADER))
    chosen = only(choose_columns(path, header, mapping), fields)
    dialect = Dialect(path, separator, ".", header, chosen)
    line = 2
    for text in _blocks(file):
        if line == 2:
            dialect = dialect._replace(decimal=_decimal(separator, text))
        lines, empty = _check_shape(text, line, dialect)
        values = _parse(text, line, dialect)
        columns = {name: values[:, k] for k, name in enumerate(chosen)}
        yield Table(path, header, columns, _place(line, np.array(empty, int)))
        line += lines
    if line == 2:
        yield Table(path, header, {name: np.empty(0) for name in chosen}, _place(2, np.empty(0, int)))


def _blocks(file: BinaryIO) -> Iterator[bytes]:
    while text := file.read(BLOCK):
        yield text + file.readline()


def _header(path: str, line: bytes) -> tuple[str, tuple[str, ...]]:
    if not line.strip():
        raise UnreadableError(
            f"{path}: the file is empty, or its first line is; line 1 must name the columns"
        )
    text = line.decode("utf-8-sig", errors="replace").rstrip("\r\n")
    if any(character < " " and character != "\t" for character in text) or len(line) == LONGEST_HEADER:
        raise UnreadableError(f"{path}: this is a binary file, not text; convert it to CSV first")
    separator = max(",;\t", key=text.count)
    return separator, tuple(name.strip().strip('"') for name in text.split(separator))


def _decimal(separator: str, text: bytes) -> str:
    return "," if separator == ";" and b"," in text[:100_000] and b"." not in text[:100_000] else "."


def _check_shape(text: bytes, first: int, dialect: Dialect) -> tuple[int, list[int]]:
    """Count the block's lines and list the empty ones; refuse those with too many or too few fields."""
    if b"\0" in text:
        raise UnreadableError(
            f"{dialect.path}: there are zero bytes from line {first} on; this is a binary file"
        )
    array = np.frombuffer(text, np.uint8)
    ends = np.flatnonzero(array == NEWLINE)
    if not text.endswith(b"\n"):
        ends = np.append(ends, len(array))
    fields = _count(array, dialect.separator, ends) + 1
    stray_return = _count(array, "\r", ends) != (array[ends - 1] == ord("\r"))
    odd = np.flatnonzero((fields != len(dialect.header)) | (_count(array, '"', ends) > 0) | stray_return)
    empty = []
    for k in odd:
        line = text[ends[k - 1] + 1 if k else 0 : ends[k]]
        if line.strip():
            refuse_ragged(line, first + int(k), dialect)
        else:
            empty.append(first + int(k))
    return len(ends), empty


def _count(array: NDArray[np.uint8], character: str, ends: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return how often a character stands in each line."""
    return np.diff(np.searchsorted(np.flatnonzero(array == ord(character)), ends), prepend=0)


def _parse(text: bytes, first: int, dialect: Dialect) -> Signal:
    """Return the block's columns in the order of `dialect.chosen`, (n, columns)."""
    order = list(dialect.chosen.values())
    if len(text) < SMALL and dialect.decimal == "." and text.strip():
        with suppress(ValueError):  # an empty cell, or anything else that is no number
            source = io.BytesIO(text)
            return np.loadtxt(source, delimiter=dialect.separator, comments=None, usecols=order, ndmin=2)
    import pandas as pd

    try:
        frame = pd.read_csv(
            io.BytesIO(text),
            sep=dialect.separator,
            decimal=dialect.decimal,
            header=None,
            names=range(len(dialect.header)),
            index_col=False,
            usecols=order,
            dtype=np.float64,
            na_values=list(NO_SAMPLE),
            keep_default_na=False,
            skipinitialspace=True,
            encoding_errors="replace",
            **_exact_floats(pd.__version__),
        )
    except pd.errors.EmptyDataError:
        return np.empty((0, len(order)))
    except (ValueError, OverflowError) as error:
        refuse_text(text, first, dialect, error)
    values: Signal = frame[order].to_numpy()
    return values


def _exact_floats(pandas_version: str) -> dict[str, Any]:
    """Ask for correctly rounded floats where they aren't yet pandas' default."""
    major, minor = pandas_version.split(".")[:2]
    return {} if (int(major), int(minor)) >= (3, 1) else {"float_precision": "round_trip"}


def _place(first: int, empty_lines: NDArray[np.intp]) -> Callable[[int], str]:
    """Return the function that names a row's line, the block's first being `first`; empty lines count too."""
    without = empty_lines - np.arange(len(empty_lines))  # where they would be but for the empty ones before

    def place(row: int) -> str:
        line = row + first
        return f"line {line + int(np.searchsorted(without, line, side='right'))}"

    return place
