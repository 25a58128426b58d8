"""Sensors that turn true motion into samples: noise, bias, quantisation.

Each constant is marked "printed" (in the paper) or "chosen by us".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY, altitude_pressure
from baroarma.noise_model import NoiseModel

Signal = NDArray[np.float64]


@dataclass(frozen=True)
class Barometer:
    """Describe a barometer by its noise and its resolution.

    Parameters
    ----------
    noise : NoiseModel
        Noise of its raw samples.
    quantum : float
        Resolution in Pa; 0: none.
    """

    noise: NoiseModel
    quantum: float = 1.0

    def sample(self, t: Signal, height: Signal, rng: np.random.Generator) -> Signal:
        """Return the pressure in Pa that it would log at true heights (m above the ISA's sea level)."""
        pressure = altitude_pressure(height + self.noise.simulate(t, rng))
        return np.round(pressure / self.quantum) * self.quantum if self.quantum else pressure


@dataclass(frozen=True)
class Imu:
    """Describe an accelerometer and a gyro: white noise per sample and a constant bias.

    Parameters
    ----------
    accel_sd, gyro_sd : float
        White noise of one sample, m/s² and rad/s.
    accel_bias_sd, gyro_bias_sd : float
        Spread of the biases of a unit, drawn once per recording and axis, m/s² and rad/s.
    """

    accel_sd: float
    gyro_sd: float
    accel_bias_sd: float
    gyro_bias_sd: float

    def sample(self, force: Signal, rate: Signal, rng: np.random.Generator) -> tuple[Signal, Signal]:
        """Return accelerometer and gyro samples of true specific force and angular rate, each (n, 3)."""
        noise = rng.normal(size=(2, *force.shape))
        bias = rng.normal(size=(2, 3))
        accel = force + self.accel_sd * noise[0] + self.accel_bias_sd * bias[0]
        return accel, rate + self.gyro_sd * noise[1] + self.gyro_bias_sd * bias[1]


BMP085: Final = Barometer(
    NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50.0, sensor="BMP085, ultra-low power"), quantum=1.0
)
"""SG13: conditioned sigma_c, tau and 1 Pa printed (Tables 1-2, Sec. 2.3); raw white sd and drift chosen by us
so that those tables come out."""
WIMU: Final = Imu(
    accel_sd=2.5e-3 * STANDARD_GRAVITY,
    gyro_sd=np.deg2rad(0.15),
    accel_bias_sd=2e-3 * STANDARD_GRAVITY,
    gyro_bias_sd=np.deg2rad(0.5),
)
"""BMA180 and ITG-3200 of SG13 and SG14; all chosen by us."""
