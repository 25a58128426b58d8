"""What the papers' two attitude filters share: a filterpy filter whose samples a compiled loop takes.

The loop and filterpy go the same way, sample by sample: forget a rate that is too old, predict with the rate
in use, then correct by the specific force, or level by it if the tilt is lost.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np

from baroarma.compiled import as_array, as_rows
from baroarma.estimators.attitude.samples import forget_rate, is_lost, is_sample, levelled, take_rate
from baroarma.estimators.base import Alignment, AttitudeEstimator, AttitudeRun, AttitudeState, Signal


class SixAxisFilter(AttitudeEstimator):
    """Take samples; a filter adds its loop, and what it does to filterpy's matrices."""

    alignment: Alignment
    x: Signal
    """State."""
    P: Signal
    """Its covariance."""
    held: Signal
    """The rate in use and the time since its sample, (4,)."""
    predict: Any
    """Filterpy's own."""

    def _start(self, alignment: Alignment | None) -> None:
        """Take an alignment, before the first sample."""
        self.alignment = alignment or Alignment()
        self.held, self._started = np.zeros(4), False
        self._gyro_bias = np.array(self.alignment.gyro_bias)

    def step(
        self, *, dt: float, accel: Signal, gyro: Signal, attitude: Signal | None = None
    ) -> AttitudeState:
        """Predict with the previous rate, correct with the accelerometer; see `AttitudeEstimator.step`.

        Compiled, and leaves filterpy's other attributes alone; `step_by_filterpy` is the same and fills them.
        """
        up, vertical, sd = self._take(np.array([dt if self._started else 0.0]), 0.0, accel, gyro)
        return AttitudeState(up[0], float(vertical[0]), float(sd[0]))

    def step_by_filterpy(
        self, *, dt: float, accel: Signal, gyro: Signal, attitude: Signal | None = None
    ) -> AttitudeState:
        """Do what `step` does, by filterpy's own `predict` and `update`: the compiled loop's reference.

        Examples
        --------
        >>> from baroarma.estimators.attitude.quaternion_ekf import QuaternionEkf
        >>> force, rate = np.array([0.1, 0.2, 9.8]), np.array([0.01, 0.0, 0.02])
        >>> compiled, reference = QuaternionEkf(), QuaternionEkf()
        >>> a = [compiled.step(dt=0.02, accel=force, gyro=rate).acceleration for _ in range(3)]
        >>> b = [reference.step_by_filterpy(dt=0.02, accel=force, gyro=rate).acceleration for _ in range(3)]
        >>> bool(np.allclose(a, b, rtol=0, atol=1e-12))
        True
        """
        dt = dt if self._started else 0.0
        accel, gyro = as_array(accel), as_array(gyro)
        self.held[:] = forget_rate(self.held, dt)
        self._fill(dt)
        self.predict()
        if is_sample(accel) and is_lost(self.held):
            if self._level(accel):
                self.held[:] = levelled(self.held)
        elif is_sample(accel):
            self._correct(accel)
        state = self._state(accel)
        self.x_post, self.P_post = self.x.copy(), self.P.copy()
        self.held[:] = take_rate(self.held, gyro, self._gyro_bias)
        self._started = True
        return state

    def run(
        self, t: Signal, accel: Signal, gyro: Signal, attitude: Signal | None = None, *, dt: float = 0.0
    ) -> AttitudeRun:
        """Take all samples, compiled; the filter then stands where the last `step` would leave it."""
        return self._take(t, float(t[0]) - dt if len(t) else 0.0, accel, gyro)

    def _take(self, t: Signal, before: float, accel: Signal, gyro: Signal) -> AttitudeRun:
        """Take samples, the first of them t[0] - before after what came before it."""
        n = len(t)
        out = AttitudeRun(np.empty((n, 3)), np.empty(n), np.empty(n))
        self._loop(as_rows(t), before, as_rows(accel, 3), as_rows(gyro, 3), out)
        self._started = self._started or n > 0
        self.x_post, self.P_post = self.x.copy(), self.P.copy()
        return out

    @abstractmethod
    def _loop(self, t: Signal, before: float, accel: Signal, gyro: Signal, out: AttitudeRun) -> None:
        """Run the compiled loop from the present state to the last row's, and fill `out`."""

    @abstractmethod
    def _fill(self, dt: float) -> None:
        """Write F and Q for filterpy's `predict` over dt s."""

    @abstractmethod
    def _level(self, accel: Signal) -> bool:
        """Take the tilt anew from this specific force; return False in free fall."""

    @abstractmethod
    def _correct(self, accel: Signal) -> None:
        """Update by filterpy."""

    @abstractmethod
    def _state(self, accel: Signal) -> AttitudeState:
        """Return the state now, with a vertical of unit length."""
