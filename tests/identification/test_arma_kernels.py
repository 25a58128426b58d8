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


def test_a_zero_and_its_reciprocal_are_the_same_process():
    """Their autocovariances differ by a factor only; beyond the unit circle the variances v grow to b²."""
    y = SG13.simulate(1500, 9)
    for a, b in ((-0.86, -0.7), (0.5, 0.8)):
        inside, outside = kernels.log_likelihood(y, a, b), kernels.log_likelihood(y, a, 1 / b)
        # 1500 terms of rounding, and a product of variances that has been taken apart at 1e200
        assert outside == pytest.approx(inside, rel=1e-11)


@pytest.mark.parametrize("seed", range(3))
def test_the_gradients_criterion_is_the_likelihoods(seed):
    y = SG13.simulate(100, seed)
    for x, z in ((1.3, -0.6), (-2.0, 0.5), (0.2, 3.0)):
        f = kernels._gradient(y, x, z)[0]
        likelihood = kernels.log_likelihood(y, -np.tanh(x), np.tanh(z))
        assert -50 * (f + 1 + np.log(2 * np.pi)) == pytest.approx(likelihood, rel=1e-12)


def grid_of_starts(y):
    """The local minima along pole and zero, on either side of where they cancel."""
    found = []
    for side in (-1, 1):
        valleys = []
        for x in kernels._ALONG:
            across = side * kernels._ACROSS - x
            values = [kernels.log_likelihood(y, -np.tanh(x), np.tanh(z)) for z in across]
            valleys.append((max(values), x, across[np.argmax(values)]))
        level = np.pad([value for value, _, _ in valleys], 1, constant_values=-np.inf)
        lowest = (level[1:-1] >= level[:-2]) & (level[1:-1] >= level[2:])
        found += [valleys[i] for i in np.flatnonzero(lowest)]
    best = max(value for value, _, _ in found)
    return [start for value, *start in found if value >= best - 10.0]


@pytest.mark.parametrize("n", [40, 300])
def test_the_descents_start_from_the_valleys_of_the_grid(n):
    """A valley whose likelihood is by a factor of e^10 below the best one's is not followed."""
    for seed in range(6):
        noise = SG13 if seed % 2 else ArmaModel((), (), 1.0, 0.1)  # white noise has the most valleys
        y = noise.simulate(n, seed)
        np.testing.assert_allclose(kernels._starts(y), grid_of_starts(y))


def test_a_descent_ends_where_the_slope_does():
    for seed in range(4):
        y = SG13.simulate(200, seed)
        for x, z in ((0.0, 0.0), (1.0, -0.3), (2.5, -2.0), (-1.0, 2.0)):
            f, x_end, z_end = kernels._descend(y, x, z)
            end, gx, gz = kernels._gradient(y, x_end, z_end)
            assert f == end <= kernels._gradient(y, x, z)[0]
            # a step that no longer lowers f, of rounding 1e-16, ends where the slope is its root
            assert np.hypot(gx, gz) < 1e-7


def test_no_descent_leaves_the_range_that_a_window_could_tell():
    for signal in (np.ones(50), (-1.0) ** np.arange(50), np.cumsum(np.ones(50))):
        for start in kernels._starts(signal):
            _, x, z = kernels._descend(signal, *start)
            assert max(abs(x), abs(z)) <= 7.0
        a, b, sd, value = kernels.maximise(signal)
        assert np.isfinite([sd, value]).all()
        assert max(abs(a), abs(b)) < 1


def test_the_fit_is_the_best_of_all_descents():
    for seed in range(8):
        noise = SG13 if seed % 2 else ArmaModel((), (), 1.0, 0.1)
        y = noise.simulate(150, seed)
        f, x, z = min(kernels._descend(y, *start) for start in kernels._starts(y))
        a, b, sd, value = kernels.maximise(y)
        assert (a, b) == pytest.approx((-np.tanh(x), np.tanh(z)), rel=1e-12)
        assert value == pytest.approx(-75 * (f + 1 + np.log(2 * np.pi)), rel=1e-12)
        assert value == pytest.approx(kernels.log_likelihood(y, a, b), rel=1e-12)
        assert np.mean(kernels.prediction_errors(y, a, b) ** 2) == pytest.approx(sd**2, rel=1e-12)


def test_the_grid_is_the_same_for_a_series_of_alternating_signs():
    np.testing.assert_array_equal(kernels._ALONG, -kernels._ALONG[::-1])
    assert (np.diff(kernels._ALONG) > 0).all()  # neighbours are compared
    assert (np.diff(kernels._ACROSS, prepend=0.0) > 0).all()


@pytest.mark.parametrize("sample", [np.inf, 1e200])
def test_a_window_whose_power_is_no_number_has_no_fit(sample):
    y = SG13.simulate(40, 10)
    y[7] = sample
    with np.errstate(over="ignore"):  # as plain Python it warns
        assert np.isnan(kernels.maximise(y)).all()
