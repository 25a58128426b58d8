"""Sensors that hung: one number for too long, while the sensor had been, or another one is, alive.

A quantised sensor at rest honestly repeats itself.  So a standstill of the barometer counts only if it lasts
much longer than usual and the noise is not below the quantum; one of an axis of the IMU only if another axis
meanwhile changes by many of its own quanta.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.finding import Finding, Severity
from baroarma.glance import some_rows, usual_interval
from baroarma.recording import Recording

Signal = NDArray[np.float64]

STUCK: Final = 10.0
"""A pressure that stands still for so many s, 50 times longer than usual, is that of a sensor that hung."""
STUCK_AXIS: Final = 2.0
"""The same in s for an axis of the IMU while others move."""
LIVELY: Final = 3.0
"""Sd over the usual step of an axis that moves; that of noise is 1, or less where quanta are coarse."""
MOVED: Final = 0.5
"""Sd in m/s² of an axis of the accelerometer that a gyro must have felt, too."""
FEWEST: Final = 100
"""Rows below which a constant means nothing."""


class _Run(NamedTuple):
    """The longest run of one number: its first and its last row."""

    first: int
    last: int


def dead_barometer(t: Signal, pressure: Signal, *, severity: Severity = "error") -> list[Finding]:
    """Return a "dead" finding if the barometer hung.

    Parameters
    ----------
    t, pressure : ndarray, shape (n,)
        Times in s and readings in Pa, no NaN.
    severity : {"warning", "error"}
        A track may live on its IMU, a noise model can't.

    Examples
    --------
    >>> t = np.arange(2000) / 50
    >>> print(dead_barometer(t, np.full(2000, 101325.0))[0])
    error (dead): The pressure never changes from 101325 Pa; a live barometer is never that quiet.
    """
    if len(t) < FEWEST or t[-1] - t[0] < STUCK:
        return []
    run = _longest_run(t, pressure, STUCK)
    if run is None:
        return []
    if run == (0, len(t) - 1):
        text = f"The pressure never changes from {pressure[0]:.6g} Pa; a live barometer is never that quiet."
        return [Finding("dead", severity, text)]
    first, last = run
    lasts = t[last] - t[first]  # from first to last sample: a gap is no run
    alive = np.concatenate((np.diff(pressure[: first + 1]), np.diff(pressure[last:])))
    usual = float(np.median(np.diff(t[np.append(0, np.flatnonzero(np.diff(pressure)) + 1)])))
    # a sensor whose noise is below its quantum may honestly stay on one value
    if lasts < 50 * usual or quantum_of(pressure) > noise_of(alive):
        return []
    text = (
        f"The pressure stands still for {lasts:.4g} s from {t[first]:.4g} s on, but otherwise changes every "
        f"{usual:.2g} s: the sensor or the logger hung; use the rest of the recording."
    )
    return [Finding("dead", severity, text)]


def stuck_axes(recording: Recording) -> list[Finding]:
    """Return a "stuck" finding for each sensor of the IMU of which axes hung while others moved."""
    if recording.accel is None or recording.gyro is None:
        return []
    columns, found = (*recording.accel.T, *recording.gyro.T), []
    for words, axes in (("accelerometer", range(3)), ("gyro", range(3, 6))):
        runs = {
            k: run for k in axes if (run := _longest_run(recording.t, columns[k], STUCK_AXIS)) is not None
        }
        stuck = {k: run for k, run in runs.items() if _others_move(columns, k, run)}
        if stuck:
            found.append(_stuck_finding(recording.t, columns, words, stuck))
    return found


def _others_move(columns: Sequence[Signal], stuck: int, run: _Run) -> bool:
    """Return True if another axis of the sensor is lively during the run; for a gyro, if the device moves."""
    rows = slice(run.first, run.last + 1)
    same = [k for k in range(stuck // 3 * 3, stuck // 3 * 3 + 3) if k != stuck]
    lively = any(np.std(_finite(columns[k][rows])) > LIVELY * _usual_step(columns[k]) > 0 for k in same)
    return lively or (stuck >= 3 and any(np.std(_finite(columns[k][rows])) > MOVED for k in range(3)))


def _finite(column: Signal) -> Signal:
    good = column[np.isfinite(column)]
    return good if len(good) else np.zeros(1)


def _stuck_finding(t: Signal, columns: Sequence[Signal], words: str, stuck: dict[int, _Run]) -> Finding:
    k, run = max(stuck.items(), key=lambda item: t[item[1].last] - t[item[1].first])
    names = ", ".join("xyz"[axis % 3] for axis in stuck)
    text = (
        f"The {words}'s {names} stand{'s' if len(stuck) == 1 else ''} still, {'xyz'[k % 3]} at "
        f"{columns[k][run.first]:.4g} {'m/s²' if k < 3 else 'rad/s'} for {t[run.last] - t[run.first]:.3g} s "
        f"from {t[run.first]:.4g} s on, while another axis moves: the sensor hung or the column is filled "
        "in; don't believe height and velocity from there on."
    )
    return Finding("stuck", "warning", text)


def _usual_step(column: Signal) -> float:
    """Return the median step between different neighbours of an axis; 0 without any."""
    rows = some_rows(len(column) - 1)
    steps = np.abs(column[rows + 1] - column[rows])
    steps = steps[steps > 0]
    return float(np.median(steps)) if len(steps) else 0.0


def quantum_of(signal: Signal) -> float:
    """Return the smallest difference of two values; differences of rounding don't count."""
    values = np.unique(signal)
    steps = np.diff(values)
    steps = steps[steps > 1e-9 * np.abs(values).max()]
    return float(steps.min()) if len(steps) else 0.0


def noise_of(differences: Signal) -> float:
    """Return the sd of the noise that is not drift from the differences of neighbouring samples."""
    return float(np.sqrt(np.mean(differences**2) / 2)) if len(differences) else 0.0


def _longest_run(t: Signal, x: Signal, shortest: float) -> _Run | None:
    """Return the longest run of equal numbers if it lasts for `shortest` s or more.

    Of samples a sixth of that apart five in a row are then equal; only if some are does it make sense to look
    at every row.
    """
    if len(t) < FEWEST:
        return None
    sparse = x[:: max(int(shortest / 6 / max(usual_interval(t), 1e-9)), 1)]
    equal = sparse[1:] == sparse[:-1]
    if not np.any(equal[3:] & equal[2:-1] & equal[1:-2] & equal[:-3]):
        return None
    changes = np.flatnonzero(x[1:] != x[:-1])
    first, last = np.append(0, changes + 1), np.append(changes, len(x) - 1)
    lasts = np.where(np.isnan(x[first]), 0.0, t[last] - t[first])
    longest = int(np.argmax(lasts))
    return _Run(int(first[longest]), int(last[longest])) if lasts[longest] >= shortest else None


def _may_stand(t: Signal, x: Signal, shortest: float) -> bool:
    grid = np.arange(t[0], t[-1], shortest / 3)
    if len(grid) > len(t):
        return True
    sparse = x[np.searchsorted(t, grid)]
    return bool(np.any(sparse[1:] == sparse[:-1]))
