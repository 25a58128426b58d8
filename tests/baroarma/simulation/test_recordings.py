"""Recordings hold the truth beside the samples and come out the same again."""

import numpy as np
import pytest

from baroarma.simulation import DEVICES, DURATIONS, Barometer, Clock, simulate, simulate_rest
from baroarma.simulation.devices import BMP085


@pytest.mark.parametrize("device", ["simple", "gy-87"])
def test_a_seed_gives_the_same_numbers_again(device):
    a, b, c = (simulate("squat", duration=20, device=device, seed=seed) for seed in (5, 5, 6))
    for name in ("pressure", "accel", "gyro", "reference_attitude"):
        assert np.array_equal(getattr(a, name), getattr(b, name), equal_nan=True), name
        assert not np.array_equal(getattr(a, name), getattr(c, name), equal_nan=True), name


def test_the_truth_is_relative_to_the_start_and_belongs_to_the_rows():
    recording = simulate("squat", duration=30, rate_hz=100, seed=1, depth=0.5)
    assert recording.reference[0] == 0
    assert recording.reference.min() == pytest.approx(-0.5, abs=1e-3)
    # central differences: the third derivative, 2 m/s³ as a squat starts, over 6, times the step squared
    velocity = np.gradient(recording.reference, recording.t)[1:-1]
    assert velocity == pytest.approx(recording.reference_velocity[1:-1], abs=4e-5)


def test_a_motion_that_ends_is_recorded_until_then_by_default():
    assert simulate("free-fall", seed=1, imu=None).duration == pytest.approx(DURATIONS["free-fall"], abs=0.1)
    assert simulate("lift", seed=1, imu=None).duration == pytest.approx(180, abs=0.1)
    assert simulate_rest(seed=1).duration == pytest.approx(600, abs=0.1)


def test_sensors_can_be_exchanged_or_left_out():
    other = Barometer(BMP085.noise, rate_hz=10, clock=Clock(offset=0.3))
    recording = simulate("rest", duration=20, device=DEVICES["wimu"], barometer=other, imu=None, seed=1)
    assert (recording.rate_hz, recording.accel) == (pytest.approx(10), None)


def test_the_level_moves_the_pressure_only():
    low, high = (simulate("rest", duration=10, level=level, seed=1) for level in (0.0, 500.0))
    assert np.mean(high.height() - low.height()) == pytest.approx(500, abs=0.1)  # 1 Pa is 9 cm
    assert np.array_equal(low.reference, high.reference)


def test_an_unknown_device_is_refused_with_those_there_are():
    with pytest.raises(ValueError, match="device 'phone' is unknown; choose one of simple, wimu, gy-87"):
        simulate("rest", device="phone")


@pytest.mark.parametrize(("duration", "rate"), [(-1, 50), (10, 0), (10, float("nan")), (float("inf"), 50)])
def test_what_makes_no_recording_is_refused(duration, rate):
    with pytest.raises(ValueError, match="make no recording"):
        simulate("rest", duration=duration, rate_hz=rate)
