"""The IMU's noise: as a device has it, as a rest shows it, as people say it."""

from dataclasses import fields, replace

import numpy as np
import pytest

from baroarma import ImuNoise, Recording
from baroarma.simulation import DEVICES, simulate


def test_a_rest_shows_the_noise_of_the_device_that_made_it():
    """Densities within 3.5 sds: 4 sds of a sd's relative error 1.17/sqrt(2 n) (n differences on 3 axes, taken
    by the median, which costs a factor of 1.6 in variance, and neighbours that share a mean)."""
    true = ImuNoise.of_device("simple")
    n = 3 * 300 / 0.2
    for seed in range(4):
        found = ImuNoise.from_recording(simulate("rest", duration=300, seed=seed))
        for name in ("accel_density", "gyro_density"):
            assert getattr(found, name) == pytest.approx(getattr(true, name), rel=3.5 * 1.9 / np.sqrt(2 * n))
        assert found.rate_hz == pytest.approx(50)


def test_the_accelerometers_bias_is_what_its_mean_differs_from_gravity():
    rest = simulate("rest", duration=60, seed=1)
    mean = np.linalg.norm(rest.accel.mean(axis=0))
    for bias in (-0.05, 0.0, 0.05):
        off = replace(rest, accel=rest.accel * (9.80665 + bias) / mean)
        assert ImuNoise.from_recording(off).accel_bias_sd == pytest.approx(abs(bias), abs=1e-12)


def test_a_wandering_bias_is_told_from_white_noise():
    """A sine of amplitude A adds A²/2 to the variance of the seconds' means; 10 % is 3 sds of the rest."""
    rest = simulate("rest", duration=200, seed=2)
    wave = 0.02 * np.sin(2 * np.pi * rest.t / 50)[:, None]
    found = ImuNoise.from_recording(replace(rest, gyro=rest.gyro + wave, accel=rest.accel + wave))
    assert found.gyro_bias_sd == pytest.approx(0.02 / np.sqrt(2), rel=0.1)
    assert found.accel_wander_sd == pytest.approx(0.02 / np.sqrt(2), rel=0.1)
    assert ImuNoise.from_recording(rest).gyro_bias_sd < 0.001


def test_a_bump_hardly_changes_the_density():
    """One second in a hundred is disturbed: of the median, that moves 1 %, and of the sd less than 2 %."""
    rest = simulate("rest", duration=100, seed=3)
    bump = np.where((rest.t > 50) & (rest.t < 51), 0.2 * np.sin(40 * rest.t), 0.0)[:, None]
    before, after = (
        ImuNoise.from_recording(replace(rest, accel=rest.accel + size * bump)) for size in (0, 1)
    )
    assert after.accel_density == pytest.approx(before.accel_density, rel=0.02)


def test_missing_samples_are_left_out():
    rest = simulate("rest", duration=60, seed=4)
    slow = replace(rest, accel=np.where(np.arange(len(rest))[:, None] % 2, np.nan, rest.accel))
    found = ImuNoise.from_recording(slow)
    assert found.rate_hz == pytest.approx(25)
    assert found.accel_sd == pytest.approx(ImuNoise.of_device("simple").accel_sd, rel=0.2)


@pytest.mark.parametrize(
    ("recording", "says"),
    [
        (simulate("squat", duration=30, seed=1), "squat is not at rest"),
        (simulate("rest", duration=5, seed=1), "rest has 4.98 s of IMU samples; at least 10 s"),
        (simulate("rest", duration=30, seed=1, imu=None), "rest has no accelerometer and gyro"),
        (
            Recording(
                t=np.arange(3.0),
                pressure=np.full(3, 1e5),
                accel=np.full((3, 3), np.nan),
                gyro=np.zeros((3, 3)),
            ),
            "the recording has 0 s of IMU samples",
        ),
    ],
    ids=["moving", "short", "no IMU", "no sample"],
)
def test_what_shows_no_noise_is_refused(recording, says):
    with pytest.raises(ValueError, match=says):
        ImuNoise.from_recording(recording)


def test_a_device_is_what_its_sensors_are():
    wimu = DEVICES["wimu"].imu
    found = ImuNoise.of_device("wimu", rate_hz=100)
    assert found.accel_sd == pytest.approx(wimu.accel_sd)
    assert found.gyro_sd == pytest.approx(wimu.gyro_sd)
    assert (found.accel_bias_sd, found.accel_wander_sd) == (wimu.accel_bias_sd, wimu.accel.drift_sd)
    assert (found.gyro_bias_sd, found.rate_hz) == (wimu.gyro.drift_sd, 100)
    with pytest.raises(ValueError, match="device 'nokia' is unknown; choose one of simple, wimu"):
        ImuNoise.of_device("nokia")


def test_impossible_noise_is_refused():
    with pytest.raises(ValueError, match="gyro_density must be a number >= 0, but it is -1"):
        ImuNoise(1e-3, -1.0, rate_hz=50)
    with pytest.raises(ValueError, match="accel_density must be positive"):
        ImuNoise(0.0, rate_hz=50)
    with pytest.raises(ValueError, match="rate_hz must be positive"):
        ImuNoise(1e-3, rate_hz=0)


def test_it_can_be_shown_and_stored():
    imu = ImuNoise(1e-3, 2e-4, 0.02, 1e-4, 3e-3, rate_hz=100)
    assert repr(imu) == (
        "<ImuNoise at 100 Hz: accel 0.001 m/s²/√Hz, bias 0.02 m/s², wander 0.003 m/s²; "
        "gyro 0.0002 rad/s/√Hz, bias 0.0001 rad/s>"
    )
    assert sorted(imu.to_dict().values()) == sorted(getattr(imu, f.name) for f in fields(imu))
