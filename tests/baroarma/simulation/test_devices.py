"""Every device records, and its noise is what its sensors' numbers make of it."""

import numpy as np
import pytest

from baroarma.simulation import BMP085, DEVICES, WIMU, simulate
from baroarma.simulation.devices import BMP390, ICM42688, METRES, MPU6050


@pytest.mark.parametrize("name", DEVICES)
def test_every_device_records_a_walk_with_truth(name):
    device, recording = DEVICES[name], simulate("walk", duration=20, device=name, seed=1)
    assert recording.rate_hz == pytest.approx(min(device.barometer.rate_hz or 50, 50), rel=0.01)
    assert np.isfinite(recording.accel).all()
    # bias, scale, noise and bandwidth leave the mean force of a walker within 3 % and some of the bias of g
    assert np.linalg.norm(recording.accel.mean(axis=0)) == pytest.approx(9.8, rel=0.05)
    height = recording.height()
    offset_sd = device.barometer.offset_sd * METRES
    assert abs(np.nanmean(height) - 100) < 4 * offset_sd + 1.0  # drift and noise make up for less than 1 m
    assert recording.reference[0] == 0


FINE = [
    (name, kind)
    for name, device in DEVICES.items()
    for kind in ("accel", "gyro")
    if getattr(device.imu, kind).quantum < 2 * getattr(device.imu, f"{kind}_sd")
]
"""Sensors whose steps are small against their noise: what rounding adds is then uniform and white."""


@pytest.mark.parametrize(("name", "kind"), FINE)
def test_white_noise_at_rest_is_the_sensors_and_its_quantisation(name, kind):
    imu, recording = DEVICES[name].imu, simulate("rest", duration=60, device=name, seed=2)
    white = np.std(np.diff(getattr(recording, kind), axis=0)) / np.sqrt(2)
    expected = np.hypot(getattr(imu, f"{kind}_sd"), getattr(imu, kind).quantum / np.sqrt(12))
    # 9000 differences of overlapping samples: the sd is known to about 1 %; 4 sigma
    assert white == pytest.approx(expected, rel=0.04)


def test_densities_become_samples_by_the_bandwidth():
    # ICM-42688: 70 ug/sqrt(Hz) behind 20 Hz of second order: 70e-6 sqrt(1.11 20) g
    assert ICM42688.accel_sd == pytest.approx(70e-6 * 9.80665 * 4.712, rel=1e-3)
    assert MPU6050.gyro_sd == pytest.approx(np.deg2rad(0.005 * 4.712), rel=1e-3)
    assert BMP390.noise.white_sd == pytest.approx(0.9 * 0.0841, rel=0.01)


def test_the_default_device_is_the_simple_one_of_the_first_paper():
    assert (DEVICES["simple"].barometer, DEVICES["simple"].imu) == (BMP085, WIMU)
    assert DEVICES["wimu"].barometer == BMP085
