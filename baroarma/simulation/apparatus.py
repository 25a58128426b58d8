"""Motions of things: a shelf and a mattress, a rod on a motor, a lift."""

from __future__ import annotations

from math import pi, sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY as G
from baroarma.simulation.jet import Jet, clock
from baroarma.simulation.paths import Knot, eased, folded, running, running_for, through
from baroarma.simulation.pose import FORWARD, LEFT, UP, Pose

Signal = NDArray[np.float64]
REST_BEFORE: Final = 5.0
"""Rest at the start of every motion, s; chosen by us (SG13 and SG14 average over 1 s of it)."""
RELEASE: Final = REST_BEFORE + 3.0
"""When the hand lets go in the free fall, s; chosen by us."""
LETTING_GO: Final = 0.02
"""How long a hand takes to let go, s; chosen by us."""
SETTLING: Final = 2.7
"""How long the second touch of the mattress lasts until rest, as a multiple of speed/g; chosen by us:
shorter, the mattress would have to pull."""
LEAST_DROP: Final = 0.01
"""Lowest shelf, m: lower, the device would land in the hand that lets it go."""


def rest(t: Signal) -> Pose:
    """Lie still."""
    return Pose(0.0 * clock(t))


def circle(t: Signal, *, frequency_hz: float = 0.5, arm: float = 0.30, rise: float = 2.0) -> Pose:
    """Turn in a vertical plane at the end of a rod [SG13, Sec. 2.4; SG14, Sec. 2.3.3].

    The arm of 0.30 m is printed, as are frequencies of 0.25 to 1.5 Hz.  The rod starts level and reaches its
    speed over `rise` s (chosen by us); the sensor turns with it, as SG14's axes say.
    """
    angle = rod_angle(t, frequency_hz=frequency_hz, rise=rise)
    return Pose(0.0 * clock(t), turns=((FORWARD, angle),), lever=(0.0, arm, 0.0))


def rod_angle(t: Signal, *, frequency_hz: float, rise: float) -> Jet:
    """Return the angle of the rod of `circle` above the level, rad."""
    return 2 * pi * frequency_hz * running(t, REST_BEFORE, rise)


def lift(
    t: Signal, *, climb: float = 12.0, speed: float = 0.2, rise: float = 1.5, pause: float = 10.0
) -> Pose:
    """Ride up by `climb` m at a constant speed (m/s), wait for `pause` s, ride down, wait, and again.

    All chosen by us: slow lifts of 0.1 to 1 m/s are what a detector of rest mistakes for it.
    """
    travel = climb / speed
    trips, local = folded(t, REST_BEFORE, travel + rise + pause)
    ride = speed * running_for(local, REST_BEFORE, rise, travel)
    down = trips % 2
    return Pose(climb * down + (1 - 2 * down) * ride)


def free_fall(
    t: Signal, *, height: float = 1.53, rebound: float = 0.35, hump: float = 0.10, tumble: float = 2.0
) -> Pose:
    """Fall from a shelf onto a mattress [SG14, Sec. 2.3.2].

    Rest on the shelf, the hand that grasps and displaces sideways without a change of height, release, fall,
    impact, rebound, second fall, rest on the mattress.  The height of 1.53 m and the phases are printed.
    Chosen by us: the share of the speed that the rebound keeps, the length of the impact `hump` (s; its peak
    of 15 g stays within 16 g, for SG14 saw no saturation) and the tumbling (rad/s).
    """
    flight = _flight(height, rebound, hump)
    moments = [knot[0] for knot in flight]
    grasp, aside = eased(t, REST_BEFORE, 0.8), eased(t, REST_BEFORE + 1.0, 1.5)
    return Pose(
        through(t, flight),
        turns=((UP, 0.2 * aside), (LEFT, 0.1 * grasp), ((0.6, 0.8, 0.0), _tumble(t, moments, tumble))),
        forward=0.4 * aside.second,
    )


def _flight(drop: float, rebound: float, hump: float) -> list[Knot]:
    """Return the knots of the height: release, flight, impact, flight, settling.

    The mattress pushes as u (1 - u)² during the first impact, u running from 0 to 1: steep at first, as a
    mattress that is slow to recover.  Of such a push, 0.6 of the impulse times the duration is height.
    """
    if drop < LEAST_DROP:
        raise ValueError(f"a free fall needs a height of at least {LEAST_DROP} m, but it is {drop:g} m")
    released = RELEASE + LETTING_GO
    speed0, sunk0 = G * LETTING_GO / 2, G * LETTING_GO**2 / 6
    speed = sqrt(speed0**2 + 2 * G * (drop - sunk0))
    touch = released + (speed - speed0) / G
    bounce = rebound * speed
    sunk = hump * (speed - 0.6 * (speed + bounce + G * hump) + G * hump / 2)
    if bounce**2 <= 2 * G * sunk:
        raise ValueError(
            f"a rebound of {rebound:g} after a hump of {hump:g} s doesn't leave the mattress; raise rebound"
        )
    speed2 = sqrt(bounce**2 - 2 * G * sunk)
    touch2 = touch + hump + (bounce + speed2) / G
    return [
        (RELEASE, 0.0, 0.0, 0.0),
        (released, -sunk0, -speed0, -G),
        (touch, -drop, -speed, -G),
        (touch + hump, -drop - sunk, bounce, -G),
        (touch2, -drop, -speed2, -G),
        (touch2 + SETTLING * speed2 / G, -drop, 0.0, 0.0),
    ]


def _tumble(t: Signal, moments: list[float], rate: float) -> Jet:
    """Return the angle of a body that turns evenly in the air, half as fast backwards after the impact."""
    rates = (0.0, rate, rate, -0.5 * rate, -0.5 * rate, 0.0)
    angles = np.cumsum([0.0, *(np.diff(moments) * (np.add(rates[1:], rates[:-1]) / 2))])
    return through(t, [(m, q, w, 0.0) for m, q, w in zip(moments, angles, rates, strict=True)])
