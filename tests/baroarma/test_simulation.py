"""Simulated recordings carry a truth that their sensors agree with."""

import numpy as np
import pytest
from scipy import integrate
from scipy.spatial.transform import Rotation

from baroarma.simulation import BMP085, simulate
from baroarma.simulation.motions import MOTIONS, move


@pytest.mark.parametrize("motion", sorted(MOTIONS))
def test_integrating_perfect_sensors_returns_the_true_height(motion):
    # strapdown with midpoint rotation and trapezoidal acceleration, second order in the step: 2 ms steps
    t = np.arange(20_000) / 500
    truth = move(motion, t, np.random.default_rng(0))
    turns = Rotation.from_rotvec(0.5 * (truth.rate[1:] + truth.rate[:-1]) / 500)
    attitude = [Rotation.from_quat(truth.attitude[0])]
    for turn in turns:
        attitude.append(attitude[-1] * turn)
    acceleration = Rotation.concatenate(attitude).apply(truth.force)[:, 2] - 9.80665
    velocity = integrate.cumulative_trapezoid(acceleration, t, initial=0)
    height = integrate.cumulative_trapezoid(velocity, t, initial=0)
    assert np.abs(height - truth.height).max() < 1e-3


@pytest.mark.parametrize("seed", range(5))
def test_a_resting_sensor_feels_gravity_upwards_in_any_mounting(seed):
    truth = move("rest", np.arange(3.0), np.random.default_rng(seed))
    up = Rotation.from_quat(truth.attitude).apply(truth.force)
    assert up == pytest.approx(np.tile((0, 0, 9.80665), (3, 1)), abs=1e-9)


def test_pressure_is_quantised_and_noisy_as_the_preset_says():
    recording = simulate("rest", duration=600, seed=2, imu=None)
    assert np.all(recording.pressure == np.round(recording.pressure))
    white = np.std(np.diff(recording.height())) / np.sqrt(2)
    expected = np.hypot(BMP085.noise.white_sd, 0.0843 / np.sqrt(12))
    # first differences also hold the GM's: 2 sigma_c^2 (1 - e^(-dt/tau)); 1/sqrt(2 n) = 0.4 %
    assert white == pytest.approx(np.hypot(expected, 0.27 * np.sqrt(0.02 / 0.75)), rel=0.02)


def test_a_seed_gives_the_same_numbers_again():
    a, b = simulate("squat", duration=20, seed=5), simulate("squat", duration=20, seed=5)
    assert np.array_equal(a.pressure, b.pressure)
    assert np.array_equal(a.gyro, b.gyro)
