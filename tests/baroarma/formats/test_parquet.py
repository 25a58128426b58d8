"""Parquet that can't be read is refused in a sentence; what can is compared in test_formats."""

import sys

import pandas as pd
import pytest

from baroarma.formats import UnreadableError, read


def test_parquet_that_is_none_is_refused(tmp_path):
    (tmp_path / "a.parquet").write_bytes(b"PAR1 nonsense")
    with pytest.raises(UnreadableError, match=r"a\.parquet: this is not a Parquet file"):
        read(tmp_path / "a.parquet")
    with pytest.raises(UnreadableError, match="no such file"):
        read(tmp_path / "b.parquet")


def test_text_in_parquet_is_refused(tmp_path):
    pd.DataFrame({"time_s": [0.0, 1.0], "pressure_pa": ["high", "low"]}).to_parquet(tmp_path / "a.parquet")
    with pytest.raises(UnreadableError, match="pressure_pa holds something else than numbers"):
        read(tmp_path / "a.parquet")


def test_text_that_is_no_text_is_refused(tmp_path):
    """Found by the fuzzer: a byte that is no UTF-8 in a column of text."""
    frame = pd.DataFrame({"time_s": [0.0, 1.0], "pressure_pa": ["101325.0@2", "101325.0@3"]})
    frame.to_parquet(tmp_path / "whole.parquet", compression=None)
    (tmp_path / "a.parquet").write_bytes((tmp_path / "whole.parquet").read_bytes().replace(b"@", b"\xff"))
    with pytest.raises(UnreadableError, match=r"a\.parquet: "):
        read(tmp_path / "a.parquet")


def test_a_bad_value_in_parquet_is_named_by_its_row(tmp_path):
    pd.DataFrame({"time_s": [0.0, 1.0], "pressure_pa": [1e5, -1.0]}).to_parquet(tmp_path / "a.parquet")
    with pytest.raises(UnreadableError, match="row 2: pressure_pa is -1"):
        read(tmp_path / "a.parquet")


def test_missing_pyarrow_is_said_in_a_sentence(tmp_path, monkeypatch):
    (tmp_path / "a.parquet").touch()
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(UnreadableError, match=r"Parquet needs pyarrow; pip install 'baroarma\[parquet\]'"):
        read(tmp_path / "a.parquet")
