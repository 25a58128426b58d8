"""Local gravity from latitude and height: Somigliana's formula on the WGS 84 ellipsoid, less upwards.

On the ellipsoid [NIMA TR8350.2, third edition, Eq. 4-1; k, e² and gamma_e from its Tables 3.3 and 3.4]

    gamma = gamma_e (1 + k sin²(phi)) / sqrt(1 - e² sin²(phi)),

and at a height h above it, to second order in h/a [Eq. 4-3]

    gamma_h = gamma (1 - 2/a (1 + f + m - 2 f sin²(phi)) h + 3 h²/a²).

Real gravity differs from that by up to about 0.001 m/s² (mountains, density of the crust): ten times less
than the latitude's 0.05 m/s² between equator and pole.

What needs it: the accelerometer's scale in `calibrate`, which can't be told from the g that it is compared
with, and the bias that `ImuNoise.from_recording` reads off one rest.  What doesn't: the trackers, who take g
from their first second of rest.  Heights from pressure are *geopotential* metres, of which one is 9.80665/g
geometric metres: 0.27 % more at the equator, 0.26 % less at the poles, 3 cm in a climb of 12 m.
"""

from __future__ import annotations

import math
from typing import Final

EQUATOR: Final = 9.7803253359
"""Normal gravity on the equator, gamma_e, m/s²."""
SOMIGLIANA: Final = 0.00193185265241
"""Somigliana's constant k = b gamma_p/(a gamma_e) - 1."""
ECCENTRICITY_SQUARED: Final = 6.69437999014e-3
"""First eccentricity squared, e²."""
SEMI_MAJOR_AXIS: Final = 6_378_137.0
"""a, m."""
FLATTENING: Final = 1 / 298.257223563
"""f."""
ROTATION: Final = 0.00344978650684
"""Centrifugal force over gravity, m = omega² a² b/GM."""
HIGHEST: Final = 100_000.0
"""Height in m beyond which the second order does not serve."""


def gravity(latitude_deg: float, height: float = 0.0) -> float:
    """Return the gravity of a place.

    Parameters
    ----------
    latitude_deg : float
        Geodetic latitude in degrees, as a GPS receiver tells it; north and south are alike.
    height : float
        Height above the ellipsoid in m, up to 100 km; above sea level serves as well (30 m are 0.0001 m/s²).

    Returns
    -------
    float
        m/s².

    Raises
    ------
    ValueError
        If the latitude is none, or the height too great.

    Examples
    --------
    >>> [round(gravity(latitude), 5) for latitude in (0, 45, 90)]
    [9.78033, 9.8062, 9.83218]
    >>> round(gravity(46.5, 3000), 4)
    9.7983
    """
    if not abs(latitude_deg) <= 90:
        raise ValueError(f"a latitude lies between -90 and 90 degrees, but this is {latitude_deg}")
    if not abs(height) <= HIGHEST:
        raise ValueError(f"the formula holds up to {HIGHEST:g} m of height, but this is {height}")
    s2 = math.sin(math.radians(latitude_deg)) ** 2
    level = EQUATOR * (1 + SOMIGLIANA * s2) / math.sqrt(1 - ECCENTRICITY_SQUARED * s2)
    h = height / SEMI_MAJOR_AXIS
    return level * (1 - 2 * (1 + FLATTENING + ROTATION - 2 * FLATTENING * s2) * h + 3 * h**2)
