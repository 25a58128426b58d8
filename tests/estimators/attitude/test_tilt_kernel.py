"""The tilt filter's matrices against SciPy, and its steps against filterpy."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from scipy.linalg import expm

from baroarma.estimators.attitude.tilt_kernel import (
    TiltSettings,
    correct_tilt,
    fill_tilt_noise,
    fill_tilt_transition,
    level_vertical,
    load_tilt,
    predict_tilt,
    store_tilt,
    tilt_measurement_variance,
)
from baroarma.rotation import skew

RNG = np.random.default_rng(7)
RATE = np.array([0.7, -1.9, 2.6, 0.0])  # the last is the age of the sample
EXACT = {"rtol": 0.0, "atol": 1e-13}  # rounding of numbers of order 1 to 10


@pytest.mark.parametrize("exponential", [True, False])
def test_the_tilts_prediction_and_update_are_filterpys(exponential, covariance, fill):
    s, (Z, a, f), P = TiltSettings(0.02, 0.1, 0.3, exponential), RNG.normal(size=(3, 3)), covariance(3)
    kf = KalmanFilter(3, 3)
    kf.x, kf.P, kf.H = Z.copy(), P.copy(), 9.8 * np.eye(3)
    kf.F = fill(fill_tilt_transition, (3, 3), RATE, 0.02, exponential)
    kf.Q = fill(fill_tilt_noise, (3, 3), Z, 0.02, 0.02)
    kf.R = tilt_measurement_variance(a, s) * np.eye(3)
    kf.predict()
    kf.update(f - 0.3 * a)
    belief = predict_tilt(load_tilt(Z, P, a), tuple(RATE), 0.02, s)
    store_tilt(correct_tilt(belief, f, 9.8, s), Z, P, a)
    np.testing.assert_allclose(Z, kf.x, rtol=0, atol=1e-11)
    np.testing.assert_allclose(P, kf.P, rtol=0, atol=1e-11)


def test_the_vertical_turns_against_the_body(fill):
    F = fill(fill_tilt_transition, (3, 3), RATE, 0.3, True)
    np.testing.assert_allclose(F, expm(-0.3 * skew(RATE[:3])), **EXACT)
    first = fill(fill_tilt_transition, (3, 3), RATE, 0.3, False)
    np.testing.assert_allclose(first, np.eye(3) - 0.3 * skew(RATE[:3]), **EXACT)


def test_tilt_noise_is_the_cross_product_with_gyro_noise(fill):
    Z = RNG.normal(size=3)
    noise = fill(fill_tilt_noise, (3, 3), Z, 0.02, 0.1)
    np.testing.assert_allclose(noise, -((0.02 * 0.1) ** 2) * skew(Z) @ skew(Z), atol=1e-18)
    assert np.linalg.eigvalsh(noise).min() > -1e-20  # positive semidefinite, up to rounding


@pytest.mark.parametrize("exponential", [True, False])
def test_a_resting_gyro_turns_no_vertical(exponential, fill):
    F = fill(fill_tilt_transition, (3, 3), np.zeros(4), 0.02, exponential)
    np.testing.assert_array_equal(F, np.eye(3))


def test_free_fall_shows_no_vertical():
    Z, P = np.array([0.0, 0.0, 1.0]), np.eye(3)
    assert not level_vertical(Z, P, np.zeros(3))
    np.testing.assert_array_equal(Z, [0.0, 0.0, 1.0])
    assert level_vertical(Z, P, np.array([0.0, 9.0, 0.0]))
    np.testing.assert_allclose(Z, [0.0, 1.0, 0.0])


def test_a_force_next_to_nothing_has_no_vertical():
    Z, P = np.array([0.0, 0.0, 1.0]), np.eye(3)
    assert not level_vertical(Z, P, np.array([1e-307, 0.0, 0.0]))  # whose square is 0
    np.testing.assert_array_equal(Z, [0, 0, 1])
