"""Noise models: identities between their views, and a round trip through JSON."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy import integrate, stats

from baroarma import Finding, NoiseModel
from baroarma.noise_model import PARAMETERS

SG13 = NoiseModel(0.27, 0.75, 0.46, rate_hz=50)
WITH_DRIFT = NoiseModel(0.27, 0.75, 0.46, 0.02, rate_hz=50)


def test_the_spectrum_integrates_to_the_variance():
    variance, _ = integrate.quad(lambda f: float(SG13.psd(f)), 0, 25, limit=200)
    assert variance == pytest.approx(0.27**2 + 0.46**2)
    assert float(SG13.autocovariance(0)) == pytest.approx(0.27**2 + 0.46**2)


def test_arma_has_the_same_spectrum_and_autocovariance():
    arma = SG13.arma(1 / 50)
    frequency = np.linspace(0, 25, 60)
    assert arma.psd(frequency) == pytest.approx(SG13.psd(frequency))
    assert arma.autocovariance(5) == pytest.approx(SG13.autocovariance(np.arange(6) / 50))


def test_a_change_of_rate_keeps_the_density():
    slow = SG13.at_rate(10)
    assert slow.white_density == pytest.approx(SG13.white_density)
    assert slow.white_sd == pytest.approx(0.46 / math.sqrt(5))
    assert slow.correlated_sd == SG13.correlated_sd


def test_averages_of_the_white_part_have_the_sd_of_the_slower_rate():
    noise = NoiseModel(0, 0, 0.46, rate_hz=50)
    averaged = noise.simulate(100_000, 0).reshape(-1, 5).mean(axis=1)
    assert np.std(averaged) == pytest.approx(noise.at_rate(10).white_sd, rel=0.02)  # 1/sqrt(2*20000) = 0.5 %


@pytest.mark.parametrize("irregular", [False, True])
def test_simulated_noise_has_the_autocovariance(irregular):
    rng = np.random.default_rng(3)
    noise = NoiseModel(0.5, 0.75, 0.2, rate_hz=10)
    t = np.cumsum(rng.uniform(0.02, 0.18, 200_000)) if irregular else np.arange(200_000) / 10
    x = noise.simulate(t, rng)
    for k in (1, 5, 10):
        expected = np.mean(noise.autocovariance(t[k:] - t[:-k]))
        assert np.mean(x[k:] * x[:-k]) == pytest.approx(expected, abs=4 * 0.29 * math.sqrt(15 / 200_000))


def test_drift_grows_with_the_square_root_of_time():
    ends = [NoiseModel(0, 0, 0, 0.02, rate_hz=1).simulate(101, seed)[-1] for seed in range(2000)]
    assert np.std(ends) == pytest.approx(0.02 * 10, rel=0.06)  # 1/sqrt(2*2000) = 1.6 %


@pytest.mark.parametrize("tau", [0.02, 0.5, 1.5, 40.0])
def test_allan_deviation_is_the_integral_of_the_spectrum(tau):
    # sigma_A^2 = 2 int S_y(f) sin^4(pi f tau)/(pi f tau)^2 df with the one-sided density (IEEE Std 1139)
    def density(f):
        w = 2 * np.pi * f
        return 2 * 2 * 0.27**2 * 0.75 / (1 + (w * 0.75) ** 2) + 2 * 0.02**2 / w**2

    f = np.geomspace(1e-5 / tau, 2e3 / tau, 2_000_001)
    y = density(f) * np.sin(np.pi * f * tau) ** 4 / (np.pi * f * tau) ** 2
    expected = math.sqrt(2 * float(integrate.trapezoid(y, f)) + WITH_DRIFT.white_density / tau)
    assert float(WITH_DRIFT.allan_deviation(tau)) == pytest.approx(expected, rel=2e-3)  # the integration's


def test_json_round_trip_is_exact(tmp_path):
    noise = NoiseModel(
        0.1 + 0.2,
        1 / 3,
        math.pi,
        1e-17,
        rate_hz=49.99999,
        ci95=dict.fromkeys(("correlated_sd", "correlation_time", "white_sd", "drift_rate"), (0.1, 2 / 3)),
        method="structural",
        sensor="BMP085",
        verdict=(Finding("gaps", "info", "One gap."),),
        whiteness_p={"ljung_box_10": 0.5, "ljung_box_40": 0.25, "bartlett": 1e-300},
        source={"name": "rest.csv", "sha256": "00", "duration_s": 600.0},
    )
    noise.save(tmp_path / "noise.json")
    again = NoiseModel.load(tmp_path / "noise.json")
    assert again == noise
    assert hash(again) == hash(noise)
    assert list(tmp_path.iterdir()) == [tmp_path / "noise.json"]
    assert json.loads((tmp_path / "noise.json").read_text())["format"] == "baroarma.noise-model"


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"format": "x"}, "no noise model"),
        ({"version": 2}, "version 2"),
        ({"white_sd_m": "much"}, "wrong kind"),
        ({"white_sd_m": -1}, "must be a number >= 0"),
        ({"ci95": {"white_sd_m": [0, 1]}}, "lacks the key"),
    ],
)
def test_a_broken_file_is_refused_in_a_sentence(tmp_path, change, sentence):
    path = tmp_path / "noise.json"
    path.write_text(json.dumps({**SG13.to_dict(), **change}))
    with pytest.raises(ValueError, match=sentence) as caught:
        NoiseModel.load(path)
    assert str(path) in str(caught.value)


def test_half_a_gauss_markov_component_is_refused():
    with pytest.raises(ValueError, match="either both are 0"):
        NoiseModel(0.27, 0, 0.46, rate_hz=50)


def test_the_density_sets_the_zero_time_constant():
    w = SG13.whitening_filter()
    s_u, s_c = 0.46**2 / 50, 2 * 0.27**2 * 0.75
    assert 1 / (2 * math.pi * w.pole_hz) == pytest.approx(0.75 * math.sqrt(s_u / (s_u + s_c)))


@pytest.mark.parametrize("value", [0, -1, float("nan")])
def test_a_rate_or_an_interval_that_cannot_be_is_named(value):
    with pytest.raises(ValueError, match="the rate must be a positive number of Hz"):
        SG13.at_rate(value)
    with pytest.raises(ValueError, match="the sampling interval must be positive"):
        SG13.arma(value)


SURE = {"correlated_sd": (0.2, 0.3), "correlation_time": (0.5, 1.0), "white_sd": (0.4, 0.5)}


def test_the_drift_that_can_not_be_excluded_is_the_rms_of_a_half_normal_with_that_quantile():
    upper = 0.02
    unsure = NoiseModel(0.27, 0.75, 0.46, rate_hz=50, ci95={**SURE, "drift_rate": (0.0, upper)})
    possible = unsure.with_possible_drift()
    # the 95 % quantile of |N(0, s²)|, whose rms is s
    assert stats.halfnorm.ppf(0.95, scale=possible.drift_rate) == pytest.approx(upper, rel=1e-6)
    assert (possible.correlated_sd, possible.correlation_time, possible.white_sd) == (0.27, 0.75, 0.46)
    assert possible.ci95 == unsure.ci95
    assert unsure.drift_rate == 0.0


def test_a_drift_that_is_there_or_excluded_or_unheard_of_stays():
    found = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50, ci95={**SURE, "drift_rate": (0.005, 0.02)})
    excluded = NoiseModel(0.27, 0.75, 0.46, rate_hz=50, ci95={**SURE, "drift_rate": (0.0, 0.0)})
    for noise in (found, excluded, SG13):
        assert noise.with_possible_drift() == noise


@pytest.mark.parametrize("field", ["correlated_sd", "correlation_time", "white_sd", "drift_rate", "rate_hz"])
@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf, 1e9 + 0.5, 9e-31])
def test_a_value_that_no_altimeter_has_is_refused_by_name(field, value):
    whole = {"correlated_sd": 0.27, "correlation_time": 0.75, "white_sd": 0.46, "drift_rate": 0.02}
    sentence = "must be a number >= 0, but it is" if not 0 <= value < math.inf else "which no altimeter has"
    with pytest.raises(ValueError, match=sentence) as caught:
        NoiseModel(**{**whole, "rate_hz": 50, field: value})
    assert str(caught.value).startswith(field)
    for edge in (1e-30, 1e9):
        assert getattr(NoiseModel(**{**whole, "rate_hz": 50, field: edge}), field) == edge


def test_a_rate_of_0_is_refused():
    with pytest.raises(ValueError, match="rate_hz must be positive"):
        NoiseModel(0, 0, 0.46, rate_hz=0)


def test_whole_numbers_become_floats_and_intervals_pairs_of_them():
    noise = NoiseModel(1, 2, 3, 4, rate_hz=5, ci95={name: [0, 9] for name in PARAMETERS})
    assert [type(getattr(noise, name)) for name in (*PARAMETERS, "rate_hz")] == [float] * 5
    assert noise.ci95 == dict.fromkeys(PARAMETERS, (0.0, 9.0))
    assert all(type(end) is float for pair in noise.ci95.values() for end in pair)
    assert noise.method == "by hand"


def test_only_the_four_terms_are_known_by_their_place():
    with pytest.raises(TypeError, match="positional"):
        NoiseModel(0.27, 0.75, 0.46, 0.02, None, rate_hz=50)
    with pytest.raises(TypeError, match="positional"):
        NoiseModel(0.27, 0.75, 0.46, 0.02, 50.0)


def test_another_rate_takes_the_white_interval_along():
    noise = NoiseModel(0.27, 0.75, 0.46, rate_hz=50, ci95=dict.fromkeys(PARAMETERS, (0.4, 0.5)))
    slow = noise.at_rate(12.5)
    assert (slow.rate_hz, slow.white_sd) == (12.5, pytest.approx(0.23))
    assert slow.ci95 == {**noise.ci95, "white_sd": (0.2, 0.25)}
    assert noise.at_rate(0.5).white_density == pytest.approx(noise.white_density)
    assert SG13.at_rate(10).ci95 is None


def test_the_line_names_the_terms_that_are_there():
    assert repr(SG13) == "<NoiseModel at 50 Hz: white 0.46 m, Gauss-Markov 0.27 m / 0.75 s, no drift>"
    drifting = NoiseModel(0, 0, 0.46, 0.02, rate_hz=50)
    assert repr(drifting) == "<NoiseModel at 50 Hz: white 0.46 m, no Gauss-Markov, drift 0.02 m/sqrt(s)>"


def test_the_drifts_density_is_that_of_differenced_white_noise():
    # b_k - b_{k-1} is white with variance drift_rate^2 dt; differencing has the gain |1 - e^{-ix}|
    f = np.array([0.01, 1.0, 10.0, 25.0])
    drift = NoiseModel(0, 0, 0, 0.02, rate_hz=50).psd(f)
    gain = np.abs(1 - np.exp(-2j * np.pi * f / 50)) ** 2
    assert drift * gain == pytest.approx(2 / 50 * 0.02**2 / 50)
    assert WITH_DRIFT.psd(f) == pytest.approx(SG13.psd(f) + drift)
    assert np.isinf(WITH_DRIFT.psd(0.0))


def test_white_noise_is_at_lag_0_and_lags_are_alike_before_and_behind():
    lags = np.array([-0.5, 0.0, 0.5])
    assert SG13.autocovariance(lags) == pytest.approx(
        0.27**2 * np.exp(-np.abs(lags) / 0.75) + [0, 0.46**2, 0]
    )
    assert NoiseModel(0, 0, 0.46, rate_hz=50).autocovariance(lags) == pytest.approx([0, 0.46**2, 0])


def test_single_precision_is_computed_in_double():
    f = np.float32([0.3, 4.7])
    for ask in (WITH_DRIFT.psd, WITH_DRIFT.autocovariance, WITH_DRIFT.allan_deviation):
        assert np.array_equal(ask(f), ask(f.astype(float)))
    irregular = np.float32([0.1, 0.3, 0.35])
    assert np.array_equal(WITH_DRIFT.simulate(irregular, 1), WITH_DRIFT.simulate(irregular.astype(float), 1))


def test_short_averages_keep_their_digits():
    # the two sides of the switch to the series, r = 0.01, against 60 digits
    from decimal import Decimal, localcontext

    for r in (1e-8, 1e-4, 0.0099, 0.0101, 0.5):
        with localcontext(prec=60):
            d = Decimal(r)
            exact = 2 * (1 - (3 - 4 * (-d).exp() + (-2 * d).exp()) / (2 * d)) / d
        found = float(NoiseModel(1.0, 1.0, 0.0, rate_hz=50).allan_deviation(r)) ** 2
        assert found == pytest.approx(
            float(exact), rel=3.5e-5
        )  # 0.35 r², the series' next term over its first


def test_n_samples_are_at_the_models_own_rate():
    t = np.arange(20) / 50
    assert np.array_equal(WITH_DRIFT.simulate(20, 1), WITH_DRIFT.simulate(t, 1))
    assert NoiseModel(0, 0, 0, 0.02, rate_hz=50).simulate(t, 1)[0] == 0
    assert len(WITH_DRIFT.simulate(0, 1)) == 0


def test_the_filter_runs_at_the_models_rate_and_has_gain_1_at_nyquist_unless_told():
    w = SG13.whitening_filter()
    assert (w.rate_hz, w.unity_gain_hz) == (50, 25)
    slow = SG13.whitening_filter(rate_hz=20)
    assert (slow.rate_hz, slow.unity_gain_hz) == (20, 10)
    white = NoiseModel(0, 0, 0.46, rate_hz=50).whitening_filter(rate_hz=20, unity_gain_hz=3)
    assert (white.rate_hz, white.unity_gain_hz) == (20, 3)


@pytest.mark.parametrize(("intervals", "exact"), [(0.4, True), (0.45, True), (0.55, False), (0.6, False)])
def test_the_sampled_process_is_undone_where_the_zero_is_within_half_an_interval(intervals, exact):
    tau, rate = 0.5, 50
    correlated, ratio = 2 * 0.27**2 * tau, (intervals / rate / tau) ** 2
    white_sd = math.sqrt(rate * correlated * ratio / (1 - ratio))  # what makes tau_o so many intervals
    noise = NoiseModel(0.27, tau, white_sd, rate_hz=rate)
    w, f = noise.whitening_filter(), np.linspace(0.01, 25, 50)
    spectrum = noise.psd(f) * np.abs(w.response(f)) ** 2
    assert (np.ptp(spectrum) < 1e-9 * spectrum[0]) == exact  # white to rounding
    assert (abs(2 * math.pi * w.pole_hz * intervals / rate - 1) < 1e-9) == (not exact)  # or by the density


def test_a_file_says_who_made_it_and_no_more_than_is_known(tmp_path):
    document = SG13.to_dict()
    assert document == {
        "format": "baroarma.noise-model",
        "version": 1,
        "correlated_sd_m": 0.27,
        "correlation_time_s": 0.75,
        "white_sd_m": 0.46,
        "drift_rate_m_per_sqrt_s": 0.0,
        "rate_hz": 50.0,
        "ci95": None,
        "method": "by hand",
        "sensor": "",
        "whiteness_p": None,
        "verdict": [],
        "source": None,
    }
    SG13.save(tmp_path / "a.json")
    assert (tmp_path / "a.json").read_text() == json.dumps(document, indent=2) + "\n"
    with pytest.raises(ValueError, match="JSON compliant"):
        replace(SG13, source={"duration_s": math.nan}).save(tmp_path / "b.json")
    assert not (tmp_path / "b.json").exists()


def test_the_summary_is_a_table_of_terms_with_intervals_and_the_verdict():
    ci95 = {**SURE, "drift_rate": (0.0, 0.02)}
    gaps = Finding("gaps", "info", "One.")
    noise = NoiseModel(0.27, 0.75, 0.46, rate_hz=50, ci95=ci95, sensor="BMP085", verdict=(gaps,))
    assert noise.summary().splitlines() == [
        "Noise of BMP085 at 50 Hz (by hand)",
        "  correlated sd          0.27 m           [0.2, 0.3]",
        "  correlation time       0.75 s           [0.5, 1]",
        "  white sd               0.46 m           [0.4, 0.5]",
        "  drift rate                0 m/sqrt(s)   [0, 0.02]",
        "  info (gaps): One.",
    ]
    by_hand = SG13.summary().splitlines()
    assert by_hand[0] == "Noise of a barometric altimeter at 50 Hz (by hand)"
    assert by_hand[3].split() == ["white", "sd", "0.46", "m"]
    assert ">One.<" in noise._repr_html_()
    assert ">0.46 m<" in SG13._repr_html_()
    assert (noise._repr_html_().count("<table"), SG13._repr_html_().count("<table")) == (2, 1)
    assert (noise._repr_html_().count("<style"), SG13._repr_html_().count("<style")) == (2, 1)


def test_it_is_drawn_where_it_is_told():
    ax = Figure().subplots()
    assert SG13.plot(ax) is ax
    assert ax.lines
