"""Horizontal accelerations of people, which no height shows."""

import numpy as np
import pytest

from baroarma.simulation.apparatus import REST_BEFORE
from baroarma.simulation.human import FAST, _along, squat
from baroarma.simulation.jet import clock, sin


def test_the_horizontal_acceleration_is_how_the_velocity_along_a_turning_heading_changes():
    t = np.arange(0, 3, 1e-4)
    way, aside, heading = 1.3 * clock(t) * clock(t), 0.2 * sin(3.0 * clock(t)), sin(clock(t))
    c, s = np.cos(heading.value), np.sin(heading.value)
    velocity = np.stack((c * way.first - s * aside.first, s * way.first + c * aside.first))
    # central differences: the third derivative, some tens, over 6, times the step squared
    change = np.gradient(velocity, 1e-4, axis=1)[:, 1:-1]
    assert np.stack(_along(way, aside, heading))[:, 1:-1] == pytest.approx(change, abs=1e-6)


T = np.arange(0, 80, 0.01)


def squats(**options):
    return squat(T, **options).height


def lowest(height):
    """Return the times of the bottoms."""
    inside = height.value[1:-1]
    return T[1:-1][(inside < height.value[:-2]) & (inside <= height.value[2:]) & (inside < -0.1)]


@pytest.mark.parametrize("pause", [1.0, 5.0])
def test_between_two_squats_one_stands_for_the_pause(pause):
    height = squats(pause=pause, period=4.0)
    moving = (height.first != 0) | (height.second != 0)
    begins, ends = (np.flatnonzero(np.diff(moving.astype(int)) == change) for change in (1, -1))
    assert T[begins[0]] == pytest.approx(REST_BEFORE, abs=0.02)
    # a squat takes its period and the time of a smooth start and end; two rows' steps of rounding
    assert T[ends[:3]] - T[begins[:3]] == pytest.approx(4.0 + FAST, abs=0.03)
    assert T[begins[1:4]] - T[ends[:3]] == pytest.approx(pause, abs=0.03)
    assert np.abs(height.value[~moving]).max() < 1e-12


def test_every_squat_with_pauses_goes_as_deep_as_told():
    height = squats(depth=0.5)
    assert np.diff(lowest(height)) == pytest.approx(4.0 + FAST + 5.0, abs=0.02)
    # the bottom is a parabola of 0.6 m/s²: 5 ms beside it are 10 um
    for when in lowest(height):
        assert height.value[np.searchsorted(T, when)] == pytest.approx(-0.5, abs=1e-4)


@pytest.mark.parametrize("pause", [0.0, 5.0])
@pytest.mark.parametrize("count", [1, 3])
def test_so_many_squats_are_done_and_then_none(count, pause):
    height = squats(count=count, pause=pause)
    assert len(lowest(height)) == count
    # without pauses the first squat starts, and the last one ends, over a whole period
    after = REST_BEFORE + (count * (4.0 + FAST + pause) if pause else (count + 1) * 4.0)
    assert not height.first[after < T].any()
    assert np.abs(height.value[after < T]).max() < 1e-12


def test_without_a_pause_one_squat_runs_into_the_next():
    height = squats(pause=0.0)
    assert np.diff(lowest(height)) == pytest.approx(4.0, abs=0.02)
    moving = height.second != 0
    # only instants without acceleration, no standing
    assert moving[T > REST_BEFORE + 0.02].mean() > 0.99
