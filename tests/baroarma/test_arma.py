"""ARMA models against statsmodels, and the two ways to split an ARMA(1,1)."""

import numpy as np
import pytest
from matplotlib.figure import Figure
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


def test_single_precision_is_computed_in_double():
    model, f = MODELS[1], np.float32([0.3, 4.7])
    assert np.array_equal(model.psd(f), model.psd(f.astype(float)))


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


def test_coefficients_of_any_kind_become_tuples_so_that_equal_models_are_equal():
    listed = ArmaModel([-1 / 2], np.array([0.25]), 1.0, 0.1)
    model = ArmaModel((-0.5,), (0.25,), 1.0, 0.1)
    assert (listed, hash(listed)) == (model, hash(model))
    assert repr(ArmaModel((-0.5, 0.3), (0.4, 0.1), 1.0, 0.02)) == (
        "<ArmaModel(2, 2): a = [-0.5, 0.3], b = [0.4, 0.1], sd 1, 0.02 s>"
    )


def test_noise_of_no_size_is_a_model_too():
    assert not ArmaModel((-0.5,), (), 0.0, 1.0).simulate(5).any()


@pytest.mark.parametrize("model", MODELS, ids=repr)
@pytest.mark.parametrize("lags", [0, 1, 2, 7])
def test_there_are_as_many_lags_as_asked_for_and_lag_0(model, lags):
    assert model.autocovariance(lags) == pytest.approx(model.autocovariance(20)[: lags + 1])


def test_a_seed_gives_the_same_noise_again_and_its_first_sample_is_stationary():
    slow = ArmaModel((-0.999,), (), 1.0, 0.1)
    assert np.array_equal(slow.simulate(7, 3), slow.simulate(7, 3))
    assert len(slow.simulate(7, 3)) == 7
    firsts = [slow.simulate(1, seed)[0] for seed in range(300)]
    # without a past the first sample had the innovation's variance, 1/500 of this; 4 sd of a variance of 300
    assert np.var(firsts) == pytest.approx(slow.autocovariance(0)[0], rel=4 * np.sqrt(2 / 300))


def test_a_model_without_white_noise_is_the_exact_gauss_markov():
    model = gauss_markov_arma(correlated_sd=1.0, correlation_time=0.7, white_sd=0.0, dt=0.1)
    assert (len(model.ar), len(model.ma), model.dt) == (1, 0, 0.1)
    assert model.autocovariance(9) == pytest.approx(np.exp(-np.arange(10) / 7))
    nearly = gauss_markov_arma(correlated_sd=1.0, correlation_time=0.7, white_sd=1e-6, dt=0.1)
    assert nearly.autocovariance(9) == pytest.approx(np.exp(-np.arange(10) / 7))


def test_a_model_without_gauss_markov_noise_is_white():
    assert gauss_markov_arma(correlated_sd=0.0, correlation_time=0.0, white_sd=1.0, dt=0.1) == ArmaModel(
        (), (), 1.0, 0.1
    )
    both = gauss_markov_arma(correlated_sd=1.0, correlation_time=0.7, white_sd=1.0, dt=0.1)
    assert both.autocovariance(1) == pytest.approx([2.0, np.exp(-1 / 7)])


def test_an_ar_part_that_does_nothing_is_forgotten_at_once():
    idle = ArmaModel((0.0,), (), 1.0, 0.1)
    assert np.array_equal(idle.simulate(5, 1), ArmaModel((), (), 1.0, 0.1).simulate(5, 1))


@pytest.mark.parametrize("how", ["exact", "bilinear"])
def test_between_the_regions_there_is_no_split(how):
    with pytest.raises(ValueError, match=r"a = -0\.5, b = -0\.5 is no Gauss-Markov"):
        ArmaModel((-0.5,), (-0.5,), 1.0, 0.1).split(how)  # white noise: nothing to tell apart


def test_what_can_not_be_split_is_told_with_its_numbers():
    sg13 = MODELS[1]
    with pytest.raises(ValueError, match="split 'halves' is unknown; choose 'exact' or 'bilinear'"):
        sg13.split("halves")
    with pytest.raises(ValueError, match="a < b < 0 is needed"):
        ArmaModel((-0.5,), (0.0,), 1.0, 0.1).split()
    with pytest.raises(ValueError, match=r"an ARMA\(1, 1\) is needed, but this is an ARMA\(2, 1\)"):
        MODELS[2].time_constants()
    for b in (-2.5, -1.0, 1.0, 1.5):
        with pytest.raises(ValueError, match=f"the MA part b = {b:.4g} cannot be inverted"):
            ArmaModel((-0.5,), (b,), 1.0, 0.1).time_constants()


def test_the_summary_tells_the_coefficients_and_what_they_stand_for():
    model = gauss_markov_arma(correlated_sd=0.27, correlation_time=0.75, white_sd=0.24, dt=0.1)
    first, *rows = model.summary().splitlines()
    assert first == repr(model)
    told = {row[:22].strip(): row[22:] for row in rows}
    assert told == {
        "a1": f"{model.ar[0]:.6g}",
        "b1": f"{model.ma[0]:.6g}",
        "innovation sd": f"{model.sd:.4g} m",
        "Gauss-Markov sd": "0.27 m",
        "correlation time": "0.75 s",
        "white sd": "0.24 m",
    }
    assert "\n  a2                  0.3\n  b1                  0.4\n" in MODELS[2].summary()
    assert MODELS[2].summary().endswith("innovation sd       1 m")
    html = MODELS[2]._repr_html_()
    for cell in ("ARMA(2, 1) of samples every 0.02 s", ">parameter<", ">value<", ">a2<", ">0.4<"):
        assert cell in html


def test_it_is_drawn_where_it_is_told():
    ax = Figure().subplots()
    assert MODELS[1].plot(ax) is ax
    assert ax.lines
