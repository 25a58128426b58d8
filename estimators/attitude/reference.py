"""The reference attitude: somebody better, such as a motion capture system, says how the body is held.

    a_OPT = up . s_A - g                                                                   [Lee16, Sec. 2.3]

It shows what the rest of an experiment loses by the attitude filter alone.
"""

from __future__ import annotations

import math

import numpy as np

from baroarma.compiled import as_array
from baroarma.estimators.attitude.samples import hold_last
from baroarma.estimators.attitude.vertical import project
from baroarma.estimators.base import Alignment, AttitudeEstimator, AttitudeRun, AttitudeState, Signal
from baroarma.rotation import up_from_quaternion


class ReferenceAttitude(AttitudeEstimator):
    """Pass a given attitude on and project the specific force by it.

    Parameters
    ----------
    accel_noise_sd : float
        m/s².  Default 0.04 (chosen by us): the MPU-6050's 400 ug/rtHz over 100 Hz, 4 mg.
    tilt_sd : float
        Error of the given tilt about each horizontal axis, rad.  Default 0.2° (chosen by us): usual for
        markers a hand's breadth apart.  Both only size the sd of the result.

    Examples
    --------
    >>> reference = ReferenceAttitude()
    >>> upside_down = np.array([1.0, 0.0, 0.0, 0.0])
    >>> state = reference.step(
    ...     dt=0.02, accel=np.array([0.0, 0.0, -9.9]), gyro=np.zeros(3), attitude=upside_down
    ... )
    >>> round(state.acceleration, 3)
    0.093
    """

    def __init__(self, *, accel_noise_sd: float = 0.04, tilt_sd: float = math.radians(0.2)) -> None:
        self.accel_noise_sd = accel_noise_sd
        self.tilt_sd = tilt_sd
        self.reset()

    def reset(self, alignment: Alignment | None = None) -> None:
        """Take gravity, and the vertical until the first attitude, from the alignment."""
        self.alignment = alignment or Alignment()
        self.up = np.array(self.alignment.up)

    def step(
        self, *, dt: float, accel: Signal, gyro: Signal, attitude: Signal | None = None
    ) -> AttitudeState:
        """Take one sample; neither time nor gyro matters."""
        rows = None if attitude is None else attitude[None]
        ups, acceleration, sd = self.run(np.zeros(1), accel[None], gyro[None], rows)
        return AttitudeState(ups[0], float(acceleration[0]), float(sd[0]))

    def run(
        self, t: Signal, accel: Signal, gyro: Signal, attitude: Signal | None = None, *, dt: float = 0.0
    ) -> AttitudeRun:
        """Take all samples; where an attitude is NaN the vertical stays what it was.

        Raises
        ------
        ValueError
            If no attitude is given.
        """
        if attitude is None:
            raise ValueError(
                "the attitude estimator 'reference' needs a recording with reference_attitude; this one has "
                "none, so choose an estimator that works from accelerometer and gyro"
            )
        ups = up_from_quaternion(attitude / np.linalg.norm(attitude, axis=1, keepdims=True))
        hold_last(ups, self.up)
        out = AttitudeRun(ups, np.empty(len(ups)), np.empty(len(ups)))
        P = self.tilt_sd**2 * np.eye(3)
        project(as_array(accel), ups, P, self.alignment.gravity, self.accel_noise_sd, *out[1:])
        return out
