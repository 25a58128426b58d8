"""What a linear height filter does to its state in a row, with its own gains and matrices.

    x_k = L x_{k-1} + g_- z_{k-1} + g z_k + b u_k

The complementary filter takes the altitude of the row before (g = 0), a Kalman filter this row's (g_- = 0).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from filterpy.kalman import KalmanFilter
from numpy.typing import NDArray

from baroarma.estimators.base import Alignment
from baroarma.estimators.height.complementary import LONGEST_WEIGHT, Complementary
from baroarma.estimators.height.linear import LinearHeight, motion_transition

Signal = NDArray[np.float64]


class Row(NamedTuple):
    """What a height filter with m states does to them in a row."""

    L: Signal
    """Its transition, the update included, (m, m)."""
    before: Signal
    """Gain g_- of the altitude of the row before, (m,)."""
    now: Signal
    """Gain g of this row's altitude, (m,)."""
    b: Signal
    """What an acceleration does, (m,)."""


def filter_rows(
    height: Complementary | LinearHeight,
    dt: float,
    new: NDArray[np.bool_],
    alignment: Alignment | None = None,
) -> Iterator[Row]:
    """Yield what a height filter does to its state at each row, from a reset on; the first takes no time.

    Parameters
    ----------
    height : Complementary or LinearHeight
        The filter; it is reset.
    dt : float
        Interval of the rows, s.
    new : ndarray, shape (n,)
        Whether there is an altitude.
    alignment : Alignment, optional
        What it is reset to.
    """
    height.reset(alignment)
    if isinstance(height, Complementary):
        return _constant_gains(height, dt, new)
    return _kalman_gains(height, dt, new)


def _constant_gains(height: Complementary, dt: float, new: NDArray[np.bool_]) -> Iterator[Row]:
    """SG14 Eq. 24, a sample weighing as long as `Complementary.slow_barometer` says."""
    K, longest, hold = height.gain, LONGEST_WEIGHT * height.time_constant, height.slow_barometer == "hold"
    F, b, none = motion_transition(dt), np.array([dt**2 / 2, dt]), np.zeros(2)
    known: dict[float, Row] = {}
    yield Row(np.eye(2), none, none, none)
    elapsed, seen = 0.0, False
    for fresh in new[:-1].tolist():
        elapsed, seen = elapsed + dt, seen or fresh
        weight = min((dt if seen else 0.0) if hold else (elapsed if fresh else 0.0), longest)
        elapsed = 0.0 if fresh else elapsed
        if weight not in known:
            g = weight * np.array([K[0] + weight / 2 * K[1], K[1]])
            known[weight] = Row(F - np.outer(g, [1, 0]), g, none, b)
        yield known[weight]


def _kalman_gains(height: LinearHeight, dt: float, new: NDArray[np.bool_]) -> Iterator[Row]:
    """Filterpy's own predict and update on the filter's own matrices; x = (I - K H)(F x + B u) + K z."""
    F, B, Q = height.transition(dt), height.input_matrix(dt), height.process_noise(dt)
    one, none = np.eye(height.dim_x), np.zeros(height.dim_x)
    for k, fresh in enumerate(new.tolist()):
        A, b = (F, B[:, 0]) if k else (one, none)
        if k:
            KalmanFilter.predict(height, F=F, Q=Q)
        if fresh:
            KalmanFilter.update(height, 0.0)
            kept = one - height.K @ height.H
            yield Row(kept @ A, none, height.K[:, 0], kept @ b)
        else:
            yield Row(A, none, none, b)
