"""What the tests of kernels share."""

import numpy as np
import pytest


@pytest.fixture
def covariance():
    """A function that draws a covariance, (n, n), of this scale."""
    rng = np.random.default_rng(7)

    def draw(n, scale=1.0):
        root = rng.normal(size=(n, n))
        return scale * root @ root.T / n

    return draw


@pytest.fixture
def fill():
    """A function that returns what a kernel writes into zeros of this shape."""

    def filled(function, shape, *args):
        out = np.zeros(shape)
        function(out, *args)
        return out

    return filled
