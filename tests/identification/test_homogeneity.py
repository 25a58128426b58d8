"""The same noise throughout: against statistics of simulations and the t-test."""

import numpy as np
import pytest
from scipy.stats import ttest_ind

from baroarma.arma import ArmaModel
from baroarma.identification.arma_fit import fit_windows
from baroarma.identification.homogeneity import anova, spectral_error, stationarity

SG13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)


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
