"""Noise models: identities between their views, and a round trip through JSON."""

import json
import math

import numpy as np
import pytest
from scipy import integrate, stats

from baroarma import Finding, NoiseModel

SG13 = NoiseModel(0.27, 0.75, 0.46, rate_hz=50)
WITH_DRIFT = NoiseModel(0.27, 0.75, 0.46, 0.02, rate_hz=50)


def test_the_spectrum_integrates_to_the_variance():
    variance, _ = integrate.quad(lambda f: float(SG13.psd(f)), 0, 25, limit=200)
    assert variance == pytest.approx(0.27**2 + 0.46**2)
    assert float(SG13.autocovariance(0)) == pytest.approx(0.27**2 + 0.46**2)


def test_arma_has_the_same_spectrum_and_autocovariance():
    arma = SG13.arma(1 / 50)
    frequency = np.linspace(0, 25, 60)
    assert arma.psd(frequency) == pytest.approx(SG13.psd(frequency))
    assert arma.autocovariance(5) == pytest.approx(SG13.autocovariance(np.arange(6) / 50))


def test_a_change_of_rate_keeps_the_density():
    slow = SG13.at_rate(10)
    assert slow.white_density == pytest.approx(SG13.white_density)
    assert slow.white_sd == pytest.approx(0.46 / math.sqrt(5))
    assert slow.correlated_sd == SG13.correlated_sd


def test_averages_of_the_white_part_have_the_sd_of_the_slower_rate():
    noise = NoiseModel(0, 0, 0.46, rate_hz=50)
    averaged = noise.simulate(100_000, 0).reshape(-1, 5).mean(axis=1)
    assert np.std(averaged) == pytest.approx(noise.at_rate(10).white_sd, rel=0.02)  # 1/sqrt(2*20000) = 0.5 %


@pytest.mark.parametrize("irregular", [False, True])
def test_simulated_noise_has_the_autocovariance(irregular):
    rng = np.random.default_rng(3)
    noise = NoiseModel(0.5, 0.75, 0.2, rate_hz=10)
    t = np.cumsum(rng.uniform(0.02, 0.18, 200_000)) if irregular else np.arange(200_000) / 10
    x = noise.simulate(t, rng)
    for k in (1, 5, 10):
        expected = np.mean(noise.autocovariance(t[k:] - t[:-k]))
        assert np.mean(x[k:] * x[:-k]) == pytest.approx(expected, abs=4 * 0.29 * math.sqrt(15 / 200_000))


def test_drift_grows_with_the_square_root_of_time():
    ends = [NoiseModel(0, 0, 0, 0.02, rate_hz=1).simulate(101, seed)[-1] for seed in range(2000)]
    assert np.std(ends) == pytest.approx(0.02 * 10, rel=0.06)  # 1/sqrt(2*2000) = 1.6 %


@pytest.mark.parametrize("tau", [0.02, 0.5, 1.5, 40.0])
def test_allan_deviation_is_the_integral_of_the_spectrum(tau):
    # sigma_A^2 = 2 int S_y(f) sin^4(pi f tau)/(pi f tau)^2 df with the one-sided density (IEEE Std 1139)
    def density(f):
        w = 2 * np.pi * f
        return 2 * 2 * 0.27**2 * 0.75 / (1 + (w * 0.75) ** 2) + 2 * 0.02**2 / w**2

    f = np.geomspace(1e-5 / tau, 2e3 / tau, 2_000_001)
    y = density(f) * np.sin(np.pi * f * tau) ** 4 / (np.pi * f * tau) ** 2
    expected = math.sqrt(2 * float(integrate.trapezoid(y, f)) + WITH_DRIFT.white_density / tau)
    assert float(WITH_DRIFT.allan_deviation(tau)) == pytest.approx(expected, rel=2e-3)  # the integration's


def test_json_round_trip_is_exact(tmp_path):
    noise = NoiseModel(
        0.1 + 0.2,
        1 / 3,
        math.pi,
        1e-17,
        rate_hz=49.99999,
        ci95=dict.fromkeys(("correlated_sd", "correlation_time", "white_sd", "drift_rate"), (0.1, 2 / 3)),
        method="structural",
        sensor="BMP085",
        verdict=(Finding("gaps", "info", "One gap."),),
        whiteness_p={"ljung_box_10": 0.5, "ljung_box_40": 0.25, "bartlett": 1e-300},
        source={"name": "rest.csv", "sha256": "00", "duration_s": 600.0},
    )
    noise.save(tmp_path / "noise.json")
    again = NoiseModel.load(tmp_path / "noise.json")
    assert again == noise
    assert hash(again) == hash(noise)
    assert list(tmp_path.iterdir()) == [tmp_path / "noise.json"]
    assert json.loads((tmp_path / "noise.json").read_text())["format"] == "baroarma.noise-model"


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"format": "x"}, "no noise model"),
        ({"version": 2}, "version 2"),
        ({"white_sd_m": "much"}, "wrong kind"),
        ({"white_sd_m": -1}, "must be a number >= 0"),
        ({"ci95": {"white_sd_m": [0, 1]}}, "lacks the key"),
    ],
)
def test_a_broken_file_is_refused_in_a_sentence(tmp_path, change, sentence):
    path = tmp_path / "noise.json"
    path.write_text(json.dumps({**SG13.to_dict(), **change}))
    with pytest.raises(ValueError, match=sentence) as caught:
        NoiseModel.load(path)
    assert str(path) in str(caught.value)


def test_half_a_gauss_markov_component_is_refused():
    with pytest.raises(ValueError, match="either both are 0"):
        NoiseModel(0.27, 0, 0.46, rate_hz=50)


def test_the_density_sets_the_zero_time_constant():
    w = SG13.whitening_filter()
    s_u, s_c = 0.46**2 / 50, 2 * 0.27**2 * 0.75
    assert 1 / (2 * math.pi * w.pole_hz) == pytest.approx(0.75 * math.sqrt(s_u / (s_u + s_c)))


@pytest.mark.parametrize("value", [0, -1, float("nan")])
def test_a_rate_or_an_interval_that_cannot_be_is_named(value):
    with pytest.raises(ValueError, match="the rate must be a positive number of Hz"):
        SG13.at_rate(value)
    with pytest.raises(ValueError, match="the sampling interval must be positive"):
        SG13.arma(value)


SURE = {"correlated_sd": (0.2, 0.3), "correlation_time": (0.5, 1.0), "white_sd": (0.4, 0.5)}


def test_the_drift_that_can_not_be_excluded_is_the_rms_of_a_half_normal_with_that_quantile():
    upper = 0.02
    unsure = NoiseModel(0.27, 0.75, 0.46, rate_hz=50, ci95={**SURE, "drift_rate": (0.0, upper)})
    possible = unsure.with_possible_drift()
    # the 95 % quantile of |N(0, s²)|, whose rms is s
    assert stats.halfnorm.ppf(0.95, scale=possible.drift_rate) == pytest.approx(upper, rel=1e-6)
    assert (possible.correlated_sd, possible.correlation_time, possible.white_sd) == (0.27, 0.75, 0.46)
    assert possible.ci95 == unsure.ci95
    assert unsure.drift_rate == 0.0


def test_a_drift_that_is_there_or_excluded_or_unheard_of_stays():
    found = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50, ci95={**SURE, "drift_rate": (0.005, 0.02)})
    excluded = NoiseModel(0.27, 0.75, 0.46, rate_hz=50, ci95={**SURE, "drift_rate": (0.0, 0.0)})
    for noise in (found, excluded, SG13):
        assert noise.with_possible_drift() == noise
