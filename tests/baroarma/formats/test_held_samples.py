"""Held samples go, honest repeats stay: on real logs and on simulated ones whose truth is known."""

import csv
import gzip
import time

import numpy as np
import pytest
from scipy.signal import lfilter

from baroarma import Recording
from baroarma.formats import drop_held_samples, read
from baroarma.formats.held_samples import slow_sensor

HONEST = [
    "ms5611_static_80hz/rest_baro",
    "pixracer_ms5611_pendulum/pendulum_baro",
    "srp_altimu10_elevator_rocket/elevator_baro",
    *(f"bmp180_stm32_rest_and_stairs/rest_oss{k}_baro" for k in range(4)),
    *(f"bmp180_stm32_rest_and_stairs/stairs_{way}_baro" for way in ("up_b5", "down_b5", "up_kapitol")),
]
STAMPFLY = ["air_d", "lift30cm_a", "lift30cm_b", "rest_f", "setdown_c", "tilt_e"]


def log_of(reading, rate=100.0, t=None):
    return Recording(t=np.arange(len(reading)) / rate if t is None else t, pressure=101_325.0 + reading)


def slow_log(ratio, noise_sd, n=6000, seed=0):
    """A 10 Hz log, clock jitter 2 %, of a sensor `ratio` times slower with quanta of 1; and what was new."""
    rng = np.random.default_rng(seed)
    own = np.floor(np.arange(n) / ratio + rng.uniform()).astype(int)
    sensor = np.round(rng.normal(0, noise_sd, own[-1] + 1))
    recording = log_of(sensor[own], t=np.arange(n) / 10 + rng.uniform(-0.002, 0.002, n))
    return recording, np.diff(own, prepend=-1) > 0


def coarse(noise_sd, rate, gm, rng, n=6000):
    """White noise of `noise_sd` quanta on Gauss-Markov noise of `gm` times that, rounded to whole quanta."""
    phi = np.exp(-1 / rate / 0.75)
    wander = lfilter([1], [1, -phi], rng.normal(0, gm * noise_sd * np.sqrt(1 - phi**2), n))
    return np.round(rng.normal(0, noise_sd, n) + wander + rng.uniform())


@pytest.mark.parametrize("name", HONEST)
def test_an_honest_sensor_is_left_alone(shared_data, name):
    found = read(shared_data / f"{name}.csv.gz")
    assert found.is_new.all()
    assert not found.notes


@pytest.mark.parametrize("gm", [0.0, 1.0, 3.0])
@pytest.mark.parametrize("noise_sd", [0.3, 0.5, 1.0, 3.0])
def test_coarse_quantisation_is_not_holding(noise_sd, gm):
    rng = np.random.default_rng(11)
    for rate in (1.0, 8.7, 25.0, 100.0, 400.0):
        for _ in range(5):
            log = log_of(coarse(noise_sd, rate, gm, rng), rate)
            assert drop_held_samples(log) is log


@pytest.mark.parametrize("quantum", [1.0, 5.0, 20.0])
def test_a_steady_climb_through_coarse_quanta_is_not_holding(quantum):
    rng = np.random.default_rng(12)
    for speed in (1.3, 4.1, 12.0):  # Pa/s
        for noise_sd in (0.0, 0.1, 0.3):
            climb = speed * np.arange(6000) / 50 + noise_sd * quantum * rng.normal(0, 1, 6000)
            log = log_of(quantum * np.round(climb / quantum), 50.0)
            assert drop_held_samples(log) is log


def test_uneven_sampling_is_not_holding():
    rng = np.random.default_rng(13)
    for steps in (rng.choice([0.012, 0.024], 8000), rng.choice([0.005, 0.02], 8000, p=[0.4, 0.6])):
        log = log_of(np.round(rng.normal(0, 0.7, 8000)), t=np.cumsum(steps))
        assert drop_held_samples(log) is log
    log = log_of(np.round(rng.normal(0, 0.4, 8000)), t=np.cumsum(rng.exponential(0.02, 8000) + 1e-4))
    assert drop_held_samples(log) is log


