"""Spikes: readings that jump away and back as no height, force or turn can, left by a disturbed bus.

A spike of the barometer begins with a jump beyond noise and motion, and within a second another one brings
the pressure back to where it was; what lies between is not air pressure.  A jump that stays is none: it may
be a door, a restart or a fault of the clock, and is left to other checks.  A force or a rate that no sensor
can report is one however long it lasts, unless a wrong unit explains it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.finding import Finding
from baroarma.glance import greatest, some_rows
from baroarma.recording import Recording

Signal = NDArray[np.float64]
Mask = NDArray[np.bool_]

LEAST_SPIKE: Final = 25.0
"""Pa, two metres: a smaller jump may be a gust or a door (chosen by us)."""
FASTEST_CLIMB: Final = 300.0
"""Pa/s, 25 m/s: what a motion may add to a jump; a rocket is faster, but doesn't come back in a second."""
OUTSTANDING: Final = 12.0
"""Robust standard deviations, of white noise, of a jump that is none of it; heavy tails are allowed for."""
COARSE: Final = 5.0
"""Quanta of a jump that is none of rounding."""
LONGEST: Final = 1.0
"""Seconds after which a pressure that has not come back is no spike."""
AROUND: Final = 25
"""Readings before and after a jump from which it must stand out, too."""
MOST_JUMPS: Final = 0.05
"""Share of readings; if more of them jump, the noise itself is like that, and nothing is dropped."""
GREATEST_FORCE: Final = 4000.0
"""m/s²: 400 g, beyond the shock sensors'."""
GREATEST_RATE: Final = 150.0
"""rad/s: twice the 4000 deg/s of the widest consumer gyros."""
LONE: Final = 2
"""Rows in a row that a spike of the IMU lasts at most: more of them are a wrong unit."""


def drop_spikes(recording: Recording) -> Recording:
    """Blank the readings that are spikes.

    Parameters
    ----------
    recording : Recording
        As logged; NaN where there is no sample.

    Returns
    -------
    Recording
        The same rows, with NaN for each spike and a "spikes" note for each sensor that has some; the given
        recording itself where there is none.

    Examples
    --------
    >>> pressure = 101325.0 + np.random.default_rng(1).normal(0, 3, 500)
    >>> pressure[200:203] = 110000.0
    >>> clean = drop_spikes(Recording(t=np.arange(500) / 50, pressure=pressure))
    >>> int(clean.is_new.sum())
    497
    >>> print(clean.notes[0])
    warning (spikes): The pressure has 1 spike, 3 readings in all, the first at 4 s (110000 Pa): no height \
changes like that, so they were dropped; check the wiring.
    """
    changes: dict[str, Any] = {}
    notes = [*_drop_from_barometer(recording, changes), *_drop_from_imu(recording, changes)]
    return replace(recording, **changes, notes=(*recording.notes, *notes)) if changes else recording


def drop_imu_spikes(recording: Recording) -> Recording:
    """Blank the spikes of accelerometer and gyro only, as `drop_spikes` does."""
    changes: dict[str, Any] = {}
    notes = _drop_from_imu(recording, changes)
    return replace(recording, **changes, notes=(*recording.notes, *notes)) if changes else recording


def pressure_spikes(t: Signal, pressure: Signal) -> tuple[Mask, int]:
    """Return which readings belong to spikes, and how many spikes these are.

    Parameters
    ----------
    t, pressure : ndarray, shape (n,)
        Times in s and readings in Pa, no NaN.
    """
    spike, count, free = np.zeros(len(t), bool), 0, 0
    if len(t) < 3:
        return spike, count
    steps = np.diff(pressure)
    limit = max(LEAST_SPIKE, _noise_limit(steps))
    jumps = np.flatnonzero(np.abs(steps) > limit)
    jumps = jumps[np.abs(steps[jumps]) > limit + FASTEST_CLIMB * (t[jumps + 1] - t[jumps])]
    if len(jumps) > MOST_JUMPS * len(t):
        return spike, count
    jumps = jumps[np.abs(steps[jumps]) > OUTSTANDING * _noise_around(steps, jumps)]
    for k, before in enumerate(jumps):
        if before < free:
            continue  # it is the end of a spike, or within one
        ends = jumps[k + 1 : k + 1 + np.searchsorted(t[jumps[k + 1 :]], t[before] + LONGEST)]
        back = ends[np.abs(pressure[ends + 1] - pressure[before]) < limit]
        if len(back):
            free = int(back[0]) + 1
            spike[before + 1 : free] = True
            count += 1
    return spike, count


