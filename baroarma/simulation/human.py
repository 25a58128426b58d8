"""Motions of people who wear the device: squats, stairs, walking."""

from __future__ import annotations

from math import pi
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.simulation.apparatus import REST_BEFORE
from baroarma.simulation.jet import Jet, clock, cos, sin
from baroarma.simulation.paths import eased, folded, running, running_for
from baroarma.simulation.pose import FORWARD, LEFT, UP, Axis, Pose

Signal = NDArray[np.float64]
WAIST: Final[Axis] = (0.10, 0.0, 0.0)
"""The device's place in front of the trunk's axis, m; chosen by us."""
TURNING: Final = 1.5
"""How long a walker takes to turn by a right angle, s (less on a shorter leg); chosen by us."""
FAST: Final = 1.0
"""How long a walker takes to come up to speed or to stop, s; chosen by us."""


def squat(
    t: Signal,
    *,
    depth: float = 0.60,
    period: float = 4.0,
    tilt: float = 0.4,
    pause: float = 5.0,
    count: int | None = None,
) -> Pose:
    """Squat with the device on the upper trunk [SG14, Sec. 2.3.4 and 3.4].

    The depth of 0.60 m is printed, as is the rest before and after each squat.  Chosen by us: the period (s),
    to which a smooth start and end add `FAST` s, the lean of the trunk `tilt` (rad), in step with the depth,
    how long one stands between two squats (`pause`, s; 0: one squat runs into the next), and the `count` of
    squats (default: until the end).
    """
    if pause:
        times, local = folded(t, REST_BEFORE, period + FAST + pause)
        local = local if count is None else np.where(times < count, local, 0.0)
        time = running_for(local, REST_BEFORE, FAST, period)
    elif count is None:
        time = running(t, REST_BEFORE, period)
    else:
        time = running_for(t, REST_BEFORE, period, count * period)
    down = 0.5 * (1.0 - cos(2 * pi / period * time))
    return Pose(-depth * down, turns=((LEFT, tilt * down),))


def stairs(
    t: Signal,
    *,
    floors: int = 3,
    floor_height: float = 1.7,
    steps: int = 10,
    cadence_hz: float = 1.5,
    pause: float = 15.0,
    bounce: float = 0.8,
    sway: float = 0.05,
    lean: float = 0.1,
) -> Pose:
    """Climb stairs with the device at the waist, and rest on every floor [SG13, Sec. 2.4].

    Three floors of 1.7 m are printed.  Chosen by us: steps per floor, steps per second, the rest on each
    floor (s; the ground floor's is at least 5), how much the speed swings with each step (`bounce`, as a
    share of the mean), and the trunk's sway and lean (rad).
    """
    steps_done = 0.0 * clock(t)
    leaning = 0.0 * clock(t)
    start = max(REST_BEFORE, pause)
    for _ in range(floors):
        flight = cadence_hz * running_for(t, start, FAST, steps / cadence_hz)
        steps_done = steps_done + flight
        leaning = leaning + 0.5 * (1.0 - cos(2 * pi / steps * flight))
        start += steps / cadence_hz + FAST + pause
    beat = sin(2 * pi * steps_done)
    side = sin(pi * steps_done)
    return Pose(
        floor_height / steps * (steps_done - bounce / (2 * pi) * beat),
        turns=((UP, sway * side), (LEFT, lean * leaning), (FORWARD, sway * side)),
        lever=WAIST,
        forward=(0.28 * steps_done - 0.01 * beat).second,  # treads of 28 cm
        left=(0.02 * side).second,
    )


def walk(
    t: Signal,
    *,
    speed: float = 1.3,
    cadence_hz: float = 2.0,
    bounce: float = 0.025,
    sway: float = 0.05,
    leg: float = 10.0,
) -> Pose:
    """Walk on level ground with the device at the waist, turning left every `leg` seconds.

    All chosen by us, as adults walk: speed (m/s), steps per second, amplitude of the trunk's bounce (m),
    which falls and rises once per step, and of its sway (rad).
    """
    pace = running(t, REST_BEFORE, FAST)
    steps = cadence_hz * pace
    beat, side = sin(2 * pi * steps), sin(pi * steps)
    corners, local = folded(t, REST_BEFORE + leg, leg)
    heading = pi / 2 * (corners + eased(local, REST_BEFORE + leg, min(TURNING, leg)))
    forward, left = _along(speed * pace + 0.01 * beat, 0.02 * side, heading)
    return Pose(
        -bounce * (1.0 - cos(2 * pi * steps)),
        turns=((UP, heading + sway * side), (LEFT, 0.5 * sway * beat), (FORWARD, sway * side)),
        lever=WAIST,
        forward=forward,
        left=left,
    )


def _along(way: Jet, aside: Jet, heading: Jet) -> tuple[Signal, Signal]:
    """Return the horizontal acceleration, world axes, of who goes and sways along a heading that turns."""
    ahead = way.second - aside.first * heading.first
    across = way.first * heading.first + aside.second
    c, s = np.cos(heading.value), np.sin(heading.value)
    return c * ahead - s * across, s * ahead + c * across
