"""Saturation: an axis of the IMU that stands at the end of its range while the motion goes on beyond.

A clipped signal leaves a plateau at its own greatest or least value, and enters and leaves it by steps of
many quanta.  A smooth peak of a coarse sensor is flat, too, but its neighbours are one quantum away.  The
range need not be known; if it is one that sensors are made for, it is named.

Each axis is looked at as it is read, so the axes must be the sensor's own, in any order and with any signs,
scales and offsets (`Calibration.apply` changes no more).  A logger that turns its readings by another angle
spreads the plateau over three axes, where each goes on moving, and it is not seen.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.finding import Finding
from baroarma.glance import column_ranges, some_rows, some_values
from baroarma.recording import Recording
from baroarma.standstill import quantum_of

Signal = NDArray[np.float64]

PLATEAU: Final = 3
"""Rows of a plateau, or three times as many as the logger repeats each sample."""
STEEP: Final = 4.0
"""Quanta between a plateau and its neighbours, at the median; a smooth peak has one."""
ROUNDING: Final = 1e-9
"""Share of its value by which a plateau may waver: gravity taken out and added again costs some 1e-16."""
LEAST_SWING: Final = (4.0, 1.5)
"""How far from its median a plateau must be: m/s² (a range of 1.5 g is 4.9 from g), rad/s (86 deg/s)."""
CLOSE: Final = 0.03
"""A plateau this near to a range that is made, as a share of it, is at its end: scales are off by as much."""


class _Sensor(NamedTuple):
    """A sensor's words and the ranges that are made."""

    name: str
    unit: str
    least_swing: float
    ranges: tuple[float, ...]
    in_words: str


_SENSORS: Final = {
    "accel": _Sensor(
        "accelerometer",
        "m/s²",
        LEAST_SWING[0],
        tuple(g * STANDARD_GRAVITY for g in (1.5, 2, 3, 4, 6, 8, 12, 16, 24, 30, 32, 64, 100, 200)),
        "{:.3g} g",
    ),
    "gyro": _Sensor(
        "gyro",
        "rad/s",
        LEAST_SWING[1],
        tuple(np.deg2rad((125, 245, 250, 300, 450, 500, 1000, 2000, 4000)).tolist()),
        "{:.4g} °/s",
    ),
}


def saturation_findings(recording: Recording) -> list[Finding]:
    """Return a "saturation" finding for each sensor of the IMU that reached the end of its range.

    Examples
    --------
    >>> t = np.arange(2000) / 100
    >>> turn = np.stack([6 * np.sin(t), 0 * t, 0 * t], axis=1)
    >>> log = Recording(t=t, pressure=np.full(2000, 101325.0), gyro=np.clip(turn, -4.363, 4.363))
    >>> print(saturation_findings(log)[0])
    warning (saturation): The gyro's x stands at 4.363 rad/s, the end of its range (250 °/s), in 941 rows, \
first at 0.82 s: the motion went beyond, and height and velocity are off from there on; set a wider range.
    """
    found = []
    for field, sensor in _SENSORS.items():
        signal = getattr(recording, field)
        if signal is None or not len(some := some_values(signal)):
            continue
        middle, plateaus = np.median(some, axis=0), []
        for k, ends in enumerate(column_ranges(signal).T):
            far = ends[np.abs(ends - middle[k]) >= sensor.least_swing]
            rows = [at for end in far if len(at := _plateau(signal[:, k], end))]
            plateaus += [(k, np.sort(np.concatenate(rows)))] if rows else []
        if plateaus:
            found.append(_finding(recording.t, signal, sensor, plateaus))
    return found


def _plateau(x: Signal, end: float) -> NDArray[np.intp]:
    """Return the rows at which an axis stands at this end of its range; none if it is no plateau."""
    at = np.flatnonzero(np.abs(x - end) <= ROUNDING * abs(end))
    return at if len(at) >= PLATEAU and _is_clipped(x, at) else at[:0]


def _is_clipped(x: Signal, at: NDArray[np.intp]) -> bool:
    """Tell a plateau that is entered steeply from the flat top of a smooth peak."""
    breaks = np.flatnonzero(np.diff(at) > 1)
    first, last = at[np.append(0, breaks + 1)], at[np.append(breaks, len(at) - 1)]
    longest = int((last - first).max()) + 1
    neighbours = np.concatenate((x[np.maximum(first - 1, 0)], x[np.minimum(last + 1, len(x) - 1)]))
    steps = np.abs(neighbours - x[at[0]])
    steps = steps[np.isfinite(steps) & (steps > 0)]
    if not len(steps):
        return False
    return longest >= PLATEAU * _repeats(x) and bool(np.median(steps) > STEEP * quantum_of(some_values(x)))


def _repeats(x: Signal) -> float:
    """Return how often the logger repeats each sample, by the changes among some rows."""
    rows = some_rows(len(x) - 1)
    return len(rows) / max(int(np.count_nonzero(x[rows + 1] != x[rows])), 1)


def _finding(
    t: Signal, signal: Signal, sensor: _Sensor, plateaus: list[tuple[int, NDArray[np.intp]]]
) -> Finding:
    rows = np.unique(np.concatenate([rows for _, rows in plateaus]))
    axis, at = min(plateaus, key=lambda plateau: plateau[1][0])
    end = float(signal[at[0], axis])
    near = min(sensor.ranges, key=lambda limit: abs(abs(end) / limit - 1))
    known = ""
    if abs(abs(end) / near - 1) < CLOSE:
        size = near / STANDARD_GRAVITY if sensor.name == "accelerometer" else float(np.rad2deg(near))
        known = f" ({sensor.in_words.format(size)})"
    names = ", ".join("xyz"[k] for k, _ in plateaus)
    text = (
        f"The {sensor.name}'s {names} stand{'s' if len(plateaus) == 1 else ''} at {end:.4g} {sensor.unit}, "
        f"the end of its range{known}, in {len(rows)} rows, first at {t[rows[0]]:.4g} s: the motion went "
        "beyond, and height and velocity are off from there on; set a wider range."
    )
    return Finding("saturation", "warning", text)
