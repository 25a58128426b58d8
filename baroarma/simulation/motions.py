"""True motions: height and tilt over time, and from them what ideal inertial sensors feel.

A motion is a height h(t) and a tilt angle about a horizontal body axis, both analytic, so that velocity,
acceleration and angular rate are exact.  The sensor is mounted at random on the body.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY

Signal = NDArray[np.float64]
REST_BEFORE: Final = 5.0
"""Rest at the start of every motion, s."""


@dataclass(frozen=True, eq=False)
class Truth:
    """Hold the true motion of a sensor at times t (n,).

    Parameters
    ----------
    t, height, velocity : ndarray, shape (n,)
        s, m and m/s, up; height relative to the start.
    attitude : ndarray, shape (n, 4)
        Quaternions body to world, scalar last.
    force, rate : ndarray, shape (n, 3)
        Specific force (m/s²) and angular rate (rad/s) in body axes.
    """

    t: Signal
    height: Signal
    velocity: Signal
    attitude: Signal
    force: Signal
    rate: Signal


def rest(t: Signal) -> tuple[Signal, ...]:
    """Return height, velocity, acceleration, tilt and tilt rate of no motion."""
    return (np.zeros_like(t),) * 5


def squat(t: Signal, *, depth: float = 0.60, period: float = 4.0, tilt: float = 0.4) -> tuple[Signal, ...]:
    """Return the trunk's motion in squats: down and up by `depth` (m), leaning by `tilt` (rad) with it.

    The depth is SG14's (Sec. 3.4, printed); period and tilt are chosen by us.
    """
    # the pace S rises smoothly over the first period, so that no sample sees a jump of acceleration
    w = 2 * np.pi / period
    since = np.maximum(t - REST_BEFORE, 0.0)
    u = np.minimum(since / period, 1.0)
    pace, change = w * u**2 * (3 - 2 * u), w / period * 6 * u * (1 - u)
    phase = w * (period * (u**3 - u**4 / 2) + np.maximum(since - period, 0.0))
    down, speed = (1 - np.cos(phase)) / 2, pace * np.sin(phase) / 2
    acceleration = (change * np.sin(phase) + pace**2 * np.cos(phase)) / 2
    return -depth * down, -depth * speed, -depth * acceleration, tilt * down, tilt * speed


MOTIONS: Final[dict[str, Callable[[Signal], tuple[Signal, ...]]]] = {"rest": rest, "squat": squat}
"""Motions by the name that users type."""


def move(motion: str, t: Signal, rng: np.random.Generator) -> Truth:
    """Return the true motion of a sensor mounted at random.

    Raises
    ------
    ValueError
        If the motion is unknown; the message lists those there are.
    """
    from scipy.spatial.transform import Rotation

    if motion not in MOTIONS:
        raise ValueError(f"motion {motion!r} is unknown; choose one of {', '.join(sorted(MOTIONS))}")
    height, velocity, acceleration, tilt, tilt_rate = MOTIONS[motion](t)
    mounting = Rotation.random(rng=rng)
    world = Rotation.from_rotvec(np.outer(tilt, (0.0, 1.0, 0.0)))  # the lean, before the mounting
    attitude = world * mounting
    up = np.outer(acceleration + STANDARD_GRAVITY, (0.0, 0.0, 1.0))
    return Truth(
        t=t,
        height=height,
        velocity=velocity,
        attitude=attitude.as_quat(),
        force=attitude.inv().apply(up),
        rate=attitude.inv().apply(np.outer(tilt_rate, (0.0, 1.0, 0.0))),
    )
