"""`baroarma calibrate`: a recording of rests in, scale, offset and gyro bias out."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baroarma.cli import main
from baroarma.formats import write_csv
from baroarma.recording import Recording


def rests(orientations):
    """Two seconds in each orientation, and a second of turning fast."""
    rng = np.random.default_rng(1)
    poses = Rotation.random(orientations, rng=rng)
    force = np.repeat(poses.inv().apply([0, 0, 9.80665]), 150, axis=0)
    gyro = np.where((np.arange(150 * orientations) % 150 >= 100)[:, None], 1.0, 0.0) * [1, -1, 1]
    accel = force / 1.01 + 0.02 * rng.normal(size=force.shape)
    gyro = gyro + 0.01 + 0.002 * rng.normal(size=force.shape)
    return Recording(t=np.arange(len(force)) / 50, pressure=np.full(len(force), 1e5), accel=accel, gyro=gyro)


@pytest.fixture
def recorded(tmp_path):
    def write(orientations):
        path = tmp_path / "turned.csv"
        write_csv(rests(orientations), path)
        return str(path)

    return write


def test_scale_and_bias_are_printed_and_written(recorded, tmp_path, capsys):
    out = tmp_path / "calibration.json"
    assert main(["calibrate", recorded(10), "--out", str(out), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert json.loads(out.read_text()) == document
    errors = (np.array(document["accel_scale"]) - 1.01) / document["accel_scale_sd"]
    assert np.abs(errors).max() < 3
    assert np.abs((np.array(document["gyro_bias_rad_s"]) - 0.01) / document["gyro_bias_sd_rad_s"]).max() < 3
    assert main(["calibrate", recorded(10)]) == 0
    assert capsys.readouterr().out.startswith("10 rests, residual")


@pytest.mark.parametrize("orientations", [1, 4])
def test_too_few_orientations_are_refused_without_a_file(recorded, tmp_path, capsys, orientations):
    out = tmp_path / "calibration.json"
    assert main(["calibrate", recorded(orientations), "--out", str(out)]) == 1
    captured = capsys.readouterr()
    assert f"{orientations}; scale and offset need at least 6" in captured.err
    assert captured.out == ""
    assert not out.exists()


def test_wrong_usage_is_exit_2(recorded, capsys):
    path = recorded(2)
    assert main(["calibrate", path, path]) == 2
    assert "one recording at a time" in capsys.readouterr().err
