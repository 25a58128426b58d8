"""The maximum of the structural likelihood against SciPy's and against the truth."""

import numpy as np
import pytest

from baroarma import NoiseModel
from baroarma.identification import structural
from baroarma.identification.intervals import intervals, log_sd, observed_information
from baroarma.identification.problem import Problem
from baroarma.identification.scoring import maximise
from baroarma.identification.structural import SUBSETS, fit_second_gauss_markov, fit_terms, select_terms
from baroarma.simulation import BMP085, simulate_rest


def problem_of(noise, n, seed):
    t = np.arange(n) / noise.rate_hz
    return Problem(t, noise.simulate(t, seed))


def test_scoring_finds_scipys_maximum():
    from scipy.optimize import minimize

    problem = problem_of(NoiseModel(0.27, 0.75, 0.46, 0.02, rate_hz=50), 6000, 4)
    fit = fit_terms(problem, ("white", "drift", "gm"))
    theirs = minimize(
        lambda x: -problem.evaluate(np.exp(x))[0],
        np.log([0.5, 0.05, 0.3, 1.0]),
        jac=lambda x: -problem.evaluate(np.exp(x))[1],
    )
    assert fit.log_likelihood >= -theirs.fun - 1e-6
    assert np.log(fit.theta) == pytest.approx(theirs.x, abs=2e-3)


def test_the_fisher_information_is_the_mean_of_the_observed_one():
    noise, theta = NoiseModel(0.27, 0.75, 0.46, 0.05, rate_hz=50), np.array([0.46, 0.05, 0.27, 0.75])
    problems = [problem_of(noise, 5000, seed) for seed in range(60)]
    fisher = np.mean([p.evaluate(theta)[2] for p in problems], axis=0)
    observed = np.mean([observed_information(p, theta, [0, 1, 2, 3]) for p in problems], axis=0)
    scores = np.array([p.evaluate(theta)[1] for p in problems])
    root = np.sqrt(np.diag(fisher))
    assert observed / np.outer(root, root) == pytest.approx(fisher / np.outer(root, root), abs=0.15)
    # the score has mean 0 and covariance = information: 60 runs, mean within 4/sqrt(60)
    assert np.all(np.abs(scores.mean(axis=0) / root) < 4 / np.sqrt(60))


@pytest.mark.slow
def test_estimates_are_unbiased_efficient_and_covered():
    """SG13's noise, 10 min at 50 Hz, 1 Pa steps; 60 seeds here, 300 in benchmarks/identification.py."""
    truth = np.array([np.hypot(0.46, 0.0843 / np.sqrt(12)), 0.01, 0.27, 0.75])
    names = ("white_sd", "drift_rate", "correlated_sd", "correlation_time")
    thetas, fisher, covered = [], np.zeros((4, 4)), 0
    for seed in range(60):
        rest = simulate_rest(600, seed=seed)
        problem = Problem(rest.t, rest.height())
        fit = fit_terms(problem, ("white", "drift", "gm"))
        thetas.append(fit.theta)
        fisher += problem.evaluate(truth)[2] / 60
        found = intervals(problem, fit)
        covered += sum(found[k][0] <= v <= found[k][1] for k, v in zip(names, truth, strict=True))
    bound = np.sqrt(np.diag(np.linalg.inv(fisher))) * truth
    bias = np.mean(thetas, axis=0) / truth - 1
    # the mean of 60 has a standard error of bound/sqrt(60): .06 % white, .4 % GM sd, 1 % tau; 3 of them
    assert abs(bias[0]) < 0.01
    assert abs(bias[2]) < 0.03 + 0.011
    assert abs(bias[3]) < 0.05 + 0.03
    ratio = np.std(thetas, axis=0, ddof=1) / bound
    assert np.all(ratio[[0, 2, 3]] < 1.15 + 3 / np.sqrt(120))  # a ratio of sds from 60 runs: 9 %
    assert 0.91 <= covered / 240 <= 0.99


