"""The verdict names each defect of a rest recording by its code, and is silent about a clean one."""

from dataclasses import replace

import numpy as np
import pytest

from baroarma import NoiseModel, Recording, identify
from baroarma.atmosphere import altitude_pressure
from baroarma.formats import drop_held_samples
from baroarma.identification.bound import cramer_rao_bound
from baroarma.identification.verdict import judge_model, judge_recording, minutes_wanting
from baroarma.simulation import BMP085, Barometer, simulate, simulate_rest

WINDY = NoiseModel(0.4, 20.0, 0.46, 0.01, rate_hz=50)


def codes(findings, *severities):
    return {f.code for f in findings if not severities or f.severity in severities}


def recording_of(height, rate_hz=50.0, quantum=0.0):
    pressure = altitude_pressure(100 + np.asarray(height))
    if quantum:
        pressure = np.round(pressure / quantum) * quantum
    return Recording(t=np.arange(len(pressure)) / rate_hz, pressure=pressure, name="made up")


def noise(seconds=120, seed=0, model=BMP085.noise):
    return model.simulate(round(seconds * model.rate_hz), seed)


def only(findings, code):
    (finding,) = [f for f in findings if f.code == code]
    return finding


@pytest.mark.parametrize("minutes", [10, 60])
def test_a_clean_rest_has_nothing_to_object_to(minutes):
    found = identify(simulate_rest(60 * minutes, seed=1, rate_hz=50 if minutes == 10 else 10))
    assert codes(found.verdict, "warning", "error") == set()
    assert found.ok


@pytest.mark.parametrize(
    "model",
    [replace(model, drift_rate=drift) for model in (BMP085.noise, WINDY) for drift in (0.01, 0.03, 0.1)],
    ids=repr,
)
def test_drift_and_wind_raise_no_false_alarm(model):
    # an alarm rate of 2 % or more per recording would show in 180 of them with 97 %
    rests = [simulate_rest(600, seed=seed, rate_hz=10, barometer=Barometer(model)) for seed in range(30)]
    assert [judge_recording(rest) for rest in rests] == [()] * 30


def test_a_squat_is_moving_by_the_imu_although_the_pressure_hardly_shows_it():
    squat = simulate("squat", duration=60, seed=1)
    finding = only(judge_recording(squat), "moving")
    assert finding.severity == "error"
    assert "IMU" in finding.message
    assert "moving" not in codes(judge_recording(replace(squat, accel=None, gyro=None)))


@pytest.mark.parametrize("seed", range(3))
def test_a_resting_imu_is_at_rest_in_any_mounting(seed):
    assert judge_recording(simulate("rest", duration=60, seed=seed)) == ()


@pytest.mark.parametrize("left_out", ["accel", "gyro"])
def test_gyro_or_accelerometer_alone_see_motion_and_rest(left_out):
    squat, rest = simulate("squat", duration=60, seed=2), simulate("rest", duration=60, seed=2)
    assert "moving" in codes(judge_recording(replace(squat, **{left_out: None})), "error")
    assert judge_recording(replace(rest, **{left_out: None})) == ()


def test_one_knock_in_ten_minutes_is_a_warning():
    rest = simulate("rest", duration=600, seed=3)
    gyro = rest.gyro.copy()
    gyro[15_010:15_030] += 1.0
    finding = only(judge_recording(replace(rest, gyro=gyro)), "moving")
    assert finding.severity == "warning"
    assert "1 of 600 seconds, first at 300 s" in finding.message


def test_an_imu_without_a_sample_leaves_the_judgement_to_the_pressure():
    squat = simulate("squat", duration=60, seed=1)
    nothing = np.full((len(squat), 3), np.nan)
    assert judge_recording(replace(squat, accel=nothing, gyro=nothing)) == ()


@pytest.mark.parametrize(
    ("climb", "name"),
    [
        (np.clip((np.arange(6000) - 3000) / 200, 0, 3.0), "one floor"),
        (np.clip((np.arange(30_000) - 6000) / 500 * 1.7, 0, 12.0), "slow stairs"),
        (np.where(np.arange(6000) < 4000, 0.0, 1.6), "put on a shelf"),
    ],
)
def test_height_that_changes_is_moving_by_pressure(climb, name):
    quiet = replace(BMP085.noise, correlated_sd=0.1)
    recording = recording_of(climb + noise(len(climb) / 50, model=quiet))
    finding = only(judge_recording(recording), "moving")
    assert finding.severity == "error", name
    assert "height changes by" in finding.message


def test_a_lift_ride_during_a_gap_is_moving():
    height = noise(120) + np.where(np.arange(6000) < 3000, 0.0, 10.0)
    recording = recording_of(height).rows(np.r_[0:2000, 4000:6000])
    assert "moving" in codes(judge_recording(recording), "error")


