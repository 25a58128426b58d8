"""Signals that nobody can change: what the results hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def read_only(value: ArrayLike) -> NDArray[np.float64]:
    """Return numbers as an array that can't be written.

    Parameters
    ----------
    value : array_like
        An array that nobody can write any more, nor what it is a view of, is returned as it is; of anything
        else a copy is made.

    Examples
    --------
    >>> mine = np.zeros(3)
    >>> fixed = read_only(mine)
    >>> mine[0] = 1.0
    >>> fixed, read_only(fixed[1:]).base is fixed
    (array([0., 0., 0.]), True)
    """
    array = np.asarray(value, dtype=float)
    if not _is_fixed(array):
        array = np.array(array)
        array.flags.writeable = False
    return array


def _is_fixed(array: object) -> bool:
    """Return whether neither the array nor what it is a view of can be written."""
    while isinstance(array, np.ndarray) and not array.flags.writeable:
        array = array.base
    return array is None
