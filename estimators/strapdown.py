"""Bourke's off-line method: strapdown between quasi-static periods, de-drifted from both ends.

Where the device is quasi-static the accelerometer gives the vertical, and the velocity is 0.  In between, the
gyro carries the vertical along; what it misses at the next quasi-static period is spread linearly over the
time in between, and so is the velocity that the integrated acceleration ends with [SG14, Sec. 2.3.4, after
Bourke et al. 2008].  The barometer has no part in it.  SG14 used it as the reference for squats.

The thresholds of the quasi-static periods and the sds are chosen by us; SG14 quotes 0.1 m/s for the velocity.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import njit
from baroarma.finding import Finding
from baroarma.recording import Recording
from baroarma.track import Track

Signal = NDArray[np.float64]
WINDOW: Final = 0.5
"""Seconds over which an instant must be quiet to be quasi-static; the longest rest lasts as long at least."""
QUIET_ACCELERATION: Final = 0.15
"""Largest sd of the specific force's modulus in the window, m/s²."""
QUIET_RATE: Final = 0.1
"""Largest rms angular rate in the window, rad/s."""
SHORTEST_REST: Final = 0.1
"""Seconds that a quasi-static period must last: the window around each of its instants is quiet besides."""
VELOCITY_SD: Final = 0.1
"""Sd of the velocity in motion, m/s [SG14, Sec. 4, of the method's own validation]."""
REST_SD: Final = 0.01
"""Sd of the velocity at rest, m/s."""
VELOCITY_MEMORY: Final = 1.0
"""Seconds over which that error keeps its sign, for the height's sd."""


def bourke_track(recording: Recording) -> Track:
    """Track a recording by Bourke's method.

    Parameters
    ----------
    recording : Recording
        With accelerometer and gyro, beginning at rest.

    Returns
    -------
    Track
        Height and velocity, with a finding when the recording has no rest at its start or end.

    Raises
    ------
    ValueError
        If there is no quasi-static period at all.
    """
    assert recording.accel is not None
    assert recording.gyro is not None
    t = recording.t
    accel, gyro = (_without_gaps(t, signal) for signal in (recording.accel, recording.gyro))
    static, gravity = _rests(t, accel, gyro)
    if not static.any():
        raise ValueError(
            f"{recording.name or 'the recording'} has no quasi-static period, between which bourke08 works; "
            "take an on-line preset"
        )
    gyro = gyro - np.median(gyro[static], axis=0)
    acceleration, velocity = np.zeros(len(t)), np.zeros(len(t))
    for start, stop in periods(~static):
        before, after = _vertical(accel, static, start - 1, -1), _vertical(accel, static, stop, +1)
        rows = slice(max(start - 1, 0), min(stop + 1, len(t)))
        up = _carry(t[rows], gyro[rows], before, after)
        acceleration[rows] = np.einsum("ij,ij->i", accel[rows], up) - gravity
        velocity[rows] = _between_rests(t[rows], acceleration[rows], before is not None, after is not None)
    steps = np.diff(t, prepend=t[:1])
    return Track(
        t,
        height=_integral(t, velocity),
        velocity=velocity,
        height_sd=np.sqrt(1e-6 + VELOCITY_SD**2 * VELOCITY_MEMORY * np.cumsum(steps * ~static)),
        velocity_sd=np.where(static, REST_SD, VELOCITY_SD),
        acceleration=acceleration,
        preset="bourke08",
        name=recording.name,
        findings=_findings(static),
    )


def _between_rests(t: Signal, acceleration: Signal, from_rest: bool, to_rest: bool) -> Signal:
    """Integrate to the velocity, which is 0 wherever there is rest; the drift is spread linearly."""
    velocity = _integral(t, acceleration)
    if not to_rest:
        return velocity
    share = (t - t[0]) / (t[-1] - t[0]) if from_rest else 1.0
    return np.asarray(velocity - velocity[-1] * share)


def quasi_static(t: Signal, accel: Signal, gyro: Signal) -> NDArray[np.bool_]:
    """Return where the device is quasi-static, (n,): quiet over the whole window around the instant."""
    half = _half_window(t)
    modulus = np.linalg.norm(accel, axis=1)
    spread = _moving_mean(modulus**2, half) - _moving_mean(modulus, half) ** 2
    rate = _moving_mean(np.sum((gyro - np.median(gyro, axis=0)) ** 2, axis=1), half)
    return (spread < QUIET_ACCELERATION**2) & (rate < QUIET_RATE**2)


