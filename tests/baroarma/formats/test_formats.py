"""Reading as a user meets it: names, sources, groups of files, and the way back."""

import gzip
import hashlib
from dataclasses import fields, replace

import numpy as np
import pytest

import baroarma as ba
from baroarma.formats import UnreadableError, read, read_all, write_csv


@pytest.fixture
def recording():
    rng = np.random.default_rng(3)
    n = 400
    pressure = 101_325 + rng.normal(0, 3, n)
    pressure[::7] = np.nan
    return ba.Recording(
        t=1.6e9 + np.cumsum(rng.uniform(0.01, 0.03, n)),
        pressure=pressure,
        accel=rng.normal(0, 9.8, (n, 3)),
        gyro=rng.normal(0, 1, (n, 3)),
        temperature=np.where(np.arange(n) % 3, np.nan, 21.3),
        reference=rng.normal(0, 1, n),
        reference_velocity=rng.normal(0, 1, n),
        reference_attitude=rng.normal(0, 1, (n, 4)),
    )


def same(a, b):
    return (a is None and b is None) or np.array_equal(a, b, equal_nan=True)


@pytest.mark.parametrize("name", ["walk.csv", "walk.csv.gz", "walk.parquet"])
def test_what_is_written_reads_back_exactly(recording, name, tmp_path):
    write_csv(recording, tmp_path / name)
    back = read(tmp_path / name)
    for field in fields(recording)[:8]:
        assert same(getattr(recording, field.name), getattr(back, field.name)), field.name
    assert back.name == "walk"
    assert not back.notes
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_absent_signals_make_no_columns(tmp_path):
    write_csv(ba.Recording(t=[0.0, 0.1], pressure=[1e5, np.nan]), tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text() == "time_s,pressure_pa\n0.0,100000.0\n0.1,\n"


def test_equal_recordings_make_equal_gzip_files(recording, tmp_path):
    for name in ("a.csv.gz", "b.csv.gz"):
        write_csv(recording, tmp_path / name)
    assert (tmp_path / "a.csv.gz").read_bytes() == (tmp_path / "b.csv.gz").read_bytes()


def test_a_failed_write_leaves_the_old_file_and_no_new_one(recording, tmp_path, monkeypatch):
    target = tmp_path / "walk.csv"
    target.write_text("precious")

    def full_disk(frame, path, **_):
        with open(path, "w") as half:
            half.write("time_s,press")
        raise OSError("no space left")

    monkeypatch.setattr("pandas.DataFrame.to_csv", full_disk)
    with pytest.raises(OSError, match="no space left"):
        write_csv(recording, target)
    assert target.read_text() == "precious"
    assert list(tmp_path.iterdir()) == [target]


def test_writing_into_a_missing_folder_says_so(recording, tmp_path):
    with pytest.raises(ValueError, match="there is no folder"):
        write_csv(recording, tmp_path / "nowhere" / "a.csv")


def test_source_is_the_hash_of_the_bytes_of_all_files_in_order(tmp_path):
    baro, accel = b"time_s,pressure_pa\n0,1e5\n1,1e5\n", b"time_s,acc_x_g,acc_y_g,acc_z_g\n0,0,0,1\n1,0,0,1\n"
    (tmp_path / "x_baro.csv").write_bytes(baro)
    (tmp_path / "x_acc.csv.gz").write_bytes(gzip.compress(accel))
    found = read(tmp_path / "x_baro.csv", tmp_path / "x_acc.csv.gz")
    expected = hashlib.sha256(baro + (tmp_path / "x_acc.csv.gz").read_bytes()).hexdigest()
    assert found.source == {"name": "x_baro.csv + x_acc.csv.gz", "sha256": expected}
    assert found.name == "x"
    assert read(tmp_path / "x_baro.csv").name == "x_baro"
    assert read(tmp_path / "x_baro.csv", name="bench").name == "bench"


def test_a_file_with_pressure_starts_a_recording(tmp_path):
    for name in ("a_baro", "b_baro"):
        (tmp_path / f"{name}.csv").write_text("time_s,altitude_m\n0,1\n1,2\n")
    (tmp_path / "b_temp.csv").write_text("time_s,temperature_c\n0,20\n1,22\n")
    a, b = read_all([tmp_path / f"{name}.csv" for name in ("a_baro", "b_baro", "b_temp")])
    assert a.temperature is None
    assert b.temperature.tolist() == [20.0, 22.0]
    assert (a.name, b.name) == ("a_baro", "b")
    with pytest.raises(UnreadableError, match="there is no pressure"):
        read_all([tmp_path / "b_temp.csv", tmp_path / "a_baro.csv"])


def test_replace_does_not_clean_again(tmp_path):
    held = np.repeat(101_325 + np.random.default_rng(0).normal(0, 3, 60), 5)
    write_csv(ba.Recording(t=np.arange(300) / 50, pressure=held), tmp_path / "held.csv")
    clean = read(tmp_path / "held.csv")
    assert clean.is_new.sum() == 60
    assert [note.code for note in clean.notes] == ["held-samples"]
    again = replace(clean, pressure=held)
    assert again.is_new.all()


def test_reading_what_was_cleaned_changes_nothing_more(shared_data, tmp_path):
    once = read(shared_data / "stampfly_tof_handheld" / "lift30cm_a.csv.gz")
    write_csv(once, tmp_path / "once.csv")
    twice = read(tmp_path / "once.csv")
    assert same(once.pressure, twice.pressure)
    assert not twice.notes
