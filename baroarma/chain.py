"""The chain of estimators once it is aligned: IMU and altitude in, the state now out.

    accel, gyro ── attitude ── vertical acceleration ──┐
                                                       ├── height
    altitude ── minus the zero ── conditioning ────────┘

Three kinds: with an attitude estimator, as drawn; with a height estimator that takes the IMU itself; and
without an IMU, where the acceleration is 0 with the sd of unseen motion.  So it is, too, wherever the last
acceleration is older than `UNFELT`.  `step` is the definition, `run` the same numbers for all rows at
once, and either goes on where the other ended.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from inspect import signature
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import as_rows, njit
from baroarma.estimators.base import (
    ROUNDING,
    STALE,
    UNFELT,
    UNSEEN_WALK,
    AttitudeEstimator,
    HeightEstimator,
    HeightRun,
)
from baroarma.estimators.conditioning import Conditioner
from baroarma.estimators.stillness import Stillness
from baroarma.recording import Recording
from baroarma.track import TrackState

Signal = NDArray[np.float64]
LEAST_STEP: Final = 1e-6
"""An interval counts as no less, s, where something is divided by it."""
MOST_REPEATS: Final = 20
"""The same altitude to the last bit, so many times in a row, is a barometer that hangs (chosen by us)."""
PART: Final = 1 << 15
"""Rows that are taken at once: what they need stays in the cache, and the system's memory is left alone."""


class ChainRun(NamedTuple):
    """What some rows give: the height estimator's columns and the vertical acceleration, (n,)."""

    height: HeightRun
    acceleration: Signal


class Chain:
    """Run the estimators one after the other.

    Parameters
    ----------
    attitude : AttitudeEstimator or None
        Reset to the alignment; None: the height estimator takes the IMU itself, or there is none.
    height : HeightEstimator
        Reset to the alignment.
    conditioner : Conditioner
        What happens to the altitude; it has seen the alignment's samples.
    zero : float
        Altitude that counts as height 0, m; NaN: the first that comes.
    rate_hz : float
        The barometer's own rate while aligning, Hz.
    with_imu : bool
        Whether there is an IMU.
    stillness : Stillness, optional
        Tells a height estimator that wants to know when the IMU feels nothing.
    """

    def __init__(
        self,
        attitude: AttitudeEstimator | None,
        height: HeightEstimator,
        conditioner: Conditioner,
        *,
        zero: float,
        rate_hz: float,
        with_imu: bool,
        stillness: Stillness | None = None,
    ) -> None:
        self.attitude, self.height, self.conditioner = attitude, height, conditioner
        self.zero, self.rate_hz, self.with_imu, self.stillness = zero, rate_hz, with_imu, stillness
        self._acceleration, self._velocity, self._age, self._started = 0.0, 0.0, 0.0, False
        self._altitude, self._repeats = math.nan, 0

    def step(
        self, *, dt: float, altitude: float, accel: Signal, gyro: Signal, attitude: Signal | None = None
    ) -> TrackState:
        """Take one row: altitude in m above the ISA's sea level, the rest as `Tracker.step`."""
        self._find_zero(altitude)
        z = self.conditioner.step(altitude - self.zero)
        if not self.with_imu:
            unseen = float(_unseen_sd(np.array(dt)))
            state = self.height.step(dt=dt, altitude=z, acceleration=0.0, acceleration_sd=unseen)
        elif self.attitude is None:
            state = self.height.step(dt=dt, altitude=z, accel=accel, gyro=gyro)
            self._acceleration = (state.velocity - self._velocity) / dt if dt > 0 else 0.0
        else:
            felt = self.attitude.step(dt=dt, accel=accel, gyro=gyro, attitude=attitude)
            used, sd, self._acceleration, self._age = _hold(
                float(dt), felt.acceleration, self._age, self._acceleration
            )
            listens: dict[str, Any] = {}
            if self.stillness is not None:
                still, shaking = self.stillness.step(dt=dt, accel=accel, gyro=gyro)
                z, self._altitude, self._repeats = _heed(z, self._altitude, self._repeats)
                listens = {"at_rest": still, "up": felt.up}
                sd = shaking if math.isnan(sd) else sd
            state = self.height.step(dt=dt, altitude=z, acceleration=used, acceleration_sd=sd, **listens)
        self._velocity, self._started = state.velocity, True
        return TrackState(*state, self._acceleration)

    def run(
        self, rows: Recording, altitude: Signal, dt: float, out: Signal, *, lag: float | None = None
    ) -> None:
        """Take all rows, with their altitudes (n,), the first of them `dt` s after what came before.

        `out` (5, n) gets height, velocity, their sds and the acceleration.  With a `lag` in s each row knows
        what came up to so much later; the smoother doesn't go on after it.
        """
        n = len(rows)
        size = n if lag is not None or not self._goes_on() else PART
        for start in range(0, n, size):
            part = slice(start, min(start + size, n))
            since = dt if start == 0 else float(rows.t[start] - rows.t[start - 1])
            found = self._take(rows.rows(part), altitude[part], since, lag)
            out[:4, part], out[4, part] = found.height, found.acceleration

    def _goes_on(self) -> bool:
        """Whether the estimators can run part by part; an older plug-in's `run` may know no `dt`."""
        runs = [estimator.run for estimator in (self.attitude, self.height) if estimator is not None]
        return all("dt" in signature(run).parameters for run in runs)

    def _take(self, rows: Recording, altitude: Signal, dt: float, lag: float | None) -> ChainRun:
        before: dict[str, Any] = {"dt": dt} if self._started else {}
        estimate = partial(self.height.run, **before) if lag is None else self._smoother(lag)
        new = np.flatnonzero(np.isfinite(altitude))
        self._find_zero(float(altitude[new[0]]) if len(new) else float("nan"))
        z = self.conditioner.run(altitude - self.zero)
        if not self.with_imu:
            none, sd = np.zeros(len(rows)), _unseen_sd(_steps(rows.t, dt))
            found = ChainRun(estimate(rows.t, z, none, sd), none)
        elif self.attitude is None:
            height = estimate(rows.t, z, accel=rows.accel, gyro=rows.gyro)
            found = ChainRun(height, np.diff(height.velocity, prepend=self._velocity) / _steps(rows.t, dt))
        else:
            assert rows.accel is not None
            assert rows.gyro is not None
            felt = self.attitude.run(rows.t, rows.accel, rows.gyro, rows.reference_attitude, **before)
            used, sd, held = self._driven(rows.t, float(rows.t[0]) - dt, felt.acceleration)
            listens = {}
            if self.stillness is not None:
                still, shaking = self.stillness.run(rows.t, rows.accel, rows.gyro, dt)
                self._altitude, self._repeats = _blank_repeats(z, self._altitude, self._repeats)
                listens = {"at_rest": still, "up": felt.up}
                sd = np.where(np.isnan(sd), shaking, sd)
            height = estimate(rows.t, z, used, sd, **listens)
            found = ChainRun(height, held)
        self._acceleration, self._velocity = float(found.acceleration[-1]), float(found.height.velocity[-1])
        self._started = True
        return found

    def _driven(self, t: Signal, before: float, acceleration: Signal) -> tuple[Signal, Signal, Signal]:
        """Return what drives the height filter, its sd where it isn't the filter's own, and what is held."""
        used, sd, held = np.empty(len(t)), np.empty(len(t)), np.empty(len(t))
        self._age = _drive(as_rows(t), before, acceleration, self._age, self._acceleration, used, sd, held)
        return used, sd, held

    def _smoother(self, lag: float) -> Callable[..., HeightRun]:
        smooth = getattr(self.height, "smooth", None)
        if smooth is None:
            raise ValueError(
                f"the height estimator {type(self.height).__name__} has no smoother; coloured-kalman has one"
            )
        return partial(smooth, lag=lag)

    def _find_zero(self, altitude: float) -> None:
        if math.isnan(self.zero):  # no sample while aligning: the first one is the zero
            self.zero = altitude


