"""The compiled loop of every linear Kalman height filter.

It knows no model: matrices come as tables, one entry for each distinct interval, built by the filter's
own named functions, with an index for each row.  Row k is

    x = F x + B u,  P = F P F' + Q + sigma_a^2 B B'             (not on the first row: index -1)
    P_bb += turned                                              (where the accelerometer has turned)
    P_hh += jump^2,  P_vv += (jump / 3 s)^2                     (where the height may have jumped)
    update with v = 0, variance `rest_variance`                 (where at rest)
    update with h = level                                       (where a level is known)
    update with z = H x + noise of variance R                   (where z is not NaN)

in the order and the form (Joseph) of filterpy's own `predict` and `update`.  Nothing is allocated on the way,
and zeros of F are passed over.  `smoother` goes back over the same rows, `bank` weighs several filters.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Signal = NDArray[np.float64]
Index = NDArray[np.int64]
JUMP_TIME: Final = 3.0
"""A height that has jumped by 1 m may be moving at 1 m in so many seconds (chosen by us)."""


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
    dt: Signal
    """Time since the row before, s, (n,)."""
    u: Signal
    """Acceleration that drives the step to row k, m/s², (n,)."""
    acceleration_variance: Signal
    """Its variance, (n,)."""
    at_rest: NDArray[np.bool_]
    """Whether the velocity is known to be 0, (n,)."""
    rest: Signal
    """The measurement matrix of the velocity, (m,)."""
    rest_variance: Signal
    """Variance of 'v = 0', (n,)."""
    level: Signal
    """Known height, m, (n,); NaN: none."""
    level_variance: Signal
    """Its variance, (n,)."""
    jump: Signal
    """By how much the height may have jumped since the row before, m, (n,); 0: not at all."""
    turned: Signal
    """Variance that the bias, state 2, has gained since then by turning, (m/s²)², (n,)."""


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
            work[i, j] = 0.0
        for k in range(m):
            if F[i, k] != 0.0:
                for j in range(m):
                    work[i, j] += F[i, k] * P[k, j]
    for i in range(m):
        for j in range(i, m):
            total = 0.0
            for k in range(m):
                if F[j, k] != 0.0:
                    total += work[i, k] * F[j, k]
            P[i, j] = P[j, i] = total


@njit(cache=True)
def innovate(x: Signal, P: Signal, h: Signal, r: float, z: float, gain: Signal) -> tuple[float, float]:
    """Return innovation and its variance of a scalar measurement; `gain` becomes P h."""
    m = len(x)
    y, s = z, r
    for i in range(m):
        gain[i] = 0.0
    for j in range(m):
        if h[j] != 0.0:
            y -= h[j] * x[j]
            for i in range(m):
                gain[i] += P[i, j] * h[j]
    for i in range(m):
        s += h[i] * gain[i]
    return y, s


@njit(cache=True)
def absorb(x: Signal, P: Signal, h: Signal, r: float, y: float, s: float, gain: Signal, work: Signal) -> None:
    """Update in place after `innovate`, Joseph form; `gain` becomes the Kalman gain.

    What is known exactly (s = 0: a second sample of the same noise) tells nothing new.
    """
    m = len(x)
    if s <= 0.0:
        gain[:] = 0.0
        return
    for j in range(m):  # (I - k h') P, then ... (I - k h')' + k r k'
        work[0, j] = gain[j]
    for i in range(m):
        gain[i] /= s
        x[i] += gain[i] * y
        for j in range(m):
            P[i, j] -= gain[i] * work[0, j]
    for i in range(m):
        total = -r * gain[i]
        for j in range(m):
            if h[j] != 0.0:
                total += P[i, j] * h[j]
        work[1, i] = total
    for i in range(m):
        for j in range(i, m):
            P[i, j] = P[j, i] = P[i, j] - work[1, i] * gain[j]


@njit(cache=True)
def update(
    x: Signal, P: Signal, h: Signal, r: float, z: float, gain: Signal, work: Signal
) -> tuple[float, float]:
    """Update in place with a scalar measurement; return the innovation and its variance."""
    y, s = innovate(x, P, h, r, z, gain)
    absorb(x, P, h, r, y, s, gain, work)
    return y, s


@njit(cache=True)
def advance(k: int, rows: Rows, jump: float, x: Signal, P: Signal, work: Signal) -> None:
    """Go from row k - 1 to row k; the height may have jumped by `jump` m on the way."""
    i = rows.transition[k]
    if i >= 0:
        predict(x, P, rows.F[i], rows.B[i], rows.Q[i], rows.u[k], rows.acceleration_variance[k], work)
    if rows.turned[k] > 0.0:
        P[2, 2] += rows.turned[k]
    if jump > 0.0:
        P[0, 0] += jump * jump
        P[1, 1] += (jump / JUMP_TIME) ** 2


@njit(cache=True)
def settle(k: int, rows: Rows, x: Signal, P: Signal, gain: Signal, work: Signal) -> tuple[float, float]:
    """Take the level of row k; return innovation and variance, (0, 1) without one."""
    if math.isnan(rows.level[k]):
        return 0.0, 1.0
    work[2, :] = 0.0
    work[2, 0] = 1.0
    return update(x, P, work[2], rows.level_variance[k], rows.level[k], gain, work)


@njit(cache=True)
def filter_rows(rows: Rows, x: Signal, P: Signal, out: Signal) -> None:
    """Filter in place from x (m,), P (m, m); out (4, n) gets height, velocity and their sds."""
    gain, work = np.empty(len(x)), np.empty((max(len(x), 3), len(x)))
    for k in range(len(rows.z)):
        row(k, rows, x, P, gain, work)
        report(k, x, P, out)


@njit(cache=True)
def row(k: int, rows: Rows, x: Signal, P: Signal, gain: Signal, work: Signal) -> None:
    """Take row k."""
    advance(k, rows, rows.jump[k], x, P, work)
    if rows.at_rest[k]:
        update(x, P, rows.rest, rows.rest_variance[k], 0.0, gain, work)
    settle(k, rows, x, P, gain, work)
    if not math.isnan(rows.z[k]):
        i = rows.measurement[k]
        update(x, P, rows.H[i], rows.R[i], rows.z[k], gain, work)


@njit(cache=True)
def report(k: int, x: Signal, P: Signal, out: Signal) -> None:
    """Write height, velocity and their sds into column k."""
    out[0, k], out[1, k] = x[0], x[1]
    out[2, k], out[3, k] = math.sqrt(max(P[0, 0], 0.0)), math.sqrt(max(P[1, 1], 0.0))
