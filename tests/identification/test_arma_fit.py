from pathlib import Path

import numpy as np
import pytest

from baroarma.arma import ArmaModel
from baroarma.identification.arma_fit import coefficient_covariance, fit_arma, fit_windows
from baroarma.identification.arma_kernels import maximise, maximise_windows

SG13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)


def test_a_general_order_is_found_within_its_own_sds():
    truth = ArmaModel(ar=(-1.2, 0.5), ma=(0.4,), sd=0.3, dt=0.1)
    fit = fit_arma(truth.simulate(4000, 1), 0.1, (2, 1))
    error = np.array([*fit.model.ar, *fit.model.ma]) - [*truth.ar, *truth.ma]
    assert error @ np.linalg.solve(fit.covariance, error) < 11.34  # chi-square of 3, 99 %
    assert fit.model.sd == pytest.approx(0.3, rel=3 / np.sqrt(2 * 4000))  # 3 sds
    assert np.mean(fit.residuals**2) == pytest.approx(fit.model.sd**2, rel=1e-9)
    assert fit.converged


def test_statsmodels_and_the_compiled_likelihood_agree():
    y = SG13.simulate(1000, 2)
    fit = fit_arma(y, 0.1)
    a, b, sd, loglik = maximise(y)
    assert loglik == pytest.approx(fit.loglik, abs=1e-3)  # where statsmodels stops by default
    # 1e-3 in log-likelihood is sqrt(2e-3) = 0.045 sds.
    sd_a, sd_b = fit.coefficient_sd
    assert abs(a - fit.model.ar[0]) < 0.045 * sd_a
    assert abs(b - fit.model.ma[0]) < 0.045 * sd_b
    assert sd == pytest.approx(fit.model.sd, rel=1e-3)


def test_equation_16_is_the_inverse_of_the_fisher_information():
    a, b, n = -0.86, -0.52, 300
    # Box & Jenkins: the errors' derivatives by a and b are two autoregressions; these are their covariances.
    information = n * np.array([[1 / (1 - a**2), -1 / (1 - a * b)], [-1 / (1 - a * b), 1 / (1 - b**2)]])
    np.testing.assert_allclose(coefficient_covariance(a, b, n), np.linalg.inv(information), rtol=1e-10)


def test_equation_16_holds_for_long_windows():
    fits = maximise_windows(SG13.simulate(400 * 1000, 3).reshape(400, 1000))
    ratio = fits[:, :2].std(axis=0) / np.sqrt(np.diag(coefficient_covariance(-0.86, -0.52, 1000)))
    # 4 % finite-sample excess plus 3 sds (3.5 % each) of an sd from 400 windows.
    np.testing.assert_allclose(ratio, 1.02, atol=0.02 + 0.106)


def test_the_covariance_of_a_fit_is_that_of_equation_16():
    fit = fit_arma(SG13.simulate(8000, 4), 0.1)
    theory = coefficient_covariance(fit.model.ar[0], fit.model.ma[0], 8000)
    np.testing.assert_allclose(fit.covariance, theory, rtol=0.1)  # outer products of 8000 scores: few %


def test_white_noise_needs_no_optimiser():
    y = np.random.default_rng(5).normal(size=500)
    fit = fit_arma(y, 0.1, (0, 0))
    variance = np.mean(y**2)
    assert fit.model.sd**2 == pytest.approx(variance)
    assert fit.fpe == pytest.approx(variance)
    assert fit.loglik == pytest.approx(-250 * (np.log(2 * np.pi * variance) + 1))
    assert fit.aic == pytest.approx(2 - 2 * fit.loglik)
    assert fit.bic == pytest.approx(np.log(500) - 2 * fit.loglik)


@pytest.mark.parametrize(
    ("y", "order", "words"),
    [
        (np.arange(30.0), (2, 1), r"30 samples is too short for ARMA\(2, 1\); use at least 80"),
        (np.ones(300), (1, 1), "constant"),
        (np.full(300, np.nan), (1, 1), "not finite"),
        (np.arange(300.0), (-1, 1), "negative order"),
    ],
)
def test_a_series_that_cannot_be_fitted_is_refused_in_a_sentence(y, order, words):
    with pytest.raises(ValueError, match=words):
        fit_arma(y, 0.1, order)


@pytest.mark.parametrize("split", ["exact", "bilinear"])
def test_each_window_is_split_as_its_own_model(split):
    fits = fit_windows(SG13.simulate(1500, 6).reshape(5, 300), 0.1, split)
    assert fits.inside.all()
    for k in range(5):
        expected = ArmaModel((fits.a[k],), (fits.b[k],), fits.innovation_sd[k], 0.1).split(split)
        assert (fits.correlated_sd[k], fits.correlation_time[k], fits.white_sd[k]) == tuple(expected)


def test_windows_outside_the_region_are_marked_not_clipped():
    y = ArmaModel(ar=(0.5,), ma=(0.9,), sd=1.0, dt=0.1).simulate(1500, 7).reshape(5, 300)
    fits = fit_windows(y, 0.1)
    assert not fits.inside.any()
    assert np.isnan(fits.white_sd).all()
    assert np.isfinite(fits.a).all()


def test_an_unknown_split_is_refused():
    with pytest.raises(ValueError, match="choose 'exact' or 'bilinear'"):
        fit_windows(SG13.simulate(300, 8).reshape(1, 300), 0.1, "linear")


def test_statsmodels_is_met_in_one_file_only():
    room = Path(__file__).resolve().parents[2] / "identification"
    guests = [path.name for path in room.glob("*.py") if "import statsmodels" in path.read_text()]
    guests += [path.name for path in room.glob("*.py") if "from statsmodels" in path.read_text()]
    assert guests == ["arma_fit.py"]
