"""`baroarma simulate`: files with truth that read back."""

import json

import numpy as np
import pytest

from baroarma import read
from baroarma.cli import main
from baroarma.formats.columns import COLUMNS
from baroarma.simulation import DEVICES, MOTIONS, simulate


@pytest.mark.parametrize("suffix", [".csv", ".csv.gz"])
def test_the_file_holds_the_simulated_recording(tmp_path, suffix):
    path = tmp_path / f"squat{suffix}"
    assert main(["simulate", "squat", "--seed", "3", "--duration", "20", "--out", str(path)]) == 0
    ours, theirs = simulate("squat", duration=20, seed=3), read(path)
    for name in ("t", "pressure", "accel", "gyro", "reference", "reference_velocity"):
        assert np.array_equal(getattr(ours, name), getattr(theirs, name)), name  # floats read back exactly


def test_a_seed_gives_the_same_file_again_and_another_a_different_one(tmp_path):
    for name, seed in (("a", "1"), ("b", "1"), ("c", "2")):
        assert (
            main(["simulate", "rest", "--duration", "5", "--seed", seed, "--out", str(tmp_path / name)]) == 0
        )
    a, b, c = ((tmp_path / name).read_bytes() for name in "abc")
    assert a == b != c


def test_rate_duration_and_the_lack_of_an_imu_are_as_asked_for(tmp_path, capsys):
    argv = ["simulate", "rest", "--no-imu", "--rate", "10", "--duration", "30", "--json"]
    assert main([*argv, "--out", str(tmp_path / "r.csv")]) == 0
    assert json.loads(capsys.readouterr().out)["rows"] == 300
    recording = read(tmp_path / "r.csv")
    assert (len(recording), recording.rate_hz, recording.accel) == (300, pytest.approx(10), None)


def test_rest_lasts_ten_minutes_unless_told_otherwise(tmp_path, capsys):
    assert main(["simulate", "rest", "--rate", "5", "--json", "--out", str(tmp_path / "r.csv")]) == 0
    assert json.loads(capsys.readouterr().out)["rows"] == 3000


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["hover"], "there is no motion 'hover'; there are rest,"),
        (["rest", "--duration", "-1"], "make no recording"),
        (["rest", "--rate", "0"], "make no recording"),
        (["rest", "--rate", "nan"], "make no recording"),
        (["rest", "--duration", "inf"], "make no recording"),
        (["rest", "--seed", "-1"], "--seed"),
    ],
)
def test_what_cannot_be_simulated_is_refused(tmp_path, capsys, options, sentence):
    assert main(["simulate", *options, "--out", str(tmp_path / "x.csv")]) == 2
    assert sentence in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("motion", ["rest", "squat"])
def test_the_file_has_the_documented_columns(tmp_path, motion):
    path = tmp_path / "r.csv"
    assert main(["simulate", motion, "--duration", "10", "--out", str(path)]) == 0
    header = path.read_text().partition("\n")[0].split(",")
    assert set(header) <= set(COLUMNS)
    assert header[:10] == [
        "time_s",
        "pressure_pa",
        *(f"acc_{axis}_m_s2" for axis in "xyz"),
        *(f"gyr_{axis}_rad_s" for axis in "xyz"),
        "ref_height_m",
        "ref_velocity_m_s",
    ]


def test_device_and_options_are_those_of_the_function(tmp_path):
    path = tmp_path / "e.csv"
    argv = ["simulate", "lee16-e", "--device", "gy-87", "--set", "levels=[0.4, 0]", "--set", "tilt=0.2"]
    assert main([*argv, "--duration", "20", "--seed", "1", "--out", str(path)]) == 0
    ours = simulate("lee16-e", duration=20, device="gy-87", seed=1, levels=[0.4, 0], tilt=0.2)
    theirs = read(path)
    assert np.array_equal(ours.accel, theirs.accel)
    assert np.array_equal(ours.pressure, theirs.pressure, equal_nan=True)  # 25 Hz: every other row is empty
    assert theirs.reference.max() == pytest.approx(0.4)


def test_the_help_lists_motions_with_their_options_and_devices(capsys):
    assert main(["simulate", "--help"]) == 0
    page = capsys.readouterr().out
    for name in (*MOTIONS, *DEVICES, "frequency_hz=0.5"):
        assert name in page


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            ["squat", "--set", "deep=1"],
            "motion 'squat' has no option 'deep'; it has depth, period, tilt, pause, count",
        ),
        (["squat", "--set", "depth=deep"], "--set takes OPTION=VALUE with a number"),
        (["squat", "--set", "depth"], "--set takes OPTION=VALUE with a number"),
        (
            ["squat", "--set", "depth=-1"],
            "depth of the motion 'squat' must be a number above 0, but it is -1",
        ),
        (["squat", "--set", "duration=9"], "motion 'squat' has no option 'duration'"),
        (["rest", "--set", "level=9"], "motion 'rest' has no option 'level'; it has none"),
        (["rest", "--device", "phone"], "there is no device 'phone'; there are simple,"),
    ],
)
def test_wrong_options_are_refused_with_what_there_is(tmp_path, capsys, options, sentence):
    assert main(["simulate", *options, "--out", str(tmp_path / "x.csv")]) == 2
    assert sentence in " ".join(capsys.readouterr().err.split())
    assert list(tmp_path.iterdir()) == []
