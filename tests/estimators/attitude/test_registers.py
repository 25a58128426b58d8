"""Tuples as vectors and symmetric matrices, against NumPy; series against functions."""

import numpy as np
import pytest

from baroarma.estimators.attitude import registers
from baroarma.estimators.attitude.registers import sine, versine

RNG = np.random.default_rng(7)


@pytest.mark.parametrize("n", [3, 4])
def test_symmetric_matrices_in_registers_are_numpys(n):
    root, (v, w) = RNG.normal(size=(n, n)), RNG.normal(size=(2, n))
    P, upper = root @ root.T, np.triu_indices(n)
    dot, plus, scaled, times, plus_outer = (
        getattr(registers, f"{name}{n}") for name in ("dot", "plus", "scaled", "times", "plus_outer")
    )
    exact = {"rtol": 0.0, "atol": 1e-14}  # rounding of numbers of order 1
    np.testing.assert_allclose(dot(tuple(v), tuple(w)), v @ w, **exact)
    np.testing.assert_allclose(plus(tuple(v), 0.3, tuple(w)), v + 0.3 * w, **exact)
    np.testing.assert_allclose(scaled(0.3, tuple(v)), 0.3 * v, **exact)
    np.testing.assert_allclose(times(tuple(P[upper]), tuple(v)), P @ v, **exact)
    outer = plus_outer(tuple(P[upper]), 0.3, tuple(v))
    np.testing.assert_allclose(outer, (P + 0.3 * np.outer(v, v))[upper], **exact)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.1, 0.4999999, 0.5, 0.5000001, 2.0, 7.0])
def test_series_and_functions_of_an_angle_agree(angle):
    assert sine(angle**2) == pytest.approx(np.sinc(angle / np.pi), abs=1e-15)
    half = np.sinc(angle / 2 / np.pi)
    assert versine(angle**2) == pytest.approx(half**2 / 2, abs=1e-15)
