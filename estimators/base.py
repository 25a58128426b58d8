"""The two interfaces of this room: attitude estimators and height estimators.

Data goes one way: accelerometer and gyro -> attitude -> vertical acceleration -> height and velocity, with
the barometer joining at the height.  A tightly coupled height estimator (`input = "imu"`) takes the IMU
itself and needs no attitude estimator before it.

`step` is the definition, `run` its repetition: row k of `run` is what the k-th `step` returns, the state *at
t_k* from samples up to t_k.  `reset` makes an estimator new.  No sample (NaN) means no update.  Everything is
SI, world z up, quaternions scalar last and body -> world.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY

Signal = NDArray[np.float64]
UNSEEN_WALK: Final = 0.5
"""How far the velocity wanders that no accelerometer sees: 0.5 m/s in a second, as people and lifts start and
stop; m/s per sqrt(s), chosen by us."""
UNFELT: Final = 0.1
"""Seconds without a new accelerometer sample after which nothing is felt: who walks is accelerated the other
way by then (chosen by us)."""
LONGEST_HOLD: Final = 0.5
"""A missing sample of the IMU is replaced by the last one for so many seconds (chosen by us): about the time
in which a limb's turn comes to its end."""
ROUNDING: Final = 1e-6
"""Sums of intervals that but for so much (s) reach a time do reach it: no clock's rounding decides, nor
whether `step` sums intervals where `run` subtracts times."""
STALE: Final = LONGEST_HOLD + ROUNDING
"""In an interval longer than this, s, no acceleration is integrated: what happened meanwhile was not felt."""


@dataclass(frozen=True)
class Alignment:
    """What a second of rest says before the motion starts.

    Parameters
    ----------
    up : tuple of float
        Unit vector in body axes that points up: the mean specific force, normalised.
    gyro_bias : tuple of float
        Mean angular rate at rest, rad/s.
    gravity : float
        Mean modulus of the specific force, m/s² (an accelerometer's scale error included).
    accel_sd, gyro_sd : float
        White noise of one sample and axis, m/s² and rad/s; NaN: not known.
    gravity_sd, gyro_bias_sd : float
        How uncertain `gravity` and each axis of `gyro_bias` are, m/s² and rad/s: more than the noise says
        where something sways; NaN: not known.

    Examples
    --------
    Told of a gyro's bias and of how the accelerometer reads g, an estimator sees a resting device rest:

    >>> from baroarma.estimators import attitude_estimator
    >>> still = {"accel": np.array([0.0, 0.0, 9.79]), "gyro": np.array([0.01, 0.0, 0.0])}
    >>> tilt = attitude_estimator("tilt-kalman")
    >>> tilt.reset(Alignment(gravity=9.79, gyro_bias=(0.01, 0.0, 0.0)))
    >>> abs(round(tilt.step(dt=0.02, **still).acceleration, 9))
    0.0
    >>> tilt.reset()
    >>> round(tilt.step(dt=0.02, **still).acceleration, 4)  # 9.79 - 9.80665
    -0.0167
    """

    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    gyro_bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gravity: float = STANDARD_GRAVITY
    accel_sd: float = float("nan")
    gyro_sd: float = float("nan")
    gravity_sd: float = float("nan")
    gyro_bias_sd: float = float("nan")


class AttitudeState(NamedTuple):
    """Tilt and what follows from it at one instant.

    Examples
    --------
    >>> from baroarma.estimators import attitude_estimator
    >>> tilt = attitude_estimator("accelerometer-norm")
    >>> state = tilt.step(dt=0.02, accel=np.array([0.0, 6.0, 8.0]), gyro=np.zeros(3))
    >>> state.up.tolist(), round(state.acceleration + STANDARD_GRAVITY, 9)
    ([0.0, 0.6, 0.8], 10.0)
    """

    up: Signal
    """Unit vector in body axes that points up, (3,)."""
    acceleration: float
    """Vertical acceleration, m/s², up; NaN without an accelerometer sample."""
    acceleration_sd: float
    """Its standard deviation, m/s²: sensor noise and tilt uncertainty."""


