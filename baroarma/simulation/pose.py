"""The rigid body: from height and turns over time to what ideal inertial sensors on it feel.

A sensor at the lever arm r of a body that turns with the rate w feels, in body axes [SG14, Eq. 14],

    f = C (p'' + g up) + w' x r + w x (w x r),

C turning world into body; at rest f points up.  The sensor's own axes lie at random on the body.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.simulation.jet import Jet

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

Signal = NDArray[np.float64]
Axis = tuple[float, float, float]
FORWARD: Final[Axis] = (1.0, 0.0, 0.0)
LEFT: Final[Axis] = (0.0, 1.0, 0.0)
UP: Final[Axis] = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Pose:
    """Hold the motion of a body.

    Parameters
    ----------
    height : Jet
        Height of the body's origin in m, up, 0 at the start.
    turns : tuple of (Axis, Jet)
        Turns about body axes by angles in rad, 0 at the start: the first turns the body in the world, each
        other turns the body as it then lies.
    lever : Axis
        The sensor's place on the body, from its origin, m in body axes.
    forward, left : ndarray, shape (n,), or 0
        Horizontal acceleration of the body's origin, m/s² in world axes.
    """

    height: Jet
    turns: tuple[tuple[Axis, Jet], ...] = ()
    lever: Axis = (0.0, 0.0, 0.0)
    forward: Signal | float = 0.0
    left: Signal | float = 0.0


@dataclass(frozen=True, eq=False)
class Truth:
    """Hold the true motion of a sensor at times t (n,).

    Parameters
    ----------
    t, height, velocity, acceleration : ndarray, shape (n,)
        s, m, m/s and m/s², up; height relative to the start.
    attitude : ndarray, shape (n, 4)
        Quaternions sensor to world, scalar last.
    force, rate : ndarray, shape (n, 3)
        Specific force (m/s²) and angular rate (rad/s) in the sensor's axes.

    Examples
    --------
    What is felt, turned into the world's axes, is the acceleration and gravity:

    >>> from scipy.spatial.transform import Rotation
    >>> from baroarma.simulation import move
    >>> truth = move("squat", np.arange(500) / 50, np.random.default_rng(1))
    >>> vertical = Rotation.from_quat(truth.attitude).apply(truth.force)[:, 2]
    >>> bool(np.allclose(vertical, truth.acceleration + STANDARD_GRAVITY))
    True
    """

    t: Signal
    height: Signal
    velocity: Signal
    acceleration: Signal
    attitude: Signal
    force: Signal
    rate: Signal


def observe(t: Signal, pose: Pose, mounting: Rotation) -> Truth:
    """Return the truth of a sensor on a body.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Time, s.
    pose : Pose
        The body's motion at these times.
    mounting : scipy.spatial.transform.Rotation
        Turns the sensor's axes into the body's.
    """
    attitude, rate, change = _turn(len(t), pose.turns)
    lever = np.asarray(pose.lever)
    # place, velocity and acceleration that the sensor has from the turning, world axes
    swing = np.cross(rate, lever)
    arm = attitude.apply(lever)
    drift = attitude.apply(swing)
    pull = attitude.apply(np.cross(change, lever) + np.cross(rate, swing))
    acceleration = pull + np.stack(np.broadcast_arrays(pose.forward, pose.left, pose.height.second), axis=-1)
    gravity = np.array((0.0, 0.0, STANDARD_GRAVITY))
    sensor = attitude * mounting
    return Truth(
        t=t,
        height=pose.height.value + arm[:, 2] - lever[2],
        velocity=pose.height.first + drift[:, 2],
        acceleration=acceleration[:, 2],
        attitude=sensor.as_quat(),
        force=sensor.inv().apply(acceleration + gravity),
        rate=mounting.inv().apply(rate),
    )


def _turn(n: int, turns: tuple[tuple[Axis, Jet], ...]) -> tuple[Rotation, Signal, Signal]:
    """Compose turns: attitude body to world, angular rate and its derivative in body axes.

    After one more turn B by the angle q about e: w' = B^T w + e q_dot, and B^T v changes by -e q_dot x B^T v.
    """
    from scipy.spatial.transform import Rotation

    attitude, rate, change = Rotation.identity(n), np.zeros((n, 3)), np.zeros((n, 3))
    for axis, angle in turns:
        turn = Rotation.from_rotvec(np.outer(angle.value, axis))
        own = np.outer(angle.first, axis)
        carried = turn.inv().apply(rate)
        change = turn.inv().apply(change) - np.cross(own, carried) + np.outer(angle.second, axis)
        rate = carried + own
        attitude = attitude * turn
    return attitude, rate, change