@pytest.mark.parametrize(
    ("noise", "terms"),
    [
        (NoiseModel(0, 0, 0.4, rate_hz=50), "white"),
        (NoiseModel(0, 0, 0.4, 0.02, rate_hz=50), "white drift"),
        (NoiseModel(0.3, 1.0, 0.4, rate_hz=50), "white gm"),
        (NoiseModel(0.3, 1.0, 0.4, 0.05, rate_hz=50), "white gm drift"),
        (NoiseModel(0.3, 1.0, 0.0, rate_hz=50), "gm"),
        (NoiseModel(0, 0, 0, 0.05, rate_hz=50), "drift"),
    ],
    ids=str,
)
def test_bic_keeps_the_terms_that_are_there(noise, terms):
    best, fits = select_terms(problem_of(noise, 30_000, 5))
    assert set(best.terms) == set(terms.split())
    assert best.bic == min(fit.bic for fit in fits)


def test_pruning_never_hides_the_winner():
    problem = problem_of(NoiseModel(0.2, 3.0, 0.4, 0.01, rate_hz=20), 4000, 6)
    everything = min(fit_terms(problem, terms).bic for terms in SUBSETS)
    assert select_terms(problem)[0].bic == pytest.approx(everything, abs=0.1)


def test_two_correlation_times_are_noticed():
    t = np.arange(30_000) / 50
    y = NoiseModel(0.3, 0.2, 0.3, rate_hz=50).simulate(t, 7) + NoiseModel(0.4, 8.0, 0, rate_hz=50).simulate(
        t, 8
    )
    problem = Problem(t, y)
    best, fits = select_terms(problem)
    assert "gm2" in fits[0].terms
    assert "gm2" not in best.terms
    second = fit_second_gauss_markov(problem, fit_terms(problem, ("white", "gm")))
    assert sorted(second.theta[[3, 5]]) == pytest.approx([0.2, 8.0], rel=0.6)


def test_a_second_term_starts_with_a_quarter_of_the_firsts_power_six_times_as_fast_or_slow(monkeypatch):
    started = []
    monkeypatch.setattr(structural, "_best_of", lambda *asked: started.append(asked))
    fit = structural.StructuralFit(("white", "gm"), np.array([0.3, 0.0, 0.4, 1.5]), 0.0, 100)
    fit_second_gauss_markov(None, fit)
    ((_, terms, starts, _),) = started
    assert terms == ("white", "gm", "gm2")
    for theta, tau in zip(starts, (0.25, 9.0), strict=True):
        assert theta[[0, 1, 3]].tolist() == [0.3, 0.0, 1.5]
        assert theta[5] == pytest.approx(tau)
        assert theta[4] ** 2 == pytest.approx(0.4**2 / 4)
        assert theta[2] ** 2 + theta[4] ** 2 == pytest.approx(0.4**2)  # together as strong as before
    assert fit.theta[2] == 0.4  # the fit itself stays


def test_a_fit_knows_its_criterion_and_its_parameters():
    problem = problem_of(NoiseModel(0.3, 1.0, 0.4, 0.05, rate_hz=10), 400, 12)
    for terms, free in ((("white", "drift"), [0, 1]), (("white", "gm"), [0, 2, 3]), (("gm",), [2, 3])):
        fit = fit_terms(problem, terms)
        assert (fit.terms, fit.n, fit.free) == (terms, 400, free)
        assert fit.log_likelihood == pytest.approx(problem.evaluate(fit.theta)[0], rel=1e-12)
        # 400 samples whose level is unknown are 399 differences
        assert fit.bic == pytest.approx(len(free) * np.log(399) - 2 * fit.log_likelihood, rel=1e-12)
        assert [j for j, v in enumerate(fit.theta) if v > 0] == free


def test_no_smaller_model_beats_the_bound_that_a_larger_one_sets():
    problem = problem_of(NoiseModel(0.3, 1.0, 0.4, 0.02, rate_hz=20), 2000, 13)
    fits = {terms: fit_terms(problem, terms) for terms in SUBSETS}
    for terms, fit in fits.items():
        larger = [other for other in fits.values() if set(terms) < set(other.terms)]
        if larger:
            least = min(other.log_likelihood for other in larger)
            bound = structural._least_bic(terms, larger)
            assert bound == pytest.approx(len(fit.free) * np.log(1999) - 2 * least, rel=1e-12)
            assert bound <= fit.bic + 1e-6  # scoring stops within so much of the maximum


