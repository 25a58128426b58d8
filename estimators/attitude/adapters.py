"""Attitude by other people's libraries: VQF (Laidig and Seel, 2023) and x-io's Fusion (Madgwick's, revised).

Both are optional: ``pip install 'baroarma[vqf]'`` or ``'baroarma[imufusion]'``.  What they share is here: the
gyro bias of the alignment is subtracted before they see a rate, a missing gyro sample is held, a missing
accelerometer sample is not shown to them, and their start is the alignment's vertical, or after a long gap
the next specific force.

They report no uncertainty of tilt.  The sd of the vertical acceleration therefore comes from a setting,

    sd² = tilt_sd² |f_h|² + accel_noise_sd²,   f_h the horizontal specific force.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from importlib import import_module
from typing import Any

import numpy as np

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.compiled import as_array
from baroarma.estimators.attitude.samples import (
    forget_rate,
    has_vertical,
    is_lost,
    is_sample,
    levelled,
    take_rate,
)
from baroarma.estimators.attitude.vertical import fill_level, project
from baroarma.estimators.base import Alignment, AttitudeEstimator, AttitudeRun, AttitudeState, Signal
from baroarma.rotation import up_from_quaternion


class Adapter(AttitudeEstimator):
    """What the adapters share; a library supplies the four methods at the end."""

    def __init__(self, accel_noise_sd: float, tilt_sd: float) -> None:
        self.accel_noise_sd = accel_noise_sd
        self.tilt_sd = tilt_sd
        self.reset()

    def reset(self, alignment: Alignment | None = None) -> None:
        """Make the library's filter anew and give it the alignment's vertical."""
        self.alignment = alignment or Alignment()
        self.held = np.zeros(4)
        self._started = False
        self._start(np.array(self.alignment.up))

    def step(
        self, *, dt: float, accel: Signal, gyro: Signal, attitude: Signal | None = None
    ) -> AttitudeState:
        """Take one sample; see `AttitudeEstimator.step`."""
        ups, acceleration, sd = self._take(np.array([dt if self._started else 0.0]), accel[None], gyro[None])
        return AttitudeState(ups[0], float(acceleration[0]), float(sd[0]))

    def run(
        self, t: Signal, accel: Signal, gyro: Signal, attitude: Signal | None = None, *, dt: float = 0.0
    ) -> AttitudeRun:
        """Take all samples, going on from where the filter stands."""
        return self._take(np.diff(t, prepend=t[:1] - dt), accel, gyro)

    def _take(self, dt: Signal, accel: Signal, gyro: Signal) -> AttitudeRun:
        accel, gyro = as_array(accel), as_array(gyro)
        n, bias = len(dt), np.array(self.alignment.gyro_bias)
        quaternions = np.empty((n, 4))
        for k in range(n):
            new = is_sample(accel[k])
            self.held[:] = forget_rate(self.held, dt[k])
            lost = is_lost(self.held)
            if lost and new and has_vertical(accel[k]):
                self._start(accel[k])
                self.held[:] = levelled(self.held)
            self.held[:] = take_rate(self.held, gyro[k], bias)
            quaternions[k] = self._advance(0.0 if lost else dt[k], self.held[:3], accel[k] if new else None)
        self._started = self._started or n > 0
        return self._project(quaternions, accel)

    def _project(self, quaternions: Signal, accel: Signal) -> AttitudeRun:
        quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
        ups = up_from_quaternion(np.roll(quaternions, -1, axis=1))
        out = AttitudeRun(ups, np.empty(len(ups)), np.empty(len(ups)))
        P = self.tilt_sd**2 * np.eye(3)
        project(accel, ups, P, self.alignment.gravity, self.accel_noise_sd, *out[1:])
        return out

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_filter": self._memory()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._start(np.array(self.alignment.up))
        self._recall(state["_filter"])

    @abstractmethod
    def _start(self, up: Signal) -> None:
        """Make the library's filter anew with this vertical, of any length."""

    @abstractmethod
    def _advance(self, dt: float, rate: Signal, accel: Signal | None) -> Signal:
        """Turn by rate times dt, then take the force; return the quaternion, scalar *first*."""

    @abstractmethod
    def _memory(self) -> Any:
        """Return what the library's filter remembers, for copies and files."""

    @abstractmethod
    def _recall(self, memory: Any) -> None:
        """Put it back."""


