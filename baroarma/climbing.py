"""Total climb and descent of a track, and the floors that were climbed.

A noisy height climbs without end: summing up |dh| over every sample counts each wiggle of the error, the more
the higher the rate.  Only *swings* count here, from one of `baroarma.turning_points` to the next.  By default
a swing must be `BELIEVED` of its sds high, which follow from the track's own, and at least `LEAST` metres.
What is counted then is a property of the motion at that threshold; smaller ups and downs, such as the trunk's
bounce at each step, are left out.

The sds of the sums come from the same covariance over all turning points.  They don't know that warm air
stretches all heights, nor what an attitude filter gets wrong.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.climbed import Climb
from baroarma.track import Track
from baroarma.turning_points import HeightErrors, find_turns

Signal = NDArray[np.float64]
LEAST: Final = 0.2
"""Least swing that counts by default, m: more than a trunk bounces in a step (chosen by us)."""
BELIEVED: Final = 5.0
"""Standard deviations of a change of height that hardly an error makes, of the many that there are in a track
(chosen by us: at 4, one level walk of three minutes in ten has a false swing, at 5 none of thirty)."""
FLOOR: Final = 3.0
"""Height of a floor by default, m (10 feet, as phones and watches count)."""
FLOOR_SHARE: Final = 0.75
"""Share of a floor that must be climbed for it to count: a half landing is none (chosen by us)."""


def climb(
    track: Track,
    *,
    threshold: float | None = None,
    floor_height: float = FLOOR,
    floors: Sequence[float] | None = None,
) -> Climb:
    """Add up how far a track went up and down, and count floors.

    Parameters
    ----------
    track : Track
        Of a tracker.
    threshold : float, optional
        Swings smaller than so many metres don't count, larger ones do, from extreme to extreme and whatever
        the sds say.  Raised, it hides small ups and downs; lowered, it counts noise.  Default: what the
        track's own sds make believable (`baroarma.turning_points`), at least 0.2 m.
    floor_height : float
        Height of a floor, m.  Counted is each floor of an ascent that is broken by no descent of half a
        floor; three quarters of a floor count as one, half a floor as none.
    floors : sequence of float, optional
        Heights of known floors above the start, m, in any order.  Then counted is how many floors lie
        between the floors nearest to successive turning points, and `floor_height` has no effect.

    Returns
    -------
    Climb
        Metres with their sds, floors, turning points.

    Raises
    ------
    ValueError
        If threshold or floor height is not positive, or fewer than two floors are known.

    Examples
    --------
    >>> from baroarma.simulation import BMP085, simulate
    >>> from baroarma.tracker import Tracker
    >>> log = simulate("stairs", duration=90, floor_height=3.2, steps=18, seed=1)
    >>> climb(Tracker(noise=BMP085.noise).run(log))
    <Climb of 'stairs': up 9.6... ± 0.1... m, down 0.00 ± 0.00 m, floors 3 up, 0 down>
    """
    levels = _check(threshold, floor_height, floors)
    if not len(track):
        return Climb(0.0, 0.0, 0.0, 0.0, 0, 0, track.t, track.height, track.name)
    errors = HeightErrors(track)
    least, sds = (LEAST, BELIEVED) if threshold is None else (threshold, 0.0)
    turns, height = find_turns(track.height, errors, least, sds)
    step = np.diff(height)
    gap = floor_height if levels is None else float(np.diff(levels).min())
    counted = _floors(find_turns(track.height, errors, gap / 2, BELIEVED)[1], gap, levels)
    up, down = step > 0, step < 0
    return Climb(
        float(step[up].sum()),
        float(np.abs(step[down]).sum()),
        errors.sd(turns, up),
        errors.sd(turns, down),
        int(counted[counted > 0].sum()),
        int(np.abs(counted[counted < 0]).sum()),
        track.t[turns],
        height,
        track.name,
    )


def _check(threshold: float | None, floor_height: float, floors: Sequence[float] | None) -> Signal | None:
    for name, value in (("threshold", threshold), ("floor height", floor_height)):
        if value is not None and not (math.isfinite(value) and value > 0):
            raise ValueError(f"the {name} must be a positive number of metres, but it is {value}")
    if floors is None:
        return None
    levels = np.unique(np.asarray(floors, float))
    if len(levels) < 2 or not np.isfinite(levels).all():
        raise ValueError(f"floors are the heights of at least two floors in m, but these are {floors!r:.60}")
    return levels


def _floors(turns: Signal, gap: float, levels: Signal | None) -> NDArray[np.intp]:
    """Return how many floors lie between successive turning points, negative downwards."""
    if levels is not None:
        nearest = np.abs(turns[:, None] - levels).argmin(axis=1)
        return np.asarray(np.diff(nearest), dtype=np.intp)
    step = np.diff(turns)
    whole = np.minimum(np.floor(np.abs(step) / gap + 1 - FLOOR_SHARE), 1e9)  # of a track that ran away
    return np.asarray(np.sign(step) * whole, dtype=np.intp)
