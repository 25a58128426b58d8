"""Where a noisy height turns: the first local extremes that its errors do not make.

A turn is believed once the height has come back from its extreme by a threshold.  (The same hysteresis
precedes rainflow counting of load cycles, and chart readers call it zigzag.)  The threshold is so many sds of
the *change* of height.  The errors of two rows are correlated, so that their difference is much smaller than
either over a short lag.  In the steady state of the two-state Kalman filter (and of the complementary filter
with its gain) height and velocity errors have the autocovariance exp((F - K H) lag) P, of which the height's
part is

    rho(lag) = exp(-x) cos(x),      x = lag sigma_v / (sqrt(2) sigma_h),

so that sd(h(t + lag) - h(t))² = 2 sigma_h² (1 - rho) + d² lag.  d² is the rate at which sigma_h² grows where
the barometer drifts; that part of sigma_h² is in both rows, and is taken off it first.

Who rests on top of a stair gives the error time to reach an extreme, and the highest row is too high.  The
height of a turn is therefore the mean of the rows around it that lie within `PLATEAU` sds of the extreme.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.track import Track

Signal = NDArray[np.float64]
GROWTH: Final = 60.0
"""Over how many s the growth of the height's variance is measured (chosen by us)."""
PLATEAU: Final = 2.0
"""Standard deviations of the change within which a row is not told from a turn's extreme."""
FORGOTTEN: Final = 20.0
"""Lag, as x in the formula above, beyond which errors are independent: exp(-20) = 2e-9."""


def find_turns(
    height: Signal, errors: HeightErrors, least: float, sds: float
) -> tuple[NDArray[np.intp], Signal]:
    """Return the rows of the turning points and their heights, each that of its plateau if `sds` count."""
    turns = turning_points(height, errors, least, sds)
    if not sds:
        return turns, height[turns]
    around = [0, *turns.tolist(), len(height) - 1]
    levels = [errors.level(height, *around[k : k + 3]) for k in range(len(turns))]
    return turns, np.array(levels)


def turning_points(height: Signal, errors: HeightErrors, least: float, sds: float) -> NDArray[np.intp]:
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


class HeightErrors:
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
