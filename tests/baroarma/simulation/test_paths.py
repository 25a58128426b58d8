"""Courses over time against SciPy's splines and against what they are made for."""

import numpy as np
import pytest
from scipy.interpolate import BPoly

from baroarma.simulation.paths import eased, folded, running, running_for, through

T = np.linspace(-1, 7, 900)


def test_a_course_through_knots_is_the_spline_with_those_derivatives():
    knots = [(0, 0, 0, 0), (1, 2, -1, 3), (1.5, 1, 0.5, -9), (4, 5, 2, 0), (6, 3, 0, 0)]
    spline = BPoly.from_derivatives([k[0] for k in knots], [k[1:] for k in knots])
    inside = np.clip(T, 0, 6)
    course = through(T, knots)
    for order, signal in enumerate((course.value, course.first, course.second)):
        assert signal == pytest.approx(spline(inside, nu=order), abs=1e-11)


def test_free_flight_between_its_own_ends_is_a_parabola():
    t = np.linspace(1, 3, 50)
    flight = through(t, [(0, 0, 0, 0), (1, 4, 5, -9.8), (3, 4 + 10 - 19.6, 5 - 19.6, -9.8), (4, 0, 0, 0)])
    since = t - 1
    assert flight.value == pytest.approx(4 + 5 * since - 4.9 * since**2, abs=1e-12)
    assert flight.second == pytest.approx(np.full(50, -9.8), abs=1e-10)


def test_a_step_goes_from_0_to_1_and_never_back():
    step = eased(T, 1.0, 2.0)
    assert (step.value[0], step.value[-1]) == (0, pytest.approx(1))
    assert step.first.min() >= -1e-15


def test_a_running_time_lags_by_half_of_its_rise_and_runs_at_full_pace():
    time = running(T, 1.0, 2.0)
    late = T >= 3
    assert time.value[late] == pytest.approx(T[late] - 2.0)
    assert time.first[late] == pytest.approx(1)
    assert not time.value[T <= 1].any()
    # the pace is the integral of its change, by trapezoids of second order
    assert time.first == pytest.approx(np.concatenate(([0], np.cumsum(_means(time.second)))), abs=1e-4)


def test_a_time_that_ends_has_run_for_its_amount():
    assert running_for(T, 0.0, 1.0, 2.5).value[-1] == pytest.approx(2.5)
    assert running_for(T, 0.0, 1.0, 0.4).value[-1] == pytest.approx(0.4)  # shorter than its rise


def test_a_folded_time_repeats_the_movement_and_counts():
    times, local = folded(T, 1.0, 2.5)
    assert times * 2.5 + local == pytest.approx(T)
    assert set(times) == {0, 1, 2}
    assert local.max() < 3.5


def _means(x):
    return 0.5 * (x[1:] + x[:-1]) * (T[1] - T[0])
