"""ARMA models against statsmodels, and the two ways to split an ARMA(1,1)."""

import numpy as np
import pytest
from scipy import integrate
from statsmodels.tsa.arima_process import ArmaProcess

from baroarma import ArmaModel
from baroarma.arma import gauss_markov_arma

MODELS = [
    ArmaModel((), (), 0.4, 0.1),
    ArmaModel((-0.86,), (-0.52,), 0.2746, 0.1),
    ArmaModel((-0.5, 0.3), (0.4,), 1.0, 0.02),
    ArmaModel((-0.5,), (0.4, -0.2, 0.1), 2.0, 1.0),
]


@pytest.mark.parametrize("model", MODELS, ids=repr)
def test_autocovariance_is_statsmodels(model):
    theirs = ArmaProcess((1, *model.ar), (1, *model.ma)).acovf(12) * model.sd**2
    assert model.autocovariance(11) == pytest.approx(theirs, abs=1e-12)


@pytest.mark.parametrize("model", MODELS, ids=repr)
def test_the_spectrum_integrates_to_the_variance(model):
    variance, _ = integrate.quad(lambda f: float(model.psd(f)), 0, 0.5 / model.dt)
    assert variance == pytest.approx(model.autocovariance(0)[0], rel=1e-7)


def test_simulated_noise_has_the_autocovariance():
    model = MODELS[1]
    y = model.simulate(400_000, 0)
    measured = [y[: len(y) - k] @ y[k:] / len(y) for k in range(4)]
    # sd of a sample autocovariance of this process at n = 4e5 is 0.0005; 4 sd
    assert measured == pytest.approx(model.autocovariance(3), abs=0.002)


def test_exact_split_undoes_gauss_markov_plus_white():
    model = gauss_markov_arma(correlated_sd=0.27, correlation_time=0.75, white_sd=0.24, dt=0.1)
    assert model.split("exact") == pytest.approx((0.27, 0.75, 0.24), rel=1e-9)
    gamma = 0.27**2 * np.exp(-np.arange(5) * 0.1 / 0.75) + np.array([0.24**2, 0, 0, 0, 0])
    assert model.autocovariance(4) == pytest.approx(gamma)


@pytest.mark.parametrize(("a", "b"), [(-0.86, -0.52), (-0.95, -0.3), (-0.5, -0.1)])
def test_bilinear_split_keeps_the_variance_exactly(a, b):
    # the identity that the printed sigma_c = beta/sqrt(2 tau) breaks (method: SG13 Eq. 7)
    model = ArmaModel((a,), (b,), 0.2746, 0.1)
    parts = model.split("bilinear")
    assert parts.correlated_sd**2 + parts.white_sd**2 == pytest.approx(model.autocovariance(0)[0], rel=1e-12)
    assert parts.correlation_time == pytest.approx(0.05 * (1 - a) / (1 + a))  # SG13, Eq. 15


def test_the_printed_formula_would_give_three_times_the_published_value():
    model = ArmaModel((-0.86,), (-0.52,), 0.2746, 0.1)
    tau, alpha = 0.05 * 1.86 / 0.14, 0.2746 * 1.52 / 1.86
    beta = np.sqrt((0.2746 * 0.48 / 0.14) ** 2 - alpha**2)
    assert beta / np.sqrt(2 * tau) == pytest.approx(0.79, abs=0.01)
    assert model.split("bilinear").correlated_sd == pytest.approx(0.26, abs=0.03)  # SG13, Table 1


@pytest.mark.parametrize(
    ("a", "b", "how"), [(-0.5, -0.6, "bilinear"), (-0.5, -0.6, "exact"), (-0.5, 0.1, "exact")]
)
def test_outside_the_region_no_split_is_invented(a, b, how):
    with pytest.raises(ValueError, match="no Gauss-Markov plus white noise"):
        ArmaModel((a,), (b,), 1.0, 0.1).split(how)


def test_sg13_whitening_filter():
    # SG13, Sec. 3.1, at 50 Hz with unity gain at 25 Hz; digits from the formulas, b = [0.954754, -0.926435]
    w = ArmaModel((-0.86,), (-0.52,), 0.2746, 0.1).whitening_filter(rate_hz=50, unity_gain_hz=25)
    assert w.b == pytest.approx((0.954754, -0.926435), abs=1e-6)
    assert w.a == pytest.approx((1, -0.881188), abs=1e-6)
    assert (w.dc_gain, w.zero_hz, w.pole_hz) == pytest.approx((0.23835, 0.23959, 1.00519), abs=1e-5)


def test_the_filter_the_paper_really_used():
    w = ArmaModel((-0.87,), (-0.50,), 1.0, 0.1).whitening_filter(rate_hz=50, unity_gain_hz=25)
    assert w.dc_gain == pytest.approx(0.2086, abs=1e-4)  # "about 0.21"; SG13 Table 5 shows slopes of 0.206


@pytest.mark.parametrize("bad", [{"ar": (-1.0,)}, {"sd": -1}, {"dt": 0}, {"ma": (np.nan,)}])
def test_impossible_models_are_refused(bad):
    with pytest.raises(ValueError, match=r"must|not stationary"):
        ArmaModel(**{"ar": (-0.5,), "ma": (), "sd": 1.0, "dt": 0.1, **bad})


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 30.0, 400.0, 1000.0])
def test_the_variance_is_the_sum_of_the_components_however_long_the_interval(ratio):
    model = gauss_markov_arma(correlated_sd=0.3, correlation_time=1 / ratio, white_sd=0.4, dt=1.0)
    assert model.autocovariance(1) == pytest.approx([0.25, 0.09 * np.exp(-ratio)])