class AttitudeRun(NamedTuple):
    """`AttitudeState` of every row: up (n, 3), acceleration (n,), acceleration_sd (n,).

    Examples
    --------
    >>> from baroarma.estimators import attitude_estimator
    >>> force = np.array([[0.0, 6.0, 8.0], [0.0, 0.0, 9.0], [np.nan, np.nan, np.nan]])
    >>> found = attitude_estimator("accelerometer-norm").run(np.arange(3) / 50, force, np.zeros((3, 3)))
    >>> (found.acceleration + STANDARD_GRAVITY).round(9)
    array([10.,  9., nan])
    >>> found.up.tolist()  # where there is no sample, the vertical is the last one
    [[0.0, 0.6, 0.8], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]
    """

    up: Signal
    acceleration: Signal
    acceleration_sd: Signal


class HeightState(NamedTuple):
    """Height (m) and vertical velocity (m/s), up, with standard deviations, at one instant.

    Parameters
    ----------
    height, velocity : float
        Height relative to the start in m and vertical velocity in m/s, up.
    height_sd, velocity_sd : float
        Their standard deviations, m and m/s.

    Examples
    --------
    At 2 m/s² without a barometer; the complementary filter goes by the sample before [SG14, Eq. 24]:

    >>> from baroarma.estimators import height_estimator
    >>> cf = height_estimator("complementary")
    >>> [cf.step(dt=0.5, altitude=float("nan"), acceleration=2.0).velocity for _ in range(3)]
    [0.0, 1.0, 2.0]
    """

    height: float
    velocity: float
    height_sd: float
    velocity_sd: float


class HeightRun(NamedTuple):
    """`HeightState` of every row, each (n,).

    Examples
    --------
    A second at 2 m/s², without a barometer; what is integrated is less and less certain:

    >>> from baroarma.estimators import height_estimator
    >>> t, silent = np.arange(101) / 100, np.full(101, np.nan)
    >>> found = height_estimator("kalman", dt=0.01).run(t, silent, np.full(101, 2.0))
    >>> round(float(found.velocity[-1]), 6), round(float(found.height[-1]), 6)
    (2.0, 1.0)
    >>> bool((np.diff(found.height_sd) > 0).all())
    True
    """

    height: Signal
    velocity: Signal
    height_sd: Signal
    velocity_sd: Signal


class AttitudeEstimator(ABC):
    """Turn accelerometer and gyro samples into tilt and vertical acceleration.

    Examples
    --------
    One for a device that never tilts:

    >>> class Level(AttitudeEstimator):
    ...     def reset(self, alignment=None):
    ...         self.alignment = alignment or Alignment()
    ...
    ...     def step(self, *, dt, accel, gyro, attitude=None):
    ...         return AttitudeState(np.array([0.0, 0.0, 1.0]), float(accel[2]) - self.alignment.gravity, 0.1)
    ...
    ...     def run(self, t, accel, gyro, attitude=None, *, dt=0.0):
    ...         states = [self.step(dt=dt, accel=force, gyro=rate) for force, rate in zip(accel, gyro)]
    ...         return AttitudeRun(*map(np.array, zip(*states)))
    >>> level = Level()
    >>> level.reset(Alignment(gravity=9.8))
    >>> level.run(np.arange(2.0), np.array([[0, 0, 9.8], [0, 0, 10.8]]), np.zeros((2, 3))).acceleration
    array([0., 1.])
    """

    @abstractmethod
    def reset(self, alignment: Alignment | None = None) -> None:
        """Start anew from an alignment (default: body z up, no gyro bias, standard gravity)."""

    @abstractmethod
    def step(
        self, *, dt: float, accel: Signal, gyro: Signal, attitude: Signal | None = None
    ) -> AttitudeState:
        """Take one sample.

        Parameters
        ----------
        dt : float
            Time since the previous sample in s; what it is on the first step has no effect.
        accel, gyro : ndarray, shape (3,)
            Specific force in m/s², angular rate in rad/s; NaN where there is no new sample.
        attitude : ndarray, shape (4,), optional
            A reference attitude, for the estimator that merely passes it on.
        """

    @abstractmethod
    def run(
        self, t: Signal, accel: Signal, gyro: Signal, attitude: Signal | None = None, *, dt: float = 0.0
    ) -> AttitudeRun:
        """Take all samples: t (n,), accel (n, 3), gyro (n, 3), attitude (n, 4) or None.

        The first row comes `dt` s after the last one taken; 0: none was.
        """


