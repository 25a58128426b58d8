"""The five test movements of Lee16 (Sec. 2.3), by hand in a gymnasium.

Printed are the extent of the movements and what the sensor's posture did in them; how fast and how often is
only drawn (Fig. 4) and therefore chosen by us: between the levels the hand eases in and out, and it tilts the
sensor from side to side on the way, never at rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np
from numpy.typing import NDArray

from baroarma.simulation.apparatus import REST_BEFORE
from baroarma.simulation.jet import clock, sin
from baroarma.simulation.paths import eased
from baroarma.simulation.pose import FORWARD, Pose

Signal = NDArray[np.float64]
Levels = Sequence[float]


def lee16_a(
    t: Signal,
    *,
    levels: Levels = (3.5, 0.0),
    leg: float = 10.0,
    pause: float = 10.0,
    tilt: float = 0.87,
    swings: int = 3,
) -> Pose:
    """Rise to 3.5 m, wait 10 s, descend, tilting by 50 degrees [Lee16, Test A].

    Printed: about 3.5 m, about 10 s, at least 45 degrees.  Chosen by us: 10 s for each way, with three
    swings on it.
    """
    return _carry(t, levels, leg, pause, tilt, swings)


def lee16_b(
    t: Signal,
    *,
    levels: Levels = (3.0, 0.0, 2.5, 0.0, 3.0, 0.0),
    leg: float = 4.0,
    pause: float = 1.0,
    tilt: float = 0.15,
    swings: int = 1,
) -> Pose:
    """Rise and descend by up to 3 m, again and again [Lee16, Test B].

    Printed: about 3 m, no large change of posture.  Chosen by us: three times, 4 s for each way.
    """
    return _carry(t, levels, leg, pause, tilt, swings)


def lee16_c(
    t: Signal,
    *,
    levels: Levels = (3.0, 0.0, 3.0, 0.5, 2.5, 0.0, 3.0, 0.0, 2.5, 0.5, 3.0, 0.0),
    leg: float = 2.0,
    pause: float = 0.3,
    tilt: float = 0.15,
    swings: int = 1,
) -> Pose:
    """Rise and descend by up to 3 m, faster and more often than in Test B [Lee16, Test C].

    Chosen by us: six times, 2 s for each way.
    """
    return _carry(t, levels, leg, pause, tilt, swings)


def lee16_d(
    t: Signal,
    *,
    levels: Levels = (0.5, 1.0, 1.5, 1.0, 0.5, 0.0),
    leg: float = 1.5,
    pause: float = 3.0,
    tilt: float = 0.05,
    swings: int = 1,
) -> Pose:
    """Go in steps up and down, then stop [Lee16, Test D].

    Printed: within 1.5 m, no change of posture.  Chosen by us: three steps of 0.5 m each way.
    """
    return _carry(t, levels, leg, pause, tilt, swings)


def lee16_e(
    t: Signal,
    *,
    levels: Levels = (0.3, 0.1, 0.6, 0.2, 0.5, 0.0),
    leg: float = 3.0,
    pause: float = 2.0,
    tilt: float = 0.5,
    swings: int = 1,
) -> Pose:
    """Change the height by little [Lee16, Test E].

    Printed: small changes, at rest at the starting height from 35 s on.  Chosen by us: the levels, and a tilt
    of 0.5 rad, for the accelerometer alone did badly in it (Table 2).
    """
    return _carry(t, levels, leg, pause, tilt, swings)


def _carry(t: Signal, levels: Levels, leg: float, pause: float, tilt: float, swings: int) -> Pose:
    """Go to each level (m) in `leg` s, rest there for `pause` s; tilt by `tilt` rad, `swings` times a leg."""
    height, progress = 0.0 * clock(t), 0.0 * clock(t)
    for i, (now, before) in enumerate(zip(levels, [0.0, *levels], strict=False)):
        way = eased(t, REST_BEFORE + i * (leg + pause), leg)
        height, progress = height + (now - before) * way, progress + way
    return Pose(height, turns=((FORWARD, tilt * sin(2 * pi * swings * progress)),))
