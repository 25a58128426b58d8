"""Parquet in and out, with the same columns as CSV; needs pyarrow."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from baroarma.formats.columns import choose_columns
from baroarma.formats.errors import UnreadableError
from baroarma.formats.table import Table

if TYPE_CHECKING:
    from pandas import DataFrame


def read_parquet(path: str, mapping: Mapping[str, str] | None = None) -> Table:
    """Read one Parquet file; parameters, result and errors as `baroarma.formats.csv.read_csv`."""
    parquet = _pyarrow_parquet(path)
    try:
        header = tuple(parquet.read_schema(path).names)
        chosen = choose_columns(path, header, mapping)
        table = parquet.read_table(path, columns=[header[k] for k in chosen.values()])
    except (UnreadableError, FileNotFoundError):
        raise
    except (ValueError, OSError) as error:  # pyarrow's own errors are of these two kinds
        raise UnreadableError(
            f"{path}: this is not a Parquet file, or it is damaged; copy it again"
        ) from error
    values = {}
    for ours, position in chosen.items():
        try:
            values[ours] = table[header[position]].to_pandas().to_numpy(np.float64, na_value=np.nan)
        except (ValueError, TypeError) as error:
            raise UnreadableError(
                f"{path}: {ours} holds something else than numbers; convert it first"
            ) from error
    return Table(path, header, values, place=lambda row: f"row {row + 1}")


def write_parquet(frame: DataFrame, path: str) -> None:
    """Write columns as Parquet."""
    _pyarrow_parquet(path)
    frame.to_parquet(path, engine="pyarrow", index=False)


def _pyarrow_parquet(path: str) -> ModuleType:
    try:
        import pyarrow.parquet
    except ImportError as error:
        raise UnreadableError(f"{path}: Parquet needs pyarrow; pip install 'baroarma[parquet]'") from error
    return pyarrow.parquet  # type: ignore[no-any-return]
