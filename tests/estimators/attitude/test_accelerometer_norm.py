"""Lee16's a_app: the modulus of the specific force minus gravity."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baroarma.estimators.attitude.accelerometer_norm import AccelerometerNorm
from baroarma.estimators.base import Alignment
from baroarma.testing import AttitudeEstimatorContract

RNG = np.random.default_rng(1)
ACCEL = np.array([0.0, 0.0, 9.8]) + RNG.normal(size=(50, 3))
ACCEL[[7, 20]] = np.nan
GYRO = np.full((50, 3), np.nan)


def test_vertical_motion_is_exact_in_every_mounting():
    a = RNG.normal(size=50)
    for mount in Rotation.random(5, rng=2):
        run = AccelerometerNorm().run(np.arange(50), (9.80665 + a)[:, None] * mount.apply([0, 0, 1.0]), GYRO)
        np.testing.assert_allclose(run.acceleration, a, atol=1e-14)
        np.testing.assert_allclose(run.up, np.tile(mount.apply([0, 0, 1.0]), (50, 1)), atol=1e-15)


def test_a_horizontal_acceleration_reads_as_half_its_square_over_g_upwards():
    state = AccelerometerNorm().step(dt=0.1, accel=np.array([0.5, 0.0, 9.80665]), gyro=np.zeros(3))
    assert state.acceleration == pytest.approx(
        0.5**2 / (2 * 9.80665), rel=0.5**2 / (4 * 9.80665**2)
    )  # next term


def test_the_run_is_the_step_repeated_and_missing_samples_hold_the_vertical():
    one, all_ = AccelerometerNorm(accel_noise_sd=0.1), AccelerometerNorm(accel_noise_sd=0.1)
    run = all_.run(np.arange(50), ACCEL, GYRO)
    states = [one.step(dt=0.02, accel=f, gyro=w) for f, w in zip(ACCEL, GYRO, strict=True)]
    for by_step, column in zip(zip(*states, strict=True), run, strict=True):
        np.testing.assert_array_equal(column, np.array(by_step))
    np.testing.assert_array_equal(run.up[7], run.up[6])
    missing = np.isnan(ACCEL[:, 0])
    np.testing.assert_array_equal(np.isnan(run.acceleration), missing)
    np.testing.assert_array_equal(run.acceleration_sd, np.where(missing, np.nan, 0.1))


def test_free_fall_has_no_vertical_but_an_acceleration():
    norm = AccelerometerNorm()
    norm.reset(Alignment(up=(0.0, 1.0, 0.0), gravity=9.9))
    state = norm.step(dt=0.1, accel=np.zeros(3), gyro=np.zeros(3))
    np.testing.assert_array_equal(state.up, [0, 1, 0])
    assert state.acceleration == -9.9


class TestAccelerometerNormKeepsTheContract(AttitudeEstimatorContract):
    def make(self):
        return AccelerometerNorm()
