"""The vertical acceleration's sd, against tilted copies."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baroarma.estimators.attitude.vertical import vertical_acceleration


def test_the_sd_of_the_vertical_acceleration_is_that_of_tilted_copies():
    up, f, n = np.array([0.0, 0.6, 0.8]), np.array([2.0, 7.0, 9.0]), 200_000
    tilt = np.array([[3e-4, 1e-4, 0.0], [1e-4, 2e-4, 0.0], [0.0, 0.0, 0.0]])  # about world x and y
    rotations = Rotation.align_vectors([[0.0, 0.0, 1.0]], [up])[0]
    to_body = rotations.inv().as_matrix()
    a, sd = vertical_acceleration(f, up, to_body, tilt, 9.8, 0.05)
    rng = np.random.default_rng(3)
    errors = rng.multivariate_normal(np.zeros(3), tilt, n) @ to_body.T
    copies = up + errors
    copies /= np.linalg.norm(copies, axis=1, keepdims=True)
    samples = np.sum(copies * (f + 0.05 * rng.normal(size=(n, 3))), axis=1) - 9.8
    assert a == pytest.approx(up @ f - 9.8, abs=1e-14)
    # the sd of n samples is good to 1/sqrt(2n) = 0.16 %; what is of second order in 1° adds less than 0.1 %
    assert samples.std() == pytest.approx(sd, rel=4 * 0.0016 + 0.001)
