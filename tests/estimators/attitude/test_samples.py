"""Samples of an IMU: which are none, and how long the last rate is held."""

import numpy as np

from baroarma.estimators.attitude.samples import (
    forget_rate,
    is_lost,
    is_rate,
    is_sample,
    levelled,
    take_rate,
)


def test_a_rate_is_held_for_half_a_second_and_then_forgotten_until_levelled():
    bias, none = np.array([0.1, 0.0, 0.0]), np.full(3, np.nan)
    held = take_rate((0.0, 0.0, 0.0, 0.0), np.array([1.1, 2.0, 3.0]), bias)
    held = take_rate(forget_rate(held, 0.3), none, bias)
    np.testing.assert_allclose(held, [1.0, 2.0, 3.0, 0.3])
    assert not is_lost(held)
    held = forget_rate(held, 0.3)
    np.testing.assert_allclose(held, [0.0, 0.0, 0.0, 0.6])
    assert is_lost(held)
    held = forget_rate(take_rate(held, np.ones(3), bias), 0.02)
    assert is_lost(held)  # a new rate does not bring the lost tilt back
    assert not is_lost(levelled(held))


def test_what_no_sensor_of_motion_says_is_no_sample():
    assert is_sample(np.array([0.0, 0.0, 313.0]))  # 32 g
    assert not is_sample(np.array([0.0, 1e6, 9.8]))
    assert is_rate(np.array([70.0, 0.0, 0.0]))  # 4000 °/s
    assert not is_rate(np.array([0.0, 1e4, 0.0]))
    for broken in (np.nan, np.inf, -np.inf):
        assert not is_sample(np.array([0.0, broken, 9.8]))
        assert not is_rate(np.array([0.0, broken, 0.0]))
