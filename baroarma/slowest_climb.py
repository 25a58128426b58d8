"""The slowest climb that is still told from rest, and the height lost meanwhile.

A sensor that feels nothing may rest or ride at a constant speed; `baroarma.estimators.height.bank` weighs the
two.  Here the tracker rides, many times, on simulated rests to which a climb is added,

    altitude += h(t),   specific force += up a(t) if the start is felt,   h'' = a,

so that every speed sees the same noise.  A climb is recognised when rest is not believed at its end; for how
long it was believed on the way is the time that took, and the most by which the height fell short of the
truth is what was lost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import altitude_pressure, pressure_altitude
from baroarma.estimators.height.bank import Decisions
from baroarma.noise_model import NoiseModel
from baroarma.recording import Recording
from baroarma.rotation import up_from_quaternion
from baroarma.simulation import Barometer, simulate
from baroarma.simulation.jet import Jet
from baroarma.simulation.paths import running
from baroarma.tracker import Tracker

Signal = NDArray[np.float64]
REST: Final = 30.0
"""Rest before the climb, s: as much certainty as is ever gathered (chosen by us)."""
EASE: Final = 1.5
"""How long the climb takes to get to its speed, s, as a lift (chosen by us)."""
SHARE: Final = 0.95
"""Share of the runs in which a climb must be recognised."""
SPEEDS: Final = tuple(m * 10.0**e for e in (-3, -2, -1, 0) for m in (1.0, 1.4, 2.0, 3.0, 4.0, 5.0, 7.0))
"""Speeds among which the slowest is searched, m/s."""


class Watch(NamedTuple):
    """What the filter of the preset `baroarma` believes, row by row after the alignment."""

    t: Signal
    """Time, s, (n,)."""
    believed: NDArray[np.bool_]
    """Whether it takes the device to be at rest, (n,)."""
    height: Signal
    """Height, m, (n,)."""


@dataclass(frozen=True)
class Climbs:
    """Hold what became of the climbs of one speed.

    Parameters
    ----------
    speed : float
        m/s.
    seconds : tuple of float
        Of each run: how long of the climb rest was believed, s; infinity: to the end.
    lost : tuple of float
        Of each run: by how much the height fell short of the truth at the worst moment, m.
    left : tuple of float
        Of each run: height minus truth at the end, m.

    Examples
    --------
    Of four climbs at 5 cm/s the last was taken for rest to the end:

    >>> inf = float("inf")
    >>> climbs = Climbs(0.05, (2.0, 3.0, 4.0, inf), lost=(0.1, 0.15, 0.2, 3.0), left=(0.0, 0.0, 0.1, -3.0))
    >>> climbs.recognised
    0.75
    >>> climbs
    <Climbs at 0.05 m/s: 75% of 4 recognised; after 3.5 s (worst inf), 0.17 m lost (worst 3)>
    """

    speed: float
    seconds: tuple[float, ...]
    lost: tuple[float, ...]
    left: tuple[float, ...]

    @property
    def recognised(self) -> float:
        """Share of the runs in which the climb was recognised."""
        return float(np.mean(np.isfinite(self.seconds)))

    def __repr__(self) -> str:
        seconds, lost = np.median(self.seconds), np.median(self.lost)
        return (
            f"<Climbs at {self.speed:.3g} m/s: {self.recognised:.0%} of {len(self.seconds)} recognised; "
            f"after {seconds:.2g} s (worst {max(self.seconds):.2g}), "
            f"{lost:.2g} m lost (worst {max(self.lost):.2g})>"
        )


def slowest_climb(
    noise: NoiseModel,
    imu: str = "simple",
    *,
    felt: bool = True,
    within: float = 60.0,
    runs: int = 20,
    seed: int = 0,
) -> Climbs:
    """Find the slowest constant climb that the preset `baroarma` tells from rest.

    Parameters
    ----------
    noise : NoiseModel
        Noise of the barometer's raw samples.
    imu : str
        The device whose IMU is simulated, by its name in `baroarma.simulation.DEVICES`.
    felt : bool
        Whether the IMU feels the start, which takes 1.5 s as in a lift; False: it feels nothing at all.
    within : float
        Length of the climb, s.  Longer: slower climbs are recognised by its end, and more height is lost.
    runs : int
        How many climbs of each speed.  In 95 % of them the climb must be recognised; more: a surer answer.
    seed : int
        For the same noise again.

    Returns
    -------
    Climbs
        Of the slowest speed of `SPEEDS` from which on all are recognised.

    Raises
    ------
    ValueError
        If `runs` or `within` is not positive, or no climb is recognised at any speed.

    Examples
    --------
    >>> slowest_climb(NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50), within=5, runs=2).speed <= 0.2
    True
    """
    if runs < 1 or not within > 0:
        raise ValueError(f"runs = {runs} and within = {within:g} s make no climb; both must be positive")
    rests = simulate_rests(noise, imu, duration=REST + within, runs=runs, seed=seed)
    found = None
    for speed in reversed(SPEEDS):
        climbs = try_climbs(rests, noise, speed, felt=felt)
        if climbs.recognised < SHARE:
            break
        found = climbs
    if found is None:
        raise ValueError(
            f"not even a climb at {SPEEDS[-1]:g} m/s is told from rest within {within:g} s; give it more time"
        )
    return found


def simulate_rests(
    noise: NoiseModel, imu: str, *, duration: float, runs: int, seed: int = 0
) -> list[Recording]:
    """Simulate rests of `duration` s with this barometer and the IMU of a device."""
    barometer = Barometer(noise, quantum=0.0, rate_hz=noise.rate_hz)
    rate_hz = max(50.0, noise.rate_hz)

    def rest(run: int) -> Recording:
        rng = np.random.default_rng((seed, run))
        return simulate("rest", duration=duration, rate_hz=rate_hz, device=imu, barometer=barometer, seed=rng)

    return [rest(run) for run in range(runs)]


def try_climbs(
    rests: Sequence[Recording], noise: NoiseModel, speed: float, *, start: float = REST, **how: Any
) -> Climbs:
    """Climb once in each rest, from `start` s to its end; options as in `add_climb`."""
    found = [_judge(add_climb(rest, speed, start=start, **how), noise, start) for rest in rests]
    seconds, lost, left = zip(*found, strict=True)
    return Climbs(speed, seconds, lost, left)


def _judge(climb: Recording, noise: NoiseModel, start: float) -> tuple[float, float, float]:
    """Return time, loss and final error of one climb, as `Climbs` has them."""
    assert climb.reference is not None
    seen = watch(climb, noise)
    error = seen.height - climb.reference[-len(seen.t) :]
    believed = np.diff(seen.t, prepend=seen.t[0])[seen.believed & (seen.t >= start)]
    return float("inf") if seen.believed[-1] else float(believed.sum()), -float(error.min()), float(error[-1])


def add_climb(
    rest: Recording, speed: float, *, felt: bool = True, start: float = REST, ease: float = EASE
) -> Recording:
    """Let a resting device climb.

    Parameters
    ----------
    rest : Recording
        At rest, with reference attitude.
    speed : float
        m/s; negative: down.
    felt : bool
        Whether the accelerometer feels the start.
    start, ease : float
        When the climb begins, and how long it takes to get to its speed, s.  Before the recording: it climbs
        already when the estimators align, and there is no start to be felt.
    """
    return follow(rest, speed * running(rest.t, start, ease), share_felt=float(felt))


def follow(rest: Recording, course: Jet, *, share_felt: float | Signal = 1.0) -> Recording:
    """Let a resting device follow a course in m, of whose acceleration the accelerometer feels this share."""
    accel, _ = _imu(rest)
    assert rest.reference is not None
    assert rest.reference_attitude is not None
    force = (share_felt * course.second)[:, None] * up_from_quaternion(rest.reference_attitude)
    return replace(
        rest,
        pressure=altitude_pressure(pressure_altitude(rest.pressure) + course.value),
        accel=accel + force,
        reference=rest.reference + course.value - course.value[0],
        reference_velocity=course.first,
    )


def watch(recording: Recording, noise: NoiseModel, *, attitude: str = "reference") -> Watch:
    """Run the chain of the preset `baroarma`, behind some attitude, and look at what it believes of rest.

    Parameters
    ----------
    recording : Recording
        With accelerometer and gyro, and what the attitude needs.
    noise : NoiseModel
        As for `Tracker`.
    attitude : str
        Name of an attitude estimator; default: the given one, so that the attitude isn't the question.
    """
    _imu(recording)  # or there is nothing to watch
    decided: list[Decisions] = []
    settings = {"decided": decided.append}
    track = Tracker(noise=noise, attitude=attitude, height_settings=settings).run(recording)
    believed = np.concatenate([decisions.believed for decisions in decided])
    later = slice(len(track) - len(believed), None)
    return Watch(track.t[later], believed, track.height[later])


def _imu(recording: Recording) -> tuple[Signal, Signal]:
    if recording.accel is None or recording.gyro is None:
        raise ValueError(
            f"{recording.name or 'the recording'} has no accelerometer and gyro, without which there are no "
            "rests to believe in; log both"
        )
    return recording.accel, recording.gyro