@pytest.mark.parametrize("ratio", [1.05, 1.2, 10 / 6.8, 1.9, 2.0, 2.3, 3.0, 7.3, 20.0])
def test_a_slow_sensors_repeats_are_dropped_whatever_the_ratio(ratio):
    recording, new = slow_log(ratio, noise_sd=1000.0)  # honest repeats: 1 in 3500
    found = drop_held_samples(recording)
    # At most 5714 / 3500 = 1.6 honest repeats are expected, 7 once in a thousand; their row is a guess.
    assert (found.is_new & ~new).sum() <= 6
    assert (new & ~found.is_new).sum() <= 6
    period = slow_sensor(recording.t, recording.pressure)[1]
    assert period == pytest.approx(
        ratio / 10, rel=0.01
    )  # jitter 2 % of an interval, averaged over > 300 runs
    assert found.notes[0].code == "held-samples"


@pytest.mark.parametrize("ratio", [1.9, 2.0, 3.0, 7.3, 20.0])
@pytest.mark.parametrize("noise_sd", [3.0, 1.0, 0.5])
def test_a_slow_and_coarse_sensor_keeps_as_many_readings_as_it_made(ratio, noise_sd):
    recording, new = slow_log(ratio, noise_sd)
    found = drop_held_samples(recording)
    # Below two rows a period a repeat may be either and counts as held: a tenth may go, hardly one may come.
    assert 0.9 * new.sum() < found.is_new.sum() < 1.01 * new.sum()
    changed = np.diff(recording.pressure, prepend=np.nan) != 0
    assert (found.is_new | ~changed).all()


@pytest.mark.parametrize("name", STAMPFLY)
def test_the_stampflys_held_altitude_is_found_without_its_flag(shared_data, name):
    path = shared_data / "stampfly_tof_handheld" / f"{name}.csv.gz"
    with gzip.open(path, "rt") as file:
        is_new = np.array([row["altitude_is_new"] == "1" for row in csv.DictReader(file)])
    found = read(path)
    assert (found.is_new | ~is_new).all()
    # The flag marks changes only; runs of 12-15 and 19-22 rows are 2 and 3 periods of 5-8 rows.
    assert is_new.sum() < found.is_new.sum() < 1.4 * is_new.sum()
    assert (
        10 < found.rate_hz < 16
    )  # README: 10.5 to 12.9 Hz, median interval 0.077 s; a BMP280's nominal 13 Hz
    gaps = np.diff(found.t[found.is_new])[1:]  # the first reading had begun before the log
    assert gaps.min() >= 0.044  # no two readings closer than 4 rows, the flag's own shortest


def test_the_pads_re_reads_go_and_late_new_readings_stay(shared_data):
    pad = read(shared_data / "srp_altimu10_elevator_rocket" / "rocket_baro.csv.gz")
    interval = np.diff(pad.t, prepend=-1.0)
    raw_short = interval < 0.05
    dropped = ~pad.is_new
    assert dropped.sum() == 182
    assert not (dropped & ~raw_short).any()
    assert (raw_short & ~dropped).sum() == 29  # unequal: the sensor did read anew
    assert [note.severity for note in pad.notes] == ["info"]


def test_blank_rows_between_do_not_matter():
    recording, _ = slow_log(3.0, 1000.0, n=1500)
    spread = np.full(3000, np.nan)
    spread[::2] = recording.pressure
    t = np.interp(np.arange(3000) / 2, np.arange(1500), recording.t) + np.arange(3000) * 1e-9
    merged = drop_held_samples(Recording(t=t, pressure=spread))
    np.testing.assert_array_equal(merged.is_new[::2], drop_held_samples(recording).is_new)
    assert not merged.is_new[1::2].any()


def test_cleaning_twice_is_cleaning_once():
    for ratio in (1.47, 2.3, 7.3):
        once = drop_held_samples(slow_log(ratio, 1.0)[0])
        assert drop_held_samples(once) is once


@pytest.mark.parametrize("n", [0, 1, 2, 3, 30])
def test_short_or_dead_logs_are_left_alone(n):
    log = log_of(np.zeros(n))
    assert drop_held_samples(log) is log


def test_the_time_it_takes_grows_with_the_log_only():
    def seconds(n):
        log = log_of(np.round(np.random.default_rng(0).normal(0, 1, n)))
        best = np.inf
        for _ in range(3):
            start = time.perf_counter()
            drop_held_samples(log)
            best = min(best, time.perf_counter() - start)
        return best

    assert seconds(300_000) < 60 * max(seconds(30_000), 1e-3)  # ten times the rows; a quadratic one takes 100
