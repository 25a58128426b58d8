"""Jets carry the derivatives that calculus gives."""

import numpy as np
import pytest

from baroarma.simulation.jet import clock, cos, sin


def test_derivatives_are_those_of_the_written_out_function():
    t = np.linspace(-2, 3, 40)
    f = 1.0 - sin(0.5 * clock(t) * clock(t)) * cos(3.0 * clock(t)) + np.float64(2.0) * clock(t)
    p, q = t**2 / 2, 3 * t
    assert f.value == pytest.approx(1 - np.sin(p) * np.cos(q) + 2 * t)
    assert f.first == pytest.approx(-t * np.cos(p) * np.cos(q) + 3 * np.sin(p) * np.sin(q) + 2)
    second = (t**2 + 9) * np.sin(p) * np.cos(q) - np.cos(p) * np.cos(q) + 6 * t * np.cos(p) * np.sin(q)
    assert f.second == pytest.approx(second)
