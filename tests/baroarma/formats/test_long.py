"""A long file read part by part is the file read at once."""

import tracemalloc
from dataclasses import fields, replace

import numpy as np
import pandas as pd
import pytest

from baroarma.formats import UnreadableError, csv, long, parquet, read, write_csv
from baroarma.formats.long import LongRecording, is_long
from baroarma.simulation import simulate

SUFFIXES = (".csv", ".csv.gz", ".parquet")


@pytest.fixture(scope="module")
def log():
    """A minute with an IMU at 50 Hz and a barometer of 10 Hz that the logger held."""
    recording = simulate("squat", duration=60, seed=4)
    rows = np.arange(len(recording)) // 5 * 5
    return replace(recording, pressure=recording.pressure[rows], reference_attitude=None)


@pytest.fixture
def small_parts(monkeypatch):
    """Parts of 333 rows, or of so few bytes of text."""
    monkeypatch.setattr(parquet, "ROWS", 333)
    monkeypatch.setattr(csv, "BLOCK", 20_001)


def together(parts):
    for field in fields(parts[0])[:8]:
        columns = [getattr(part, field.name) for part in parts]
        yield field.name, None if columns[0] is None else np.concatenate(columns)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_parts_are_the_whole_held_samples_and_all(log, tmp_path, small_parts, suffix):
    write_csv(log, path := tmp_path / f"log{suffix}")
    whole, long_one = read(path), LongRecording(path)
    parts = list(long_one.parts())
    assert len(parts) > 5
    assert np.isnan(whole.pressure).mean() == pytest.approx(0.8, abs=0.01)  # four of five were held
    for name, column in together(parts):
        np.testing.assert_array_equal(column, getattr(whole, name), err_msg=name)
    assert long_one.barometer.notes == parts[0].notes == whole.notes
    assert long_one.barometer.source == parts[0].source == whole.source
    assert long_one.barometer.name == parts[0].name == whole.name == "log"


def test_rows_before_and_after_are_left_out_after_the_cleaning(log, tmp_path, small_parts):
    write_csv(log, path := tmp_path / "log.csv")
    whole, long_one = read(path).between(7.011, 33.3), LongRecording(path, start=7.011, stop=33.3)
    for name, column in together(list(long_one.parts())):
        np.testing.assert_array_equal(column, getattr(whole, name), err_msg=name)
    np.testing.assert_array_equal(long_one.barometer.pressure, whole.pressure)


def test_a_visitor_sees_all_rows_as_logged(log, tmp_path, small_parts):
    write_csv(log, path := tmp_path / "log.csv")
    seen = []
    LongRecording(path, visit=seen.append)
    np.testing.assert_array_equal(np.concatenate([part.pressure for part in seen]), log.pressure)
    np.testing.assert_array_equal(np.concatenate([part.gyro for part in seen]), log.gyro)


def frame(n=2000):
    return pd.DataFrame({"time_s": np.arange(n) / 50, "pressure_pa": 101325 + np.arange(n) % 7 * 1.5})


@pytest.mark.parametrize("row", [332, 333, 334])  # the border of two parts lies before row 333
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_clock_that_runs_backwards_is_named_as_read_names_it(tmp_path, small_parts, suffix, row):
    table = frame()
    table.loc[row, "time_s"] = 1.0
    path = tmp_path / f"log{suffix}"
    table.to_parquet(path) if suffix == ".parquet" else table.to_csv(path, index=False)
    with pytest.raises(UnreadableError, match="runs backwards") as whole:
        read(path)
    with pytest.raises(UnreadableError) as in_parts:
        LongRecording(path)
    assert str(in_parts.value) == str(whole.value)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_repeated_times_are_counted_over_all_parts(tmp_path, small_parts, suffix):
    table, path = frame(), tmp_path / f"log{suffix}"
    table.loc[[333, 700], "time_s"] = table.time_s[[332, 699]].to_numpy()
    table.to_parquet(path) if suffix == ".parquet" else table.to_csv(path, index=False)
    whole, long_one = read(path), LongRecording(path)
    assert "2 of 2000 rows repeat" in str(long_one.barometer.notes)
    assert long_one.barometer.notes == whole.notes
    np.testing.assert_array_equal(np.concatenate([part.t for part in long_one.parts()]), whole.t)


