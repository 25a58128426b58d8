"""Parquet in and out, with the same columns as CSV; needs pyarrow."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator, Mapping
from types import ModuleType
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.formats.columns import choose_columns, only
from baroarma.formats.errors import UnreadableError, bomb_limit
from baroarma.formats.table import Table, joined

if TYPE_CHECKING:
    from pandas import DataFrame

ROWS: Final = 1 << 18
"""Rows that are read at a time: 17 MB of eight columns."""
BUFFER: Final = 1 << 20
"""Bytes of a column that are fetched at a time; by default the whole file would stay in memory."""


def read_parquet(path: str, mapping: Mapping[str, str] | None = None) -> Table:
    """Read one Parquet file; parameters, result and errors as `baroarma.formats.csv.read_csv`."""
    return joined(list(parquet_tables(path, mapping)))


def parquet_tables(
    path: str, mapping: Mapping[str, str] | None = None, *, fields: Collection[str] | None = None
) -> Iterator[Table]:
    """Read one Parquet file, some rows at a time; see `baroarma.formats.csv.csv_tables`."""
    pyarrow = _pyarrow(path)
    try:
        with pyarrow.parquet.ParquetFile(path, pre_buffer=False, buffer_size=BUFFER) as file:
            yield from _read(path, file, mapping, fields)
        pyarrow.default_memory_pool().release_unused()  # it would keep a tenth of a GB for the next file
    except (UnreadableError, FileNotFoundError):
        raise
    except (pyarrow.ArrowException, ValueError, OSError) as error:
        raise UnreadableError(
            f"{path}: this is not a Parquet file, or it is damaged; copy it again"
        ) from error


def _read(
    path: str, file: Any, mapping: Mapping[str, str] | None, fields: Collection[str] | None
) -> Iterator[Table]:
    header = tuple(file.schema_arrow.names)
    chosen = only(choose_columns(path, header, mapping), fields)
    _refuse_bombs(path, file.metadata.num_rows)
    before = 0
    for batch in file.iter_batches(ROWS, columns=[header[k] for k in chosen.values()]):
        values = {ours: _numbers(path, ours, batch[header[k]]) for ours, k in chosen.items()}
        yield Table(path, header, values, _place(before))
        before += len(batch)
    if not before:
        yield Table(path, header, {ours: np.empty(0) for ours in chosen}, _place(0))


def _refuse_bombs(path: str, rows: int) -> None:
    """Refuse more rows than the file can have packed: equal cells take no space in it, but in memory."""
    if 8 * rows > bomb_limit(os.path.getsize(path)):
        raise UnreadableError(
            f"{path}: {rows} rows are more than a log of {os.path.getsize(path)} bytes has; look at the file"
        )


def _numbers(path: str, name: str, column: Any) -> NDArray[np.float64]:
    try:
        numbers: NDArray[np.float64] = column.to_pandas().to_numpy(np.float64, na_value=np.nan)
    except (ValueError, TypeError) as error:
        raise UnreadableError(
            f"{path}: {name} holds something else than numbers; convert it first"
        ) from error
    return numbers


def _place(before: int) -> Callable[[int], str]:
    return lambda row: f"row {before + row + 1}"


def write_parquet(frame: DataFrame, path: str) -> None:
    """Write columns as Parquet."""
    _pyarrow(path)
    frame.to_parquet(path, engine="pyarrow", index=False)


def _pyarrow(path: str) -> ModuleType:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise UnreadableError(f"{path}: Parquet needs pyarrow; pip install 'baroarma[parquet]'") from error
    return pyarrow  # type: ignore[no-any-return]
