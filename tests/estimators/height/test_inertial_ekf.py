import numpy as np
import pytest
from filterpy.common import Saver
from filterpy.kalman import ExtendedKalmanFilter, IMMEstimator
from scipy.spatial.transform import Rotation

from baroarma import NoiseModel
from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.estimators import height_estimator
from baroarma.estimators.base import Alignment
from baroarma.estimators.height import inertial_model as model
from baroarma.estimators.height.inertial_ekf import InertialEkf
from baroarma.testing import HeightEstimatorContract

SG13 = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
SONOH = {"accel_bias_sd": 0.1, "accel_scale_sd": 0.01}
ZHANG = {"accel_bias_sd": 0.1, "gyro_bias_sd": 0.01, "baseline_sd": 1.0}


class TestContract(HeightEstimatorContract):
    def make(self):
        return height_estimator("inertial-ekf", dt=0.02)


class TestContractSonOh(HeightEstimatorContract):
    def make(self):
        return height_estimator("inertial-ekf", noise=SG13, **SONOH)


class TestContractZhang(HeightEstimatorContract):
    def make(self):
        return height_estimator("inertial-ekf", noise=SG13, **ZHANG)


def awkward_state(seed):
    rng = np.random.default_rng(seed)
    x = rng.normal(scale=0.1, size=model.STATES)
    x[model.UP] = Rotation.random(rng=rng).apply([0, 0, 1])
    return x, rng.normal(scale=10, size=3), rng.normal(scale=2, size=3)


@pytest.mark.parametrize("seed", range(3))
def test_jacobian_is_that_of_finite_differences(seed):
    x, accel, gyro = awkward_state(seed)
    F, _, of_rate = model.jacobian(x, accel, gyro, 0.02)
    step = 1e-6

    def difference(move, size):
        units = step * np.eye(size)
        return np.array([(move(u) - move(-u)) / (2 * step) for u in units]).T

    by_state = difference(lambda d: model.move(x + d, accel, gyro, STANDARD_GRAVITY, 0.02), model.STATES)
    by_rate = difference(lambda d: model.move(x, accel, gyro + d, STANDARD_GRAVITY, 0.02), 3)
    # central differences with 1e-6: 1e-12 of truncation, 1e-16/1e-6 times values of 10 of rounding
    np.testing.assert_allclose(F, by_state, atol=1e-8)
    np.testing.assert_allclose(of_rate, by_rate, atol=1e-8)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 0.5, 3.0])
def test_rotation_is_scipys(angle):
    phi = angle * np.array([0.6, 0.0, -0.8])
    np.testing.assert_allclose(model.rotation(phi), Rotation.from_rotvec(phi).as_matrix(), atol=1e-14)


@pytest.mark.parametrize("angle", [1e-6, 0.0099, 0.0101, 1.0])
def test_left_jacobian_turns_small_changes_of_a_rotation_vector(angle):
    phi, d = angle * np.array([0.6, 0.0, -0.8]), 1e-6 * np.array([1.0, 2.0, 3.0])
    change = Rotation.from_rotvec(phi + d) * Rotation.from_rotvec(phi).inv()
    # second order in d, and rounding
    np.testing.assert_allclose(change.as_rotvec(), model.rotation_jacobian(phi) @ d, atol=1e-11)


def imu(n, *, height_acceleration=0.0, tilt=0.0, rate=50):
    """A device that is tilted about its x axis and moves vertically, without noise: t, accel, gyro."""
    up = np.array([0.0, np.sin(tilt), np.cos(tilt)])
    accel = np.outer(STANDARD_GRAVITY + np.broadcast_to(height_acceleration, n), up)
    return np.arange(n) / rate, accel, np.zeros((n, 3))


def test_a_vertical_motion_leaves_the_tilt_alone():
    n = 500
    a = 3 * np.sin(2 * np.pi * 0.5 * np.arange(n) / 50)
    t, accel, gyro = imu(n, height_acceleration=a, tilt=0.4)
    kf = InertialEkf(dt=0.02, **SONOH)
    kf.reset(Alignment(up=(0.0, np.sin(0.4), np.cos(0.4))))
    run = kf.run(t, np.full(n, np.nan), accel=accel, gyro=gyro)
    np.testing.assert_allclose(kf.x[model.UP, 0], [0, np.sin(0.4), np.cos(0.4)], atol=1e-12)
    velocity = np.concatenate([[0], np.cumsum(a[:-1]) / 50])
    np.testing.assert_allclose(run.velocity, velocity, atol=1e-9)


