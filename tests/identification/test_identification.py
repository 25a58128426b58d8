"""`identify` from end to end: any log gives a model or a reason, and everything it says is plain data."""

import json
import math
import time
from dataclasses import replace

import numpy as np
import pytest

from baroarma import NoiseModel, Recording, identify
from baroarma.atmosphere import altitude_pressure, temperature_factor
from baroarma.identification import WindowSettings
from baroarma.noise_model import JSON_KEYS, PARAMETERS
from baroarma.simulation import BMP085, Barometer, simulate_rest


@pytest.fixture(scope="module")
def rest():
    return simulate_rest(300, seed=1)


@pytest.fixture(scope="module")
def found(rest):
    return identify(rest)


def of_pressure(pressure, rate_hz=50.0):
    return Recording(t=np.arange(len(pressure)) / rate_hz, pressure=pressure, name="made up")


def plain(value):
    """Whether a value is made of what JSON knows, NumPy's scalars excluded."""
    if isinstance(value, dict):
        return all(type(k) is str and plain(v) for k, v in value.items())
    if isinstance(value, list):
        return all(plain(v) for v in value)
    return value is None or type(value) in (str, int, bool) or (type(value) is float and math.isfinite(value))


def test_the_model_finds_the_truth_within_its_intervals(found):
    truth = replace(BMP085.noise, drift_rate=0.01)
    inside = [
        found.model.ci95[name][0] <= getattr(truth, name) <= found.model.ci95[name][1] for name in PARAMETERS
    ]
    assert sum(inside) >= 3  # four intervals of 95 %: two outside in 1 % of cases
    assert found.model.method == "structural"
    assert found.model.rate_hz == pytest.approx(50)


@pytest.mark.parametrize("name", PARAMETERS)
def test_each_value_lies_in_its_interval(found, name):
    low, high = found.model.ci95[name]
    assert low <= getattr(found.model, name) <= high


@pytest.mark.parametrize("options", [{}, {"method": "windows"}, {"terms": ("white",)}, {"terms": ("gm",)}])
def test_everything_in_the_json_is_plain_and_finite(rest, options):
    body = identify(rest, **options).to_dict()
    assert plain(body)
    model = NoiseModel.from_dict(json.loads(json.dumps(body, allow_nan=False)))
    assert model == identify(rest, **options).model


def test_the_json_holds_the_documented_keys_at_the_top(found):
    documented = {
        *JSON_KEYS,
        "format",
        "version",
        "rate_hz",
        "ci95",
        "method",
        "whiteness_p",
        "verdict",
        "source",
    }
    body = found.to_dict()
    assert documented <= set(body)
    assert set(body["ci95"]) == set(JSON_KEYS)
    assert set(body["whiteness_p"]) == {"ljung_box_10", "ljung_box_40", "bartlett"}
    assert set(body["source"]) == {"name", "sha256", "duration_s"}


def test_a_refused_log_has_null_for_a_model(rest):
    body = identify(rest.between(0, 5)).to_dict()
    assert plain(body)
    assert all(body[key] is None for key in (*JSON_KEYS, "rate_hz", "ci95", "whiteness_p"))
    assert body["verdict"][0]["code"] == "too-short"
    assert body["source"]["name"] == "rest"


def test_parameters_and_intervals_are_python_floats(found):
    assert "np." not in repr(vars(found.model))


@pytest.mark.parametrize(
    "terms", [("white",), ("drift",), ("gm",), ("white", "gm"), ("gm", "drift"), ("drift", "gm", "white")]
)
def test_terms_that_were_asked_for_are_the_ones_in_the_model(rest, terms):
    model = identify(rest, terms=terms).model
    assert (model.white_sd > 0, model.drift_rate > 0, model.has_gauss_markov) == tuple(
        term in terms for term in ("white", "drift", "gm")
    )
    for name in PARAMETERS:
        low, high = model.ci95[name]
        assert 0 <= low <= getattr(model, name) <= high


