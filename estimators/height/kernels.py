"""The compiled loop of every linear Kalman height filter.

It knows no model: matrices come as tables, one entry for each distinct interval, built by the filter's
own named functions, with an index for each row.  Row k is

    x = F x + B u,  P = F P F' + Q + sigma_a^2 B B'             (not on the first row: index -1)
    update with v = 0, variance `rest_variance`                 (where at rest)
    update with z = H x + noise of variance R                   (where z is not NaN)

in the order and the form (Joseph) of filterpy's own `predict` and `update`.  Nothing is allocated on the way.
`smoother` goes back over the same rows.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Signal = NDArray[np.float64]
Index = NDArray[np.int64]


class Rows(NamedTuple):
    """What the loop reads: tables of matrices, and n rows that point into them."""

    F: Signal
    """Transitions, (tables, m, m)."""
    B: Signal
    """Input matrices, (tables, m)."""
    Q: Signal
    """Process noise without the acceleration's, (tables, m, m)."""
    transition: Index
    """Which of these leads to row k, (n,); -1 on the first row."""
    H: Signal
    """Measurement matrices, (tables, m)."""
    R: Signal
    """Measurement noise, (tables,)."""
    measurement: Index
    """Which of these belongs to row k, (n,)."""
    z: Signal
    """Measurements, (n,); NaN: none."""
    u: Signal
    """Acceleration that drives the step to row k, m/s², (n,)."""
    acceleration_variance: Signal
    """Its variance, (n,)."""
    at_rest: NDArray[np.bool_]
    """Whether the velocity is known to be 0, (n,)."""
    rest: Signal
    """The measurement matrix of the velocity, (m,)."""
    rest_variance: float
    """Variance of 'v = 0'."""


@njit(cache=True)
def predict(
    x: Signal, P: Signal, F: Signal, B: Signal, Q: Signal, u: float, variance: float, work: Signal
) -> None:
    """Predict in place: x = F x + B u, P = F P F' + Q + variance B B'."""
    m = len(x)
    for i in range(m):
        work[i, 0] = B[i] * u
        for j in range(m):
            work[i, 0] += F[i, j] * x[j]
    for i in range(m):
        x[i] = work[i, 0]
    sandwich(F, P, work)
    for i in range(m):
        for j in range(m):
            P[i, j] += Q[i, j] + variance * B[i] * B[j]


@njit(cache=True)
def sandwich(F: Signal, P: Signal, work: Signal) -> None:
    """Replace P by F P F' in place."""
    m = len(P)
    for i in range(m):
        for j in range(m):
            total = 0.0
            for k in range(m):
                total += F[i, k] * P[k, j]
            work[i, j] = total
    for i in range(m):
        for j in range(m):
            total = 0.0
            for k in range(m):
                total += work[i, k] * F[j, k]
            P[i, j] = total


@njit(cache=True)
def update(
    x: Signal, P: Signal, h: Signal, r: float, z: float, gain: Signal, work: Signal
) -> tuple[float, float]:
    """Update in place with a scalar measurement, Joseph form; return the innovation and its variance."""
    m = len(x)
    y, s = z, r
    for i in range(m):
        gain[i] = 0.0
        for j in range(m):
            gain[i] += P[i, j] * h[j]
    for i in range(m):
        y -= h[i] * x[i]
        s += h[i] * gain[i]
    for i in range(m):
        gain[i] /= s
        x[i] += gain[i] * y
    for i in range(m):
        for j in range(m):
            work[i, j] = (1.0 if i == j else 0.0) - gain[i] * h[j]
    _joseph(P, work, gain, r)
    return y, s


@njit(cache=True)
def _joseph(P: Signal, left: Signal, gain: Signal, r: float) -> None:
    """P = left P left' + r gain gain' in place; left (m + 1, m) is I - gain h' and a row to work in."""
    m = len(P)
    for j in range(m):  # columns: left @ P
        for i in range(m):
            left[m, i] = P[i, j]
        for i in range(m):
            total = 0.0
            for k in range(m):
                total += left[i, k] * left[m, k]
            P[i, j] = total
    for i in range(m):  # rows: ... @ left'
        for k in range(m):
            left[m, k] = P[i, k]
        for j in range(m):
            total = r * gain[i] * gain[j]
            for k in range(m):
                total += left[m, k] * left[j, k]
            P[i, j] = total


@njit(cache=True)
def row(k: int, rows: Rows, x: Signal, P: Signal, gain: Signal, work: Signal) -> None:
    """Take row k."""
    i = rows.transition[k]
    if i >= 0:
        predict(x, P, rows.F[i], rows.B[i], rows.Q[i], rows.u[k], rows.acceleration_variance[k], work)
    if rows.at_rest[k]:
        update(x, P, rows.rest, rows.rest_variance, 0.0, gain, work)
    if not math.isnan(rows.z[k]):
        i = rows.measurement[k]
        update(x, P, rows.H[i], rows.R[i], rows.z[k], gain, work)


@njit(cache=True)
def filter_rows(rows: Rows, x: Signal, P: Signal, out: Signal) -> None:
    """Filter in place from x (m,), P (m, m); out (4, n) gets height, velocity and their sds."""
    gain, work = np.empty(len(x)), np.empty((len(x) + 1, len(x)))
    for k in range(len(rows.z)):
        row(k, rows, x, P, gain, work)
        out[0, k], out[1, k] = x[0], x[1]
        out[2, k], out[3, k] = math.sqrt(P[0, 0]), math.sqrt(P[1, 1])
