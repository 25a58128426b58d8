"""Tables and datasets: everything arrives, under documented names, with units, and comes back exactly."""

import sys

import numpy as np
import pandas as pd
import pytest

import baroarma as ba
from baroarma.experiments.result import Result, Row
from baroarma.finding import Finding
from baroarma.formats import write_csv
from baroarma.formats.columns import COLUMNS
from baroarma.identification.windows import identify_windows
from baroarma.labelled import VARIABLES
from baroarma.simulation import simulate
from baroarma.track import Track


@pytest.fixture(scope="module")
def squats():
    return simulate("squat", duration=5, seed=1)


@pytest.fixture(scope="module")
def track():
    t = np.arange(100) / 50
    signals = (np.sin(t), np.cos(t), np.full(100, 0.1), np.full(100, 0.01), -np.sin(t))
    return Track(t, *signals, preset="p", name="ride", findings=(Finding("gaps", "info", "One."),))


def test_a_recordings_frame_is_the_file_that_would_be_written(squats, tmp_path):
    write_csv(squats, tmp_path / "squat.csv")
    pd.testing.assert_frame_equal(pd.read_csv(tmp_path / "squat.csv"), squats.to_frame())
    assert set(squats.to_frame()) <= set(COLUMNS)


def test_a_frame_without_imu_has_no_columns_of_it():
    assert list(ba.Recording(t=[0, 1], pressure=[1e5, 1e5]).to_frame()) == ["time_s", "pressure_pa"]


def test_a_recording_comes_back_from_xarray_exactly(squats):
    xarray = pytest.importorskip("xarray")
    found = squats.to_xarray()
    back = ba.Recording(t=found.t.values, name=found.name, **{k: v.values for k, v in found.items()})
    assert isinstance(found, xarray.Dataset)
    pd.testing.assert_frame_equal(back.to_frame(), squats.to_frame())
    assert np.array_equal(back.reference_attitude, squats.reference_attitude)
    assert found.accel.sel(axis="z").values.tolist() == squats.accel[:, 2].tolist()
    assert found.reference_attitude.component.values.tolist() == list("xyzw")


def test_a_track_comes_back_from_xarray_exactly(track):
    pytest.importorskip("xarray")
    found = track.to_xarray()
    back = Track(found.t.values, **{name: values.values for name, values in found.items()})
    for name in ("t", "height", "velocity", "height_sd", "velocity_sd", "acceleration"):
        assert np.array_equal(getattr(back, name), getattr(track, name))
    assert found.attrs == {"name": "ride", "preset": "p", "findings": ["info (gaps): One."]}


def test_every_variable_has_its_unit(squats, track):
    pytest.importorskip("xarray")
    for found in (squats.to_xarray(), track.to_xarray()):
        assert found.t.attrs == {"units": "s", "long_name": "time"}
        for name, values in found.items():
            assert (values.attrs["units"], values.attrs["long_name"]) == VARIABLES[name][:2]
    assert track.to_xarray().velocity.attrs["units"] == "m s-1"


def test_without_xarray_a_sentence_says_what_to_install(track, monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(ImportError, match=r"needs xarray; pip install 'baroarma\[xarray\]'"):
        track.to_xarray()


def test_a_prediction_is_a_frame_over_time():
    found = ba.predict_accuracy(ba.NoiseModel(0.27, 0.75, 0.46, rate_hz=50), "simple", "sg14-a", 5.0)
    frame = found.to_frame()
    assert list(frame) == ["time_s", "height_sd_m", "velocity_sd_m_s"]
    assert np.array_equal(frame.height_sd_m, found.height_sd)


def test_windows_are_a_frame_with_a_row_each():
    noise = ba.NoiseModel(0.27, 0.75, 0.46, rate_hz=50)
    found = identify_windows(np.arange(9000) / 50, noise.simulate(9000, 1))
    frame = found.to_frame()
    assert len(frame) == len(found)
    assert np.array_equal(frame.correlation_time_s, found.fits.correlation_time)
    assert np.array_equal(frame.a, found.fits.a)
    assert np.array_equal(frame.ljung_box_p, found.ljung_box_p)


def test_an_experiment_is_a_frame_whose_missing_numbers_are_nan():
    rows = (Row("A", "x (m)", 0.4, None, None, None, 0, ""), Row("B", "x (m)", None, None, 0.3, 0.1, 5, ""))
    frame = Result("e", "t", (), rows).to_frame()
    assert frame.published.tolist()[0] == 0.4
    assert frame.reproduced.isna().tolist() == [True, False]
    assert frame.published_sd.dtype == float
    assert frame.trials.tolist() == [0, 5]
