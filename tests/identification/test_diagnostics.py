import numpy as np
import pytest
from scipy.stats import kstest, ttest_ind
from statsmodels.stats.diagnostic import acorr_ljungbox

from baroarma.arma import ArmaModel
from baroarma.identification.arma_fit import fit_windows
from baroarma.identification.diagnostics import (
    anova,
    averaging_study,
    cumulative_periodogram_test,
    ljung_box,
    order_table,
    spectral_error,
    stationarity,
    whiteness_of_windows,
)
from baroarma.noise_model import NoiseModel

SG13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
T = np.arange(30000) / 50


def bmp085(seed):
    """Ten minutes of the simulated sensor: SG13's noise at 50 Hz in steps of 1 Pa (8.43 cm there)."""
    noise = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)
    return 0.0843 * np.round((100 + noise.simulate(T, seed)) / 0.0843)


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


def test_the_order_table_prefers_the_true_order_and_its_criteria_agree():
    table = order_table(SG13.simulate(2000, 5), 0.1, 2, 2)
    assert table.best("bic") == (1, 1)
    # FPE is AIC in another dress: n log FPE - AIC is the same for all orders but for terms d^3/n^2 and the
    # start-up of the likelihood (log-determinant over n, below 3 for these orders).
    difference = [2000 * np.log(fit.fpe) - fit.aic for order, fit in table.fits.items() if order != (0, 0)]
    assert np.ptp(difference) < 3
    assert table.summary().count("*") == 3
    with pytest.raises(ValueError, match="choose 'fpe', 'aic' or 'bic'"):
        table.best("r2")


def test_the_spectral_error_of_the_true_model_is_what_sampling_makes_it():
    y = SG13.simulate(800 * 300, 6).reshape(800, 300)
    got = np.mean([spectral_error(SG13, row, 20) for row in y])
    # White errors: Var(c_0)/sd^4 = 2/n, Var(c_k)/sd^4 = (n - k)/n^2; dividing by c_0 adds a share of O(1/n).
    expected = 2 / 300 + 2 * np.sum(300 - np.arange(1, 21)) / 300**2
    assert got == pytest.approx(expected, rel=0.05)
    assert spectral_error(SG13, 2 * y[0]) > (1 / 4 - 1) ** 2 * 0.8  # twice the noise: at least (1/4 - 1)^2


def test_stationary_noise_passes_the_stationarity_test_and_a_louder_half_does_not():
    p = [
        stationarity(SG13.simulate(3000, 100 + k).reshape(10, 300), 0.1, trials=39, seed=k).p
        for k in range(14)
    ]
    assert np.sum(np.array(p) <= 0.05) <= 3  # more has a probability of 0.4 % (binomial, 14 times 5 %)
    y = SG13.simulate(6000, 7).reshape(20, 300).copy()
    y[10:] *= 1.6
    assert stationarity(y, 0.1, trials=99).p < 0.05


def test_the_analysis_of_variance_of_two_recordings_is_the_t_test():
    rng = np.random.default_rng(8)
    x, y = rng.normal(size=20), rng.normal(0.3, size=18)
    t = ttest_ind(x, y)
    got = anova([x, [*y, np.nan]], "a")
    assert got.statistic == pytest.approx(t.statistic**2)
    assert got.p == pytest.approx(t.pvalue)
    with pytest.raises(ValueError, match="2 recordings"):
        anova([x])


def test_recordings_of_one_sensor_share_their_coefficients():
    """SG13, Sec. 3.1: six recordings, p > 0.4 for a and p > 0.26 for b."""
    fits = [fit_windows(SG13.simulate(6000, 20 + k).reshape(20, 300), 0.1) for k in range(6)]
    assert anova([f.a for f in fits], "a").p > 0.01
    assert anova([f.b for f in fits], "b").p > 0.01


def test_averages_longer_than_the_decimation_do_not_fit_as_in_figure_5():
    studies = [averaging_study(T, bmp085(seed), (1, 4, 8, 16)) for seed in range(4)]
    rejected = {
        m: np.mean([s.rows[k].bartlett_failures for s in studies]) for k, m in enumerate((1, 4, 8, 16))
    }
    outside = {m: np.mean([s.rows[k].outside for s in studies]) for k, m in enumerate((1, 4, 8, 16))}
    ljung = {m: np.mean([s.rows[k].ljung_box_failures for s in studies]) for k, m in enumerate((1, 4, 8, 16))}
    # Of 80 windows: nearly none where the model holds, nearly all where it can't; between them Bartlett's
    # test is blind, and Ljung-Box and the region speak (trial values 2, 47, 79 %; 3 sds of 80 draws: 17 %).
    assert max(rejected[1], rejected[4], outside[4]) <= 0.05
    assert rejected[8] <= 0.10
    assert ljung[8] == pytest.approx(0.47, abs=0.17)
    assert outside[8] == pytest.approx(0.79, abs=0.17)
    assert rejected[16] == pytest.approx(0.86, abs=0.17)
    assert outside[16] == 1.0
    for study in studies:
        one, four = study.rows[:2]
        assert four.theory_white_sd == pytest.approx(one.white_sd.mean / 2)
        assert four.white_sd.mean == pytest.approx(four.theory_white_sd, rel=0.1)  # 4 % low, +- 2 %
        assert four.total_sd.mean < one.total_sd.mean
    assert "Bartlett" in studies[0].summary()


def test_of_a_long_series_of_awkward_length_a_few_samples_do_not_matter():
    x = np.random.default_rng(8).normal(size=262_147)  # a prime, 3 above a power of 2
    outcome = cumulative_periodogram_test(x)
    power = np.cumsum(np.abs(np.fft.rfft(x - x.mean())[1:131_074]) ** 2)
    steps = np.arange(131_073) / 131_072
    distance = max(np.max(steps[1:] - power[:-1] / power[-1]), np.max(power[:-1] / power[-1] - steps[:-1]))
    # three samples of a quarter million move the statistic by their share of the total power, 1e-5
    assert outcome.statistic == pytest.approx(distance, abs=3e-5)
