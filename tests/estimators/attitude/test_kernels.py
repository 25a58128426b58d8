"""The compiled matrices and steps, against SciPy, filterpy and the papers' own matrix forms."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from baroarma.estimators.attitude import kernels
from baroarma.estimators.attitude.kernels import EkfSettings
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


def test_predict_is_filterpys():
    kf = KalmanFilter(7, 3)
    kf.x, kf.P, kf.Q, kf.F = RNG.normal(size=7), covariance(7), covariance(7), RNG.normal(size=(7, 7))
    kf.F[RNG.random((7, 7)) < 0.4] = 0.0
    x, P = kf.x.copy(), kf.P.copy()
    kernels.predict(x, P, kf.F, kf.Q, np.empty((7, 7)))
    kf.predict()
    np.testing.assert_allclose(x, kf.x, **EXACT)
    np.testing.assert_allclose(P, kf.P, **EXACT)


def test_one_component_after_the_other_is_filterpys_joseph_update():
    kf = KalmanFilter(7, 3)
    kf.x, kf.P, kf.H, kf.R = RNG.normal(size=7), covariance(7), RNG.normal(size=(3, 7)), 0.3 * np.eye(3)
    x, P, z = kf.x.copy(), kf.P.copy(), RNG.normal(size=3)
    for row, value in zip(kf.H, z, strict=True):
        kernels.update(x, P, row, value - row @ x, 0.3, np.empty((7, 7)))
    kf.update(z)
    np.testing.assert_allclose(x, kf.x, **EXACT)
    np.testing.assert_allclose(P, kf.P, **EXACT)


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
    held, bias, none = np.zeros(4), np.array([0.1, 0.0, 0.0]), np.full(3, np.nan)
    kernels.take_rate(held, np.array([1.1, 2.0, 3.0]), bias)
    assert not kernels.forget_rate(held, 0.3)
    kernels.take_rate(held, none, bias)
    np.testing.assert_allclose(held, [1.0, 2.0, 3.0, 0.3])
    assert kernels.forget_rate(held, 0.3)
    np.testing.assert_allclose(held, [0.0, 0.0, 0.0, 0.6])
    kernels.take_rate(held, np.ones(3), bias)
    assert kernels.forget_rate(held, 0.02)  # a new rate does not bring the lost tilt back
    Z, P = np.array([0.0, 0.0, 1.0]), np.eye(3)
    kernels.level_vertical(Z, P, held, np.zeros(3))  # and free fall shows no vertical
    assert kernels.forget_rate(held, 0.02)
    kernels.level_vertical(Z, P, held, np.array([0.0, 9.0, 0.0]))
    assert not kernels.forget_rate(held, 0.02)
    np.testing.assert_allclose(Z, [0.0, 1.0, 0.0])