def _steps(t: Signal, dt: float) -> Signal:
    return np.concatenate(([dt], np.diff(t)))


def _unseen_sd(dt: Signal) -> Signal:
    """Return the sd in m/s² that an acceleration held over dt must have for the velocity to wander so."""
    return UNSEEN_WALK / np.sqrt(np.maximum(dt, LEAST_STEP))


@njit(cache=True)
def _drive(
    t: Signal,
    before: float,
    acceleration: Signal,
    age: float,
    last: float,
    used: Signal,
    sd: Signal,
    held: Signal,
) -> float:
    """Fill the last three from accelerations that may be missing; return how old the last one is, s."""
    for k in range(len(t)):
        used[k], sd[k], last, age = _hold(t[k] - before, acceleration[k], age, last)
        before, held[k] = t[k], last
    return age


@njit(cache=True)
def _hold(dt: float, acceleration: float, age: float, last: float) -> tuple[float, float, float, float]:
    """Return the acceleration to use, its sd, the last number and how old it is, s.

    What is not felt is an acceleration of 0 with the sd of unseen motion, and so is that of a long step; else
    the sd is NaN.
    """
    longest, before = UNFELT + ROUNDING, age
    age = age + dt if math.isnan(acceleration) else 0.0
    unfelt, sd = age > longest, math.nan
    used = 0.0 if unfelt else acceleration
    if unfelt or dt > STALE:
        since = age if unfelt and before <= longest else dt  # what was held until now was not felt either
        sd = UNSEEN_WALK * math.sqrt(max(since, LEAST_STEP)) / max(dt, LEAST_STEP)
    return used, sd, last if math.isnan(used) else used, age


@njit(cache=True)
def _blank_repeats(altitude: Signal, last: float, repeats: int) -> tuple[float, int]:
    """Leave of altitudes what is news; return the last one, and how many times in a row it has come again."""
    for k in range(len(altitude)):
        altitude[k], last, repeats = _heed(altitude[k], last, repeats)
    return last, repeats


@njit(cache=True)
def _heed(altitude: float, last: float, repeats: int) -> tuple[float, float, int]:
    """Return an altitude if it is news, else NaN; then what `_blank_repeats` does.

    Nothing rests as still as a barometer that hangs.
    """
    if math.isnan(altitude):
        return altitude, last, repeats
    repeats = repeats + 1 if altitude == last else 0
    return (math.nan if repeats >= MOST_REPEATS else altitude), altitude, repeats