class HeightEstimator(ABC):
    """Turn vertical acceleration (or the IMU) and barometric height into height and velocity.

    Examples
    --------
    The barometer alone, each new sample taken as it is:

    >>> class Barometer(HeightEstimator):
    ...     def reset(self, alignment=None):
    ...         self.state = HeightState(0.0, 0.0, 1e-3, 1.0)
    ...
    ...     def step(self, *, dt, altitude, **unused):
    ...         if not np.isnan(altitude):
    ...             self.state = HeightState(altitude, 0.0, 0.5, 1.0)
    ...         return self.state
    ...
    ...     def run(self, t, altitude, *unused, dt=0.0, **also_unused):
    ...         return HeightRun(*np.array([self.step(dt=dt, altitude=z) for z in altitude]).T)
    >>> barometer = Barometer()
    >>> barometer.reset()
    >>> barometer.run(np.arange(3.0), np.array([np.nan, 0.3, np.nan])).height.tolist()
    [0.0, 0.3, 0.3]
    """

    input: ClassVar[Literal["acceleration", "imu"]] = "acceleration"
    """What it integrates: a vertical acceleration, or accelerometer and gyro themselves."""
    listens_to_rest: bool = False
    """Whether it wants to be told when the IMU is still, and which way is up, and judges for itself what
    follows.  Others are given neither."""

    @abstractmethod
    def reset(self, alignment: Alignment | None = None) -> None:
        """Start anew at height 0 and velocity 0."""

    def look_back(self, t: Signal, altitude: Signal, *, dt: float) -> None:  # noqa: B027 - most learn nothing
        """Learn from the rest before the first row, if that tells it anything; for who `listens_to_rest`.

        Parameters
        ----------
        t, altitude : ndarray, shape (n,)
            As in `run`; the rest of the alignment.
        dt : float
            Time from the last of them to the first row, s.
        """

    @abstractmethod
    def step(
        self,
        *,
        dt: float,
        altitude: float,
        acceleration: float = float("nan"),
        acceleration_sd: float = float("nan"),
        accel: Signal | None = None,
        gyro: Signal | None = None,
        at_rest: bool = False,
        up: Signal | None = None,
    ) -> HeightState:
        """Take one sample.

        Parameters
        ----------
        dt : float
            Time since the previous sample in s; what it is on the first step has no effect.
        altitude : float
            Barometric height relative to the start in m; NaN: no new sample.
        acceleration : float
            Vertical acceleration in m/s², up; NaN: no new sample, the last one is held.
        acceleration_sd : float
            Its standard deviation; NaN: the estimator's own setting.
        accel, gyro : ndarray, shape (3,), optional
            The IMU itself, for `input = "imu"`.
        at_rest : bool
            Whether something that knows (a rest detector) says that the device does not move now.
        up : ndarray, shape (3,), optional
            The vertical in body axes, which says how the accelerometer's bias turns.
        """

    @abstractmethod
    def run(
        self,
        t: Signal,
        altitude: Signal,
        acceleration: Signal | None = None,
        acceleration_sd: Signal | None = None,
        accel: Signal | None = None,
        gyro: Signal | None = None,
        at_rest: NDArray[np.bool_] | None = None,
        up: Signal | None = None,
        *,
        dt: float = 0.0,
    ) -> HeightRun:
        """Take all samples, each (n,) or (n, 3); the first `dt` s after the last one taken, 0: none was."""