def test_terms_asked_for_that_are_not_there_are_near_zero_with_an_upper_end():
    white = simulate_rest(200, seed=2, barometer=Barometer(NoiseModel(0, 0, 0.4, rate_hz=50), 0))
    model = identify(white, terms=("white", "gm", "drift")).model
    assert model.white_sd == pytest.approx(0.4, rel=0.03)  # 10000 samples: 4 sd of 0.7 %
    assert model.drift_rate < 0.02
    assert model.ci95["drift_rate"][0] == 0
    assert all(math.isfinite(v) for interval in model.ci95.values() for v in interval)


@pytest.mark.parametrize("method", ["structural", "windows"])
def test_a_log_without_gauss_markov_noise_gives_a_model_by_both_methods(method):
    white = simulate_rest(300, seed=3, barometer=Barometer(NoiseModel(0, 0, 0.4, rate_hz=50), 0))
    found = identify(white, method=method)
    assert "no-gm" in {f.code for f in found.verdict}
    # windows that find a component by chance take it from the white noise
    assert math.hypot(found.model.white_sd, 2 * found.model.correlated_sd) == pytest.approx(0.4, rel=0.05)
    assert plain(found.to_dict())


def test_windows_without_any_inside_the_region_report_white_noise_alone():
    # an MA of the wrong sign: raw differences, negatively correlated
    x = np.random.default_rng(0).normal(size=6001)
    found = identify(of_pressure(altitude_pressure(100 + 0.3 * np.diff(x)), 10.0), method="windows")
    assert not found.model.has_gauss_markov
    assert {"no-gm", "not-white"} <= {f.code for f in found.verdict}
    assert plain(found.to_dict())


def test_the_windows_method_keeps_its_table_and_its_settings_count(rest):
    settings = WindowSettings(window=100)
    found = identify(rest, method="windows", settings=settings, split="bilinear")
    assert len(found.windows) == 30  # 300 s in windows of 100 samples at 0.1 s
    assert found.windows.split == "bilinear"
    assert found.model.white_sd == pytest.approx(2 * found.windows.table["white_sd"].mean)  # sqrt(M = 4)


def test_each_code_is_said_once_by_the_windows_method(rest):
    found = identify(rest.rows(np.r_[0:7000, 7100:15000]), method="windows")
    codes = [f.code for f in found.verdict]
    assert len(codes) == len(set(codes))


def test_a_log_too_short_for_one_window_is_refused_by_the_windows_method(rest):
    found = identify(rest.between(0, 20), method="windows")
    assert not found.ok
    assert found.verdict[-1].code == "too-short"
    assert "record at least" in found.verdict[-1].message


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"method": "guess"}, "method 'guess' is unknown"),
        ({"terms": ("pink",)}, "'pink'"),
        ({"terms": ()}, "unknown"),
        ({"terms": "white"}, "'white' are unknown"),
    ],
)
def test_wrong_options_are_refused(rest, options, message):
    with pytest.raises(ValueError, match=message):
        identify(rest, **options)


def odd_logs():
    rng = np.random.default_rng(4)
    toggling = 101325.0 + (rng.random(3000) < 0.3)
    three = 101325.0 + np.round(rng.normal(0, 0.5, 3000)).clip(-1, 1)
    jumpy = Recording(t=np.cumsum(rng.exponential(0.02, 5000)), pressure=101325 + rng.normal(0, 5, 5000))
    holes = 101325 + rng.normal(0, 5, 6000)
    holes[rng.random(6000) < 0.7] = np.nan
    return {
        "one quantum toggling": of_pressure(toggling),
        "three distinct values": of_pressure(three),
        "a hundred samples": of_pressure(101325 + rng.normal(0, 5, 100), 8.0),
        "times of a Poisson process": jumpy,
        "seven in ten missing": of_pressure(holes),
        "a ramp with little noise": of_pressure(101325 + 0.001 * np.arange(3000) + rng.normal(0, 1e-3, 3000)),
        "a sine": of_pressure(101325 + 5 * np.sin(np.arange(3000) / 40)),
        "a square wave": of_pressure(101325 + np.sign(np.sin(np.arange(3000) / 7.3))),
        "alternating": of_pressure(101325 + (np.arange(3000) % 2.0)),
        "two hours in the middle lost": Recording(
            t=np.r_[np.arange(2000) / 50, 7200 + np.arange(2000) / 50],
            pressure=101325 + rng.normal(0, 5, 4000),
        ),
        "a clock in 1e9 s": Recording(
            t=1.7e9 + np.arange(3000) / 50, pressure=101325 + rng.normal(0, 5, 3000)
        ),
        "a century lost": Recording(
            t=np.r_[np.arange(2000) / 50, 3e9 + np.arange(2000) / 50],
            pressure=101325 + rng.normal(0, 5, 4000),
        ),
    }


