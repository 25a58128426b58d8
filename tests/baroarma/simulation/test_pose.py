"""The rigid body against finite differences of the pose itself."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baroarma.simulation.jet import clock, cos, sin
from baroarma.simulation.pose import FORWARD, LEFT, UP, Pose, observe

STEP = 1e-4
T = np.arange(0, 2, STEP)
LEVER = np.array([0.3, -0.2, 0.5])
MOUNTING = Rotation.from_euler("xyz", [0.4, -1.0, 2.0])
WITHIN = (
    20 * STEP**2
)  # central differences: the third derivative, some tens here, over 6, times the step squared


@pytest.fixture(scope="module")
def truth():
    """A body that turns about three axes and rises, and a sensor at its lever arm, mounted askew."""
    time = clock(T)
    turns = ((UP, 1.5 * sin(time)), (LEFT, 0.8 * sin(2.0 * time)), (FORWARD, 1.0 - cos(3.0 * time)))
    pose = Pose(0.1 * sin(4.0 * time), turns, tuple(LEVER), forward=np.cos(T), left=0.5 * np.sin(T))
    return observe(T, pose, MOUNTING)


def test_the_angular_rate_is_how_the_attitude_turns(truth):
    attitude = Rotation.from_quat(truth.attitude)
    turned = (attitude[:-2].inv() * attitude[2:]).as_rotvec() / (2 * STEP)
    assert turned == pytest.approx(truth.rate[1:-1], abs=WITHIN)


def test_height_and_velocity_are_those_of_the_sensor_not_of_the_body(truth):
    body = Rotation.from_quat(truth.attitude) * MOUNTING.inv()
    height = 0.1 * np.sin(4 * T) + body.apply(LEVER)[:, 2] - LEVER[2]
    assert truth.height == pytest.approx(height, abs=1e-14)
    assert np.gradient(height, STEP)[1:-1] == pytest.approx(truth.velocity[1:-1], abs=WITHIN)


def test_the_specific_force_is_the_sensors_acceleration_less_gravity(truth):
    sensor = Rotation.from_quat(truth.attitude)
    arm = (sensor * MOUNTING.inv()).apply(LEVER)
    path = arm + np.stack((-np.cos(T), -0.5 * np.sin(T), 0.1 * np.sin(4 * T)), axis=1)
    acceleration = (path[2:] - 2 * path[1:-1] + path[:-2]) / STEP**2
    felt = sensor.apply(truth.force)[1:-1] - (0, 0, 9.80665)
    # rounding: four times some metres, each rotated in several operations of 2e-16, over step²
    assert felt == pytest.approx(acceleration, abs=WITHIN + 4e-15 / STEP**2)
    assert truth.acceleration[1:-1] == pytest.approx(felt[:, 2], abs=1e-12)


def test_quaternions_do_not_flip(truth):
    assert np.abs(np.diff(truth.attitude, axis=0)).max() < 10 * STEP  # half of the rate, some rad/s