def test_a_clock_that_stands_still_too_often_is_refused_as_by_read(tmp_path, small_parts):
    table, path = frame(), tmp_path / "log.csv"
    table["time_s"] = np.round(table.time_s, 1)
    table.to_csv(path, index=False)
    with pytest.raises(UnreadableError, match="stands still") as whole:
        read(path)
    with pytest.raises(UnreadableError) as in_parts:
        LongRecording(path)
    assert str(in_parts.value) == str(whole.value)


def test_what_read_refuses_is_refused(tmp_path, small_parts):
    frame()[:0].to_csv(empty := tmp_path / "empty.csv", index=False)
    frame()[["time_s"]].to_csv(blind := tmp_path / "blind.csv", index=False)
    frame().to_csv(good := tmp_path / "good.csv", index=False)
    for path, mapping, why in (
        (empty, None, "no row of data"),
        (blind, None, "no pressure"),
        (good, {"temperature_c": "warmth"}, "no column is called 'warmth'"),
    ):
        with pytest.raises(UnreadableError, match=why):
            LongRecording(path, mapping=mapping)


def test_a_gyro_in_the_wrong_unit_is_noticed_where_it_turns_fast(log, tmp_path, small_parts):
    gyro = log.gyro.copy()
    gyro[1500:1510] = 400.0  # a lone row would be a spike
    write_csv(replace(log, gyro=gyro), path := tmp_path / "log.csv")
    notes = LongRecording(path, visit=lambda part: None).barometer.notes
    assert [note.message for note in notes] == [note.message for note in read(path).notes]
    assert "deg/s" in notes[-1].message


def test_only_large_files_with_pressure_are_long(tmp_path, monkeypatch):
    frame().to_csv(path := tmp_path / "log.csv", index=False)
    frame().rename(columns={"pressure_pa": "temperature_c"}).to_csv(
        other := tmp_path / "acc.csv", index=False
    )
    assert not is_long(path)
    monkeypatch.setattr(long, "LONG", path.stat().st_size)
    assert is_long(path)
    assert not is_long(other)
    assert is_long(other, {"pressure_pa": "temperature_c"})
    assert not is_long(tmp_path)
    assert not is_long(tmp_path / "nothing.csv")


def test_the_parts_need_no_more_memory_than_a_part(tmp_path, monkeypatch):
    monkeypatch.setattr(parquet, "ROWS", 10_000)
    n = 200_000
    table = frame(n).assign(
        **{f"{s}_{x}_{u}": 0.5 for s, u in (("acc", "m_s2"), ("gyr", "rad_s")) for x in "xyz"}
    )
    table.to_parquet(path := tmp_path / "log.parquet")
    long_one = LongRecording(path)
    tracemalloc.start()
    rows = sum(len(part) for part in long_one.parts())
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert rows == n
    part = 10_000 * 8 * 8
    assert peak < 6 * part < n * 8 * 8 / 3  # a part before and after each conversion, and the one before it


@pytest.mark.parametrize("block", [1 << 22, 60])
def test_a_clock_that_was_set_is_named_within_a_part_and_between_parts(tmp_path, monkeypatch, block):
    monkeypatch.setattr(csv, "BLOCK", block)
    rows = "".join(f"{k + (1_770_000_000 if k > 5 else 0)},{101_325 + k % 3}\n" for k in range(12))
    (path := tmp_path / "log.csv").write_text("time_s,pressure_pa\n" + rows)
    said = "line 8: the time is 1770000006 s after 5 s: it jumps as if the clock was set"
    for reader in (read, LongRecording):
        with pytest.raises(UnreadableError, match=said):
            reader(path)


def test_slow_rows_and_a_night_without_power_are_no_clock_that_was_set(tmp_path):
    for step, gap in ((1e8, 1e8), (1.0, 1e6)):  # hours in ns; twelve days' gap
        times = [0, step, 2 * step, 2 * step + gap, 3 * step + gap]
        rows = "".join(f"{t},{101_325 + k}\n" for k, t in enumerate(times))
        (path := tmp_path / "log.csv").write_text("time_s,pressure_pa\n" + rows)
        assert len(read(path)) == 5


def test_an_unended_last_line_is_noted_by_both_readers(tmp_path, small_parts):
    (path := tmp_path / "log.csv").write_text("time_s,pressure_pa\n0,101325\n1,101326\n2,10132")
    whole, long_one = read(path), LongRecording(path).barometer
    assert "unended-line" in [note.code for note in whole.notes]
    assert whole.notes == long_one.notes
