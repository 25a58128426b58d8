"""The compiled loop of every linear Kalman height filter.

It knows no model: matrices come as tables, one entry for each distinct interval, built by the filter's
own named functions, with an index for each row.  Row k is

    x = F x + B u,  P = F P F' + Q + sigma_a^2 B B'             (not on the first row: index -1)
    P_bb += turned                                              (where the accelerometer has turned)
    P_hh += jump^2,  P_vv += (jump / 3 s)^2                     (where the height may have jumped)
    P_vv += startled                                            (where a rest proved the velocity wrong)
    update with v = 0, variance `rest_variance`                 (where at rest)
    update with h = level                                       (where a level is known)
    update with z = H x + noise of variance R                   (where z is not NaN)

in the order and the form (Joseph) of filterpy's own `predict` and `update`.  Nothing is allocated on the way,
and zeros of F and H are passed over.  `smoother` goes back over the same rows, `bank` weighs several filters.

States and covariances come as stacks, x (filters, m) and P (filters, m, m), with the index i of the filter
meant; arrays are passed one by one and the functions inlined, since views and tuples of arrays would cost
more than the arithmetic.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Signal = NDArray[np.float64]
Index = NDArray[np.int64]
HEIGHT: Final = 0
VELOCITY: Final = 1
BIAS: Final = 2
"""Places in the state; the last only where `Rows.turned` is used."""
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
    ends: Index
    """Where each row of F ends in `columns`, with a 0 before, (m + 1,)."""
    columns: Index
    """Columns of the entries of F that are not 0, row after row."""
    transition: Index
    """Which transition leads to row k, (n,); -1 on the first row."""
    H: Signal
    """Measurement matrices, (tables, m)."""
    R: Signal
    """Measurement noise, (tables,)."""
    seen: Index
    """Columns of H that are not 0."""
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
    rest_variance: Signal
    """Variance of 'v = 0', (n,)."""
    level: Signal
    """Known height, m, (n,); NaN: none."""
    level_variance: Signal
    """Its variance, (n,)."""
    jump: Signal
    """By how much the height may have jumped since the row before, m, (n,); negative: the offset."""
    turned: Signal
    """Variance that the bias, state 2, has gained since then by turning, (m/s²)², (n,)."""
    startled: Signal
    """Variance of the velocity that proved wrong at row k, (m/s)², (n,); 0: none did."""
    offset: int
    """Place of the barometer's offset in the state."""


class Tables(NamedTuple):
    """The matrices of one interval, as tables of one entry; names and shapes as in `Rows`."""

    F: Signal
    B: Signal
    Q: Signal


class Row(NamedTuple):
    """One row in plain numbers, for `step`; names as in `Rows`."""

    z: float
    dt: float
    u: float
    acceleration_variance: float
    at_rest: bool
    rest_variance: float
    level: float
    level_variance: float
    turned: float
    offset: int


def entries(F: Signal) -> tuple[Index, Index]:
    """Return `ends` and `columns` of a stack of matrices (tables, m, m): where any of them is not 0.

    Examples
    --------
    >>> ends, columns = entries(np.array([[[1.0, 0.1], [0.0, 1.0]]]))
    >>> ends.tolist(), columns.tolist()
    ([0, 2, 3], [0, 1, 1])
    """
    used = (F != 0).any(axis=0)
    ends = np.concatenate([[0], np.cumsum(used.sum(axis=1))])
    return ends.astype(np.int64), np.nonzero(used)[1].astype(np.int64)


@njit(cache=True, error_model="numpy", inline="always")
def predict(
    i: int,
    x: Signal,
    P: Signal,
    F: Signal,
    B: Signal,
    Q: Signal,
    t: int,
    ends: Index,
    columns: Index,
    u: float,
    variance: float,
    work: Signal,
) -> None:
    """Predict by transition t: x = F x + B u, P = F P F' + Q + variance B B'; work (m + 1, m)."""
    m = x.shape[1]
    for a in range(m):
        total = B[t, a] * u
        for c in range(m):
            work[a, c] = 0.0
        for e in range(ends[a], ends[a + 1]):
            b = columns[e]
            total += F[t, a, b] * x[i, b]
            for c in range(m):
                work[a, c] += F[t, a, b] * P[i, b, c]
        work[m, a] = total
    for a in range(m):
        x[i, a] = work[m, a]
        for c in range(a, m):
            total = Q[t, a, c] + variance * B[t, a] * B[t, c]
            for e in range(ends[c], ends[c + 1]):
                total += work[a, columns[e]] * F[t, c, columns[e]]
            P[i, a, c] = total
            P[i, c, a] = total


