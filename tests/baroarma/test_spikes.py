"""Spikes go, and nothing that a barometer may honestly say."""

from dataclasses import replace

import numpy as np
import pytest

from baroarma.recording import Recording
from baroarma.simulation import MOTIONS, simulate
from baroarma.spikes import drop_imu_spikes, drop_spikes, pressure_spikes


def quiet(seed=0, n=3000, sd=3.0):
    return np.arange(n) / 50, 101_325 + np.random.default_rng(seed).normal(0, sd, n)


@pytest.mark.parametrize("length", [1, 2, 10, 49])
@pytest.mark.parametrize("size", [-40_000.0, 200.0])
def test_a_spike_of_up_to_a_second_is_found_whole_and_nothing_else(length, size):
    t, pressure = quiet()
    pressure[1000 : 1000 + length] += size
    spike, count = pressure_spikes(t, pressure)
    assert count == 1
    np.testing.assert_array_equal(np.flatnonzero(spike), np.arange(1000, 1000 + length))


def test_readings_between_two_spikes_stay():
    t, pressure = quiet()
    pressure[[1000, 1001, 1010, 1030]] = 110_000.0
    spike, count = pressure_spikes(t, pressure)
    assert count == 3
    np.testing.assert_array_equal(np.flatnonzero(spike), [1000, 1001, 1010, 1030])


def test_a_burst_of_garbage_goes_whole():
    t, pressure = quiet()
    pressure[500:520] = np.random.default_rng(3).uniform(20_000, 120_000, 20)
    assert np.flatnonzero(pressure_spikes(t, pressure)[0]).tolist() == list(range(500, 520))


def test_a_step_that_stays_is_no_spike():
    t, pressure = quiet()
    pressure[1000:] += 500.0
    assert pressure_spikes(t, pressure)[1] == 0


@pytest.mark.parametrize("seed", range(20))
def test_heavy_tails_are_no_spikes(seed):
    t, pressure = quiet(seed)
    tails = 5 * np.random.default_rng(100 + seed).standard_t(6, len(t))  # kurtosis 6
    assert pressure_spikes(t, pressure + tails)[1] == 0


def test_coarse_readings_are_no_spikes():
    t, pressure = quiet(sd=20.0)
    assert pressure_spikes(t, np.round(pressure / 50) * 50)[1] == 0


@pytest.mark.parametrize("motion", MOTIONS)
def test_no_motion_is_a_spike(motion):
    log = simulate(motion, duration=30, seed=4)
    assert drop_spikes(log) is log


def test_turbulence_around_a_rocket_is_none_though_the_pad_was_calm():
    t, pressure = quiet(n=20_000)
    pressure[18_000:] += np.random.default_rng(5).normal(0, 60.0, 2000)
    assert pressure_spikes(t, pressure)[1] == 0


def test_impossible_forces_and_rates_are_blanked_alone():
    log = simulate("squat", duration=20, seed=1)
    accel, gyro = log.accel.copy(), log.gyro.copy()
    accel[100, 2], gyro[200:202, 0] = -1e6, 1e4
    clean = drop_imu_spikes(replace(log, accel=accel, gyro=gyro))
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(clean.accel).any(axis=1)), [100])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(clean.gyro).any(axis=1)), [200, 201])
    assert [note.code for note in clean.notes] == ["spikes", "spikes"]


def test_rates_that_last_are_a_unit_and_stay():
    log = simulate("squat", duration=20, seed=1)
    fast = replace(log, gyro=log.gyro + 500.0)
    assert drop_imu_spikes(fast) is fast


def test_short_and_empty_logs_have_none():
    for n in range(4):
        log = Recording(t=np.arange(n), pressure=np.r_[1e5, 2e5, 1e5][:n] if n < 4 else np.full(n, np.nan))
        assert drop_spikes(log) is log or n == 3
