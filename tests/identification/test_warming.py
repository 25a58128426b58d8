"""A warm-up is told in metres per kelvin, with an interval that the truth lies in."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import binom

from baroarma import NoiseModel, Recording, identify, read
from baroarma.atmosphere import altitude_pressure
from baroarma.identification.regression import least_squares
from baroarma.identification.warming import warm_up

T = np.arange(0, 300, 0.4)
WARMTH = 40 - 15 * np.exp(-T / 60) - 7 * np.exp(-(((T - 200) / 40) ** 2))
"""Warms up by 15 K within minutes, then someone opens a window."""


def warmed(seed, *, slope=0.2, course=WARMTH, drift=0.02, jitter=0.0, trend=0.0, reading_sd=0.01):
    """A rest at 2.5 Hz whose height follows `course`, and passes on the temperature reading's own noise."""
    rng = np.random.default_rng(seed)
    noise = NoiseModel(0, 0, 0.2, drift, rate_hz=2.5).simulate(T, rng)
    reading = reading_sd * rng.normal(size=len(T))
    height = 100 + slope * course + jitter * reading + trend * T + noise
    return Recording(t=T, pressure=altitude_pressure(height), temperature=WARMTH + reading, name="warmed")


@cache
def found(seed):
    return warm_up(warmed(seed))


def test_the_interval_covers_the_truth_as_often_as_it_says():
    runs = [found(seed) for seed in range(100)]
    covered = sum(run.ci95[0] <= 0.2 <= run.ci95[1] for run in runs)
    low, high = binom.ppf([0.005, 0.995], 100, 0.95)  # 99 % of all such experiments: 89 to 99
    assert low <= covered <= high
    z = np.array([(run.slope - 0.2) / np.ptp(run.ci95) * 2 * 1.96 for run in runs])
    assert abs(z.mean()) < 2.6 / np.sqrt(len(z))  # no bias: 99 %
    assert np.mean([run.status == "effect" for run in runs]) > 0.8


def test_without_an_effect_few_logs_show_one():
    runs = [warm_up(warmed(seed, slope=0.0)) for seed in range(40)]
    shown = sum(run.status == "effect" for run in runs)
    assert shown <= binom.ppf(0.995, 40, 0.05 + 0.05)  # of either cause, temperature or settling


def test_a_lag_and_jitter_are_found():
    course = np.empty_like(T)
    course[0] = WARMTH[0]
    for k in range(1, len(T)):
        course[k] = course[k - 1] + (WARMTH[k] - course[k - 1]) * -np.expm1(-0.4 / 30)
    late = [warm_up(warmed(seed, course=course, jitter=-20.0, drift=0.005)) for seed in range(5)]
    assert all(run.cause == "temperature" for run in late)
    assert (
        24 <= np.median([run.lag for run in late]) <= 37
    )  # neighbours of 30 s in the grid of time constants
    for run in late:
        assert run.ci95[0] < 0.2 < run.ci95[1]
        # 750 readings of 0.01 K against 0.2 m: 0.73 m/K; the smoothing takes 4 % of the reading's noise
        assert run.jitter == pytest.approx(-20, abs=3 * 0.73 + 0.8)
        assert run.jitter_sd == pytest.approx(0.2, rel=0.15)


def test_a_settling_without_temperature_is_found():
    settling = 2.0 * np.exp(-T / 45)
    for seed in range(5):
        rest = replace(warmed(seed, slope=1.0, course=-settling, drift=0.005), temperature=None)
        run = warm_up(rest)
        assert run.cause == "settling"
        assert run.unit == "m"
        assert run.ci95[0] < -2.0 < run.ci95[1]
        assert run.jitter_sd == 0
        assert np.isnan(run.pascal_per_kelvin)
        assert np.isnan(run.span)


def test_compensated_it_is_as_if_it_had_been_warm_from_the_start():
    for seed in range(3):
        rest, run = warmed(seed), found(seed)
        warm = warmed(seed, slope=0.0)
        truth = 0.2 * (WARMTH - WARMTH[-1])
        left = run.compensate().height() - warm.height() - 0.2 * WARMTH[-1]
        # what is left is the effect's error: that of the slope, and 0.2 m/K of what smoothing leaves
        assert np.abs(left).max() < np.ptp(run.ci95) / 2 * 1.5 * 15 + 0.02
        assert np.abs(run.effect - truth).max() == pytest.approx(np.abs(left).max(), abs=0.02)
        assert rest.notes == ()
        assert [note.code for note in run.compensate().notes] == ["warm-up-compensated"]