def test_a_sensor_of_one_sample_a_minute_may_drift_more_between_its_means():
    drifting = NoiseModel(0, 0, 0.1, 0.05, rate_hz=1 / 60)
    assert "moving" not in codes(judge_recording(recording_of(noise(86_400, model=drifting), 1 / 60)))
    ride = np.where(np.arange(1440) < 700, 0.0, 30.0)
    assert "moving" in codes(judge_recording(recording_of(ride + noise(86_400, model=drifting), 1 / 60)))


@pytest.mark.parametrize(("rows", "rate_hz"), [(99, 5), (400, 50), (1, 1), (0, 1)])
def test_too_few_samples_or_seconds_are_an_error(rows, rate_hz):
    found = identify(recording_of(noise()[:rows], rate_hz))
    assert not found.ok
    assert only(found.verdict, "too-short").severity == "error"


def test_a_log_of_few_correlation_times_is_too_short():
    slow = NoiseModel(0.4, 20.0, 0.2, rate_hz=10)
    found = identify(simulate_rest(300, seed=4, rate_hz=10, barometer=Barometer(slow)), terms=("white", "gm"))
    finding = only(found.verdict, "too-short")
    assert finding.severity == "warning"
    assert f"about {found.minutes_wanting:.0f} minutes more" in finding.message


def test_the_minutes_asked_for_bring_the_half_width_to_ten_percent():
    truth = NoiseModel(0.3, 1.0, 0.3, rate_hz=10)
    asked = []
    for seed in range(8):
        short = identify(simulate_rest(600, seed=seed, rate_hz=10, barometer=Barometer(truth, 0)))
        asked.append(10 + short.minutes_wanting)
    enough = 60 * float(np.median(asked))
    half_widths = []
    for seed in range(4):
        rest = simulate_rest(enough, seed=100 + seed, rate_hz=10, barometer=Barometer(truth, 0))
        low, high = identify(rest).model.ci95["correlation_time"]
        half_widths.append((high - low) / 2 / truth.correlation_time)
    # the advice's own scatter: tau is known to 10 % in 10 min, and with it the duration to 20 %
    assert np.mean(half_widths) == pytest.approx(0.10, rel=0.2)
    # and by theory: 1.96 times the Cramer-Rao bound
    bound = 1.96 * cramer_rao_bound(truth, enough)["correlation_time"] / truth.correlation_time
    assert np.mean(half_widths) == pytest.approx(bound, rel=0.15)


def test_the_advice_is_the_square_of_the_half_width():
    def model(factor):
        ci95 = {"correlated_sd": (0.2, 0.3), "correlation_time": (1 / factor, factor), "white_sd": (0.4, 0.5)}
        return NoiseModel(0.25, 1.0, 0.45, rate_hz=50, ci95={**ci95, "drift_rate": (0.0, 0.1)})

    ten_percent = np.arcsinh(0.10)
    assert minutes_wanting(model(np.exp(ten_percent)), 600) == pytest.approx(0, abs=1e-9)
    assert minutes_wanting(model(np.exp(3 * ten_percent)), 600) == pytest.approx(80)
    assert minutes_wanting(model(np.exp(0.5 * ten_percent)), 600) == 0
    assert minutes_wanting(NoiseModel(0, 0, 0.4, rate_hz=50), 600) is None
    assert minutes_wanting(BMP085.noise, 600) is None


def test_gaps_are_named_and_counted():
    recording = recording_of(noise()).rows(np.r_[0:1000, 1100:3000, 3010:6000])
    finding = only(judge_recording(recording), "gaps")
    assert finding.severity == "info"
    assert finding.message.startswith("2 gaps, the longest 2.02 s, 2.2 s lost")
    half = recording_of(noise()).rows(np.r_[0:1500, 4500:6000])
    assert only(judge_recording(half), "gaps").severity == "warning"


def test_held_samples_that_reading_found_are_in_the_verdict():
    slow = np.repeat(noise(1200, model=replace(BMP085.noise, rate_hz=10))[::2], 10)
    found = judge_recording(drop_held_samples(recording_of(slow)))
    assert "held-samples" in codes(found, "warning")


def test_a_quantum_above_the_noise_is_coarse():
    fine = NoiseModel(0.1, 1.0, 0.1, 0.01, rate_hz=50)
    assert "coarse-quantisation" not in codes(judge_recording(recording_of(noise(model=fine), quantum=1)))
    found = identify(recording_of(noise(600, model=fine), quantum=10))
    assert "coarse-quantisation" in codes(found.verdict, "warning")
    assert "0.84 m is coarser" in only(found.verdict, "coarse-quantisation").message


