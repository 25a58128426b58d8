"""The papers' processing gives the truth back when nothing disturbs it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baroarma.experiments.processing import (
    align_encoder,
    circle_reference,
    crossing,
    free_fall,
    plateaus,
    relative_altitude,
    rmse,
    shrunk,
    with_axes_of_world,
)
from baroarma.noise_model import NoiseModel
from baroarma.simulation import Barometer, Imu, simulate, simulate_with_encoder

SILENT = {"barometer": Barometer(NoiseModel(0, 0, 1e-9, rate_hz=50), quantum=0), "imu": Imu(0, 0, 0, 0)}


def test_rmse_is_the_square_root_of_the_mean_square():
    assert rmse(np.array([1.0, 2.0]), np.array([0.0, 0.0])) == pytest.approx(np.sqrt(2.5))


@pytest.mark.parametrize("seed", range(3))
def test_the_encoder_is_put_on_the_recordings_clock(seed):
    recording, encoder = simulate_with_encoder(duration=20, frequency_hz=1.0, counts=0, seed=seed, **SILENT)
    angle = align_encoder(recording, encoder.t, encoder.angle)
    height, velocity = circle_reference(recording.t, angle, 0.30)
    # both rates are linear between samples to 0.1 ms at 5 degrees/s; times the speed of 1.9 m/s
    assert np.abs(height - recording.reference).max() < 5e-4
    # a central difference over 2 T loses (omega T)²/6 = 0.26 % of 1.9 m/s, and lags nothing
    inner = slice(300, -1)
    assert np.abs(velocity - recording.reference_velocity)[inner].max() < 0.0075


def test_an_encoder_that_started_late_is_found_all_the_same():
    recording, encoder = simulate_with_encoder(duration=20, frequency_hz=1.0, counts=0, seed=1, **SILENT)
    angle = align_encoder(recording, encoder.t, encoder.angle)
    later = align_encoder(recording, encoder.t + 123.0, encoder.angle)
    np.testing.assert_allclose(later, angle, atol=1e-6)  # 1e-13 s of rounding times 6 rad/s, with room


def test_a_rate_that_stays_low_aligns_nothing():
    with pytest.raises(ValueError, match="no motion to align by"):
        crossing(np.arange(3.0), np.zeros(3))


def test_the_fall_is_found_and_follows_its_parabola():
    recording = simulate("free-fall", seed=1, **SILENT)
    rows, height, velocity = free_fall(recording, 1.53)
    truth = recording.reference[rows]
    # the hand lets go over 20 ms; |f| = g/2 in the middle of it, so both agree to g (10 ms)²/6 there
    assert np.abs(truth - truth[0] - (height - height[0])).max() < 2e-3
    assert np.abs(recording.reference_velocity[rows] - velocity).max() < 9.81 * 0.01 / 4
    assert len(velocity) == pytest.approx(50 * np.sqrt(2 * 1.53 / 9.80665), abs=1)
    assert velocity[-1] < -5


def test_a_share_of_the_barometer_is_a_share_of_every_change():
    recording = simulate("squat", duration=20, seed=2)
    half = relative_altitude(shrunk(recording, 0.5))
    # the mean over the first second is that of the altitude, and the altitude is exact to rounding
    np.testing.assert_allclose(half, 0.5 * relative_altitude(recording), atol=1e-6)


def test_axes_of_the_world_are_those_at_the_start():
    recording = simulate("circle", duration=10, seed=3, **SILENT)
    level = with_axes_of_world(recording)
    assert Rotation.from_quat(level.reference_attitude[0].copy()).magnitude() == pytest.approx(0, abs=1e-12)
    assert level.accel[0] == pytest.approx([0, 0, 9.80665])
    # remounting changes what each axis feels, not what the world sees
    for one in (recording, level):
        up = Rotation.from_quat(np.array(one.reference_attitude)).apply(np.array(one.accel))[:, 2]
        expected = np.gradient(recording.reference_velocity, recording.t) + 9.80665
        assert np.abs(up - expected)[2:-2].max() < 0.02  # differentiated over 40 ms
    assert np.ptp(level.gyro[:, 1:]) == pytest.approx(0, abs=1e-9)  # it turns about its own x


def test_the_bias_capture_takes_the_first_second():
    recording = simulate("rest", duration=5, seed=4)
    relative = relative_altitude(recording)
    assert relative[:50].mean() == pytest.approx(0, abs=1e-9)
    gaps = replace(recording, pressure=np.where(np.arange(250) % 2, np.nan, recording.pressure))
    assert np.nanmean(relative_altitude(gaps)[:50]) == pytest.approx(0, abs=1e-9)


def test_a_plateau_is_where_the_height_stays():
    assert plateaus(np.array([0.0, 1.69, 1.695, 1.705, 3.0]), 1.7).tolist() == [
        False,
        False,
        True,
        True,
        False,
    ]