class VqfAttitude(Adapter):
    """Estimate attitude by VQF, on-line and from six axes.

    VQF knows one sampling interval.  Here each rate is multiplied by dt times `rate_hz`, so that the angle
    turned is right whatever the interval, gaps included; only VQF's own filters count samples.

    Parameters
    ----------
    rate_hz : float
        Nominal rate of the samples.  Default 50.  At twice this rate VQF's time constants are half as long.
    time_constant : float
        tauAcc, s: larger trusts the gyro longer.  Default 3 (VQF's).
    accel_noise_sd : float
        m/s².  Default 0.04 (chosen by us): 4 mg, as an MPU-6050's.
    tilt_sd : float
        Error of tilt about each horizontal axis, rad.  Default 1° (chosen by us).  Both only size the sd.

    Raises
    ------
    ValueError
        If the package vqf is not installed.

    Examples
    --------
    A device that lies 0.3 rad askew and rises with 0.5 m/s² for a second:

    >>> up = np.array([0.0, np.sin(0.3), np.cos(0.3)])
    >>> attitude = VqfAttitude(rate_hz=50)
    >>> attitude.reset(Alignment(up=tuple(up)))
    >>> force = np.tile((STANDARD_GRAVITY + 0.5) * up, (50, 1))
    >>> attitude.run(np.arange(50) / 50, force, np.zeros((50, 3))).acceleration[[0, -1]].round(6).tolist()
    [0.5, 0.5]
    """

    def __init__(
        self,
        *,
        rate_hz: float = 50.0,
        time_constant: float = 3.0,
        accel_noise_sd: float = 0.04,
        tilt_sd: float = math.radians(1.0),
    ) -> None:
        self.rate_hz = rate_hz
        self.time_constant = time_constant
        super().__init__(accel_noise_sd, tilt_sd)

    def _start(self, up: Signal) -> None:
        """Make a filter that stands as if it had rested like this for ever."""
        vqf = _library("vqf")
        self._filter = vqf.VQF(1 / self.rate_hz, tauAcc=self.time_constant)
        force = self.alignment.gravity * up / np.linalg.norm(up)
        b, a = (np.array(self._filter.coeffs[name]) for name in ("accLpB", "accLpA"))
        state = self._filter.state
        state["accQuat"] = _level(up)
        state["lastAccLp"] = force
        state["accLpState"] = np.concatenate([vqf.VQF.filterInitialState(f, b, a) for f in force])
        self._filter.state = state

    def _advance(self, dt: float, rate: Signal, accel: Signal | None) -> Signal:
        self._filter.updateGyr(rate * (dt * self.rate_hz))
        if accel is not None:
            self._filter.updateAcc(np.ascontiguousarray(accel))
        return np.asarray(self._filter.getQuat6D())

    def _memory(self) -> Any:
        return self._filter.state

    def _recall(self, memory: Any) -> None:
        self._filter.state = memory


class ImufusionAttitude(Adapter):
    """Estimate attitude by x-io's Fusion, without its start-up ramp; it takes each interval as it comes.

    Fusion computes in single precision: its numbers are good to about 1e-6.

    Parameters
    ----------
    gain : float
        Larger: tilt follows the accelerometer faster.  Default 0.5 (Fusion's).
    accel_noise_sd, tilt_sd : float
        As in `VqfAttitude`.

    Raises
    ------
    ValueError
        If the package imufusion is not installed.

    Examples
    --------
    Turned by 90° within a second, the gyro alone being trusted:

    >>> attitude = ImufusionAttitude(gain=0.0)
    >>> attitude.reset()
    >>> turning = np.tile([np.pi / 2, 0.0, 0.0], (101, 1))
    >>> found = attitude.run(np.arange(101) / 100, np.full((101, 3), np.nan), turning)
    >>> found.up[-1].round(3).tolist()
    [0.0, 1.0, 0.0]
    """

    def __init__(
        self, *, gain: float = 0.5, accel_noise_sd: float = 0.04, tilt_sd: float = math.radians(1.0)
    ) -> None:
        self.gain = gain
        super().__init__(accel_noise_sd, tilt_sd)

    def _start(self, up: Signal) -> None:
        fusion = _library("imufusion")
        self._filter = fusion.Ahrs()
        self._filter.set_settings(fusion.AhrsSettings(convention=fusion.CONVENTION_NWU, gain=self.gain))
        self._filter.skip_startup()
        self._filter.set_quaternion(_level(up))

    def _advance(self, dt: float, rate: Signal, accel: Signal | None) -> Signal:
        self._filter.set_sample_period(dt)
        force = np.zeros(3) if accel is None else accel / STANDARD_GRAVITY  # 0 is Fusion's "no sample"
        self._filter.update_no_magnetometer(np.degrees(rate), force)
        return np.asarray(self._filter.get_quaternion())

    def _memory(self) -> Any:
        return self._filter.get_quaternion()

    def _recall(self, memory: Any) -> None:
        self._filter.set_quaternion(memory)


def _level(up: Signal) -> Signal:
    """Return the levelled quaternion, scalar first."""
    q = np.empty(4)
    fill_level(q, up)
    return np.roll(q, 1)


def _library(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise ValueError(
            f"this attitude estimator needs the package {name}, which is not installed; "
            f"run: pip install 'baroarma[{name}]'"
        ) from None
