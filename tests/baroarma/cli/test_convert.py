"""`baroarma convert`: what is read from any format is read again from what was written."""

import json
import sys
import zipfile
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import baroarma as ba
from baroarma.cli import main
from baroarma.formats import read, write_csv
from baroarma.simulation import simulate

OURS = ["t.csv", "t.csv.gz", "t.parquet"]


def assert_equal(a, b):
    for field in fields(ba.Recording)[:8]:
        ours, theirs = getattr(a, field.name), getattr(b, field.name)
        assert (ours is None) == (theirs is None), field.name
        assert ours is None or np.array_equal(ours, theirs, equal_nan=True), field.name


def signals(width):
    """Return any readable floats, some rows without a sample; or no signal."""
    shape = (12, width) if width > 1 else (12,)
    values = arrays(float, shape, elements=st.floats(-1e6, 1e6))
    return st.none() | st.builds(without, values, st.sets(st.integers(0, 11)))


def without(values, rows):
    values = values.copy()
    values[sorted(rows)] = np.nan
    return values


@settings(max_examples=40, deadline=None)
@given(
    t=arrays(float, 12, elements=st.floats(-1e6, 1e6), unique=True),  # no clock that was set
    pressure=arrays(float, 12, elements=st.floats(1e-3, 1e7) | st.just(float("nan"))),
    accel=signals(3),
    gyro=signals(3),
    reference=signals(1),
    attitude=signals(4),
    name=st.sampled_from(OURS),
)
def test_converting_any_recording_changes_nothing(
    tmp_path_factory, t, pressure, accel, gyro, reference, attitude, name
):
    folder = tmp_path_factory.mktemp("any")
    pressure[0] = 101_325.0  # a recording without any pressure is refused
    others = {"accel": accel, "gyro": gyro, "reference": reference, "reference_attitude": attitude}
    write_csv(ba.Recording(t=np.sort(t), pressure=pressure, **others), folder / "x.csv")
    assert main(["convert", str(folder / "x.csv"), str(folder / name)]) == 0
    assert_equal(read(folder / name), read(folder / "x.csv"))


@pytest.fixture(scope="module")
def export(tmp_path_factory):
    """Two streams of a phone, with held samples of the barometer."""
    path = tmp_path_factory.mktemp("export") / "ride.zip"
    device = simulate("lift", duration=30, device="bmp390-bmi270", seed=2)
    held = device.pressure[np.arange(len(device)) // 5 * 5] / 100
    with zipfile.ZipFile(path, "w") as archive:
        for file, names, values in (
            ("Pressure.csv", ["Pressure (hPa)"], held[:, None]),
            ("Accelerometer.csv", [f"Acceleration {axis} (m/s^2)" for axis in "xyz"], device.accel),
        ):
            t = device.t + (0.003 if file == "Accelerometer.csv" else 0.0)
            rows = np.column_stack([t, values]).tolist()
            lines = ["Time (s)," + ",".join(names), *(",".join(map(repr, row)) for row in rows)]
            archive.writestr(file, "\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("name", OURS)
def test_a_converted_log_is_read_like_the_log(export, tmp_path, name, capsys):
    assert main(["convert", str(export), str(tmp_path / name)]) == 0
    log, converted = read(export), read(tmp_path / name)
    assert_equal(converted, log)
    assert [note.code for note in log.notes] == ["held-samples"]
    assert "held-samples" in capsys.readouterr().err
    assert not converted.notes  # the repeats are empty cells now
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_streams_map_and_times_are_those_of_the_other_commands(tmp_path, capsys):
    (tmp_path / "b.csv").write_text("time_s,BaroPress\n0,1000\n1,1001\n2,\n3,1002\n")
    (tmp_path / "a.csv").write_text("time_s,temperature_c\n0,20\n3,23\n")
    argv = ["convert", str(tmp_path / "b.csv"), str(tmp_path / "a.csv"), str(tmp_path / "out.csv")]
    assert main([*argv, "--map", "pressure_hpa=BaroPress", "--start", "1", "--json"]) == 0
    text = (tmp_path / "out.csv").read_text()
    assert text == "time_s,pressure_pa,temperature_c\n1.0,100100.0,21.0\n2.0,,22.0\n3.0,100200.0,23.0\n"
    said = json.loads(capsys.readouterr().out)
    assert {key: said[key] for key in ("rows", "duration_s", "pressure_samples", "pressure_rate_hz")} == {
        "rows": 3,
        "duration_s": 2.0,
        "pressure_samples": 2,
        "pressure_rate_hz": 0.5,
    }
    assert said["signals"] == ["temperature"]
    assert said["findings"] == []
    assert said["source"]["name"] == "b.csv + a.csv"


def test_a_single_sample_has_no_rate(tmp_path, capsys):
    (tmp_path / "a.csv").write_text("time_s,pressure_pa\n0,1e5\n")
    assert main(["convert", str(tmp_path / "a.csv"), str(tmp_path / "b.csv"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["pressure_rate_hz"] is None


def test_what_cannot_be_converted_is_refused_and_nothing_is_written(export, tmp_path, capsys, monkeypatch):
    rest = tmp_path / "rest.csv"
    write_csv(replace(simulate("rest", duration=5, seed=1), accel=None), rest)
    cut = tmp_path / "cut.zip"
    cut.write_bytes(export.read_bytes()[:500])
    before = sorted(tmp_path.iterdir())
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    (tmp_path / "log.ulg").write_bytes(b"ULog")
    monkeypatch.setitem(sys.modules, "pyulog", None)
    for inputs, out, sentence in (
        ([rest], rest, "is what is to be converted; write to another file"),
        ([rest, export], tmp_path / "out.csv", "one recording at a time, but these are 2: rest, ride"),
        ([tmp_path / "none.bin"], tmp_path / "out.csv", "there is no such file"),
        ([rest], tmp_path / "no" / "out.csv", "there is no folder"),
        ([cut], tmp_path / "out.csv", "cut.zip: this is not a zip file, or it is damaged"),
        ([rest], tmp_path / "out.parquet", "pip install 'baroarma[parquet]'"),
        ([tmp_path / "log.ulg"], tmp_path / "out.csv", "pip install 'baroarma[ulog]'"),
    ):
        assert main(["convert", *map(str, inputs), str(out)]) == 2, sentence
        said = capsys.readouterr().err
        assert sentence in said
        assert "Traceback" not in said
    assert sorted(tmp_path.iterdir()) == sorted([*before, tmp_path / "log.ulg"])
