"""Vertical acceleration without attitude: modulus of the specific force minus gravity [Lee16, Sec. 2.3].

    a_app = |s_A| - g

It needs no gyro and no alignment.  A horizontal acceleration a_h reads as about a_h²/(2 g) upwards, and so
does everything that turns: an error of the method, which its standard deviation does not contain.
"""

from __future__ import annotations

import numpy as np

from baroarma.estimators.attitude.samples import hold_last
from baroarma.estimators.base import Alignment, AttitudeEstimator, AttitudeRun, AttitudeState, Signal


class AccelerometerNorm(AttitudeEstimator):
    """Take the specific force itself for the vertical.

    Parameters
    ----------
    accel_noise_sd : float
        m/s².  Default 0.04 (chosen by us): the MPU-6050's 400 ug/rtHz over 100 Hz, 4 mg.  It is the sd of
        the result and has no other effect.

    Examples
    --------
    >>> norm = AccelerometerNorm()
    >>> state = norm.step(dt=0.02, accel=np.array([0.0, 6.0, 8.0]), gyro=np.zeros(3))
    >>> state.up, round(state.acceleration, 3)
    (array([0. , 0.6, 0.8]), 0.193)
    """

    def __init__(self, *, accel_noise_sd: float = 0.04) -> None:
        self.accel_noise_sd = accel_noise_sd
        self.reset()

    def reset(self, alignment: Alignment | None = None) -> None:
        """Take gravity, and the vertical until the first sample, from the alignment."""
        self.alignment = alignment or Alignment()
        self.up = np.array(self.alignment.up)

    def step(
        self, *, dt: float, accel: Signal, gyro: Signal, attitude: Signal | None = None
    ) -> AttitudeState:
        """Take one sample; neither time nor gyro matters."""
        ups, acceleration, sd = self.run(np.zeros(1), accel[None], gyro[None])
        return AttitudeState(ups[0], float(acceleration[0]), float(sd[0]))

    def run(
        self, t: Signal, accel: Signal, gyro: Signal, attitude: Signal | None = None, *, dt: float = 0.0
    ) -> AttitudeRun:
        """Take all samples; without one the vertical stays what it was."""
        modulus = np.linalg.norm(accel, axis=1)
        ups = np.full(accel.shape, np.nan)
        np.divide(accel, modulus[:, None], out=ups, where=modulus[:, None] > 0)
        hold_last(ups, self.up)
        sd = np.where(np.isfinite(modulus), self.accel_noise_sd, np.nan)
        return AttitudeRun(ups, modulus - self.alignment.gravity, sd)