def test_the_fits_come_with_the_best_first():
    problem = problem_of(NoiseModel(0.3, 1.0, 0.4, rate_hz=50), 10_000, 14)
    best, fits = select_terms(problem)
    assert [fit.bic for fit in fits] == sorted(fit.bic for fit in fits)
    assert best is min((fit for fit in fits if "gm2" not in fit.terms), key=lambda fit: fit.bic)
    assert sum("gm2" in fit.terms for fit in fits) == 1
    _, white = select_terms(problem_of(NoiseModel(0, 0, 0.4, rate_hz=50), 10_000, 14))
    assert not any("gm2" in fit.terms for fit in white)


def test_smaller_models_are_also_tried_from_where_the_largest_led(monkeypatch):
    asked = []

    def fit_and_note(problem, terms, start=None):
        asked.append((terms, start))
        return fit_terms(problem, terms, start)

    monkeypatch.setattr(structural, "fit_terms", fit_and_note)
    problem = problem_of(NoiseModel(0.3, 1.0, 0.4, 0.02, rate_hz=20), 1000, 16)
    _, fits = select_terms(problem)
    (largest,) = (fit for fit in fits if fit.terms == SUBSETS[0])
    assert asked[0] == (SUBSETS[0], None)
    assert len(asked) > 1
    assert all(start is largest.theta for _, start in asked[1:])


def test_a_start_of_ones_own_is_tried_and_no_start_is_taken_out_of_bounds():
    problem = problem_of(NoiseModel(0.3, 1.0, 0.4, 0.02, rate_hz=20), 1000, 15)
    plain = fit_terms(problem, ("white", "gm"))
    low, high = problem.bounds(4)
    far = fit_terms(problem, ("white", "gm"), np.array([1e9, 5.0, 1e-9, 1e9]))
    assert far.theta[1] == 0.0
    assert far.log_likelihood == pytest.approx(plain.log_likelihood, abs=1e-3)
    assert (far.theta[[0, 2, 3]] >= low[[0, 2, 3]]).all()
    assert (far.theta[[0, 2, 3]] <= high[[0, 2, 3]]).all()


def test_terms_that_are_switched_off_leave_the_others_as_they_are():
    theta = np.array([0.3, 0.1, 0.4, 1.5])
    assert structural._on_terms(theta, ("white", "gm")).tolist() == [0.3, 0.0, 0.4, 1.5]
    assert structural._on_terms(theta, ("drift",)).tolist() == [0.0, 0.1]


def test_gaps_and_jitter_do_not_bias():
    noise, rng = NoiseModel(0.27, 0.75, 0.2, 0.02, rate_hz=10), np.random.default_rng(9)
    ratios = []
    for seed in range(12):
        t = np.cumsum(rng.uniform(0.05, 0.15, 8000))
        t = t[(t % 60 < 45) & (rng.random(8000) > 0.2)]

        problem = Problem(t, noise.simulate(t, seed))
        fit = fit_terms(problem, ("white", "drift", "gm"))
        ratios.append(np.log(fit.theta / [0.2, 0.02, 0.27, 0.75]) / log_sd(problem, fit))
    z = np.array(ratios)[:, [0, 2, 3]]
    assert np.all(np.abs(z.mean(axis=0)) < 3.5 / np.sqrt(12))
    assert 0.6 < np.sqrt(np.mean(z**2)) < 1.5  # 36 standard normals


def test_an_absent_terms_upper_end_covers_a_term_too_small_to_see():
    hidden = NoiseModel(0.03, 2.0, 0.46, 0.01, rate_hz=50)
    problem = problem_of(hidden, 30_000, 10)
    best, _ = select_terms(problem)
    found = intervals(problem, best)
    assert "gm" not in best.terms
    assert found["correlated_sd"][0] == 0
    assert 0.03 < found["correlated_sd"][1] < 0.2


def test_the_profile_interval_ends_where_the_likelihood_ratio_is_chi_square():
    problem = problem_of(BMP085.noise, 30_000, 11)
    fit = fit_terms(problem, ("white", "drift", "gm"))
    low, high = intervals(problem, fit)["drift_rate"]
    for end in (low, high):
        theta = fit.theta.copy()
        theta[1] = end
        _, value = maximise(problem, theta, [0, 2, 3])
        assert 2 * (fit.log_likelihood - value) == pytest.approx(3.84, abs=0.1)
