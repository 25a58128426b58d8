"""The compiled matrices and steps, against SciPy, filterpy and the papers' own matrix forms."""

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter, KalmanFilter
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from baroarma.estimators.attitude import kernels
from baroarma.estimators.attitude.kernels import EkfSettings, TiltSettings
from baroarma.rotation import skew

RNG = np.random.default_rng(7)
ROTATION = Rotation.random(rng=7)
Q = ROTATION.as_quat()
RATE = np.array([0.7, -1.9, 2.6, 0.0])  # the last is the age of the sample
SETTINGS = EkfSettings(0.02, 0.1, 5e-4, 0.0, 1.5, 0.01, 0.001)
EXACT = {"rtol": 0.0, "atol": 1e-13}  # rounding of numbers of order 1 to 10


def covariance(n, scale=1.0):
    root = RNG.normal(size=(n, n))
    return scale * root @ root.T / n


def fill(function, shape, *args):
    out = np.zeros(shape)
    function(out, *args)
    return out


@pytest.mark.parametrize("decay", [0.0, 2.0])
def test_the_prediction_in_blocks_is_filterpys(decay):
    s, x, P = SETTINGS._replace(bias_decay=decay), np.append(Q, RNG.normal(size=3)), covariance(7)
    kf = KalmanFilter(7, 3)
    kf.x, kf.P = x.copy(), P.copy()
    kf.F = fill(kernels.fill_quaternion_transition, (7, 7), RATE, 0.02, decay)
    kf.Q = fill(kernels.fill_quaternion_noise, (7, 7), x, P, 0.02, s)
    kf.predict()
    kernels.store_belief(kernels.predict_quaternion(kernels.load_belief(x, P), tuple(RATE), 0.02, s), x, P)
    np.testing.assert_allclose(x, kf.x, **EXACT)
    np.testing.assert_allclose(P, kf.P, **EXACT)


@pytest.mark.parametrize("beyond", [(), (0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)])
def test_one_component_after_the_other_is_filterpys_update_with_those_within_the_gate(beyond):
    x, P = np.append(Q, RNG.normal(size=3)), covariance(7, 0.01)
    P += 0.01 * np.eye(7)
    force = 9.8 * fill(kernels.fill_up, 3, Q) + x[4:] + RNG.uniform(-1, 1, 3)  # the gate is 1.5
    force[list(beyond)] += 10.0
    H = np.hstack([9.8 * fill(kernels.fill_up_jacobian, (3, 4), Q), np.eye(3)])
    H[list(beyond)] = 0.0
    ekf = ExtendedKalmanFilter(7, 3)
    ekf.x, ekf.P, ekf.R = x.copy(), P.copy(), SETTINGS.accel_noise_sd**2 * np.eye(3)
    ekf.update(force, lambda x: H, lambda x: 9.8 * fill(kernels.fill_up, 3, x) + x[4:])
    ekf.x[:4] /= np.linalg.norm(ekf.x[:4])
    kernels.store_belief(kernels.correct_quaternion(kernels.load_belief(x, P), force, 9.8, SETTINGS), x, P)
    # S is up to 1e5 times R, which costs Joseph's form five digits of the sixteen
    np.testing.assert_allclose(x, ekf.x, rtol=0, atol=1e-11)
    np.testing.assert_allclose(P, ekf.P, rtol=0, atol=1e-11)


@pytest.mark.parametrize("exponential", [True, False])
def test_the_tilts_prediction_and_update_are_filterpys(exponential):
    s, (Z, a, f), P = TiltSettings(0.02, 0.1, 0.3, exponential), RNG.normal(size=(3, 3)), covariance(3)
    kf = KalmanFilter(3, 3)
    kf.x, kf.P, kf.H = Z.copy(), P.copy(), 9.8 * np.eye(3)
    kf.F = fill(kernels.fill_tilt_transition, (3, 3), RATE, 0.02, exponential)
    kf.Q = fill(kernels.fill_tilt_noise, (3, 3), Z, 0.02, 0.02)
    kf.R = kernels.tilt_measurement_variance(a, s) * np.eye(3)
    kf.predict()
    kf.update(f - 0.3 * a)
    belief = kernels.predict_tilt(kernels.load_tilt(Z, P, a), tuple(RATE), 0.02, s)
    kernels.store_tilt(kernels.correct_tilt(belief, f, 9.8, s), Z, P, a)
    np.testing.assert_allclose(Z, kf.x, rtol=0, atol=1e-11)
    np.testing.assert_allclose(P, kf.P, rtol=0, atol=1e-11)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.1, 0.4999999, 0.5, 0.5000001, 2.0, 7.0])
def test_series_and_functions_of_an_angle_agree(angle):
    assert kernels.sine(angle**2) == pytest.approx(np.sinc(angle / np.pi), abs=1e-15)
    half = np.sinc(angle / 2 / np.pi)
    assert kernels.versine(angle**2) == pytest.approx(half**2 / 2, abs=1e-15)


