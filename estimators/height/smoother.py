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
from numpy.typing import NDArray

from baroarma.compiled import njit
from baroarma.estimators.height.kernels import (
    HEIGHT,
    VELOCITY,
    Rows,
    absorb,
    innovate,
    loosen,
    pin,
    predict,
)

Signal = NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def smooth_rows(rows: Rows, lag: float, size: tuple[int, ...], x: Signal, P: Signal, out: Signal) -> None:
    """Filter in place from x (1, m), P (1, m, m), then go back; out (4, n) as in `filter_rows`.

    With an infinite `lag` row k knows all rows, otherwise those up to `lag` s after it.
    """
    n, m = len(rows.z), len(size)
    assert x.shape[1] == m and P.shape[1] == m and P.shape[2] == m  # noqa: PT018 - compiled
    xs, Ps = np.empty((n + 1, m)), np.empty((n + 1, m, m))  # before the first row, then after each
    gains, told, work = np.empty((3, m)), np.empty((3, 2)), np.empty((m + 1, m))
    xs[0], Ps[0] = x[0], P[0]
    for k in range(n):
        _row(k, rows, x, P, gains, told, work, size)
        xs[k + 1], Ps[k + 1] = x[0], P[0]
    adjoint, spread, turn = np.zeros(m), np.zeros((m, m)), np.empty((m, m))
    last, ahead = n - 1, 0.0  # the last row that row k may know, and how far ahead it is
    for k in range(n - 1, -1, -1):
        if lag < math.inf:
            while last > k and ahead > lag:
                ahead -= rows.dt[last]
                last -= 1
            adjoint[:], spread[:] = 0.0, 0.0
            for j in range(last, k, -1):
                x[0], P[0] = xs[j], Ps[j]
                _back(j, rows, x, P, gains, told, work, adjoint, spread, turn, size)
        for i in range(2):
            mean, variance = _smoothed(i, xs[k + 1], Ps[k + 1], adjoint, spread)
            out[i, k], out[2 + i, k] = mean, math.sqrt(max(variance, 0.0))
        if lag == math.inf:
            x[0], P[0] = xs[k], Ps[k]
            _back(k, rows, x, P, gains, told, work, adjoint, spread, turn, size)
        ahead += rows.dt[k]
    x[0], P[0] = xs[n], Ps[n]


@njit(cache=True, error_model="numpy")
def _row(
    k: int,
    rows: Rows,
    x: Signal,
    P: Signal,
    gains: Signal,
    told: Signal,
    work: Signal,
    size: tuple[int, ...],
) -> None:
    """Take row k as `filter_rows` does; keep gain, innovation and its variance of each measurement."""
    t, j = rows.transition[k], rows.measurement[k]
    if t >= 0:
        u, variance = rows.u[k], rows.acceleration_variance[k]
        predict(0, x, P, rows.F, rows.B, rows.Q, t, rows.ends, rows.columns, u, variance, work, size)
    loosen(0, P, rows.turned[k], rows.jump[k], rows.startled[k], rows.offset)
    if rows.at_rest[k]:
        told[0] = pin(0, x, P, VELOCITY, 0.0, rows.rest_variance[k], gains[0], work, size)
    if not math.isnan(rows.level[k]):
        told[1] = pin(0, x, P, HEIGHT, rows.level[k], rows.level_variance[k], gains[1], work, size)
    if not math.isnan(rows.z[k]):
        y, s = innovate(0, x, P, rows.H, j, rows.R[j], rows.z[k], gains[2], size)
        absorb(0, x, P, rows.H, j, rows.R[j], y, s, gains[2], work, size)
        told[2] = y, s


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
    told: Signal,
    work: Signal,
    adjoint: Signal,
    spread: Signal,
    turn: Signal,
    size: tuple[int, ...],
) -> None:
    """Take the adjoint from after row k to before it; x and P are the filter's before row k."""
    _row(k, rows, x, P, gains, told, work, size)
    if not math.isnan(rows.z[k]):
        _absorb(adjoint, spread, rows.H[rows.measurement[k]], gains[2], told[2], turn, work)
    unit = np.zeros(len(adjoint))
    if not math.isnan(rows.level[k]):
        unit[HEIGHT] = 1.0
        _absorb(adjoint, spread, unit, gains[1], told[1], turn, work)
        unit[HEIGHT] = 0.0
    if rows.at_rest[k]:
        unit[VELOCITY] = 1.0
        _absorb(adjoint, spread, unit, gains[0], told[0], turn, work)
    if rows.transition[k] >= 0:
        turn[:] = rows.F[rows.transition[k]].T
        _turn(adjoint, spread, turn, work)


@njit(cache=True)
def _absorb(
    adjoint: Signal, spread: Signal, h: Signal, gain: Signal, told: Signal, turn: Signal, work: Signal
) -> None:
    """Go back over a measurement h of gain K; `told` is its innovation and its variance."""
    m, y, s = len(h), told[0], told[1]
    if s <= 0.0:  # known exactly before: the filter took nothing from it
        return
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
    """Let l = T l and L = T L T' in place."""
    m = len(adjoint)
    for i in range(m):
        work[m, i] = 0.0
        for j in range(m):
            work[m, i] += turn[i, j] * adjoint[j]
            work[i, j] = 0.0
        for k in range(m):
            for j in range(m):
                work[i, j] += turn[i, k] * spread[k, j]
    for i in range(m):
        adjoint[i] = work[m, i]
        for j in range(m):
            spread[i, j] = 0.0
            for k in range(m):
                spread[i, j] += work[i, k] * turn[j, k]
