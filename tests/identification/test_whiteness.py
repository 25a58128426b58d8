"""Whiteness tests: against their own distributions, statsmodels and cases by hand."""

import numpy as np
import pytest
from scipy.stats import kstest
from statsmodels.stats.diagnostic import acorr_ljungbox

from baroarma.arma import ArmaModel
from baroarma.identification.arma_fit import fit_windows
from baroarma.identification.whiteness import cumulative_periodogram_test, ljung_box, whiteness_of_windows

SG13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
T = np.arange(30000) / 50


def test_bartlett_s_p_is_exact_for_white_noise():
    x = np.random.default_rng(1).normal(size=(2000, 300))
    p = [cumulative_periodogram_test(row).p for row in x]
    assert kstest(p, "uniform").pvalue > 0.01  # uniform p-values fail this in 1 %


def test_ljung_box_rejects_white_noise_about_as_often_as_it_says():
    x = np.random.default_rng(1).normal(size=(2000, 300))
    p = np.array([ljung_box(row, 20).p for row in x])
    # Chi-square is its limit for long series; 300 samples and 20 lags reject 6 to 6.5 %; 3 sds are 1.6 %.
    assert 0.044 < np.mean(p < 0.05) < 0.081


def test_both_whiteness_tests_notice_the_coloured_noise_of_the_paper():
    x = SG13.simulate(300, 1)
    assert cumulative_periodogram_test(x).p < 1e-6
    assert ljung_box(x, 20).p < 1e-6
    assert "not white" in ljung_box(x, 20).message


def test_on_arma_residuals_bartlett_is_conservative_and_ljung_box_is_not():
    fits = fit_windows(SG13.simulate(400 * 300, 2).reshape(400, 300), 0.1)
    bartlett, ljung = whiteness_of_windows(fits)
    # At a true 5 % one expects 20 +- 4.4 of 400; at the 0.2 % of Bartlett's test 0.8 +- 0.9.
    assert np.sum(bartlett < 0.05) <= 4
    assert 20 - 13 <= np.sum(ljung < 0.05) <= 20 + 13


@pytest.mark.parametrize(("lags", "fitted"), [(10, 0), (20, 2), (40, 2)])
def test_ljung_box_is_that_of_statsmodels(lags, fitted):
    x = np.random.default_rng(3).normal(size=300)
    theirs = acorr_ljungbox(x, lags=[lags], model_df=fitted)
    ours = ljung_box(x, lags, fitted)
    assert ours.statistic == pytest.approx(theirs["lb_stat"].iloc[0], rel=1e-10)
    assert ours.p == pytest.approx(theirs["lb_pvalue"].iloc[0], rel=1e-8)


def test_a_periodogram_of_one_frequency_is_as_far_from_the_diagonal_as_can_be():
    n, k = 301, 40  # 150 frequencies, all power at the 40th: the cumulative sum jumps from 0 to 1 there
    x = np.cos(2 * np.pi * k * np.arange(n) / n)
    assert cumulative_periodogram_test(x).statistic == pytest.approx(1 - (k - 1) / 149, abs=1e-9)


def test_a_million_residuals_are_no_problem():
    x = np.random.default_rng(4).normal(size=1_000_003)
    assert cumulative_periodogram_test(x).p > 0.01
    assert ljung_box(x, 40).p > 0.01


@pytest.mark.parametrize(
    ("x", "words"),
    [([1.0] * 50, "all 1"), ([np.nan] * 50, "not all finite"), ([1.0, 2.0], "too few")],
)
def test_residuals_that_cannot_be_tested_are_refused(x, words):
    with pytest.raises(ValueError, match=words):
        cumulative_periodogram_test(x)


def test_ljung_box_needs_more_lags_than_fitted_parameters():
    with pytest.raises(ValueError, match="2 lags leave nothing after 2 fitted parameters"):
        ljung_box(np.arange(50.0), 2, 2)


def test_of_a_long_series_of_awkward_length_a_few_samples_do_not_matter():
    x = np.random.default_rng(8).normal(size=262_147)  # a prime, 3 above a power of 2
    outcome = cumulative_periodogram_test(x)
    power = np.cumsum(np.abs(np.fft.rfft(x - x.mean())[1:131_074]) ** 2)
    steps = np.arange(131_073) / 131_072
    distance = max(np.max(steps[1:] - power[:-1] / power[-1]), np.max(power[:-1] / power[-1] - steps[:-1]))
    # three samples of a quarter million move the statistic by their share of the total power, 1e-5
    assert outcome.statistic == pytest.approx(distance, abs=3e-5)
