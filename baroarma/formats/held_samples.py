"""Held samples: readings that a logger repeated although the sensor had made no new one.

A filter that takes one reading twice believes it twice.  `drop_held_samples` blanks the repeats (NaN, the
row stays) where the *timing* shows them, never for being equal alone: a quantised sensor at rest honestly
repeats itself.

* *Re-reads.*  Readings much closer together than usual (less than half the median interval), most of them
  equal to the one before: a logger that catches up after a stall.  The equal ones go; the unequal ones are
  new readings with late stamps and stay.
* *A slow sensor in a fast log.*  Let a value's age be the time since it first appeared.  Honest noise changes
  most readily right after a change, so its hazard of changing (per reading) falls with age.  A held value
  can't change before the sensor's own period P and does so at once after it: its hazard rises.  P is the
  mean of the shorter intervals between changes.

There a run of equal readings that lasts 5/4, 9/4 … periods counts as 2, 3 … honest readings, evenly spread,
and any shorter one as one: losing an honest repeat costs less than fusing one reading twice.

What escapes: a sensor hardly slower than the log (P below 1.5 intervals) whose quanta are as coarse as its
noise: its repeats can't be told from honest ones by their timing.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.finding import Finding
from baroarma.recording import Recording

Signal = NDArray[np.float64]
Mask = NDArray[np.bool_]

EVIDENCE: Final = 14.0
"""Nats by which the data must contradict honesty: one false alarm in e^14, about a million, recordings."""
ODDS: Final = 2.0
"""The odds of a change must rise at least so much after the sensor's own period."""
SHORT: Final = 0.5
"""A reading is a re-read below this fraction of the median interval."""
LATE: Final = 0.25
"""An equal reading is honest only this fraction of a period after a new one was due."""
MIN_RUNS: Final = 20
"""Fewer changes of value than this say nothing about a sensor's own period."""


def drop_held_samples(recording: Recording) -> Recording:
    """Blank the pressure readings that the logger merely repeated.

    Parameters
    ----------
    recording : Recording
        As logged; NaN where there is no sample.

    Returns
    -------
    Recording
        The same rows, with NaN for each held sample and one "held-samples" note for each kind found; the
        given recording itself where there is nothing to drop.

    Examples
    --------
    A barometer of 10 Hz in a log of 50 Hz:

    >>> reading = np.repeat(101325.0 + np.random.default_rng(1).normal(0, 3, 100), 5)
    >>> log = Recording(t=np.arange(500) / 50, pressure=reading)
    >>> clean = drop_held_samples(log)
    >>> clean
    <Recording '': 500 rows, 9.98 s, pressure 100 samples at 10 Hz>
    >>> print(clean.notes[0])
    warning (held-samples): 400 of 500 pressure readings repeat the one before: the sensor itself gives \
about 10 Hz in a log of 50 Hz; the repeats were dropped.
    """
    rows = np.flatnonzero(recording.is_new)
    t, x = recording.t[rows], recording.pressure[rows]
    again = reread(t, x)
    held, period = slow_sensor(t[~again], x[~again])
    notes = _notes(t, again, held, period)
    if not notes:
        return recording
    pressure = recording.pressure.copy()
    pressure[rows[again]] = np.nan
    pressure[rows[~again][held]] = np.nan
    return replace(recording, pressure=pressure, notes=(*recording.notes, *notes))


def _notes(t: Signal, again: Mask, held: Mask, period: float) -> list[Finding]:
    notes, n = [], len(t)
    if again.any():
        text = (
            f"{again.sum()} of {n} pressure readings repeat the one before within less than half the "
            f"usual {np.median(np.diff(t)):.3g} s: the logger read the sensor twice; they were dropped."
        )
        notes.append(Finding("held-samples", "info", text))
    if held.any():
        rate = 1 / np.median(np.diff(t[~again]))
        text = (
            f"{held.sum()} of {n} pressure readings repeat the one before: the sensor itself gives about "
            f"{1 / period:.3g} Hz in a log of {rate:.3g} Hz; the repeats were dropped."
        )
        notes.append(Finding("held-samples", "warning", text))
    return notes


def reread(t: Signal, x: Signal) -> Mask:
    """Return which readings are equal re-reads: much closer together than usual, and mostly equal.

    Parameters
    ----------
    t, x : ndarray, shape (n,)
        Times in s and readings, no NaN.

    Examples
    --------
    >>> t = np.array([0.0, 1, 2, 5, 5.01, 5.02, 5.03, 5.04, 6, 7, 8, 9, 10])
    >>> reread(t, np.array([3.0, 1, 4, 1, 1, 1, 1, 1, 5, 9, 2, 6, 5])).nonzero()[0]
    array([4, 5, 6, 7])
    """
    none = np.zeros(len(t), bool)
    if len(t) < 3:
        return none
    elapsed, equal = np.diff(t), np.diff(x) == 0
    short = elapsed < SHORT * np.median(elapsed)
    usual = (equal[~short].sum() + 1) / (np.count_nonzero(~short) + 2)  # Laplace: never 0 or 1
    share = equal[short].mean() if short.any() else 0.0
    if share < 0.5 or not _exceeds(share, short.sum(), usual, EVIDENCE / 2):  # 1 in 1000: there may be few
        return none
    return np.concatenate(([False], short & equal))


