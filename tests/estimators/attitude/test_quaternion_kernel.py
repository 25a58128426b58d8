"""The quaternion filter's steps, against filterpy with `quaternion_matrices`."""

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter, KalmanFilter
from scipy.spatial.transform import Rotation

from baroarma.estimators.attitude.quaternion_kernel import (
    correct_quaternion,
    half_turn,
    load_belief,
    predict_quaternion,
    store_belief,
)
from baroarma.estimators.attitude.quaternion_matrices import (
    EkfSettings,
    fill_quaternion_noise,
    fill_quaternion_transition,
    fill_up,
    fill_up_jacobian,
)

RNG = np.random.default_rng(7)
Q = Rotation.random(rng=7).as_quat()
RATE = np.array([0.7, -1.9, 2.6, 0.0])  # the last is the age of the sample
SETTINGS = EkfSettings(0.02, 0.1, 5e-4, 0.0, 1.5, 0.01, 0.001)
EXACT = {"rtol": 0.0, "atol": 1e-13}  # rounding of numbers of order 1 to 10


@pytest.mark.parametrize("decay", [0.0, 2.0])
def test_the_prediction_in_blocks_is_filterpys(decay, covariance, fill):
    s, x, P = SETTINGS._replace(bias_decay=decay), np.append(Q, RNG.normal(size=3)), covariance(7)
    kf = KalmanFilter(7, 3)
    kf.x, kf.P = x.copy(), P.copy()
    kf.F = fill(fill_quaternion_transition, (7, 7), RATE, 0.02, decay)
    kf.Q = fill(fill_quaternion_noise, (7, 7), x, P, 0.02, s)
    kf.predict()
    store_belief(predict_quaternion(load_belief(x, P), tuple(RATE), 0.02, s), x, P)
    np.testing.assert_allclose(x, kf.x, **EXACT)
    np.testing.assert_allclose(P, kf.P, **EXACT)


@pytest.mark.parametrize("beyond", [(), (0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)])
def test_one_component_after_the_other_is_filterpys_update_with_those_within_the_gate(
    beyond, covariance, fill
):
    x, P = np.append(Q, RNG.normal(size=3)), covariance(7, 0.01)
    P += 0.01 * np.eye(7)
    force = 9.8 * fill(fill_up, 3, Q) + x[4:] + RNG.uniform(-1, 1, 3)  # the gate is 1.5
    force[list(beyond)] += 10.0
    H = np.hstack([9.8 * fill(fill_up_jacobian, (3, 4), Q), np.eye(3)])
    H[list(beyond)] = 0.0
    ekf = ExtendedKalmanFilter(7, 3)
    ekf.x, ekf.P, ekf.R = x.copy(), P.copy(), SETTINGS.accel_noise_sd**2 * np.eye(3)
    ekf.update(force, lambda x: H, lambda x: 9.8 * fill(fill_up, 3, x) + x[4:])
    ekf.x[:4] /= np.linalg.norm(ekf.x[:4])
    store_belief(correct_quaternion(load_belief(x, P), force, 9.8, SETTINGS), x, P)
    # S is up to 1e5 times R, which costs Joseph's form five digits of the sixteen
    np.testing.assert_allclose(x, ekf.x, rtol=0, atol=1e-11)
    np.testing.assert_allclose(P, ekf.P, rtol=0, atol=1e-11)


@pytest.mark.parametrize("angle", [0.01, 0.9, 1.1, 4.0])
def test_half_a_turn_is_scipys_quaternion(angle):
    rate = angle / 0.3 * RATE[:3] / np.linalg.norm(RATE[:3])
    turn = half_turn((*rate, 0.0), 0.3)
    np.testing.assert_allclose(turn, Rotation.from_rotvec(0.3 * rate).as_quat(scalar_first=True), **EXACT)
