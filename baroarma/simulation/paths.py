"""Smooth courses over time, of which motions are made; each has a continuous acceleration.

Two kinds suffice.  A quintic is the one polynomial that meets position, velocity and acceleration at both
ends of an interval; free flight, being a parabola, is the quintic between its own ends.  And a time that
begins to run smoothly turns every periodic movement into one that starts from rest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from baroarma.simulation.jet import Jet

Signal = NDArray[np.float64]
Knot = tuple[float, float, float, float]
"""Time, position, velocity, acceleration."""


def through(t: Signal, knots: Sequence[Knot]) -> Jet:
    """Return the course through knots, a quintic between each two of them.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Time, s.
    knots : sequence of Knot
        At least two, in order; the first and the last at rest, for there the course stays outside.

    Returns
    -------
    Jet
        Position with velocity and acceleration, continuous all three.

    Examples
    --------
    >>> through(np.array([-1.0, 0.5, 3.0]), [(0, 0, 0, 0), (1, 2, 0, 0)]).value
    array([0., 1., 2.])
    """
    table = np.asarray(knots, float)
    k = np.clip(np.searchsorted(table[:, 0], t, side="right") - 1, 0, len(table) - 2)
    start, end = table[k].T, table[k + 1].T
    T = end[0] - start[0]
    u = np.clip((t - start[0]) / T, 0.0, 1.0)
    x, v, a = (end[i] * T ** (i - 1) for i in (1, 2, 3))
    x0, v0, a0 = (start[i] * T ** (i - 1) for i in (1, 2, 3))
    # what the parabola of the start leaves to be made up at the end: in position, slope and curvature
    dx, dv, da = x - x0 - v0 - a0 / 2, v - v0 - a0, (a - a0) / 2
    c3, c4, c5 = 10 * dx - 4 * dv + da, -15 * dx + 7 * dv - 2 * da, 6 * dx - 3 * dv + da
    value = x0 + u * (v0 + u * (a0 / 2 + u * (c3 + u * (c4 + u * c5))))
    first = v0 + u * (a0 + u * (3 * c3 + u * (4 * c4 + u * 5 * c5)))
    second = a0 + u * (6 * c3 + u * (12 * c4 + u * 20 * c5))
    return Jet(value, first / T, second / T**2)


def eased(t: Signal, start: float, length: float) -> Jet:
    """Return the smooth step from 0 before `start` (s) to 1 after `length` more seconds."""
    return through(t, [(start, 0.0, 0.0, 0.0), (start + length, 1.0, 0.0, 0.0)])


def running(t: Signal, start: float, rise: float) -> Jet:
    """Return a time that stands at 0 until `start` and runs at full pace `rise` seconds later (both s).

    The pace rises as 3u² - 2u³, so the lost time is rise/2.
    """
    since = np.maximum(t - start, 0.0)
    u = np.minimum(since / rise, 1.0)
    return Jet(
        rise * (u**3 - u**4 / 2) + np.maximum(since - rise, 0.0),
        u**2 * (3 - 2 * u),
        6 * u * (1 - u) / rise,
    )


def folded(t: Signal, start: float, period: float) -> tuple[Signal, Signal]:
    """Return how often a movement that begins at `start` has been repeated, and t as if it never had (s).

    Examples
    --------
    >>> folded(np.array([1.0, 6.0, 17.0]), start=5.0, period=10.0)
    (array([0., 0., 1.]), array([1., 6., 7.]))
    """
    times = np.maximum(np.floor((t - start) / period), 0.0)
    return times, t - times * period


def running_for(t: Signal, start: float, rise: float, amount: float) -> Jet:
    """Return a time that runs from 0 to `amount` (s) and rises and ebbs over `rise` seconds each."""
    return running(t, start, rise) - running(t, start + amount, rise)