def test_identify_goes_on_without_the_drift_that_was_temperature():
    rest = warmed(3, slope=0.4)
    before, after = identify(rest), identify(warm_up(rest).compensate())
    assert after.model.drift_rate < 0.75 * before.model.drift_rate
    low, high = after.model.ci95["drift_rate"]
    assert low < 0.02 < high


def test_a_trend_of_the_weather_that_looks_like_warming_is_not_told_from_it():
    slowly = 20 + 10 * (1 - np.exp(-T / 600))  # nearly a straight line in 300 s
    weather = replace(warmed(1, slope=0.0, drift=0.002, trend=0.01), temperature=slowly)
    run = warm_up(weather)
    assert run.ci95[0] > 0  # the temperature would explain it
    assert run.status == "not-separable"
    assert "relative_to" in run.verdict()


def test_a_temperature_that_hardly_changes_teaches_nothing():
    rng = np.random.default_rng(5)
    rest = replace(
        warmed(5, slope=0.0), temperature=25 + 0.05 * np.sin(T / 40) + 0.007 * rng.normal(size=len(T))
    )
    run = warm_up(rest)
    assert run.status == "hardly-warmed"
    assert "changes by 0.1" in run.verdict() or "changes by 0.09" in run.verdict()  # K, twice 0.05


def test_its_regression_is_generalised_least_squares_with_the_noises_covariance():
    import statsmodels.api as sm

    rng = np.random.default_rng(7)
    t = np.cumsum(rng.uniform(0.1, 0.4, size=120))
    x = np.stack([np.sin(t / 5), t**2 / 100], axis=1)
    y = 3 + x @ [0.7, -0.2] + 0.3 * rng.normal(size=len(t))
    white, drift, sd, tau = theta = np.array([0.3, 0.05, 0.2, 1.5])
    lag = np.abs(t[:, None] - t)
    covariance = white**2 * np.eye(len(t)) + drift**2 * np.minimum(t[:, None], t) + sd**2 * np.exp(-lag / tau)
    gls = sm.GLS(y, sm.add_constant(x), sigma=covariance).fit()
    sds = np.sqrt(np.diag(gls.normalized_cov_params))[1:]
    coefficients, ours = least_squares(t, y, x, theta)
    # both are exact; 1e-6 is what the dense solution and the filter lose in 120 steps
    assert np.allclose(coefficients, gls.params[1:], rtol=1e-6)
    assert np.allclose(ours, sds, rtol=1e-6)


def test_too_little_is_refused():
    with pytest.raises(
        ValueError, match=r"50 pressure samples over 19.6 s; a warm-up needs 100 or more over 60 s"
    ):
        warm_up(warmed(1).rows(slice(50)))


def test_a_real_warm_up_settles_and_is_no_longer_one_when_compensated(shared_data):
    rest = read(shared_data / "pixracer_ms5611_pendulum" / "pendulum_baro.csv.gz")
    run = warm_up(rest)
    # the folder's README: from 571 to 573.4 m in the first 120 s, which an exponential of 45 s is at 93 % of
    assert run.effect[0] == pytest.approx(-2.4 / 0.93, abs=0.2)  # 0.2 m: sd of a sample
    assert run.status == "effect"
    assert run.drift_rates[1] < 0.5 * run.drift_rates[0]
    codes = [finding.code for finding in identify(run.compensate()).verdict]
    assert "warm-up" not in codes
    assert "warm-up-compensated" in codes


def test_a_bmp180_passes_on_its_thermometers_noise(shared_data):
    for mode in range(4):
        rest = read(shared_data / "bmp180_stm32_rest_and_stairs" / f"rest_oss{mode}_baro.csv.gz")
        run = warm_up(rest)
        # compensated with its own thermometer, a reading is off by some 250 Pa/K times that one's error
        assert -30 < run.jitter < -20
        assert run.jitter_sd > 0.1
