"""Local gravity is that of the WGS 84 ellipsoid, on it and above it."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from baroarma.local_gravity import ECCENTRICITY_SQUARED, FLATTENING, ROTATION, SEMI_MAJOR_AXIS, gravity

GM, OMEGA = 3986004.418e8, 7292115e-11
"""The other two defining constants of WGS 84, TR8350.2 Table 3.1: m³/s² and rad/s."""
B = SEMI_MAJOR_AXIS * math.sqrt(1 - ECCENTRICITY_SQUARED)
E = SEMI_MAJOR_AXIS * math.sqrt(ECCENTRICITY_SQUARED)


def q(u):
    return 0.5 * ((1 + 3 * u**2 / E**2) * math.atan(E / u) - 3 * u / E)


def potential(x, z):
    """The exact gravity potential of the level ellipsoid, in ellipsoidal coordinates (Heiskanen, Moritz)."""
    rr = x**2 + z**2 - E**2
    u = math.sqrt(0.5 * (rr + math.sqrt(rr**2 + 4 * E**2 * z**2)))
    sin2 = (z / u) ** 2
    spinning = 0.5 * OMEGA**2 * SEMI_MAJOR_AXIS**2 * q(u) / q(B) * (sin2 - 1 / 3)
    return GM / E * math.atan(E / u) + spinning + 0.5 * OMEGA**2 * x**2


def slope_of_potential(latitude_deg, height, step=100.0):
    phi = math.radians(latitude_deg)
    n = SEMI_MAJOR_AXIS / math.sqrt(1 - ECCENTRICITY_SQUARED * math.sin(phi) ** 2)
    x, z = (n + height) * math.cos(phi), (n * (1 - ECCENTRICITY_SQUARED) + height) * math.sin(phi)
    along_x = potential(x + step, z) - potential(x - step, z)
    along_z = potential(x, z + step) - potential(x, z - step)
    return math.hypot(along_x, along_z) / (2 * step)


@pytest.mark.parametrize("height", [0.0, 1000.0, 10_000.0])
@pytest.mark.parametrize("latitude_deg", [0.0, 30.0, 45.0, -60.0, 90.0])
def test_it_is_the_gradient_of_the_level_ellipsoids_potential(latitude_deg, height):
    # left out of the formula: the third order of h/a; of the gradient (Bruns: twice the mean curvature and
    # twice omega²/g), 3 f² and 3 m², m being f; of the second order, a few f.  The potential's q cancels
    # from 36 to 7e-5: 1e-5 m²/s² of the potential are rounding, over 200 m
    r = height / SEMI_MAJOR_AXIS
    left_out = 9.8 * (4 * r**3 + 6 * FLATTENING * r**2 + 6 * FLATTENING**2 * r)
    assert gravity(latitude_deg, height) == pytest.approx(
        slope_of_potential(latitude_deg, height), abs=left_out + 5e-8
    )


@pytest.mark.parametrize(
    ("latitude_deg", "published"),
    [(0.0, 9.7803253359), (90.0, 9.8321849378)],  # TR8350.2 Table 3.4
)
def test_it_is_the_published_gravity_of_equator_and_pole(latitude_deg, published):
    assert gravity(latitude_deg) == pytest.approx(published, abs=1e-10)  # digits printed


def test_the_constants_belong_to_one_ellipsoid():
    # b/a = 1 - f = sqrt(1 - e²) and m = omega² a² b/GM, to the digits of f, e² and m (TR8350.2, Table 3.3)
    assert pytest.approx(1 - math.sqrt(1 - ECCENTRICITY_SQUARED), abs=1e-14) == FLATTENING
    assert pytest.approx(OMEGA**2 * SEMI_MAJOR_AXIS**2 * B / GM, abs=1e-14) == ROTATION


def test_its_mean_over_the_ellipsoid_is_the_published_one():
    def band(phi):
        return math.cos(phi) / (1 - ECCENTRICITY_SQUARED * math.sin(phi) ** 2) ** 2

    total = quad(lambda phi: gravity(math.degrees(phi)) * band(phi), 0, math.pi / 2)[0]
    mean = total / quad(band, 0, math.pi / 2)[0]
    assert mean == pytest.approx(9.7976432222, abs=1e-9)  # TR8350.2 Table 3.4, mean value of normal gravity


def test_standard_gravity_is_found_half_way_between_equator_and_pole():
    latitudes = np.linspace(40, 50, 1001)
    nearest = min(latitudes, key=lambda latitude: abs(gravity(latitude) - 9.80665))
    assert nearest == pytest.approx(
        45.5, abs=0.05
    )  # 45 degrees by the formula of 1901, and half a degree since


def test_north_and_south_are_alike_and_gravity_falls_upwards():
    assert gravity(52.3) == gravity(-52.3)
    # 0.3086 mGal per metre, the free-air gradient of the textbooks, to its digits
    assert gravity(45.0) - gravity(45.0, 1.0) == pytest.approx(0.3086e-5, abs=1e-9)


def test_places_that_are_none_are_refused():
    with pytest.raises(ValueError, match="between -90 and 90 degrees, but this is 91"):
        gravity(91)
    with pytest.raises(ValueError, match="this is nan"):
        gravity(float("nan"))
    assert 9.4 < gravity(90, 100_000) < gravity(90)
    with pytest.raises(ValueError, match="up to 100000 m of height, but this is 400000"):
        gravity(0, 400_000)