def _rests(t: Signal, accel: Signal, gyro: Signal) -> tuple[NDArray[np.bool_], float]:
    """Return where there is rest, and the modulus of the specific force there.

    The turning points of a squat are quiet, too, and so is its gentle start, but there the force is not that
    of the longest rest (its median: a rest may have a gentle end).
    """
    static = _long_enough(t, quasi_static(t, accel, gyro))
    longest = max(periods(static), key=lambda rest: t[rest[1] - 1] - t[rest[0]], default=(0, 1))
    if t[longest[1] - 1] - t[longest[0]] < WINDOW:
        return np.zeros(len(t), np.bool_), 0.0
    modulus = np.linalg.norm(accel, axis=1)
    gravity = float(np.median(modulus[slice(*longest)]))
    still = np.abs(_moving_mean(modulus, _half_window(t)) - gravity) < QUIET_ACCELERATION
    return _long_enough(t, static & still), gravity


def _long_enough(t: Signal, static: NDArray[np.bool_]) -> NDArray[np.bool_]:
    for start, stop in periods(static):
        static[start:stop] = t[stop - 1] - t[start] >= SHORTEST_REST
    return static


def periods(which: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return first row and row after the last of each run of True.

    Examples
    --------
    >>> periods(np.array([True, False, True, True]))
    [(0, 1), (2, 4)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate(([False], which, [False])).astype(int)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _half_window(t: Signal) -> int:
    return max(1, round(0.5 * WINDOW / float(np.median(np.diff(t)))))


def _moving_mean(x: Signal, half: int) -> Signal:
    """Centred mean over 2 half + 1 samples, fewer at the ends."""
    total = np.concatenate(([0.0], np.cumsum(x)))
    low = np.maximum(np.arange(len(x)) - half, 0)
    high = np.minimum(np.arange(len(x)) + half + 1, len(x))
    return np.asarray((total[high] - total[low]) / (high - low))


def _vertical(accel: Signal, static: NDArray[np.bool_], row: int, direction: int) -> Signal | None:
    """Mean direction of the specific force over the quasi-static period that begins at a row."""
    if not 0 <= row < len(static):
        return None
    rest = static[row::direction]
    length = len(rest) if rest.all() else int(np.argmin(rest))
    mean = accel[row::direction][:length].mean(axis=0)
    return np.asarray(mean / np.linalg.norm(mean))


def _carry(t: Signal, gyro: Signal, before: Signal | None, after: Signal | None) -> Signal:
    """Carry the vertical (body axes) through a period; spread what it misses at the end."""
    if before is None:
        assert after is not None
        return _rotate(-t[::-1], -gyro[::-1], after, np.zeros(3))[::-1]
    if after is None:
        return _rotate(t, gyro, before, np.zeros(3))
    end = _rotate(t, gyro, before, np.zeros(3))[-1]
    axis = np.cross(end, after)
    norm = float(np.linalg.norm(axis))
    angle = np.arctan2(norm, float(end @ after))
    return _rotate(t, gyro, before, axis / norm * angle if norm > 0 else np.zeros(3))


@njit(cache=True)
def _rotate(t: Signal, gyro: Signal, up: Signal, correction: Signal) -> Signal:
    """Rotate the vertical with minus the midpoint rate, then by the share of the correction so far."""
    out = np.empty((len(t), 3))
    now = up.copy()
    for k in range(len(t)):
        if k > 0:
            now = _turn(now, -0.5 * (gyro[k] + gyro[k - 1]) * (t[k] - t[k - 1]))
        out[k] = _turn(now, correction * ((t[k] - t[0]) / (t[-1] - t[0])))
    return out


@njit(cache=True)
def _turn(v: Signal, rotation: Signal) -> Signal:
    """Rodrigues' formula."""
    angle = np.sqrt(np.sum(rotation**2))
    if angle < 1e-12:
        return v.copy()
    k = rotation / angle
    turned: Signal = (
        v * np.cos(angle) + np.cross(k, v) * np.sin(angle) + k * np.sum(k * v) * (1 - np.cos(angle))
    )
    return turned


def _integral(t: Signal, x: Signal) -> Signal:
    return np.concatenate(([0.0], np.cumsum(0.5 * (x[1:] + x[:-1]) * np.diff(t))))


def _without_gaps(t: Signal, signal: Signal) -> Signal:
    """Interpolate rows without a sample."""
    good = np.isfinite(signal).all(axis=1)
    if not good.any():
        raise ValueError("the recording has no complete IMU sample")
    return np.stack([np.interp(t, t[good], signal[good, i]) for i in range(3)], axis=1)


def _findings(static: NDArray[np.bool_]) -> tuple[Finding, ...]:
    ends = [where for where, row in (("start", 0), ("end", -1)) if not static[row]]
    if not ends:
        return ()
    message = f"There is no rest at the {' and '.join(ends)}: the drift there is not taken out."
    return (Finding("no-rest", "warning", message),)
