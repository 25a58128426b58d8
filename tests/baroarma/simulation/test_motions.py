"""True motions: what ideal sensors feel integrates back to the truth, and follows the papers' equations."""

import numpy as np
import pytest
from numba import njit
from scipy.spatial.transform import Rotation

from baroarma.simulation.motions import DURATIONS, MOTIONS, REST_BEFORE, move, options_of

G = 9.80665
THREE_MINUTES = 180.0


@njit
def strapdown(t, force, rate, attitude):
    """Height from specific force and rate: rotation by the mean of two rates, trapezoids; order 2 in the step."""
    height = np.zeros(len(t))
    up, velocity = attitude[2].copy(), 0.0  # the vertical in the sensor's axes is all that height needs
    before = np.sum(up * force[0]) - G
    for k in range(1, len(t)):
        dt = t[k] - t[k - 1]
        turn = -0.5 * (rate[k] + rate[k - 1]) * dt
        angle = np.sqrt(np.sum(turn**2))
        if angle > 0:
            axis = turn / angle
            up = (
                up * np.cos(angle)
                + np.cross(axis, up) * np.sin(angle)
                + axis * np.sum(axis * up) * (1 - np.cos(angle))
            )
        now = np.sum(up * force[k]) - G
        height[k] = height[k - 1] + velocity * dt + (2 * before + now) * dt**2 / 6
        velocity += 0.5 * (before + now) * dt
        before = now
    return height


def fine_times(motion):
    """2 ms, but 0.1 ms around the free fall, whose impact ramps up by 4000 m/s³."""
    if motion != "free-fall":
        return np.arange(0, THREE_MINUTES, 0.002)
    return np.concatenate((np.arange(0, 7.9, 0.002), np.arange(7.9, 9.9, 1e-4), np.arange(9.9, 180, 0.002)))


@pytest.mark.parametrize("motion", MOTIONS)
def test_integrating_perfect_sensors_returns_the_true_height_for_three_minutes(motion):
    t = fine_times(motion)
    truth = move(motion, t, np.random.default_rng(0))
    attitude = Rotation.from_quat(truth.attitude[0]).as_matrix()
    error = strapdown(t, truth.force, truth.rate, attitude) - truth.height
    print(motion, np.abs(error).max())
    assert np.abs(error).max() < 1e-3  # 1 mm, as promised
