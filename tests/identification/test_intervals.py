"""95 % intervals of structural fits: they cover, they stay finite, and absent terms have an upper end."""

import math
from dataclasses import replace

import numpy as np
import pytest

from baroarma import NoiseModel
from baroarma.identification.intervals import CHI95, intervals, log_sd, observed_information
from baroarma.identification.problem import Problem
from baroarma.identification.scoring import maximise
from baroarma.identification.structural import SUBSETS, fit_terms

NOISE = NoiseModel(0.3, 0.5, 0.3, 0.05, rate_hz=10)
THETA = np.array([0.3, 0.05, 0.3, 0.5])
NAMES = ("white_sd", "drift_rate", "correlated_sd", "correlation_time")


def problem_of(noise, n, seed):
    t = np.arange(n) / noise.rate_hz
    return Problem(t, noise.simulate(t, seed))


def test_intervals_cover_the_truth():
    inside = []
    for seed in range(120):
        problem = problem_of(NOISE, 3000, seed)
        found = intervals(problem, fit_terms(problem, ("white", "drift", "gm")))
        inside.append([found[n][0] <= v <= found[n][1] for n, v in zip(NAMES, THETA, strict=True)])
    # 480 intervals in 120 groups: the standard error of the share is at most 2 % (all four of a fit together)
    assert 0.91 <= np.mean(inside) <= 0.99
    assert np.all(np.mean(inside, axis=0) >= 0.95 - 3 * math.sqrt(0.95 * 0.05 / 120))


@pytest.mark.parametrize("terms", SUBSETS, ids=" + ".join)
def test_every_model_has_four_finite_intervals_of_plain_floats(terms):
    problem = problem_of(NOISE, 1500, 1)
    fit = fit_terms(problem, terms)
    found = intervals(problem, fit)
    assert set(found) == set(NAMES)
    for name, value in zip(NAMES, [*fit.theta, 0.0, 0.0][:4], strict=True):
        low, high = found[name]
        assert type(low) is type(high) is float
        assert 0 <= low <= value * (1 + 1e-12)
        assert value < high < math.inf
        assert (low == 0) >= (value == 0)


def test_an_absent_terms_interval_starts_at_zero_and_ends_where_the_likelihood_falls():
    problem = problem_of(NoiseModel(0, 0, 0.3, rate_hz=10), 3000, 2)
    low, high = intervals(problem, fit_terms(problem, ("white",)))["drift_rate"]
    assert low == 0
    best = fit_terms(problem, ("white", "drift"))
    _, value = maximise(problem, np.array([0.3, high]), [0])
    # the search stops within 1 % of the quantile
    assert 2 * (best.log_likelihood - value) == pytest.approx(CHI95, rel=0.02)


def test_wald_sds_are_those_of_repeated_samples():
    estimates, sds = [], []
    for seed in range(80):
        problem = problem_of(NOISE, 3000, seed)
        fit = fit_terms(problem, ("white", "drift", "gm"))
        estimates.append(np.log(fit.theta))
        sds.append(log_sd(problem, fit))
    wald, scatter = np.median(sds, axis=0), np.std(estimates, axis=0, ddof=1)
    # an sd from 80 samples has a standard error of 8 %; the drift's logarithm is far from normal
    assert scatter[[0, 2, 3]] / wald[[0, 2, 3]] == pytest.approx(1, abs=0.25)


def test_a_parameter_that_the_data_know_nothing_about_is_unknown_not_certain():
    problem = problem_of(NoiseModel(0, 0, 0.3, rate_hz=10), 2000, 3)
    least = problem.bounds(4)[0][2]
    fit = replace(fit_terms(problem, ("white", "gm")), theta=np.array([0.3, 0.0, least, 1.0]))
    sd = log_sd(problem, fit)
    assert sd[3] > 1  # a factor of e and more
    assert sd[0] == pytest.approx(1 / math.sqrt(2 * 2000), rel=0.1)
    assert intervals(problem, fit)["correlated_sd"][0] == 0


def test_the_observed_information_is_symmetric_and_positive():
    problem = problem_of(NOISE, 3000, 4)
    fit = fit_terms(problem, ("white", "drift", "gm"))
    information = observed_information(problem, fit.theta, fit.free)
    assert information == pytest.approx(information.T)
    assert np.linalg.eigvalsh(information)[0] > 0
