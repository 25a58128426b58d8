"""Rest alignment: tilt, gyro bias and gravity from the first second."""

import numpy as np
import pytest

from baroarma.estimators.attitude.alignment import align

T = np.arange(100) / 50
UP = np.array([0.48, -0.6, 0.64])
FORCE = 9.9 * np.tile(UP, (100, 1))
RATE = np.tile([0.01, -0.02, 0.03], (100, 1))


def test_rest_gives_tilt_bias_and_the_accelerometers_own_gravity():
    start = align(T, FORCE, RATE)
    np.testing.assert_allclose(start.up, UP, atol=1e-15)
    np.testing.assert_allclose(start.gyro_bias, RATE[0], atol=1e-15)
    assert start.gravity == pytest.approx(9.9, abs=1e-12)


def test_only_the_first_second_counts_and_its_end_does_not():
    force, rate = FORCE.copy(), RATE.copy()
    force[T >= 1], rate[T >= 1] = 100.0, 100.0
    assert align(T, force, rate) == align(T, FORCE, RATE)
    assert align(T + 1234.5, force, rate) == align(T, FORCE, RATE)
    assert align(T, force, rate, duration=1.02) != align(T, FORCE, RATE)


def test_rows_without_a_sample_are_left_out_sensor_by_sensor():
    rng = np.random.default_rng(1)
    force, rate = FORCE + rng.normal(size=(100, 3)), RATE + rng.normal(size=(100, 3))
    expected = align(T[::2], force[::2], rate[::2])
    force[1::2, 1] = np.nan
    start = align(T, force, rate)
    assert (start.up, start.gravity) == (expected.up, expected.gravity)
    assert start.gyro_bias == align(T, FORCE, rate).gyro_bias


@pytest.mark.parametrize(("sensor", "force", "rate"), [("accelerometer", np.nan, 0.0), ("gyro", 9.8, np.nan)])
def test_without_samples_the_error_names_the_sensor_and_what_to_do(sensor, force, rate):
    with pytest.raises(ValueError, match=f"no {sensor} sample in the first 1 s; align over a longer"):
        align(T, np.full((100, 3), force), np.full((100, 3), rate))


def test_an_empty_recording_is_refused_in_the_same_words():
    with pytest.raises(ValueError, match="no accelerometer sample"):
        align([], np.empty((0, 3)), np.empty((0, 3)))


def test_an_accelerometer_in_g_is_refused_with_its_value():
    with pytest.raises(ValueError, match=r"first 1 s is 1 m/s².*must be in m/s²"):
        align(T, FORCE / 9.9, RATE)
