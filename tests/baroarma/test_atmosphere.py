"""The International Standard Atmosphere."""

import numpy as np
import pytest

from baroarma.atmosphere import (
    EXPONENT,
    LAPSE_RATE,
    STANDARD_GRAVITY,
    altitude_pressure,
    metres_per_pascal,
    pressure_altitude,
    temperature_factor,
)


def test_height_and_pressure_are_inverse():
    height = np.linspace(-400, 10_000, 50)
    assert pressure_altitude(altitude_pressure(height)) == pytest.approx(height, abs=1e-8)


@pytest.mark.parametrize(
    ("height", "pressure"), [(0, 101325.0), (1000, 89874.6), (5000, 54019.9), (11000, 22632.1)]
)
def test_pressure_is_the_published_one(height, pressure):
    # ISO 2533 / U.S. Standard Atmosphere 1976, table of geopotential heights; six printed digits
    assert float(altitude_pressure(height)) == pytest.approx(pressure, rel=3e-5)


def test_metres_per_pascal_is_the_slope():
    slope = -(pressure_altitude(100_001.0) - pressure_altitude(99_999.0)) / 2
    assert metres_per_pascal(100_000.0) == pytest.approx(float(slope), rel=1e-8)


def test_one_pascal_is_the_papers_quantum():
    # SG13, Sec. 2.3: "1 Pa (corresponding to about 8.43 cm)", a sea-level pressure of about 99 900 Pa
    assert metres_per_pascal(99_900.0) == pytest.approx(0.0843, abs=2e-4)


def test_warm_air_stretches_metres():
    assert temperature_factor(101_325.0, 15.0) == pytest.approx(1.0)
    assert temperature_factor(101_325.0, 15.0 + 28.815) == pytest.approx(1.1)


def test_the_exponent_is_that_of_dry_air_in_standard_gravity():
    # R = 287.05287 J/(kg K) and 9.80665 m/s2, ISO 2533; the exponent's six digits
    assert STANDARD_GRAVITY == 9.80665
    assert pytest.approx(287.05287 * LAPSE_RATE / STANDARD_GRAVITY, abs=1e-6) == EXPONENT


def test_the_isa_is_as_warm_as_its_lapse_rate_says():
    # 3000 m: 288.15 K - 19.5 K; the exponent's digits make 1e-6 of it
    air = temperature_factor(float(altitude_pressure(3000.0)), -4.5)
    assert air == pytest.approx(1.0, rel=1e-6)


def test_single_precision_is_computed_in_double():
    logged = np.float32([100_000.25, 89_874.5])
    assert np.array_equal(pressure_altitude(logged), pressure_altitude(logged.astype(float)))
    heights = np.float32([123.456, -7.1])
    assert np.array_equal(altitude_pressure(heights), altitude_pressure(heights.astype(float)))
