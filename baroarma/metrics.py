"""How far a track is from a reference, and how late the reference itself is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.recording import Recording
from baroarma.track import Track

Signal = NDArray[np.float64]
ZEROED_OVER: Final = 1.0
"""Seconds at the start over which track and reference are both zeroed."""
DIFFERENTIATED_OVER: Final = 0.2
"""Seconds around an instant over which a reference without velocity is differentiated."""
ASIDE: Final = 0.1
"""Seconds beside the best lag at which the velocities must fit worse,"""
SHARP: Final = 1.03
"""by this factor of the variance left unexplained: real hand motions make 1.06 to 1.25, a lift at constant
speed 1.004 (chosen by us)."""
LAG_STEP: Final = 0.005
"""Grid of the lags that are tried, s; a parabola goes between them."""
ENOUGH_CORRELATION: Final = 0.7
"""A reference that correlates less with the track says nothing about its lag (chosen by us)."""
MOVING: Final = 0.01
"""Nor does one whose velocity has a smaller sd, m/s."""


@dataclass(frozen=True)
class Errors:
    """Hold the errors of one track; None where the reference doesn't tell.

    Parameters
    ----------
    height_rmse, height_bias : float or None
        Root mean square and mean of height minus reference, m [SG14, Eq. 28].
    velocity_rmse : float or None
        Root mean square of velocity minus reference velocity, m/s.
    closure : float
        Height over the last second, m: what a ride that ends where it began should leave at 0.

    Examples
    --------
    A track that jumps to 2 m after the first second of four, while the reference stays where it is:

    >>> from baroarma.recording import Recording
    >>> t = np.arange(40) / 10
    >>> ride = Recording(t=t, pressure=np.full(40, 101325.0), reference=np.zeros(40))
    >>> found = errors(Track(t, np.where(t < 1, 0.0, 2.0), *np.zeros((4, 40))), ride)
    >>> found.height_bias, round(found.height_rmse**2, 6), found.closure  # 3/4 of 2 m, 3/4 of 4 m²
    (1.5, 3.0, 2.0)
    """

    height_rmse: float | None
    height_bias: float | None
    velocity_rmse: float | None
    closure: float


def errors(track: Track, recording: Recording, *, reference_lag: float = 0.0) -> Errors:
    """Compare a track with the recording's reference, both zeroed over the reference's first second.

    Parameters
    ----------
    track : Track
        A track of the recording.
    recording : Recording
        With `reference`, and `reference_velocity` or else the reference's derivative.
    reference_lag : float
        How late the reference is, s; it is shifted back by so much.

    Examples
    --------
    >>> from baroarma.simulation import BMP085, simulate
    >>> from baroarma.tracker import Tracker
    >>> stairs = simulate("stairs", duration=60, seed=1)
    >>> found = errors(Tracker(noise=BMP085.noise).run(stairs), stairs)
    >>> found.height_rmse < 0.1, found.velocity_rmse < 0.02
    (True, True)
    """
    t = track.t
    closure = float(np.mean(track.height[t >= t[-1] - ZEROED_OVER]))
    found = reference_at(recording, t, reference_lag)
    known = np.isfinite(found[0]) if found else np.zeros(len(t), np.bool_)
    if found is None or not known.any():
        return Errors(None, None, None, closure)
    height, velocity = found
    start = known & (t - t[known][0] < ZEROED_OVER)
    off = track.height - height
    off = (off - np.mean(off[start]))[known]
    moving = np.isfinite(velocity)
    return Errors(
        height_rmse=_rms(off),
        height_bias=float(np.mean(off)),
        velocity_rmse=_rms((track.velocity - velocity)[moving]) if moving.any() else None,
        closure=closure,
    )


def reference_at(recording: Recording, t: Signal, lag: float) -> tuple[Signal, Signal] | None:
    """Return reference height and velocity at times t, NaN where unknown; None without a reference.

    A reference without velocity is differentiated over the `DIFFERENTIATED_OVER` seconds around each instant,
    so that a laser's millimetre steps do not become spikes.

    Parameters
    ----------
    recording : Recording
        With or without `reference`.
    t : ndarray, shape (n,)
        Times on the recording's clock, s.
    lag : float
        How late the reference is, s: what it says at t + lag held at t.

    Returns
    -------
    tuple of ndarray, each of shape (n,), or None
        Height in m and velocity in m/s, up.

    Examples
    --------
    A lift at 0.5 m/s, seen 0.2 s late:

    >>> from baroarma.recording import Recording
    >>> t = np.arange(0, 10, 0.1)
    >>> ride = Recording(t=t, pressure=np.full(100, 101325.0), reference=0.5 * (t - 0.2))
    >>> height, velocity = reference_at(ride, np.array([4.0, 5.0]), lag=0.2)
    >>> height.round(6).tolist(), velocity.round(6).tolist()
    ([2.0, 2.5], [0.5, 0.5])
    """
    if recording.reference is None or not np.isfinite(recording.reference).any():
        return None
    good = np.isfinite(recording.reference)
    source_t, source = recording.t[good] - lag, recording.reference[good]
    height = np.interp(t, source_t, source, left=np.nan, right=np.nan)
    if recording.reference_velocity is not None:
        velocity = np.interp(t, source_t, recording.reference_velocity[good], left=np.nan, right=np.nan)
        return height, velocity
    half = DIFFERENTIATED_OVER / 2
    later, earlier = (np.interp(t + s * half, source_t, source, np.nan, np.nan) for s in (+1, -1))
    return height, (later - earlier) / (2 * half)


def estimate_reference_lag(track: Track, recording: Recording, longest: float = 0.6) -> float | None:
    """Estimate how late the reference is against the IMU, s.

    The lag at which the reference's velocity correlates best with the track's; the inertial velocity has no
    lag of its own worth the name.

    Parameters
    ----------
    track : Track
        A track of the recording that used its IMU.
    recording : Recording
        With a reference.
    longest : float
        Lags up to so many seconds, late or early, are tried.

    Returns
    -------
    float or None
        None when the reference hardly moves or hardly correlates, the best lag is the longest, or another one
        is about as good.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from baroarma.simulation import BMP085, simulate
    >>> from baroarma.tracker import Tracker
    >>> squats = simulate("squat", duration=30, seed=1)
    >>> track = Tracker(noise=BMP085.noise).run(squats)
    >>> late = replace(squats, reference=np.roll(squats.reference, 10), reference_velocity=None)
    >>> abs(estimate_reference_lag(track, late) - 10 / 50) < 0.02
    True
    """
    lags = LAG_STEP * np.arange(-round(longest / LAG_STEP), round(longest / LAG_STEP) + 1)
    scores = np.array([_correlation(track, recording, lag) for lag in lags])
    best = int(np.argmax(scores))
    if scores[best] < ENOUGH_CORRELATION or not 0 < best < len(lags) - 1:
        return None
    aside = [_correlation(track, recording, lags[best] + shift) for shift in (-ASIDE, ASIDE)]
    if 1 - max(aside) ** 2 < SHARP * (1 - scores[best] ** 2):
        return None  # a slow motion fits about as well at any lag
    left, top, right = scores[best - 1 : best + 2]  # the first of the largest: left < top
    return float(lags[best] + LAG_STEP / 2 * (left - right) / (left - 2 * top + right))


def _correlation(track: Track, recording: Recording, lag: float) -> float:
    """Correlation of the velocities, -1 where there is too little to correlate."""
    found = reference_at(recording, track.t, lag)
    if found is None:
        return -1.0
    known = np.isfinite(found[1])
    a, b = track.velocity[known], found[1][known]
    if len(a) < 3 or np.std(a) < MOVING or np.std(b) < MOVING:
        return -1.0
    return float(np.corrcoef(a, b)[0, 1])


def _rms(x: Signal) -> float:
    return float(np.sqrt(np.mean(x**2)))
