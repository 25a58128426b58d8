"""Pooling and comparing: their intervals cover, their p-values are honest."""

import math
from dataclasses import replace

import numpy as np
import pytest

from baroarma import Finding, NoiseModel, identify
from baroarma.identification import compare_models, pool
from baroarma.identification.population import table
from baroarma.noise_model import PARAMETERS
from baroarma.simulation import BMP085, Barometer, simulate_rest

TRUTH = np.array([0.27, 0.75, 0.46, 0.01])
LOG_SD = np.array([0.03, 0.08, 0.005, 0.3])


def estimate(rng, between=0.0, truth=TRUTH):
    """One made-up rest: log-normal scatter of the estimates, intervals that know it."""
    values = truth * np.exp(LOG_SD * rng.normal(size=4) + between * rng.normal(size=4))
    half = np.exp(1.96 * LOG_SD)
    ci95 = {name: (v / h, v * h) for name, v, h in zip(PARAMETERS, values, half, strict=True)}
    return NoiseModel(*values, rate_hz=50, ci95=ci95)


@pytest.mark.parametrize(("rests", "between"), [(2, 0.0), (6, 0.0), (6, 0.1), (12, 0.3)])
def test_pooled_intervals_cover_the_truth(rests, between):
    rng, covered, sets = np.random.default_rng(rests), 0, 150
    for _ in range(sets):
        ci95 = pool([estimate(rng, between) for _ in range(rests)]).ci95
        covered += sum(
            low <= v <= high for (low, high), v in zip((ci95[n] for n in PARAMETERS), TRUTH, strict=True)
        )
    # 95 %, with three binomial standard errors of 600 trials: 2.7 %
    assert 0.923 <= covered / (4 * sets) <= 0.977


def test_pooling_many_rests_sharpens_with_the_root_of_their_number():
    rng = np.random.default_rng(0)
    low, high = pool([estimate(rng) for _ in range(16)]).ci95["white_sd"]
    # homogeneous: 1/4 of one rest's; a between-variance that chance finds widens it a little
    assert math.log(high / low) == pytest.approx(2 * 1.96 * LOG_SD[2] / 4, rel=0.35)


def test_rests_that_disagree_are_said_to():
    rng = np.random.default_rng(1)
    agree, differ = (pool([estimate(rng, between) for _ in range(10)]) for between in (0.0, 0.5))
    assert agree.verdict == ()
    assert differ.verdict[0].code == "heterogeneous"
    assert "10 rests disagree about" in differ.verdict[0].message


def test_pooling_one_model_changes_nothing_but_its_name():
    one = estimate(np.random.default_rng(2))
    pooled = pool([one])
    assert [getattr(pooled, n) for n in PARAMETERS] == pytest.approx([getattr(one, n) for n in PARAMETERS])
    for name in PARAMETERS:
        assert pooled.ci95[name] == pytest.approx(one.ci95[name])
    assert pooled.method == "pooled"


def test_an_absent_term_needs_a_majority_to_stay_absent():
    rng = np.random.default_rng(3)
    ci95 = {"correlated_sd": (0, 0.1), "correlation_time": (0, 60), "white_sd": (0.45, 0.47)}
    without = NoiseModel(0, 0, 0.46, 0.01, rate_hz=50, ci95={**ci95, "drift_rate": (0.005, 0.02)})
    minority = pool([without, estimate(rng), estimate(rng)])
    assert minority.correlated_sd == pytest.approx(0.27, rel=0.1)
    majority = pool([without, without, estimate(rng)])
    assert (majority.correlated_sd, majority.correlation_time) == (0, 0)
    assert majority.ci95["correlated_sd"][1] > 0.27


def test_models_at_other_rates_are_pooled_by_density():
    one = estimate(np.random.default_rng(4))
    pooled = pool([one, one.at_rate(200)])
    assert pooled.rate_hz == 50
    assert pooled.white_sd == pytest.approx(one.white_sd)


def test_a_unit_with_more_white_noise_is_told_from_one_without():
    rng = np.random.default_rng(5)
    worse = estimate(rng, truth=TRUTH * [1, 1, 1.3, 1])
    by_name = {r.parameter: r for r in compare_models(worse, estimate(rng))}
    low, high = by_name["white_sd"].ci95
    assert low > 1
    assert low < 1.3 < high
    assert by_name["white_sd"].p < 1e-6


def test_equal_units_are_called_different_in_five_percent():
    rng = np.random.default_rng(6)
    p = [r.p for _ in range(150) for r in compare_models(estimate(rng), estimate(rng))]
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.027)  # three binomial standard errors


def test_a_missing_term_has_no_ratio():
    ci95 = {"correlated_sd": (0, 0.1), "correlation_time": (0, 60), "white_sd": (0.45, 0.47)}
    white = NoiseModel(0, 0, 0.46, 0.01, rate_hz=50, ci95={**ci95, "drift_rate": (0.005, 0.02)})
    for other in (white, estimate(np.random.default_rng(7))):
        first = compare_models(white, other)[0]
        assert first.ratio is None
        assert "lack it" in str(first)


@pytest.mark.parametrize("call", [pool, lambda models: compare_models(*models)])
def test_models_without_intervals_are_refused(call):
    with pytest.raises(ValueError, match="has no intervals"):
        call([BMP085.noise, BMP085.noise])


def test_nothing_to_pool_is_refused():
    with pytest.raises(ValueError, match="no model to pool"):
        pool([])


def test_identified_recordings_pool_compare_and_print():
    noisy = Barometer(replace(BMP085.noise, white_sd=1.3 * 0.46))
    rests = [simulate_rest(200, seed=1), simulate_rest(200, seed=2, barometer=noisy)]
    found = [identify(replace(r, name=n)) for r, n in zip(rests, ("good", "bad"), strict=True)]
    pooled = pool([f.model for f in found])
    assert pooled.source == {"name": "good, bad", "sha256": None, "duration_s": pytest.approx(399.96)}
    assert pooled.verdict[0].code == "heterogeneous"
    text = table(found, pooled)
    assert [line.split()[0] for line in text.splitlines()[:4]] == ["recording", "good", "bad", "pooled"]
    assert "bad against good:" in text
    assert "white sd: 1.3" in text


def test_a_refused_recording_has_dashes_in_the_table():
    found = identify(simulate_rest(5, seed=1))
    assert found.verdict[0] == Finding("too-short", "error", found.verdict[0].message)
    assert table([found, found]).splitlines()[1].split() == ["rest", "-", "-", "-", "-", "too-short"]
