"""Back over the rows of a linear Kalman height filter: the modified Bryson-Frazier smoother, compiled.

Fixed-interval: one way back, over all rows.  Fixed-lag: for every row the way back from `lag` s later, which
costs as many steps as there are rows in the lag.

With the adjoint l and its covariance L, both zero at the end, the estimate after row k given *all* rows is

    x_s = x - P l,   P_s = P - P L P.

Going back over a measurement, L = C' L C + h h'/S and l = C' l - h y/S with C = I - K h'; over a step,
L = F' L F and l = F' l [Bierman 1973].  Unlike Rauch, Tung and Striebel's it inverts no covariance, so that
states that are known exactly or repeat another one do no harm.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from baroarma.estimators.height.kernels import Rows, advance, row, sandwich, settle, update

Signal = NDArray[np.float64]


@njit(cache=True)
def smooth_rows(rows: Rows, lag: float, x: Signal, P: Signal, out: Signal) -> None:
    """Filter in place, then go back; out (4, n) gets height, velocity and their sds, given later rows, too.

    With an infinite `lag` row k knows all rows, otherwise those up to `lag` s after it.
    """
    n, m = len(rows.z), len(x)
    xs, Ps = np.empty((n + 1, m)), np.empty((n + 1, m, m))  # before the first row, then after each
    gains, work = np.empty((3, m)), np.empty((m + 1, m))
    xs[0], Ps[0] = x, P
    for k in range(n):
        row(k, rows, x, P, gains[0], work)
        xs[k + 1], Ps[k + 1] = x, P
    adjoint, spread, turn = np.zeros(m), np.zeros((m, m)), np.empty((m, m))
    last, ahead = n - 1, 0.0  # the last row that row k may know, and how far ahead it is
    for k in range(n - 1, -1, -1):
        if lag < math.inf:
            while last > k and ahead > lag:
                ahead -= rows.dt[last]
                last -= 1
            adjoint[:], spread[:] = 0.0, 0.0
            for j in range(last, k, -1):
                x[:], P[:] = xs[j], Ps[j]
                _back(j, rows, x, P, gains, work, adjoint, spread, turn)
        for i in range(2):
            mean, variance = _smoothed(i, xs[k + 1], Ps[k + 1], adjoint, spread)
            out[i, k], out[2 + i, k] = mean, math.sqrt(max(variance, 0.0))
        if lag == math.inf:
            x[:], P[:] = xs[k], Ps[k]
            _back(k, rows, x, P, gains, work, adjoint, spread, turn)
        ahead += rows.dt[k]
    x[:], P[:] = xs[n], Ps[n]


@njit(cache=True)
def _smoothed(i: int, x: Signal, P: Signal, adjoint: Signal, spread: Signal) -> tuple[float, float]:
    """Mean and variance of state i."""
    mean, variance = x[i], P[i, i]
    for a in range(len(x)):
        mean -= P[i, a] * adjoint[a]
        for b in range(len(x)):
            variance -= P[i, a] * spread[a, b] * P[b, i]
    return mean, variance


@njit(cache=True)
def _back(
    k: int,
    rows: Rows,
    x: Signal,
    P: Signal,
    gains: Signal,
    work: Signal,
    adjoint: Signal,
    spread: Signal,
    turn: Signal,
) -> None:
    """Take the adjoint from after row k to before it; x and P are the filter's before row k."""
    advance(k, rows, rows.jump[k], x, P, work)
    y_rest, s_rest = 0.0, 1.0
    if rows.at_rest[k]:
        y_rest, s_rest = update(x, P, rows.rest, rows.rest_variance[k], 0.0, gains[0], work)
    y_level, s_level = settle(k, rows, x, P, gains[1], work)
    if not math.isnan(rows.z[k]):
        i = rows.measurement[k]
        y, s = update(x, P, rows.H[i], rows.R[i], rows.z[k], gains[2], work)
        _absorb(adjoint, spread, rows.H[i], gains[2], y, s, turn, work)
    if not math.isnan(rows.level[k]):
        height = np.zeros(len(x))
        height[0] = 1.0
        _absorb(adjoint, spread, height, gains[1], y_level, s_level, turn, work)
    if rows.at_rest[k]:
        _absorb(adjoint, spread, rows.rest, gains[0], y_rest, s_rest, turn, work)
    step = rows.transition[k]
    if step >= 0:
        turn[:] = rows.F[step].T
        _turn(adjoint, spread, turn, work)


@njit(cache=True)
def _absorb(
    adjoint: Signal,
    spread: Signal,
    h: Signal,
    gain: Signal,
    y: float,
    s: float,
    turn: Signal,
    work: Signal,
) -> None:
    if s <= 0.0:  # known exactly before: the filter took nothing from it
        return
    m = len(h)
    for i in range(m):
        for j in range(m):
            turn[i, j] = (1.0 if i == j else 0.0) - h[i] * gain[j]  # C' = I - h K'
    _turn(adjoint, spread, turn, work)
    for i in range(m):
        adjoint[i] -= h[i] * y / s
        for j in range(m):
            spread[i, j] += h[i] * h[j] / s


@njit(cache=True)
def _turn(adjoint: Signal, spread: Signal, turn: Signal, work: Signal) -> None:
    m = len(adjoint)
    for i in range(m):
        work[i, 0] = 0.0
        for j in range(m):
            work[i, 0] += turn[i, j] * adjoint[j]
    for i in range(m):
        adjoint[i] = work[i, 0]
    sandwich(turn, spread, work)