@pytest.mark.parametrize("angle", [0.01, 0.9, 1.1, 4.0])
def test_half_a_turn_is_scipys_quaternion(angle):
    rate = angle / 0.3 * RATE[:3] / np.linalg.norm(RATE[:3])
    turn = kernels.half_turn((*rate, 0.0), 0.3)
    np.testing.assert_allclose(turn, Rotation.from_rotvec(0.3 * rate).as_quat(scalar_first=True), **EXACT)


def test_the_vertical_is_the_corrected_equation_23_and_scipys():
    q, q4 = Q[:3], Q[3]
    up = fill(kernels.fill_up, 3, Q)
    c_nb = np.eye(3) + 2 * q4 * skew(q) + 2 * skew(q) @ skew(q)
    np.testing.assert_allclose(c_nb, ROTATION.as_matrix(), **EXACT)
    np.testing.assert_allclose(up, c_nb[2], **EXACT)


def test_the_jacobian_of_the_vertical_is_equation_18_and_the_finite_difference():
    q, q4, g = Q[:3], Q[3], np.array([0.0, 0.0, -1.0])  # z up
    J = fill(kernels.fill_up_jacobian, (3, 4), Q)
    left = -2 * q4 * skew(g) - 2 * (skew(g) @ skew(q) - 2 * skew(q) @ skew(g))
    np.testing.assert_allclose(J, np.column_stack([left, 2 * skew(q) @ g]), **EXACT)
    steps = 1e-5 * np.eye(4)
    difference = [fill(kernels.fill_up, 3, Q + s) - fill(kernels.fill_up, 3, Q - s) for s in steps]
    np.testing.assert_allclose(J, np.transpose(difference) / 2e-5, atol=1e-6)


@pytest.mark.parametrize("up", [[0, 0, 1.0], [0, 0, -2.0], [1e-9, 0, -1], [0.48, -0.6, 0.64], [-3.0, 2, -5]])
def test_levelling_turns_the_given_vertical_up_by_the_shortest_way(up):
    up = np.array(up) / np.linalg.norm(up)
    q = fill(kernels.fill_level, 4, 5.0 * up)
    np.testing.assert_allclose(fill(kernels.fill_up, 3, q), up, **EXACT)
    shortest = np.arctan2(np.hypot(up[0], up[1]), up[2])
    assert Rotation.from_quat(q).magnitude() == pytest.approx(shortest, abs=1e-13)


def test_the_quaternion_turns_as_the_body_does():
    F = fill(kernels.fill_quaternion_transition, (7, 7), RATE, 0.3, 0.5)
    turned = ROTATION * Rotation.from_rotvec(0.3 * RATE[:3])
    q = F[:4, :4] @ Q
    np.testing.assert_allclose(q * np.sign(q @ turned.as_quat()), turned.as_quat(), **EXACT)
    omega = np.block([[-skew(RATE[:3]), RATE[:3, None]], [-RATE[None, :3], np.zeros((1, 1))]])  # Eq. 3
    np.testing.assert_allclose(F[:4, :4], expm(0.15 * omega), **EXACT)
    np.testing.assert_allclose(F[4:, 4:], np.exp(-0.15) * np.eye(3), **EXACT)
    assert not F[:4, 4:].any()
    assert not F[4:, :4].any()


@pytest.mark.parametrize("function", [kernels.fill_quaternion_transition, kernels.fill_tilt_transition])
def test_a_resting_gyro_turns_nothing(function):
    n = 7 if function is kernels.fill_quaternion_transition else 3
    np.testing.assert_array_equal(fill(function, (n, n), np.zeros(4), 0.02, 0), np.eye(n))


def test_the_vertical_turns_against_the_body():
    F = fill(kernels.fill_tilt_transition, (3, 3), RATE, 0.3, True)
    np.testing.assert_allclose(F, expm(-0.3 * skew(RATE[:3])), **EXACT)
    first = fill(kernels.fill_tilt_transition, (3, 3), RATE, 0.3, False)
    np.testing.assert_allclose(first, np.eye(3) - 0.3 * skew(RATE[:3]), **EXACT)


def test_quaternion_noise_is_the_mean_of_equation_9_over_the_quaternions_distribution():
    x, P = np.append(Q, np.zeros(3)), covariance(7, 0.01)
    noise = fill(kernels.fill_quaternion_noise, (7, 7), x, P, 0.02, SETTINGS)
    root = np.linalg.cholesky(4 * P[:4, :4]).T
    mean = np.zeros((4, 4))
    for q in [*(Q + root), *(Q - root)]:  # eight points with these two moments: exact for squares
        E = np.vstack([q[3] * np.eye(3) + skew(q[:3]), -q[None, :3]])  # Eq. 10
        mean += E @ E.T / 8
    np.testing.assert_allclose(noise[:4, :4], mean * (0.02 / 2 * 0.02) ** 2, atol=1e-18)


