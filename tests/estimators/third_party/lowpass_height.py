"""A third party's height estimator: a low-pass filter of the barometer that ignores the accelerometer."""

import math

import numpy as np

from baroarma.estimators.base import HeightEstimator, HeightRun, HeightState


class LowPass(HeightEstimator):
    """Follow the barometer with a time constant of 1 s; the sd only grows without it."""

    def __init__(self, *, noise=None, dt=None, time_constant=1.0):
        self.white_sd = 0.5 if noise is None else noise.white_sd
        self.time_constant = time_constant
        self.reset()

    def reset(self, alignment=None):
        self.height, self.variance, self.started = 0.0, 1e-6, False

    def step(self, *, dt, altitude, at_rest=False, **unused):
        gain = -math.expm1(-dt / self.time_constant) if self.started else 0.0
        self.variance += dt if self.started else 0.0
        self.started = True
        velocity = 0.0
        if not math.isnan(altitude):
            velocity = (altitude - self.height) / self.time_constant
            self.height += gain * (altitude - self.height)
            self.variance = (1 - gain) ** 2 * self.variance + gain**2 * self.white_sd**2
        return HeightState(self.height, velocity, math.sqrt(self.variance), 1.0)

    def run(self, t, altitude, *unused, **also_unused):
        steps = zip(np.diff(t, prepend=t[:1]), altitude, strict=True)
        states = [self.step(dt=float(dt), altitude=float(z)) for dt, z in steps]
        return HeightRun(*np.array(states).reshape(-1, 4).T)
