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
from numpy.typing import NDArray

from baroarma.compiled import njit

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
    size: tuple[int, ...],
) -> None:
    """Predict by transition t: x = F x + B u, P = F P F' + Q + variance B B'; work (m + 1, m)."""
    m = len(size)
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
def predict_motion(
    i: int,
    x: Signal,
    P: Signal,
    F: Signal,
    B: Signal,
    Q: Signal,
    t: int,
    u: float,
    variance: float,
    work: Signal,
    size: tuple[int, ...],
) -> None:
    """Do what `predict` does in a fraction of the time, for [h, v, bias, states that only decay], Q diagonal.

    In such an F a state hears only of those after it, so its rows can be applied in place, one by one.
    """
    m, dt, half = len(size), F[t, HEIGHT, VELOCITY], F[t, HEIGHT, BIAS]
    for c in range(m):
        work[0, c] = P[i, HEIGHT, c] + dt * P[i, VELOCITY, c] + half * P[i, BIAS, c]
        work[1, c] = P[i, VELOCITY, c] - dt * P[i, BIAS, c]
    work[0, HEIGHT] += dt * work[0, VELOCITY] + half * work[0, BIAS]
    work[0, VELOCITY] -= dt * work[0, BIAS]
    work[1, VELOCITY] -= dt * work[1, BIAS]
    work[1, HEIGHT] = work[0, VELOCITY]
    for a in range(2):
        for c in range(m):
            P[i, a, c] = work[a, c]
        for c in range(2, m):
            P[i, c, a] = work[a, c]
        for c in range(2):
            P[i, a, c] += variance * B[t, a] * B[t, c]
    x[i, HEIGHT] += dt * x[i, VELOCITY] + half * x[i, BIAS] + B[t, HEIGHT] * u
    x[i, VELOCITY] += B[t, VELOCITY] * u - dt * x[i, BIAS]
    for a in range(BIAS, m):
        if F[t, a, a] != 1.0:
            x[i, a] *= F[t, a, a]
            for c in range(m):
                P[i, a, c] *= F[t, a, a]
                P[i, c, a] *= F[t, a, a]
    for a in range(m):
        P[i, a, a] += Q[t, a, a]


@njit(cache=True, error_model="numpy", inline="always")
def innovate(
    i: int, x: Signal, P: Signal, H: Signal, j: int, r: float, z: float, gain: Signal, size: tuple[int, ...]
) -> tuple[float, float]:
    """Return innovation and its variance of z = H_j x + noise; `gain` becomes P H'."""
    m, y, s = len(size), z, r
    for a in range(m):
        total = 0.0
        for c in range(m):
            total += P[i, a, c] * H[j, c]
        gain[a] = total
        y -= H[j, a] * x[i, a]
        s += H[j, a] * total
    return y, s


@njit(cache=True, error_model="numpy", inline="always")
def absorb(
    i: int,
    x: Signal,
    P: Signal,
    H: Signal,
    j: int,
    r: float,
    y: float,
    s: float,
    gain: Signal,
    work: Signal,
    size: tuple[int, ...],
) -> None:
    """Update after `innovate`, P = (I - k h) P (I - k h)' + k r k'; `gain` becomes k.

    What is known exactly (s = 0: a second sample of the same noise) tells nothing new.
    """
    m = len(size)
    share = 1.0 / s if s > 0.0 else 0.0
    for a in range(m):
        work[0, a] = gain[a]
        gain[a] *= share
        x[i, a] += gain[a] * y
    for a in range(m):
        total = -r * gain[a]
        for b in range(m):
            total += (P[i, a, b] - gain[a] * work[0, b]) * H[j, b]
        work[1, a] = total
    for a in range(m):
        for b in range(a, m):
            entry = P[i, a, b] - (gain[a] * work[0, b] + work[1, a] * gain[b])
            P[i, a, b] = entry
            P[i, b, a] = entry


