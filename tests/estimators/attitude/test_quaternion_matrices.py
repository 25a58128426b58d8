"""The quaternion filter's matrices, against SciPy and the paper's own matrix forms."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from baroarma.estimators.attitude.quaternion_matrices import (
    EkfSettings,
    fill_quaternion_noise,
    fill_quaternion_transition,
    fill_up,
    fill_up_jacobian,
    level_quaternion,
)
from baroarma.estimators.attitude.vertical import fill_level
from baroarma.rotation import skew

ROTATION = Rotation.random(rng=7)
Q = ROTATION.as_quat()
RATE = np.array([0.7, -1.9, 2.6, 0.0])  # the last is the age of the sample
SETTINGS = EkfSettings(0.02, 0.1, 5e-4, 0.0, 1.5, 0.01, 0.001)
EXACT = {"rtol": 0.0, "atol": 1e-13}  # rounding of numbers of order 1 to 10


def test_the_vertical_is_the_corrected_equation_23_and_scipys(fill):
    q, q4 = Q[:3], Q[3]
    up = fill(fill_up, 3, Q)
    c_nb = np.eye(3) + 2 * q4 * skew(q) + 2 * skew(q) @ skew(q)
    np.testing.assert_allclose(c_nb, ROTATION.as_matrix(), **EXACT)
    np.testing.assert_allclose(up, c_nb[2], **EXACT)


def test_the_jacobian_of_the_vertical_is_equation_18_and_the_finite_difference(fill):
    q, q4, g = Q[:3], Q[3], np.array([0.0, 0.0, -1.0])  # z up
    J = fill(fill_up_jacobian, (3, 4), Q)
    left = -2 * q4 * skew(g) - 2 * (skew(g) @ skew(q) - 2 * skew(q) @ skew(g))
    np.testing.assert_allclose(J, np.column_stack([left, 2 * skew(q) @ g]), **EXACT)
    steps = 1e-5 * np.eye(4)
    difference = [fill(fill_up, 3, Q + s) - fill(fill_up, 3, Q - s) for s in steps]
    np.testing.assert_allclose(J, np.transpose(difference) / 2e-5, atol=1e-6)


@pytest.mark.parametrize("up", [[0, 0, 1.0], [0, 0, -2.0], [1e-9, 0, -1], [0.48, -0.6, 0.64], [-3.0, 2, -5]])
def test_levelling_turns_the_given_vertical_up_by_the_shortest_way(up, fill):
    up = np.array(up) / np.linalg.norm(up)
    q = fill(fill_level, 4, 5.0 * up)
    np.testing.assert_allclose(fill(fill_up, 3, q), up, **EXACT)
    shortest = np.arctan2(np.hypot(up[0], up[1]), up[2])
    assert Rotation.from_quat(q).magnitude() == pytest.approx(shortest, abs=1e-13)


def test_the_quaternion_turns_as_the_body_does(fill):
    F = fill(fill_quaternion_transition, (7, 7), RATE, 0.3, 0.5)
    turned = ROTATION * Rotation.from_rotvec(0.3 * RATE[:3])
    q = F[:4, :4] @ Q
    np.testing.assert_allclose(q * np.sign(q @ turned.as_quat()), turned.as_quat(), **EXACT)
    omega = np.block([[-skew(RATE[:3]), RATE[:3, None]], [-RATE[None, :3], np.zeros((1, 1))]])  # Eq. 3
    np.testing.assert_allclose(F[:4, :4], expm(0.15 * omega), **EXACT)
    np.testing.assert_allclose(F[4:, 4:], np.exp(-0.15) * np.eye(3), **EXACT)
    assert not F[:4, 4:].any()
    assert not F[4:, :4].any()


def test_a_resting_gyro_turns_no_quaternion(fill):
    F = fill(fill_quaternion_transition, (7, 7), np.zeros(4), 0.02, 0.0)
    np.testing.assert_array_equal(F, np.eye(7))


def test_quaternion_noise_is_the_mean_of_equation_9_over_the_quaternions_distribution(covariance, fill):
    x, P = np.append(Q, np.zeros(3)), covariance(7, 0.01)
    noise = fill(fill_quaternion_noise, (7, 7), x, P, 0.02, SETTINGS)
    root = np.linalg.cholesky(4 * P[:4, :4]).T
    mean = np.zeros((4, 4))
    for q in [*(Q + root), *(Q - root)]:  # eight points with these two moments: exact for squares
        E = np.vstack([q[3] * np.eye(3) + skew(q[:3]), -q[None, :3]])  # Eq. 10
        mean += E @ E.T / 8
    np.testing.assert_allclose(noise[:4, :4], mean * (0.02 / 2 * 0.02) ** 2, atol=1e-18)


def test_bias_noise_without_decay_is_the_limit_of_little_decay(covariance, fill):
    x, P = np.append(Q, np.zeros(3)), covariance(7)
    none, little, some = (
        fill(fill_quaternion_noise, (7, 7), x, P, 0.02, SETTINGS._replace(bias_decay=a))[6, 6]
        for a in (0.0, 1e-12, 3.0)
    )
    assert none == 0.02 * 5e-4**2
    assert little == pytest.approx(none, rel=1e-12)
    assert some == pytest.approx((1 - np.exp(-2 * 3.0 * 0.02)) / (2 * 3.0) * 5e-4**2, rel=1e-12)  # Eq. 7


def test_free_fall_levels_no_quaternion():
    x = np.append(Q, np.zeros(3))
    assert not level_quaternion(x, np.eye(7), np.zeros(3), 0.01)
    np.testing.assert_array_equal(x[:4], Q)
