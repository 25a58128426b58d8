"""Total climb and descent of a track, and the floors that were climbed.

A noisy height climbs without end: summing up |dh| over every sample counts each wiggle of the error, the more
the higher the rate.  Only *swings* count here: from one turning point to the next, where a turn is believed
once the height has come back from its extreme by a threshold.  (The same hysteresis precedes rainflow
counting of load cycles, and chart readers call it zigzag.)  What is counted then is a property of the motion
at that threshold; smaller ups and downs, such as the trunk's bounce at each step, are left out.

By default the threshold follows from the track's own sds.  The errors of two rows are correlated, so that
their difference is much smaller than either over a short lag.  In the steady state of the two-state Kalman
filter (and of the complementary filter with its gain) height and velocity errors have the autocovariance
exp((F - K H) lag) P, of which the height's part is

    rho(lag) = exp(-x) cos(x),      x = lag sigma_v / (sqrt(2) sigma_h),

so that sd(h(t + lag) - h(t))² = 2 sigma_h² (1 - rho) + d² lag.  d² is the rate at which sigma_h² grows where
the barometer drifts; that part of sigma_h² is in both rows, and is taken off it first.  A swing must be
`BELIEVED` of these sds high, and at least `LEAST` metres.

Who rests on top of a stair gives the error time to reach an extreme, and the highest row is too high.  The
height of a turn is therefore the mean of the rows around it that lie within `PLATEAU` sds of the extreme.
The sds of the sums come from the same covariance over all turning points.  They don't know that warm air
stretches all heights, nor what an attitude filter gets wrong.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.track import Track

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
GROWTH: Final = 60.0
"""Over how many s the growth of the height's variance is measured (chosen by us)."""
PLATEAU: Final = 2.0
"""Standard deviations of the change within which a row is not told from a turn's extreme."""
FORGOTTEN: Final = 20.0
"""Lag, as x in the formula above, beyond which errors are independent: exp(-20) = 2e-9."""


