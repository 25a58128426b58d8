"""The reference attitude: given by somebody better."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baroarma.estimators.attitude.reference import ReferenceAttitude
from baroarma.testing import AttitudeEstimatorContract

RNG = np.random.default_rng(1)
ROTATIONS = Rotation.random(60, rng=1)
WORLD = np.array([0.0, 0.0, 9.80665]) + RNG.normal(size=(60, 3))
ACCEL = ROTATIONS.inv().apply(WORLD)
GYRO = np.full((60, 3), np.nan)
T = np.arange(60) / 50


def test_the_vertical_acceleration_is_the_worlds_whatever_the_heading_and_the_length_of_the_quaternion():
    scale = RNG.uniform(0.5, 2, (60, 1))
    run = ReferenceAttitude().run(T, ACCEL, GYRO, scale * ROTATIONS.as_quat())
    np.testing.assert_allclose(run.acceleration, WORLD[:, 2] - 9.80665, atol=1e-13)  # rounding
    np.testing.assert_allclose(run.up, ROTATIONS.inv().apply([0, 0, 1.0]), atol=1e-14)


def test_the_sd_is_tilt_times_horizontal_force_plus_noise():
    run = ReferenceAttitude(accel_noise_sd=0.1, tilt_sd=0.05).run(T, ACCEL, GYRO, ROTATIONS.as_quat())
    horizontal = np.hypot(WORLD[:, 0], WORLD[:, 1])
    np.testing.assert_allclose(run.acceleration_sd, np.hypot(0.05 * horizontal, 0.1), rtol=1e-12)


def test_the_run_is_the_step_repeated_and_a_missing_attitude_is_held():
    attitude, accel = ROTATIONS.as_quat(), ACCEL.copy()
    attitude[[0, 9]], accel[[9, 30]] = np.nan, np.nan
    one, all_ = ReferenceAttitude(), ReferenceAttitude()
    run = all_.run(T, accel, GYRO, attitude)
    states = [one.step(dt=0.02, accel=accel[k], gyro=GYRO[k], attitude=attitude[k]) for k in range(60)]
    for by_step, column in zip(zip(*states, strict=True), run, strict=True):
        np.testing.assert_array_equal(column, np.array(by_step))
    np.testing.assert_array_equal(run.up[[0, 9]], [[0, 0, 1], run.up[8]])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(run.acceleration)), [9, 30])


def test_without_an_attitude_it_says_what_it_needs():
    with pytest.raises(ValueError, match="'reference' needs a recording with reference_attitude"):
        ReferenceAttitude().step(dt=0.02, accel=np.zeros(3), gyro=np.zeros(3))


class TestReferenceAttitudeKeepsTheContract(AttitudeEstimatorContract):
    def make(self):
        return ReferenceAttitude()
