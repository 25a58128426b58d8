"""Hints for other programs: a filter or simulator that does what they assume confirms each number."""

import math
from xml.etree import ElementTree

import numpy as np
import pytest

from baroarma import NoiseModel
from baroarma.atmosphere import altitude_pressure
from baroarma.estimators.height.kalman import white_sd
from baroarma.export import hints
from baroarma.export.hints import white_equivalent_sd

NOISE = NoiseModel(0.27, 0.75, 0.46, rate_hz=50)
DRIFTING = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)
WALK = NoiseModel(0, 0, 0.3, 0.02, rate_hz=10)


def settings_of(noise, tool, **options):
    (hint,) = (h for h in hints(noise, **options) if h.tool == tool)
    return {s.name: s.value for s in hint.settings}


def test_the_white_equivalent_has_the_models_density_at_low_frequency():
    # one-sided densities; at 1 mHz the Gauss-Markov term is at its plateau to (2 pi f tau)² = 2e-5
    density = 2 * white_equivalent_sd(NOISE, 20.0) ** 2 / 20.0
    assert NOISE.psd(1e-3) == pytest.approx(density, rel=1e-3)
    assert white_equivalent_sd(NOISE, 50.0) == pytest.approx(white_sd(NOISE, 0.02, "inflate"))


def test_means_over_a_long_time_scatter_as_if_the_white_equivalent_were_true():
    rng = np.random.default_rng(3)
    n, blocks = 4000, 400  # 80 s each, a hundred correlation times
    means = [NOISE.simulate(n, rng).mean() for _ in range(blocks)]
    sd = white_equivalent_sd(NOISE, 50.0) / math.sqrt(n)
    # the sd of 400 is known to 1/sqrt(800) = 3.5 %; four of these, and 1 % for the blocks' ends
    assert np.std(means) / sd == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize(("tool", "name"), [("PX4", "EKF2_BARO_NOISE"), ("ArduPilot", "EK3_ALT_M_NSE")])
def test_autopilots_get_the_white_equivalent_at_the_rate_they_fuse(tool, name):
    value = settings_of(NOISE, tool)[name]
    assert value == pytest.approx(white_equivalent_sd(NOISE, 20.0), abs=0.05)
    slow = NoiseModel(0.27, 0.75, 0.46, rate_hz=8)
    assert settings_of(slow, tool)[name] == pytest.approx(white_equivalent_sd(slow, 8.0), abs=0.05)


def test_autopilots_limits_are_kept_and_told():
    quiet = NoiseModel(0, 0, 0.001, rate_hz=50)
    (px4, ardupilot, *_) = hints(quiet)
    assert (px4.settings[0].value, ardupilot.settings[0].value) == (0.01, 0.1)
    assert "kept within 0.01 to 15 m" in px4.settings[0].why
    loud = settings_of(NoiseModel(30.0, 10.0, 1.0, rate_hz=50), "PX4")
    assert loud["EKF2_BARO_NOISE"] == 15.0


def matlab(values, n, rng):
    """What altimeterSensor does, from its documentation: white and first-order noise, in m."""
    from scipy.signal import lfilter

    rate, density, instability, d = values.values()
    white = density * math.sqrt(rate / 2) * rng.normal(size=n)
    slow = lfilter([1.0], [1.0, -d], math.sqrt(2 * (1 - d)) * instability * rng.normal(size=n))
    return white + slow


def gazebo(values, n, rng):
    """What the Gaussian noise with a dynamic bias does, from its documentation, in Pa."""
    from scipy.signal import lfilter

    rate, sd, start, drive, tau = values.values()
    phi = math.exp(-1 / (rate * tau))
    steps = drive * math.sqrt(tau / 2 * -math.expm1(-2 / (rate * tau))) * rng.normal(size=n)
    steps[0] = start * rng.normal()
    return sd * rng.normal(size=n) + lfilter([1.0], [1.0, -phi], steps)


@pytest.mark.parametrize("tool", ["MATLAB", "Gazebo"])
def test_simulators_then_make_noise_of_the_models_autocovariance(tool):
    rng, n = np.random.default_rng(4), 200_000
    simulated = {"MATLAB": matlab, "Gazebo": gazebo}[tool](settings_of(NOISE, tool), n, rng)
    if tool == "Gazebo":
        pascals = float(altitude_pressure(0.0) - altitude_pressure(1.0))
        simulated = simulated / pascals
    for lag in (0, 1, 20, 50):
        found = np.mean(simulated[: n - lag] * simulated[lag:])
        # 4000 s hold some 2700 independent stretches of 2 tau: 2 sd of their variance is 4 % of sigma_c²
        assert found == pytest.approx(
            NOISE.autocovariance(lag / 50.0), abs=0.06 * 0.27**2 + 0.004 * 0.46**2
        ), lag


def test_without_gauss_markov_gazebos_slow_bias_is_the_drift():
    values = settings_of(WALK, "Gazebo")
    pascals = values["stddev"] / WALK.white_sd
    paths = [gazebo({**values, "stddev": 0.0}, 601, np.random.default_rng(seed)) for seed in range(400)]
    grown = np.std([path[-1] - path[0] for path in paths]) / pascals
    # a minute of random walk; 400 of them tell its sd to 3.5 %, four of these
    assert grown == pytest.approx(WALK.drift_rate * math.sqrt(60), rel=0.14)


def test_gazebos_snippet_is_xml_with_the_numbers():
    (hint,) = (h for h in hints(NOISE) if h.tool == "Gazebo")
    sensor = ElementTree.fromstring(hint.snippet)
    assert sensor.get("type") == "air_pressure"
    assert float(sensor.find("update_rate").text) == 50
    noise = sensor.find("air_pressure/pressure/noise")
    for setting in hint.settings[1:]:
        assert float(noise.find(setting.name).text) == pytest.approx(setting.value, rel=1e-5)


def test_higher_up_a_metre_is_fewer_pascals():
    low, high = (settings_of(NOISE, "Gazebo", pressure=p)["stddev"] for p in (101_325.0, 70_000.0))
    assert low == pytest.approx(0.46 * 12.01, rel=1e-3)  # ISA at sea level: 12.01 Pa/m
    assert high < 0.8 * low
    with pytest.raises(ValueError, match="positive number of Pa, but it is 0"):
        hints(NOISE, pressure=0.0)


def test_a_drift_that_no_parameter_carries_is_told():
    for hint in hints(DRIFTING):
        assert any("0.01 m in a second and 0.077 m in a minute" in limit for limit in hint.limits), hint.tool
    assert not any("drift" in limit for hint in hints(NOISE) for limit in hint.limits)