@njit(cache=True, error_model="numpy", inline="always")
def innovate(
    i: int, x: Signal, P: Signal, H: Signal, j: int, r: float, seen: Index, z: float, gain: Signal
) -> tuple[float, float]:
    """Return innovation and its variance of z = H_j x + noise; `gain` becomes P H'."""
    m = x.shape[1]
    y, s = z, r
    for a in range(m):
        gain[a] = 0.0
    for e in range(len(seen)):
        c = seen[e]
        y -= H[j, c] * x[i, c]
        for a in range(m):
            gain[a] += P[i, c, a] * H[j, c]
    for e in range(len(seen)):
        s += H[j, seen[e]] * gain[seen[e]]
    return y, s


@njit(cache=True, error_model="numpy", inline="always")
def absorb(
    i: int,
    x: Signal,
    P: Signal,
    H: Signal,
    j: int,
    r: float,
    seen: Index,
    y: float,
    s: float,
    gain: Signal,
    work: Signal,
) -> None:
    """Update after `innovate`, P = (I - k h) P (I - k h)' + k r k'; `gain` becomes k.

    What is known exactly (s = 0: a second sample of the same noise) tells nothing new.
    """
    m = x.shape[1]
    if s <= 0.0:
        for a in range(m):
            gain[a] = 0.0
        return
    for a in range(m):
        work[0, a] = gain[a]
        gain[a] /= s
        x[i, a] += gain[a] * y
    for a in range(m):
        for b in range(m):
            P[i, a, b] -= gain[a] * work[0, b]
    for a in range(m):
        work[1, a] = -r * gain[a]
        for e in range(len(seen)):
            work[1, a] += P[i, a, seen[e]] * H[j, seen[e]]
    for a in range(m):
        for b in range(a, m):
            entry = P[i, a, b] - work[1, a] * gain[b]
            P[i, a, b] = entry
            P[i, b, a] = entry


@njit(cache=True, error_model="numpy", inline="always")
def pin(
    i: int, x: Signal, P: Signal, state: int, value: float, variance: float, gain: Signal, work: Signal
) -> tuple[float, float]:
    """Update with one state known to be `value`; return innovation and variance; `gain` becomes k."""
    m = x.shape[1]
    y, s = value - x[i, state], P[i, state, state] + variance
    if s <= 0.0:
        for a in range(m):
            gain[a] = 0.0
        return y, s
    for a in range(m):
        work[0, a] = P[i, state, a]
        gain[a] = work[0, a] / s
    for a in range(m):
        x[i, a] += gain[a] * y
        for b in range(m):
            P[i, a, b] -= gain[a] * work[0, b]
    for a in range(m):
        work[1, a] = P[i, a, state] - variance * gain[a]
    for a in range(m):
        for b in range(a, m):
            entry = P[i, a, b] - work[1, a] * gain[b]
            P[i, a, b] = entry
            P[i, b, a] = entry
    return y, s


@njit(cache=True, error_model="numpy", inline="always")
def loosen(i: int, P: Signal, turned: float, jump: float, startled: float, offset: int) -> None:
    """Let the bias have turned, height or offset have jumped, the velocity have been wrong."""
    if turned > 0.0:
        P[i, BIAS, BIAS] += turned
    if jump > 0.0:
        P[i, HEIGHT, HEIGHT] += jump * jump
        P[i, VELOCITY, VELOCITY] += (jump / JUMP_TIME) ** 2
    if jump < 0.0:
        P[i, offset, offset] += jump * jump
    P[i, VELOCITY, VELOCITY] += startled


