"""Rotations: the little that SciPy's `Rotation` does not give directly.

Quaternions are scalar last and turn body into world, as in SciPy; world z is up and the heading is arbitrary.
What matters for height is the tilt alone: `up`, the world's z axis seen from the body, which is the third row
of the rotation matrix,

    up = (2(q1 q3 - q2 q4), 2(q2 q3 + q1 q4), 1 - 2(q1^2 + q2^2)).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def skew(v: ArrayLike) -> NDArray[np.float64]:
    """Return the matrix [v x] with [v x] w = v x w [SG14, Eq. 4].

    Parameters
    ----------
    v : array_like, shape (3,)
        Any vector.

    Returns
    -------
    ndarray, shape (3, 3)
        The skew-symmetric matrix, in the unit of `v`.

    Examples
    --------
    >>> skew([1.0, 2.0, 3.0]) @ [0.0, 0.0, 1.0]
    array([ 2., -1.,  0.])
    """
    x, y, z = np.asarray(v, float)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def up_from_quaternion(q: ArrayLike) -> NDArray[np.float64]:
    """Return the world's z axis in body axes.

    Parameters
    ----------
    q : array_like, shape (4,) or (n, 4)
        Unit quaternions body to world; NaN stays NaN.

    Returns
    -------
    ndarray, shape (3,) or (n, 3)
        Unit vectors that point up.

    Examples
    --------
    A half turn about x puts the body upside down:

    >>> up_from_quaternion([1.0, 0.0, 0.0, 0.0])
    array([ 0.,  0., -1.])
    """
    x, y, z, w = np.moveaxis(np.asarray(q, float), -1, 0)
    return np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=-1)


def angle_between(a: ArrayLike, b: ArrayLike) -> NDArray[np.float64]:
    """Return the angle between two vectors: the tilt error, if both are verticals.

    Unlike the arc cosine of the dot product it is exact for small angles.

    Parameters
    ----------
    a, b : array_like, shape (3,) or (n, 3)
        Vectors of any length but 0; one may be single.

    Returns
    -------
    ndarray, shape () or (n,)
        Angle in rad, 0 to pi.

    Examples
    --------
    >>> float(angle_between([0.0, 0.0, 1.0], [1e-9, 0.0, 1.0]))
    1e-09
    """
    a, b = np.broadcast_arrays(np.asarray(a, float), np.asarray(b, float))
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(a * b, axis=-1)))
