"""`baroarma simulate`: files with truth that read back."""

import json

import numpy as np
import pytest

from baroarma import read
from baroarma.cli import main
from baroarma.simulation import simulate


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
        (["hover"], "motion 'hover' is unknown; choose one of"),
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