@njit(cache=True, error_model="numpy", inline="always")
def report(k: int, i: int, x: Signal, P: Signal, out: Signal) -> None:
    """Write height, velocity and their sds into column k."""
    out[0, k], out[1, k] = x[i, HEIGHT], x[i, VELOCITY]
    out[2, k] = math.sqrt(max(P[i, HEIGHT, HEIGHT], 0.0))
    out[3, k] = math.sqrt(max(P[i, VELOCITY, VELOCITY], 0.0))


@njit(cache=True, error_model="numpy")
def filter_rows(rows: Rows, x: Signal, P: Signal, out: Signal) -> None:
    """Filter in place from x (1, m), P (1, m, m); out (4, n) gets height, velocity and their sds."""
    m = x.shape[1]
    gain, work = np.empty(m), np.empty((m + 1, m))
    F, B, Q, ends, columns, transition, H, R, seen, measurement, z = rows[:11]
    _, u, variance, at_rest, rest_variance, level, level_variance, jump, turned, startled, offset = rows[11:]
    for k in range(len(z)):
        if transition[k] >= 0:
            predict(0, x, P, F, B, Q, transition[k], ends, columns, u[k], variance[k], work)
        loosen(0, P, turned[k], jump[k], startled[k], offset)
        if at_rest[k]:
            pin(0, x, P, VELOCITY, 0.0, rest_variance[k], gain, work)
        if not math.isnan(level[k]):
            pin(0, x, P, HEIGHT, level[k], level_variance[k], gain, work)
        if not math.isnan(z[k]):
            j = measurement[k]
            y, s = innovate(0, x, P, H, j, R[j], seen, z[k], gain)
            absorb(0, x, P, H, j, R[j], seen, y, s, gain, work)
        report(k, 0, x, P, out)


@njit(cache=True, error_model="numpy", inline="always")
def one_row(tables: Tables, H: Signal, r: float, first: bool, row: Row) -> Rows:
    """Return `Rows` of a single row, given its tables and H (1, m), R."""
    F, B, Q = tables
    m = F.shape[1]
    places, used = np.zeros(m * m + 2 * m + 3, np.int64), 0
    where, ends, seen, columns = places[:2], places[2 : m + 3], places[m + 3 : 2 * m + 3], places[2 * m + 3 :]
    for a in range(m):
        ends[a + 1] = ends[a]
        for b in range(m):
            if F[0, a, b] != 0.0:
                columns[ends[a + 1]] = b
                ends[a + 1] += 1
        if H[0, a] != 0.0:
            seen[used] = a
            used += 1
    cells, at_rest = np.zeros(11), np.full(1, row.at_rest)
    where[0] = -1 if first else 0
    cells[0], cells[1], cells[2], cells[3] = row.z, row.dt, row.u, row.acceleration_variance
    cells[4], cells[5], cells[6], cells[7] = row.rest_variance, row.level, row.level_variance, row.turned
    cells[8] = r
    # fmt: off
    return Rows(F, B, Q, ends, columns, where[:1], H, cells[8:9], seen[:used], where[1:], cells[:1],
                cells[1:2], cells[2:3], cells[3:4], at_rest, cells[4:5], cells[5:6], cells[6:7],
                cells[9:10], cells[7:8], cells[10:], row.offset)
    # fmt: on


@njit(cache=True, error_model="numpy")
def filter_row(
    F: Signal,
    B: Signal,
    Q: Signal,
    H: Signal,
    r: float,
    first: bool,
    z: float,
    dt: float,
    u: float,
    variance: float,
    at_rest: bool,
    rest_variance: float,
    level: float,
    level_variance: float,
    turned: float,
    offset: int,
    x: Signal,
    P: Signal,
) -> tuple[float, float, float, float]:
    """Filter one row in place from x (m,), P (m, m); return height, velocity and their sds.

    The matrices and the `Row` come one by one, since Python passes named tuples slowly.
    """
    m, out = len(x), np.empty((4, 1))
    row = Row(z, dt, u, variance, at_rest, rest_variance, level, level_variance, turned, offset)
    filter_rows(one_row(Tables(F, B, Q), H, r, first, row), x.reshape((1, m)), P.reshape((1, m, m)), out)
    return out[0, 0], out[1, 0], out[2, 0], out[3, 0]