@dataclass(frozen=True, eq=False, repr=False)
class Climb:
    """Hold how far a track went up and down.

    Parameters
    ----------
    ascent, descent : float
        Sums of the swings up and down, m, both positive.
    ascent_sd, descent_sd : float
        Their standard deviations, m.
    floors_up, floors_down : int
        Floors climbed and descended.
    t, height : ndarray, shape (m,)
        Times in s and heights in m of the turning points, the first and last extreme among them; none when
        nothing moved.  What goes up between them is the ascent, what goes down the descent.
    name : str
        Name of the recording.

    Examples
    --------
    Up a stair of 3 m, down by half of it, up to 4 m; the ripple of 5 cm is no climbing:

    >>> t = np.linspace(0, 60, 601)
    >>> height = np.interp(t, [0, 20, 40, 60], [0, 3, 1.5, 4]) + 0.05 * np.sin(10 * t)
    >>> found = climb(Track(t, height, np.zeros(601), *np.full((2, 601), 0.05), np.zeros(601)), threshold=0.5)
    >>> round(found.ascent, 1), round(found.descent, 1)  # 3 + 2.5 and 1.5, and the ripple at the turns
    (5.6, 1.6)
    >>> found.t.round().tolist()
    [0.0, 20.0, 40.0, 60.0]
    """

    ascent: float
    descent: float
    ascent_sd: float
    descent_sd: float
    floors_up: int
    floors_down: int
    t: Signal
    height: Signal
    name: str = ""

    def __repr__(self) -> str:
        return (
            f"<Climb of {self.name!r}: up {self.ascent:.2f} ± {self.ascent_sd:.2f} m, down "
            f"{self.descent:.2f} ± {self.descent_sd:.2f} m, floors {self.floors_up} up, {self.floors_down} "
            "down>"
        )

    def summary(self) -> str:
        """Return the result as a sentence."""
        swings = len(self.t) - 1
        turns = f"in {swings} swing" + "s" * (swings > 1) if swings > 0 else "without a swing"
        return (
            f"climbs {self.ascent:.2f} m (sd {self.ascent_sd:.2g}), descends {self.descent:.2f} m (sd "
            f"{self.descent_sd:.2g}) {turns}; floors: {self.floors_up} up, {self.floors_down} down"
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON object: metres, floors, and the turning points as lists."""
        return {
            "ascent_m": self.ascent,
            "ascent_sd_m": self.ascent_sd,
            "descent_m": self.descent,
            "descent_sd_m": self.descent_sd,
            "floors_up": self.floors_up,
            "floors_down": self.floors_down,
            "turning_points": {"time_s": self.t.tolist(), "height_m": self.height.tolist()},
        }

    def _repr_html_(self) -> str:
        up = ("up", self.ascent, self.ascent_sd, self.floors_up)
        down = ("down", self.descent, self.descent_sd, self.floors_down)
        body = "".join(
            f"<tr><th>{word}</th><td>{metres:.2f}</td><td>{sd:.2f}</td><td>{floors}</td></tr>"
            for word, metres, sd, floors in (up, down)
        )
        head = "<tr><th></th><th>m</th><th>sd m</th><th>floors</th></tr>"
        return f"<table><caption>{escape(self.name)}</caption>{head}{body}</table>"

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the swings; see `baroarma.plotting.climb.plot_climb`."""
        from baroarma.plotting.climb import plot_climb

        return plot_climb(self, ax)


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
        track's own sds make believable (module docstring), at least 0.2 m.
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
    errors = _Errors(track)
    least, sds = (LEAST, BELIEVED) if threshold is None else (threshold, 0.0)
    turns, height = _turns(track.height, errors, least, sds)
    step = np.diff(height)
    gap = floor_height if levels is None else float(np.diff(levels).min())
    counted = _floors(_turns(track.height, errors, gap / 2, BELIEVED)[1], gap, levels)
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


def _turns(height: Signal, errors: _Errors, least: float, sds: float) -> tuple[NDArray[np.intp], Signal]:
    """Return the rows of the turning points and their heights, each that of its plateau if `sds` count."""
    turns = turning_points(height, errors, least, sds)
    if not sds:
        return turns, height[turns]
    around = [0, *turns.tolist(), len(height) - 1]
    levels = [errors.level(height, *around[k : k + 3]) for k in range(len(turns))]
    return turns, np.array(levels)


class _Errors:
    """The errors of a track's heights, as the module's docstring has them."""

    def __init__(self, track: Track) -> None:
        self.t = track.t - track.t[0]
        self.growth = _growth(self.t, track.height_sd**2)
        own = track.height_sd**2 - self.growth * self.t
        # what the drift leaves is at least what the velocity's error makes of a second
        self.sd_now = np.sqrt(np.maximum(own, np.minimum(track.velocity_sd, track.height_sd) ** 2))
        rate = track.velocity_sd / (math.sqrt(2) * np.maximum(self.sd_now, 1e-12))
        self.x = np.concatenate(([0.0], np.cumsum(np.diff(self.t) * rate[1:])))

    def change_sd(self, i: int, j: int) -> float:
        """Return the sd of the change of height from row i to a later row j."""
        a, b, x = self.sd_now[i], self.sd_now[j], self.x[j] - self.x[i]
        rho = math.exp(-x) * math.cos(x)
        return math.sqrt((a - b) ** 2 + 2 * a * b * (1 - rho) + self.growth * (self.t[j] - self.t[i]))

    def level(self, height: Signal, before: int, turn: int, after: int) -> float:
        """Return the mean height around a turn, of the unbroken rows that are not told from its extreme."""
        rows = slice(before, after + 1)
        x, lag = np.abs(self.x[rows] - self.x[turn]), np.abs(self.t[rows] - self.t[turn])
        a, b = self.sd_now[turn], self.sd_now[rows]
        variance = (a - b) ** 2 + 2 * a * b * (1 - np.exp(-x) * np.cos(x)) + self.growth * lag
        away = np.flatnonzero(np.abs(height[rows] - height[turn]) > PLATEAU * np.sqrt(variance))
        k = int(np.searchsorted(away, turn - before))
        first = int(away[k - 1]) + 1 if k else 0
        last = int(away[k]) if k < len(away) else after + 1 - before
        return float(height[before + first : before + last].mean())

    def sd(self, turns: NDArray[np.intp], chosen: NDArray[np.bool_]) -> float:
        """Return the sd of the sum of the chosen swings between the turning points."""
        if not chosen.any():
            return 0.0
        weight = np.append(0.0, chosen) - np.append(chosen, 0.0)
        weight, x = weight * self.sd_now[turns], self.x[turns]
        variance = self.growth * float(np.diff(self.t[turns])[chosen].sum())
        for i, end in enumerate(np.searchsorted(x, x + FORGOTTEN)):
            lag = x[i + 1 : end] - x[i]
            variance += weight[i] ** 2 + 2 * weight[i] * float(
                weight[i + 1 : end] @ (np.exp(-lag) * np.cos(lag))
            )
        return math.sqrt(max(variance, 0.0))


def _growth(t: Signal, variance: Signal) -> float:
    """Return the median rate at which the height's variance grows, m²/s; 0 in less than a minute."""
    later = np.searchsorted(t, t + GROWTH)
    there = later < len(t)
    if not there.any():
        return 0.0
    rate = (variance[later[there]] - variance[there]) / (t[later[there]] - t[there])
    return max(float(np.median(rate)), 0.0)


def turning_points(height: Signal, errors: _Errors, least: float, sds: float) -> NDArray[np.intp]:
    """Return the rows where the height turns, the first and last extreme among them; none without a swing.

    A turn is believed at the first local extreme that is `least` m and `sds` standard deviations of the
    change away from the extreme so far.
    """

    def believed(i: int, j: int) -> bool:
        size = abs(h[j] - h[i])
        return bool(size >= least and size >= sds * errors.change_sd(i, j))

    h = height.tolist()
    turns: list[int] = []
    low = high = 0
    going = 0
    for j in _extremes(height):
        if going >= 0 and h[j] > h[high]:
            high = j
        if going <= 0 and h[j] < h[low]:
            low = j
        if going <= 0 and h[j] > h[low] and believed(low, j):
            turns.append(low)
            going, high = 1, j
        elif going >= 0 and h[j] < h[high] and believed(high, j):
            turns.append(high)
            going, low = -1, j
    if going:
        turns.append(high if going > 0 else low)
    return np.array(turns, dtype=np.intp)


def _extremes(height: Signal) -> list[int]:
    """Return the rows higher or lower than both neighbours (of equal ones the last), and the ends."""
    step = np.diff(height)
    moved = np.flatnonzero(step)
    turned = moved[:-1][np.sign(step[moved[1:]]) != np.sign(step[moved[:-1]])] + 1
    return [0, *turned.tolist(), len(height) - 1]


def _floors(turns: Signal, gap: float, levels: Signal | None) -> NDArray[np.intp]:
    """Return how many floors lie between successive turning points, negative downwards."""
    if levels is not None:
        nearest = np.abs(turns[:, None] - levels).argmin(axis=1)
        return np.asarray(np.diff(nearest), dtype=np.intp)
    step = np.diff(turns)
    whole = np.minimum(np.floor(np.abs(step) / gap + 1 - FLOOR_SHARE), 1e9)  # of a track that ran away
    return np.asarray(np.sign(step) * whole, dtype=np.intp)
