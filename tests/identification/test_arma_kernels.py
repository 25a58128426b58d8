import warnings

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.stats import multivariate_normal
from statsmodels.tsa.arima.model import ARIMA

from baroarma.arma import ArmaModel
from baroarma.identification import arma_kernels as kernels

SG13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)


@pytest.mark.parametrize(("a", "b"), [(-0.86, -0.52), (0.5, -0.3), (-0.99, 0.95), (0.3, 0.3), (-0.7, 0.999)])
def test_the_likelihood_is_that_of_the_dense_gaussian(a, b):
    y = SG13.simulate(60, 1)
    unit = ArmaModel((a,), (b,), 1.0, 0.1)
    covariance = toeplitz(unit.autocovariance(59))
    variance = y @ np.linalg.solve(covariance, y) / 60
    dense = multivariate_normal(cov=variance * covariance, allow_singular=False).logpdf(y)
    assert kernels.log_likelihood(y, a, b) == pytest.approx(dense, abs=1e-7)  # the dense side's rounding


def test_the_gradient_is_that_of_finite_differences():
    y, h = SG13.simulate(300, 2), 1e-3

    def slope(f):  # five points: the error is h^4 = 1e-12 times the fifth derivative over 30
        return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h)

    for x, z in ((0.5, -0.3), (1.5, -1.0), (-2.0, 1.9), (3.0, 3.0)):
        _, gx, gz = kernels._gradient(y, x, z)
        numerical = (
            slope(lambda d, x=x, z=z: kernels._gradient(y, x + d, z)[0]),
            slope(lambda d, x=x, z=z: kernels._gradient(y, x, z + d)[0]),
        )
        np.testing.assert_allclose([gx, gz], numerical, atol=1e-9)


def test_the_maximum_is_that_of_statsmodels():
    y = SG13.simulate(12 * 300, 3).reshape(12, 300)
    ours = kernels.maximise_windows(y)
    for row, window in zip(ours, y, strict=True):
        arima = ARIMA(window, order=(1, 0, 1), trend="n", concentrate_scale=True)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # so tight a tolerance makes its optimiser complain of rounding
            fit = arima.fit(method_kwargs={"pgtol": 1e-10, "factr": 10, "maxiter": 500})
        np.testing.assert_allclose(row[:2], [-fit.params[0], fit.params[1]], atol=1e-4)  # as promised
        # A likelihood is flat at its maximum: coefficients right to 1e-4 make it right to 1e-4 too.
        assert row[3] == pytest.approx(fit.llf, abs=1e-4)
        assert row[2] ** 2 == pytest.approx(fit.scale, rel=1e-3)


def test_cancelling_pole_and_zero_do_not_hide_the_highest_maximum():
    """White noise has many maxima near b = a; a 100 x 100 grid finds none that is higher."""
    y = np.random.default_rng(4).normal(size=(60, 300))
    best = kernels.maximise_windows(y)[:, 3]
    points = np.tanh(np.linspace(-5, 5, 100))
    grid = [max(kernels.log_likelihood(row, a, b) for a in points for b in points) for row in y]
    # 0.1 in log-likelihood is a tenth of AIC's price of one parameter; one window in 60 may miss it.
    assert np.sum(np.array(grid) > best + 0.1) <= 1


def test_alternating_signs_mirror_both_coefficients():
    y = SG13.simulate(20 * 300, 5).reshape(20, 300)
    plain = kernels.maximise_windows(y)
    mirrored = kernels.maximise_windows(y * (-1.0) ** np.arange(300))
    np.testing.assert_allclose(mirrored, plain * [-1, -1, 1, 1], atol=1e-6)  # the optimiser's own tolerance


def test_prediction_errors_have_the_innovations_variance():
    y = SG13.simulate(300, 6)
    a, b, sd, _ = kernels.maximise(y)
    e = kernels.prediction_errors(y, a, b)
    assert np.mean(e**2) == pytest.approx(sd**2, rel=1e-12)  # an identity of the concentrated likelihood
    # Asymptotically e_k + b e_{k-1} = y_k + a y_{k-1}; after 100 samples the start has faded by |b|^100.
    left = e[101:] + b * e[100:-1]
    np.testing.assert_allclose(left, y[101:] + a * y[100:-1], atol=1e-12)


def test_a_dead_window_has_no_fit_and_disturbs_no_other():
    y = SG13.simulate(600, 7).reshape(2, 300)
    stacked = kernels.maximise_windows(np.vstack([y[:1], np.zeros((1, 300)), y[1:]]))
    assert np.isnan(stacked[1]).all()
    np.testing.assert_array_equal(stacked[[0, 2]], kernels.maximise_windows(y))


def test_the_estimate_scales_with_the_unit():
    y = SG13.simulate(300, 8)
    a, b, sd, _ = kernels.maximise(y)
    scaled = kernels.maximise(y * 1e-3)
    np.testing.assert_allclose(scaled[:3], [a, b, sd * 1e-3], rtol=1e-6)