def test_it_levels_by_the_accelerometer_and_follows_the_gyro():
    n, turn = 3000, 0.3
    t, accel, gyro = imu(n, tilt=0.1)
    kf = InertialEkf(dt=0.02, initial_tilt_sd=0.2)  # told level
    kf.run(t, np.zeros(n), accel=accel, gyro=gyro)
    assert np.arctan2(kf.x[1, 0], kf.x[2, 0]) == pytest.approx(0.1, abs=0.005)
    kf.reset(Alignment(up=(0.0, np.sin(0.1), np.cos(0.1))))
    none = np.full((50, 3), np.nan)
    kf.run(t[:50], np.full(50, np.nan), accel=none, gyro=np.tile([turn, 0, 0], (50, 1)))
    # up turns against the body: 49 intervals of 0.3 rad/s
    assert np.arctan2(kf.x[1, 0], kf.x[2, 0]) == pytest.approx(0.1 + 49 * 0.02 * turn, abs=1e-9)


def test_it_finds_bias_scale_and_baseline_with_honest_sds():
    rng, n, runs = np.random.default_rng(5), 1000, 8
    motion = 1.0 * np.sin(2 * np.pi * 0.5 * np.arange(n) / 50)
    height = np.zeros(n)
    velocity = np.concatenate([[0], np.cumsum(motion[:-1]) / 50])
    height[1:] = np.cumsum(velocity[:-1] / 50 + motion[:-1] / 5000)
    nees = []
    for _ in range(runs):
        t, accel, gyro = imu(n, height_acceleration=motion)
        bias, baseline, gyro_bias = rng.normal(scale=[0.1, 1.0, 0.01])
        accel = accel + np.array([0, 0, bias]) + rng.normal(scale=0.04, size=(n, 3))
        gyro = gyro + np.array([gyro_bias, 0, 0]) + rng.normal(scale=9e-4, size=(n, 3))
        z = height + baseline + rng.normal(scale=0.3, size=n)
        kf = InertialEkf(dt=0.02, **ZHANG, accel_bias_walk=0, gyro_bias_walk=0, baseline_walk=0)
        run = kf.run(t, z, accel=accel, gyro=gyro)
        errors = np.array([run.height[-1] - height[-1], kf.x[7, 0] - bias, kf.x[14, 0] - baseline])
        index = [model.HEIGHT, 7, model.BASELINE]
        nees.append(errors**2 / np.diag(kf.P)[index])
        assert kf.P[7, 7] < 0.5 * 0.1**2  # the barometer does find the bias
    # mean of 8 squares of unit normals: sd 0.5; the velocity starts better than its sd says
    assert (np.mean(nees, axis=0) < 1 + 3 * 0.5).all()
    assert np.mean(nees) > 0.2


def test_what_is_not_estimated_stays_zero():
    t, accel, gyro = imu(200, tilt=0.1)
    kf = InertialEkf(dt=0.02, accel_bias_sd=0.1)
    kf.run(t, np.ones(200), accel=accel, gyro=gyro)
    assert (kf.x[8:] == 0).all()
    assert (kf.x[5:8] != 0).any()
    assert (kf.P[8:] == 0).all()


def test_at_rest_the_velocity_is_known():
    t, accel, gyro = imu(100)
    run = InertialEkf(dt=0.02).run(t, np.ones(100), accel=accel, gyro=gyro, at_rest=np.ones(100, bool))
    assert run.velocity_sd[-1] < 0.01
    assert np.abs(run.height[-1]) < 0.01


def test_it_is_a_filterpy_filter():
    kf = InertialEkf(dt=0.02, **SONOH)
    assert isinstance(kf, ExtendedKalmanFilter)
    saver = Saver(kf)
    for z in (0.1, 0.2, 0.3):
        kf.predict()
        kf.update(z)
        saver.save()
    saver.to_array()
    assert saver.x.shape == (3, 15, 1)
    kf.update(None)  # no sample
    assert np.array_equal(kf.x, saver.x[-1])
    imm = IMMEstimator([InertialEkf(dt=0.02), InertialEkf(dt=0.02)], [0.5, 0.5], np.full((2, 2), 0.5))
    alone = InertialEkf(dt=0.02)
    for z in (0.1, 0.2, 0.3):
        for each in (imm, alone):
            each.predict()
            each.update(z)
    np.testing.assert_allclose(imm.x, alone.x, atol=1e-12)


def test_without_an_imu_it_says_what_it_needs():
    with pytest.raises(ValueError, match="pass accel= in m/s² and gyro="):
        InertialEkf(dt=0.02).step(dt=0.02, altitude=0.0, acceleration=0.1)
    with pytest.raises(ValueError, match="give dt= in s, or noise="):
        InertialEkf()