def slow_sensor(t: Signal, x: Signal) -> tuple[Mask, float]:
    """Return which readings a logger held because the sensor is slower, and the sensor's own period in s.

    Parameters
    ----------
    t, x : ndarray, shape (n,)
        Times in s and readings, no NaN and no re-reads.

    Returns
    -------
    held : ndarray of bool, shape (n,)
        All False for an honest log.
    period : float
        The sensor's own period in s; NaN for an honest log.
    """
    honest = np.zeros(len(t), bool), math.nan
    runs = _runs(t, x)
    if len(runs.duration) < MIN_RUNS:
        return honest
    interval = float(np.median(np.diff(t)))
    period = _own_period(runs.duration, interval)
    if not _hazard_rises(runs, period, interval):
        return honest
    return _held(t, runs, period, interval), period


class _Runs(NamedTuple):
    """Runs of equal readings; those with a change on both sides are counted, hence J = changes - 1."""

    age: Signal  # (n,) time since the reading's value first appeared
    run: NDArray[np.intp]  # (n,) its run: -1 before the first change, J after the last
    duration: Signal  # (J,) from change to change
    before: Signal  # (J,) the change that began it
    after: Signal  # (J,) the change that ended it


def _runs(t: Signal, x: Signal) -> _Runs:
    changes = np.flatnonzero(np.diff(x)) + 1
    run = np.searchsorted(changes, np.arange(len(t)), side="right") - 1
    begin = np.concatenate((t[:1], t[changes]))
    step = x[changes] - x[changes - 1]
    return _Runs(t - begin[run + 1], run, np.diff(t[changes]), step[:-1], step[1:])


def _held(t: Signal, runs: _Runs, period: float, interval: float) -> Mask:
    """Return all readings of each run but its first, and but those that spread its honest repeats evenly."""
    run = runs.run + 1
    first = np.flatnonzero(runs.age == 0)
    last = np.append(first[1:] - 1, len(t) - 1)
    repeats = np.maximum(np.floor(runs.age[last] / period - LATE), 0.0)
    spacing = np.diff(t[first], append=t[-1] + interval) / (repeats + 1)
    reading = np.minimum(np.floor((runs.age + interval / 2) / spacing[run]), repeats[run])
    held = runs.age > 0
    held[1:] &= reading[1:] == reading[:-1]
    return held


def _own_period(duration: Signal, interval: float) -> float:
    """Return the mean interval between changes, leaving out those that span an honest repeat."""
    low = np.quantile(duration, 0.1, method="lower")
    return float(duration[duration < 1.5 * low + 0.7 * interval].mean())


def _hazard_rises(runs: _Runs, period: float, interval: float) -> bool:
    """Compare how readily a value changes before the period is over and just after it."""
    edge = max(period - interval / 2, 1.5 * interval)  # halfway between two readings, for jittery clocks
    usable = ~_is_ramp(runs)
    inside = (runs.run >= 0) & (runs.run < len(usable)) & (runs.age > 0)
    age = runs.age[inside][usable[runs.run[inside]]]
    duration = runs.duration[usable]

    def hazard(low: float, high: float) -> tuple[float, int]:
        changed = int(np.sum((duration >= low) & (duration < high)))
        stayed = int(np.sum((age >= low) & (age < high)))
        return changed / max(changed + stayed, 1), changed + stayed

    early, _ = hazard(0.0, edge)
    late, trials = hazard(edge, edge + max(1.25 * interval, 0.5 * period))
    return late * (1 - early) > ODDS * early * (1 - late) and _exceeds(late, trials, early, EVIDENCE)


def _is_ramp(runs: _Runs) -> Mask:
    """Return which runs are steps of a staircase: a steady climb through quanta is regular too."""
    quantum = np.quantile(np.abs(runs.before), 0.05)  # for a fine sensor something well below its noise
    up, down = (runs.before > 0) & (runs.after > 0), (runs.before < 0) & (runs.after < 0)
    small = np.maximum(np.abs(runs.before), np.abs(runs.after)) <= 1.5 * quantum
    steps: Mask = (up | down) & small
    return steps


def _exceeds(share: float, trials: int, expected: float, evidence: float) -> bool:
    """Return True if so large a share in so many trials contradicts the expected one (Chernoff's bound)."""
    if share <= expected:
        return False
    nats = 0.0
    for p, q in ((share, expected), (1 - share, 1 - expected)):
        if p > 0:
            nats += p * math.log(p / max(q, 1e-12))
    return bool(trials * nats > evidence)
