"""The covariance of a linear height filter's errors at rest, by the true noise instead of the assumed one.

At rest the truth is 0 and the filter's state *is* its error.  Together with the noise that drives it
(`error_sources`) it is one linear system, and the covariance of that is [Lyapunov]

    S_k = A_k S_{k-1} A_k' + Q_k.

A filter whose model is the truth has S = its own P: then this is the finite-horizon Riccati recursion.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import reduce
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.error_sources import (
    ACCEL,
    ACCEL_BEFORE,
    BEFORE,
    SAMPLE,
    ZERO,
    Errors,
    Step,
    aligned_covariance,
    noise_step,
)
from baroarma.estimators.colouring import block_diagonal
from baroarma.estimators.height.complementary import Complementary
from baroarma.estimators.height.linear import LinearHeight
from baroarma.filter_rows import Row, filter_rows

Signal = NDArray[np.float64]

STEADY: Final = 1e-3
"""Relative change below which variances and gains stand still."""


class Propagation(NamedTuple):
    """What becomes of the errors: sds of each row (n,), and where they end (None: nowhere)."""

    height_sd: Signal
    velocity_sd: Signal
    steady_height_sd: float | None
    steady_velocity_sd: float | None


def propagate(height: Complementary | LinearHeight, errors: Errors, rows: int) -> Propagation:
    """Propagate the covariance of the errors from the first sample on.

    Parameters
    ----------
    height : Complementary or LinearHeight
        The filter; it is reset.
    errors : Errors
        What drives it.
    rows : int
        Number n of rows, those of the alignment included: the track is 0 there, and so is its error.
    """
    new, start = errors.new_samples(rows), errors.aligned_rows
    m = 2 if isinstance(height, Complementary) else height.dim_x
    S = np.zeros((errors.size + m, errors.size + m))
    S[: errors.size, : errors.size] = aligned_covariance(errors, new[:start])
    sds, steps = np.zeros((2, rows)), dict[int, Step]()
    last, back = _compared(errors, rows, start)
    for k, step in enumerate(_steps(height, errors, new[start:]), start):
        S = step.spread(S)
        sds[:, k] = np.sqrt(np.diag(S)[errors.size : errors.size + 2])
        if k in last or k in back:
            steps[k] = step
    cycles = [reduce(Step.then, (steps[k] for k in cycle)) for cycle in (last, back) if len(cycle)]
    return Propagation(sds[0], sds[1], *_steady(cycles, S, errors.size))


def _steps(height: Complementary | LinearHeight, errors: Errors, new: NDArray[np.bool_]) -> Iterator[Step]:
    """Yield the whole system's step of each row after the alignment."""
    noise = [noise_step(errors, still=False, samples=10**9, fresh=f, share=0.0) for f in (False, True)]
    last: tuple[Row, bool] | None = None
    rows = filter_rows(height, errors.dt, new, errors.rest)
    for row, fresh in zip(rows, new.tolist(), strict=True):
        if last is None or last[0] is not row or last[1] != fresh:
            last, m = (row, fresh), len(row.b)
            A, Q = noise[fresh]
            still = Step(block_diagonal(A, np.eye(m)), block_diagonal(Q, np.zeros((m, m))))
            step = still.then(_filter_step(errors, row, midpoint=height.drive.midpoint))
        yield step


def _filter_step(errors: Errors, row: Row, *, midpoint: bool) -> Step:
    size, m = errors.size, len(row.b)
    A = np.eye(size + m)
    x = A[size:]
    x[:, size:], x[:, BEFORE], x[:, SAMPLE] = row.L, row.before, row.now
    x[:, ZERO] = -errors.dc_gain * (row.before + row.now)
    x[:, ACCEL_BEFORE], x[:, ACCEL] = (row.b / 2, row.b / 2) if midpoint else (row.b, 0.0)
    return Step(A, np.zeros_like(A))


def _compared(errors: Errors, rows: int, start: int) -> tuple[range, range]:
    """Return the rows of the last cycle of barometer samples, and of one half the run before; empty: none."""
    period = round(errors.rows_per_sample)
    shift = (rows - start) // (2 * period) * period
    if period != errors.rows_per_sample or shift < period:
        return range(0), range(0)
    return range(rows - period, rows), range(rows - period - shift, rows - shift)


def _steady(cycles: list[Step], S: Signal, size: int) -> tuple[float | None, float | None]:
    """Return where the sds of height and velocity end if the last cycle goes on for ever, by doubling it.

    None where the variance still grows after 2^20 cycles, and where the gains still change.
    """
    if (
        not cycles
        or np.abs(cycles[0].A - cycles[1].A).max() > STEADY * np.abs(cycles[0].A[size:, :size]).max()
    ):
        return None, None
    cycle = cycles[0]
    for _ in range(20):
        cycle = cycle.then(cycle)
    before, after = (np.diag(step.spread(S))[size : size + 2] for step in (cycle, cycle.then(cycle)))
    height, velocity = (
        float(math.sqrt(end)) if abs(end - now) < STEADY * now else None
        for now, end in zip(before, after, strict=True)
    )
    return height, velocity
