"""Rotation: the vertical from a quaternion, the angle between two verticals."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baroarma.rotation import angle_between, skew, up_from_quaternion


def test_up_is_the_world_z_axis_seen_from_the_body_as_in_scipy():
    rotations = Rotation.random(100, rng=1)
    expected = rotations.inv().apply([0.0, 0.0, 1.0])
    ups = up_from_quaternion(rotations.as_quat())
    np.testing.assert_allclose(ups, expected, atol=1e-14)  # rounding
    np.testing.assert_array_equal(up_from_quaternion(rotations.as_quat()[7]), ups[7])


def test_a_missing_quaternion_has_no_vertical():
    ups = up_from_quaternion([[0.0, 0.0, 0.0, 1.0], [np.nan] * 4])
    np.testing.assert_array_equal(ups, [[0.0, 0.0, 1.0], [np.nan] * 3])


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 0.3, np.pi / 2, np.pi - 1e-6, np.pi])
def test_the_angle_of_a_turn_about_a_horizontal_axis_is_the_turn(angle):
    turned = Rotation.from_rotvec([0.6 * angle, 0.8 * angle, 0.0]).apply([0.0, 0.0, 9.8])
    np.testing.assert_allclose(angle_between([0.0, 0.0, 2.0], turned), angle, rtol=1e-14, atol=1e-15)


def test_angles_are_taken_row_by_row_or_against_one_vector():
    rows = np.eye(3)
    np.testing.assert_allclose(angle_between(rows, rows[0]), [0.0, np.pi / 2, np.pi / 2])
    np.testing.assert_allclose(angle_between(rows, np.roll(rows, 1, axis=0)), np.pi / 2)


def test_the_skew_matrix_is_the_cross_product():
    v, w = np.random.default_rng(1).normal(size=(2, 3))
    np.testing.assert_allclose(skew(v) @ w, np.cross(v, w), atol=1e-15)


def test_whole_numbers_are_as_good_as_others():
    # a sensor's raw counts are int16: their products would not fit
    ups = np.array([[20_000, 0, 20_000], [0, 30_000, 0]], dtype=np.int16)
    np.testing.assert_allclose(angle_between(ups, ups[1]), [np.pi / 2, 0.0])
    np.testing.assert_allclose(angle_between(ups[1], ups), [np.pi / 2, 0.0])
    np.testing.assert_array_equal(
        up_from_quaternion(np.array([1, 0, 0, 0], dtype=np.uint8)), [0.0, 0.0, -1.0]
    )
    assert skew(np.array([1, 2, 3], dtype=np.uint8)).tolist() == [[0, -3, 2], [3, 0, -1], [-2, 1, 0]]
