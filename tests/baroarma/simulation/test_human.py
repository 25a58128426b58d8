"""Horizontal accelerations of people, which no height shows."""

import numpy as np
import pytest

from baroarma.simulation.human import _along
from baroarma.simulation.jet import clock, sin


def test_the_horizontal_acceleration_is_how_the_velocity_along_a_turning_heading_changes():
    t = np.arange(0, 3, 1e-4)
    way, aside, heading = 1.3 * clock(t) * clock(t), 0.2 * sin(3.0 * clock(t)), sin(clock(t))
    c, s = np.cos(heading.value), np.sin(heading.value)
    velocity = np.stack((c * way.first - s * aside.first, s * way.first + c * aside.first))
    # central differences: the third derivative, some tens, over 6, times the step squared
    change = np.gradient(velocity, 1e-4, axis=1)[:, 1:-1]
    assert np.stack(_along(way, aside, heading))[:, 1:-1] == pytest.approx(change, abs=1e-6)