def test_a_start_that_settles_is_warm_up_and_the_advice_cures_it():
    t = np.arange(30_000) / 50
    recording = recording_of(2.0 * np.exp(-t / 60) + noise(600))
    finding = only(judge_recording(recording), "warm-up")
    assert finding.severity == "warning"
    assert "above" in finding.message
    seconds = float(finding.message.split("drop the first ")[1].split(" s")[0])
    assert 60 < seconds < 240  # 1 to 4 time constants: from 2 m to some cm
    assert "warm-up" not in codes(judge_recording(recording.between(seconds, np.inf)))


def test_a_constant_pressure_is_dead():
    recording = Recording(t=np.arange(1000) / 50, pressure=np.full(1000, 101325.0))
    assert codes(judge_recording(recording), "error") == {"dead"}


@pytest.mark.parametrize("stuck", [slice(2000, 4000), slice(0, 2000), slice(4000, 6000)])
def test_a_pressure_that_stands_still_for_a_while_is_dead(stuck):
    pressure = recording_of(noise()).pressure.copy()
    pressure[stuck] = pressure[stuck][0]
    finding = only(judge_recording(Recording(t=np.arange(6000) / 50, pressure=pressure)), "dead")
    assert finding.severity == "error"
    assert f"from {stuck.start / 50:g} s on" in finding.message


def test_a_quiet_sensor_that_stays_on_one_quantum_is_coarse_but_not_dead():
    pressure = np.full(30_000, 101320.0)
    pressure[[5000, 5001, 20_000]] = 101330.0
    found = judge_recording(Recording(t=np.arange(30_000) / 50, pressure=pressure))
    assert codes(found) == {"coarse-quantisation"}


@pytest.mark.parametrize(("factor", "advice"), [(0.01, "hPa"), (1e-5, "unit"), (100, "unit"), (-1, "unit")])
def test_a_pressure_that_cannot_be_is_a_wrong_unit(factor, advice):
    recording = recording_of(noise())
    found = identify(replace(recording, pressure=factor * recording.pressure))
    assert not found.ok
    assert advice in only(found.verdict, "units").message


def test_prediction_errors_that_are_not_white_are_named():
    # a hum at 5 Hz is neither white nor Gauss-Markov nor drift
    found = identify(recording_of(noise(300) + 0.5 * np.sin(2 * np.pi * 5 * np.arange(15_000) / 50)))
    finding = only(found.verdict, "not-white")
    assert finding.severity == "warning"
    assert "Bartlett" in finding.message
    assert min(found.model.whiteness_p.values()) < 1e-3


def test_a_log_without_a_gauss_markov_component_says_so():
    white = NoiseModel(0, 0, 0.46, 0.01, rate_hz=50)
    found = identify(recording_of(noise(600, model=white)))
    finding = only(found.verdict, "no-gm")
    assert finding.severity == "info"
    assert "white noise and drift explain them" in finding.message
    asked = identify(recording_of(noise(600)), terms=("white",))
    assert "asked for without" in only(asked.verdict, "no-gm").message


def test_two_correlation_times_are_a_warning():
    slow = NoiseModel(0.4, 8.0, 0.0, rate_hz=50)
    found = identify(
        recording_of(noise(600, model=replace(BMP085.noise, correlation_time=0.2)) + noise(600, 1, slow))
    )
    assert "two-time-constants" in codes(found.verdict, "warning")
    assert found.model.has_gauss_markov


def test_a_model_without_intervals_or_p_values_can_be_judged():
    assert judge_model(BMP085.noise, duration=600) == ()
    assert codes(judge_model(NoiseModel(0, 0, 0.4, rate_hz=50), duration=600)) == {"no-gm"}


def test_an_interval_down_to_zero_says_that_the_correlation_time_is_unknown():
    half_a_minute = identify(simulate_rest(30, seed=5), method="windows")  # one window: no scatter to see
    finding = only(half_a_minute.verdict, "too-short")
    assert "do not determine the correlation time" in finding.message
    assert half_a_minute.minutes_wanting is None


@pytest.mark.parametrize("method", ["structural", "windows"])
def test_a_bump_too_small_for_a_ten_second_mean_is_still_named(method):
    rest = simulate_rest(300, seed=6)
    bump = np.zeros(len(rest))
    bump[7500:7600] = -60 * np.hanning(100)  # lifted by 5 m for 2 s, at 150 s
    found = identify(replace(rest, pressure=rest.pressure + bump), method=method)
    finding = only(found.verdict, "moving")
    assert finding.severity == "warning"
    assert "near 150 s" in finding.message or "near 151 s" in finding.message
    assert all(f.code != "moving" for f in identify(rest, method=method).verdict)


def test_rests_without_a_bump_are_not_accused():
    for seed in range(10):
        codes = [f.code for f in identify(simulate_rest(600, seed=seed), terms=("white",)).verdict]
        assert "moving" not in codes  # not even where the model asked for misses most of the noise