@pytest.mark.parametrize("name", odd_logs())
@pytest.mark.parametrize("options", [{}, {"terms": ("white", "gm", "drift")}, {"method": "windows"}], ids=str)
def test_any_log_gives_a_model_or_a_reason(name, options):
    found = identify(odd_logs()[name], **options)
    assert found.ok or any(f.severity == "error" for f in found.verdict)
    assert plain(found.to_dict())
    assert found.recording.name in found.summary()
    assert repr(found).startswith("<Identification of ")


def test_temperature_scales_every_metre_and_no_second(rest, found):
    warm = identify(rest, temperature=35.0)
    factor = temperature_factor(float(np.median(rest.pressure)), 35.0)
    assert factor > 1.05
    for name in ("correlated_sd", "white_sd", "drift_rate"):
        assert getattr(warm.model, name) == pytest.approx(factor * getattr(found.model, name), rel=1e-3)
    # scoring stops at 1e-4 of the sd
    assert warm.model.correlation_time == pytest.approx(found.model.correlation_time, rel=1e-3)


def test_heights_may_have_any_level_and_time_any_start(rest, found):
    later = identify(replace(rest, t=rest.t + 1000.0))
    for name in PARAMETERS:  # rounding of time stamps and scoring's stop, both below 1e-3
        assert getattr(later.model, name) == pytest.approx(getattr(found.model, name), rel=1e-3, abs=1e-6)


def test_prediction_errors_are_standardised(found):
    assert len(found.residuals) == len(found.recording) - 1
    assert np.std(found.residuals) == pytest.approx(1, abs=4 / math.sqrt(2 * len(found.residuals)))


def test_second_opinions_are_there_when_asked_for(found):
    allan = found.allan()
    model = found.model.allan_deviation(allan.tau)
    assert np.mean((allan.low <= model) & (model <= allan.high)) > 0.7  # a 95 % band, correlated over tau
    assert found.stationarity().p > 0.001  # it is stationary but for a drift that detrending removes
    assert found.orders(1, 1).best("bic") == (1, 1)  # SG13, Sec. 2.5


def test_second_opinions_refuse_a_log_without_a_window(rest):
    with pytest.raises(ValueError, match="long enough for a window"):
        identify(rest.between(0, 20)).orders()


def test_the_summary_names_terms_tests_and_advice(found):
    text = found.summary()
    for piece in ("BIC above the best", "white + Gauss-Markov", "bartlett p = ", "more minutes"):
        assert piece in text


@pytest.mark.slow
def test_ten_minutes_at_fifty_hertz_take_less_than_half_a_second():
    identify(simulate_rest(60, seed=1))  # compiled and imported
    recording, seconds = simulate_rest(600, seed=2), []
    for _ in range(3):
        start = (
            time.thread_time()
        )  # this thread's own work: other processes and idle BLAS threads don't count
        identify(recording)
        seconds.append(time.thread_time() - start)
    assert min(seconds) < 0.5


def test_second_opinions_come_as_text_with_reasons_where_they_cannot():
    clean = identify(simulate_rest(300, seed=1)).diagnostics()
    assert "leaves white noise" in clean
    assert "nan" not in clean
    white = identify(simulate_rest(300, seed=1, barometer=Barometer(NoiseModel(0, 0, 0.4, rate_hz=50))))
    assert "no Gauss-Markov noise to whiten" in white.diagnostics()


def test_a_file_name_instead_of_a_recording_is_told_what_to_do():
    with pytest.raises(
        TypeError, match=r"identify takes a Recording, not 'rest.csv'; baroarma.read makes one"
    ):
        identify("rest.csv")


@pytest.mark.parametrize("method", ["structural", "windows"])
def test_an_unknown_split_is_refused_by_either_method(rest, method):
    with pytest.raises(ValueError, match="split 'even' is unknown"):
        identify(rest, method=method, split="even")