def _noise_around(steps: Signal, jumps: NDArray[np.intp]) -> Signal:
    """Return the robust sd in Pa of the steps around each jump: wind and flight are noisier than a rest."""
    rows = jumps[:, None] + np.arange(-AROUND, AROUND + 1)
    return np.asarray(1.4826 * np.median(np.abs(steps[np.clip(rows, 0, len(steps) - 1)]), axis=1))


def _noise_limit(steps: Signal) -> float:
    """Return the largest step in Pa that noise and rounding make."""
    some = np.abs(steps[some_rows(len(steps))])
    quantum = float(np.min(some, where=some > 0, initial=np.inf))
    noise = 1.4826 * float(np.median(some))
    return max(OUTSTANDING * noise, COARSE * quantum if np.isfinite(quantum) else 0.0)


def spike_note(t: Signal, pressure: Signal, spike: Mask, count: int, *, dropped: bool = True) -> Finding:
    """Say how many spikes there are, and where."""
    first, readings = int(spike.argmax()), int(spike.sum())
    done = "so they were dropped" if dropped else "so drop them, as read() and drop_spikes do"
    text = (
        f"The pressure has {_many(count, 'spike')}, {_many(readings, 'reading')} in all, the first at "
        f"{t[first]:.6g} s ({pressure[first]:.6g} Pa): no height changes like that, {done}; check the wiring."
    )
    return Finding("spikes", "warning", text)


def _many(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _drop_from_barometer(recording: Recording, changes: dict[str, Any]) -> list[Finding]:
    rows = np.flatnonzero(recording.is_new)
    t, pressure = recording.t[rows], recording.pressure[rows]
    spike, count = pressure_spikes(t, pressure)
    if not count:
        return []
    changes["pressure"] = recording.pressure.copy()
    changes["pressure"][rows[spike]] = np.nan
    return [spike_note(t, pressure, spike, count)]


def _drop_from_imu(recording: Recording, changes: dict[str, Any]) -> list[Finding]:
    notes = []
    for field, words, unit, limit in (
        ("accel", "specific force", "m/s²", GREATEST_FORCE),
        ("gyro", "angular rate", "rad/s", GREATEST_RATE),
    ):
        signal = getattr(recording, field)
        if signal is None or greatest(signal) < limit:
            continue
        spike = _lone(np.abs(np.nan_to_num(signal)).max(axis=1) >= limit)
        if not spike.any():
            continue
        first = int(spike.argmax())
        text = (
            f"The {words} has spikes in {_many(int(spike.sum()), 'row')}, the first at "
            f"{recording.t[first]:.6g} s ({np.nanmax(np.abs(signal[first])):.4g} {unit}): no sensor measures "
            "that, so they were dropped."
        )
        changes[field] = np.where(spike[:, None], np.nan, signal)
        notes.append(Finding("spikes", "warning", text))
    return notes


def _lone(beyond: Mask) -> Mask:
    """Return the rows beyond the limit that have neighbours within it, at most `LONE` in a row."""
    edges = np.flatnonzero(np.diff(beyond, prepend=False, append=False)).reshape(-1, 2)
    lone = np.zeros(len(beyond), bool)
    for start, stop in edges[edges[:, 1] - edges[:, 0] <= LONE]:
        lone[start:stop] = True
    return lone