@njit(cache=True, error_model="numpy", inline="always")
def pin(
    i: int,
    x: Signal,
    P: Signal,
    state: int,
    value: float,
    variance: float,
    gain: Signal,
    work: Signal,
    size: tuple[int, ...],
) -> tuple[float, float]:
    """Update with one state known to be `value`; return innovation and variance; `gain` becomes k."""
    m = len(size)
    y, s = value - x[i, state], P[i, state, state] + variance
    share = 1.0 / s if s > 0.0 else 0.0
    for a in range(m):
        work[0, a] = P[i, state, a]
        gain[a] = work[0, a] * share
        x[i, a] += gain[a] * y
    for a in range(m):
        work[1, a] = work[0, a] - gain[a] * work[0, state] - variance * gain[a]
    for a in range(m):
        for b in range(a, m):
            entry = P[i, a, b] - (gain[a] * work[0, b] + work[1, a] * gain[b])
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
def filter_rows(rows: Rows, size: tuple[int, ...], x: Signal, P: Signal, out: Signal) -> None:
    """Filter in place from x (1, m), P (1, m, m); out (4, n) gets height, velocity and their sds.

    `size` is a tuple as long as the state: the compiler knows a tuple's length, unlike a shape, and unrolls
    the loops over the states.
    """
    m = len(size)
    assert x.shape[1] == m and P.shape[1] == m and P.shape[2] == m  # noqa: PT018 - compiled
    gain, work = np.empty(m), np.empty((m + 1, m))
    F, B, Q, ends, columns, transition, H, R, measurement, z = rows[:10]
    _, u, variance, at_rest, rest_variance, level, level_variance, jump, turned, startled, offset = rows[10:]
    for k in range(len(z)):
        if transition[k] >= 0:
            predict(0, x, P, F, B, Q, transition[k], ends, columns, u[k], variance[k], work, size)
        loosen(0, P, turned[k], jump[k], startled[k], offset)
        if at_rest[k]:
            pin(0, x, P, VELOCITY, 0.0, rest_variance[k], gain, work, size)
        if not math.isnan(level[k]):
            pin(0, x, P, HEIGHT, level[k], level_variance[k], gain, work, size)
        if not math.isnan(z[k]):
            j = measurement[k]
            y, s = innovate(0, x, P, H, j, R[j], z[k], gain, size)
            absorb(0, x, P, H, j, R[j], y, s, gain, work, size)
        report(k, 0, x, P, out)


@njit(cache=True, error_model="numpy", inline="always")
def one_row(tables: Tables, H: Signal, r: float, first: bool, row: Row) -> Rows:
    """Return `Rows` of a single row, given its tables and H (1, m), R."""
    F, B, Q = tables
    m = F.shape[1]
    places = np.zeros(m * m + m + 3, np.int64)
    where, ends, columns = places[:2], places[2 : m + 3], places[m + 3 :]
    for a in range(m):
        ends[a + 1] = ends[a]
        for b in range(m):
            if F[0, a, b] != 0.0:
                columns[ends[a + 1]] = b
                ends[a + 1] += 1
    cells, at_rest = np.zeros(11), np.full(1, row.at_rest)
    where[0] = -1 if first else 0
    cells[0], cells[1], cells[2], cells[3] = row.z, row.dt, row.u, row.acceleration_variance
    cells[4], cells[5], cells[6], cells[7] = row.rest_variance, row.level, row.level_variance, row.turned
    cells[8] = r
    # fmt: off
    return Rows(F, B, Q, ends, columns, where[:1], H, cells[8:9], where[1:], cells[:1],
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
    size: tuple[int, ...],
    x: Signal,
    P: Signal,
) -> tuple[float, float, float, float]:
    """Filter one row in place from x (m,), P (m, m); return height, velocity and their sds.

    The matrices and the `Row` come one by one, since Python passes named tuples slowly.
    """
    m, out = len(x), np.empty((4, 1))
    row = Row(z, dt, u, variance, at_rest, rest_variance, level, level_variance, turned, offset)
    filter_rows(
        one_row(Tables(F, B, Q), H, r, first, row), size, x.reshape((1, m)), P.reshape((1, m, m)), out
    )
    return out[0, 0], out[1, 0], out[2, 0], out[3, 0]