def test_bias_noise_without_decay_is_the_limit_of_little_decay():
    x, P = np.append(Q, np.zeros(3)), covariance(7)
    none, little, some = (
        fill(kernels.fill_quaternion_noise, (7, 7), x, P, 0.02, SETTINGS._replace(bias_decay=a))[6, 6]
        for a in (0.0, 1e-12, 3.0)
    )
    assert none == 0.02 * 5e-4**2
    assert little == pytest.approx(none, rel=1e-12)
    assert some == pytest.approx((1 - np.exp(-2 * 3.0 * 0.02)) / (2 * 3.0) * 5e-4**2, rel=1e-12)  # Eq. 7


def test_tilt_noise_is_the_cross_product_with_gyro_noise():
    Z = RNG.normal(size=3)
    noise = fill(kernels.fill_tilt_noise, (3, 3), Z, 0.02, 0.1)
    np.testing.assert_allclose(noise, -((0.02 * 0.1) ** 2) * skew(Z) @ skew(Z), atol=1e-18)
    assert np.linalg.eigvalsh(noise).min() > -1e-20  # positive semidefinite, up to rounding


def test_the_sd_of_the_vertical_acceleration_is_that_of_tilted_copies():
    up, f, n = np.array([0.0, 0.6, 0.8]), np.array([2.0, 7.0, 9.0]), 200_000
    tilt = np.array([[3e-4, 1e-4, 0.0], [1e-4, 2e-4, 0.0], [0.0, 0.0, 0.0]])  # about world x and y
    rotations = Rotation.align_vectors([[0.0, 0.0, 1.0]], [up])[0]
    to_body = rotations.inv().as_matrix()
    a, sd = kernels.vertical_acceleration(f, up, to_body, tilt, 9.8, 0.05)
    rng = np.random.default_rng(3)
    errors = rng.multivariate_normal(np.zeros(3), tilt, n) @ to_body.T
    copies = up + errors
    copies /= np.linalg.norm(copies, axis=1, keepdims=True)
    samples = np.sum(copies * (f + 0.05 * rng.normal(size=(n, 3))), axis=1) - 9.8
    assert a == pytest.approx(up @ f - 9.8, abs=1e-14)
    # the sd of n samples is good to 1/sqrt(2n) = 0.16 %; what is of second order in 1° adds less than 0.1 %
    assert samples.std() == pytest.approx(sd, rel=4 * 0.0016 + 0.001)


def test_a_rate_is_held_for_half_a_second_and_then_forgotten_until_levelled():
    bias, none = np.array([0.1, 0.0, 0.0]), np.full(3, np.nan)
    held = kernels.take_rate((0.0, 0.0, 0.0, 0.0), np.array([1.1, 2.0, 3.0]), bias)
    held = kernels.take_rate(kernels.forget_rate(held, 0.3), none, bias)
    np.testing.assert_allclose(held, [1.0, 2.0, 3.0, 0.3])
    assert not kernels.is_lost(held)
    held = kernels.forget_rate(held, 0.3)
    np.testing.assert_allclose(held, [0.0, 0.0, 0.0, 0.6])
    assert kernels.is_lost(held)
    held = kernels.forget_rate(kernels.take_rate(held, np.ones(3), bias), 0.02)
    assert kernels.is_lost(held)  # a new rate does not bring the lost tilt back
    assert not kernels.is_lost(kernels.levelled(held))


def test_free_fall_shows_no_vertical():
    Z, P, x = np.array([0.0, 0.0, 1.0]), np.eye(3), np.append(Q, np.zeros(3))
    assert not kernels.level_vertical(Z, P, np.zeros(3))
    assert not kernels.level_quaternion(x, np.eye(7), np.zeros(3), 0.01)
    np.testing.assert_array_equal(x[:4], Q)
    assert kernels.level_vertical(Z, P, np.array([0.0, 9.0, 0.0]))
    np.testing.assert_allclose(Z, [0.0, 1.0, 0.0])


def test_what_no_sensor_of_motion_says_is_no_sample():
    assert kernels.is_sample(np.array([0.0, 0.0, 313.0]))  # 32 g
    assert not kernels.is_sample(np.array([0.0, 1e6, 9.8]))
    assert kernels.is_rate(np.array([70.0, 0.0, 0.0]))  # 4000 °/s
    assert not kernels.is_rate(np.array([0.0, 1e4, 0.0]))
    for broken in (np.nan, np.inf, -np.inf):
        assert not kernels.is_sample(np.array([0.0, broken, 9.8]))
        assert not kernels.is_rate(np.array([0.0, broken, 0.0]))


def test_a_force_next_to_nothing_has_no_vertical():
    Z, P = np.array([0.0, 0.0, 1.0]), np.eye(3)
    assert not kernels.level_vertical(Z, P, np.array([1e-307, 0.0, 0.0]))  # whose square is 0
    np.testing.assert_array_equal(Z, [0, 0, 1])
