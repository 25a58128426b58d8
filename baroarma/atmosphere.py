"""The International Standard Atmosphere: pressure to height and back.

Below 11 km the ISA has the sea-level pressure p0 = 101 325 Pa, the sea-level temperature T0 = 288.15 K and a
lapse rate of 6.5 K/km, hence the barometric formula [SG13, Eq. 4]

    h = T0/L (1 - (p/p0)^(R L/g)) = 44330.77 m (1 - (p/p0)^0.190263).

Real air is warmer or colder than the ISA's; a pressure *difference* then spans more or fewer metres by the
factor T/T_ISA.  `metres_per_pascal` and `temperature_factor` say by how much.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

STANDARD_GRAVITY: Final = 9.80665
"""Standard gravity, m/s²."""
SEA_LEVEL_PRESSURE: Final = 101_325.0
"""Pressure of the ISA at sea level, Pa."""
SEA_LEVEL_TEMPERATURE: Final = 288.15
"""Temperature of the ISA at sea level, K."""
LAPSE_RATE: Final = 0.0065
"""Fall of temperature with height in the ISA, K/m."""
EXPONENT: Final = 0.190263
"""R L / g for dry air."""
SCALE_HEIGHT: Final = SEA_LEVEL_TEMPERATURE / LAPSE_RATE
"""T0/L, m: the height at which the formula would reach vacuum."""


def pressure_altitude(pressure: ArrayLike) -> NDArray[np.float64]:
    """Convert pressure to height above the ISA's sea level.

    Parameters
    ----------
    pressure : array_like
        Pressure in Pa, positive; NaN (no sample) stays NaN.

    Returns
    -------
    ndarray
        Height in m, positive up, same shape [SG13, Eq. 4].

    Examples
    --------
    >>> round(float(pressure_altitude(100_000.0)), 3)
    110.884
    """
    return SCALE_HEIGHT * (1.0 - (np.asarray(pressure, float) / SEA_LEVEL_PRESSURE) ** EXPONENT)


def altitude_pressure(height: ArrayLike) -> NDArray[np.float64]:
    """Convert height above the ISA's sea level to pressure: the inverse of `pressure_altitude`.

    Parameters
    ----------
    height : array_like
        Height in m, below 44 330 m.

    Returns
    -------
    ndarray
        Pressure in Pa.

    Examples
    --------
    >>> round(float(altitude_pressure(0.0)), 1)
    101325.0
    """
    return SEA_LEVEL_PRESSURE * (1.0 - np.asarray(height, float) / SCALE_HEIGHT) ** (1 / EXPONENT)


def metres_per_pascal(pressure: float) -> float:
    """Return how many metres of ISA height one pascal makes at this pressure (positive).

    Examples
    --------
    >>> round(metres_per_pascal(101_325.0), 4)
    0.0832
    """
    return float(SCALE_HEIGHT * EXPONENT / pressure * (pressure / SEA_LEVEL_PRESSURE) ** EXPONENT)


def temperature_factor(pressure: float, temperature: float) -> float:
    """Return the factor by which ISA height differences are to be multiplied in air of this temperature.

    Parameters
    ----------
    pressure : float
        Pressure in Pa at which the air is looked at.
    temperature : float
        Temperature of the *air* (not of the sensor's die, which is warmer) in °C.

    Returns
    -------
    float
        T/T_ISA, 1 when the air is the ISA's.

    Examples
    --------
    >>> round(temperature_factor(101_325.0, 25.0), 4)
    1.0347
    """
    isa = SEA_LEVEL_TEMPERATURE * (pressure / SEA_LEVEL_PRESSURE) ** EXPONENT
    return float((temperature + 273.15) / isa)
