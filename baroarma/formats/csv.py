"""CSV in and out: `.csv`, `.csv.gz`, with comma, semicolon (then also decimal comma) or tab.

The file is read in blocks of whole lines, so that a log of several GB is never held as text.  Of each block
the separators are counted, then pandas parses the columns we need; only where that fails `bad_lines`
searches line by line, for the message.  Floats are written in the shortest form that reads back exactly.

What could fill the memory is refused: a line of more than 1 MB, and gzip that grows to more than 200 times
its size (and more than 64 MB), where a log grows 3 to 50 times.
"""

from __future__ import annotations

import gzip
import io
import math
import os
import zlib
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, BinaryIO, Final, cast

import numpy as np
from numpy.typing import NDArray

from baroarma.finding import Finding
from baroarma.formats.bad_lines import NO_SAMPLE, Dialect, refuse_ragged, refuse_text
from baroarma.formats.columns import choose_columns, only
from baroarma.formats.errors import UnreadableError, bomb_limit
from baroarma.formats.first_line import LONGEST_HEADER, first_line
from baroarma.formats.table import Table, joined

if TYPE_CHECKING:
    from pandas import DataFrame

Signal = NDArray[np.float64]

BLOCK: Final = 1 << 22
"""Bytes of text that are parsed at a time; line ends alone take forty times as much memory."""
SMALL: Final = 1 << 20
"""Bytes of text that NumPy parses before pandas would be imported."""
LONGEST_LINE: Final = 1 << 20
"""Bytes; a longer line is no row."""
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
        with gzip.open(path, "rb") if _is_packed(path) else open(path, "rb") as file:
            yield from _read(path, cast(BinaryIO, file), mapping, fields)
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        if str(error).startswith("Not a gzipped file"):
            raise UnreadableError(
                f"{path}: this is not gzip; drop the .gz from its name if it is plain text"
            ) from error
        raise UnreadableError(f"{path}: the gzip data are cut off or damaged; copy the file again") from error


def write_csv(frame: DataFrame, path: str, *, compress: bool) -> None:
    """Write columns as CSV, or as CSV in gzip without time stamp: equal columns give equal files."""
    if not compress:
        frame.to_csv(path, index=False, lineterminator="\n")
        return
    with open(path, "wb") as raw, gzip.GzipFile("", "wb", compresslevel=6, fileobj=raw, mtime=0) as packed:
        frame.to_csv(packed, index=False, lineterminator="\n")


def _is_packed(path: str) -> bool:
    return path.lower().endswith(".gz")


def _read(
    path: str, file: BinaryIO, mapping: Mapping[str, str] | None, fields: Collection[str] | None
) -> Iterator[Table]:
    separator, header = first_line(path, file.readline(LONGEST_HEADER), packed=_is_packed(path))
    chosen = only(choose_columns(path, header, mapping), fields)
    dialect = Dialect(path, separator, ".", header, chosen)
    line = 2
    for text in _blocks(path, file):
        if line == 2:
            dialect = dialect._replace(decimal=_decimal(separator, text))
        lines, empty = _check_shape(text, line, dialect)
        values = _parse(text, line, dialect)
        columns = {name: values[:, k] for k, name in enumerate(chosen)}
        yield Table(path, header, columns, _place(line, empty), _unended(path, text))
        line += lines
    if line == 2:
        yield Table(path, header, {name: np.empty(0) for name in chosen}, _place(2, np.empty(0, int)))


def _blocks(path: str, file: BinaryIO) -> Iterator[bytes]:
    most = bomb_limit(os.path.getsize(path)) if _is_packed(path) else math.inf
    size = 0
    while text := file.read(BLOCK):
        text += file.readline(LONGEST_LINE)
        size += len(text)
        if size > most:
            raise UnreadableError(
                f"{path}: the gzip data grow to more than {most / 1e6:.0f} MB, more than a log's would; "
                "unpack the file and look at it"
            )
        yield text


def _unended(path: str, text: bytes) -> tuple[Finding, ...]:
    """Note a last line without end: should the file be cut off there, nothing else tells."""
    if text.endswith((b"\n", b"\r")):
        return ()
    last = repr(text[text.rfind(b"\n") + 1 :].decode("utf-8", "replace")[-40:])
    said = (
        f"{os.path.basename(path)}: the last line has no end; if the file was cut off, {last} is cut off too."
    )
    return (Finding("unended-line", "info", said),)


def _decimal(separator: str, text: bytes) -> str:
    return "," if separator in ";\t" and b"," in text[:100_000] and b"." not in text[:100_000] else "."


def _check_shape(text: bytes, first: int, dialect: Dialect) -> tuple[int, NDArray[np.intp]]:
    """Count the block's lines and list the empty ones; refuse those with too many or too few fields."""
    _refuse_no_lines(text, first, dialect.path)
    array = np.frombuffer(text, np.uint8)
    ends = np.flatnonzero(array == NEWLINE)
    if not text.endswith(b"\n"):
        ends = np.append(ends, len(array))
    lengths = np.diff(ends, prepend=-1) - 1
    ends_in_return = array[ends - 1] == ord("\r")
    is_empty = lengths <= ends_in_return
    stray_return = _count(array, "\r", ends) != ends_in_return
    odd = (_count(array, dialect.separator, ends) + 1 != len(dialect.header)) | stray_return
    odd |= _count(array, '"', ends) > 0
    for k in np.flatnonzero(odd & ~is_empty):
        line = text[ends[k] - lengths[k] : ends[k]]
        if line.strip():
            refuse_ragged(line, first + int(k), dialect)
        else:
            is_empty[k] = True
    return len(ends), first + np.flatnonzero(is_empty)


def _refuse_no_lines(text: bytes, first: int, path: str) -> None:
    if (zero := text.find(0)) >= 0:
        raise UnreadableError(
            f"{path}, line {first + text.count(NEWLINE, 0, zero)}: there are zero bytes, as after a crash or "
            "in a binary file; delete the lines that have them"
        )
    if len(text) >= LONGEST_LINE and b"\n" not in text[-LONGEST_LINE:]:
        raise UnreadableError(
            f"{path}, line {first + text.count(NEWLINE)}: the line is longer than {LONGEST_LINE / 1e6:.0f} "
            "MB; this is no table"
        )


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
