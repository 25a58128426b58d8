"""A sensor that hung is told from one that is honestly quiet."""

from dataclasses import replace

import numpy as np
import pytest

from baroarma.recording import Recording
from baroarma.simulation import simulate
from baroarma.standstill import dead_barometer, noise_of, quantum_of, stuck_axes


def test_quantum_and_noise_are_what_was_put_in():
    rng = np.random.default_rng(1)
    signal = np.round(rng.normal(0, 3, 5000) / 0.25) * 0.25
    assert quantum_of(signal) == 0.25
    assert quantum_of(np.full(5, 3.0)) == 0.0
    # the variance of the differences of white noise is known to 1/sqrt(n), and rounding adds q²/12
    assert noise_of(np.diff(signal)) == pytest.approx(np.sqrt(9 + 0.25**2 / 12), rel=4 / np.sqrt(5000))


@pytest.mark.parametrize(("seconds", "found"), [(9, False), (11, True)])
def test_a_barometer_that_stands_still_for_ten_seconds_hung(seconds, found):
    t = np.arange(3000) / 50
    pressure = 1e5 + np.random.default_rng(2).normal(0, 3, 3000)
    pressure[1000 : 1000 + 50 * seconds] = 1e5
    assert bool(dead_barometer(t, pressure)) == found


def test_a_quantum_above_the_noise_stands_still_honestly():
    t = np.arange(6000) / 50
    pressure = np.round((1e5 + 0.2 * np.sin(t / 30)) / 10) * 10
    pressure[3000:3002] += 10
    assert dead_barometer(t, pressure) == []


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize(("field", "name"), [("accel", "accelerometer"), ("gyro", "gyro")])
def test_each_axis_that_hangs_while_the_others_move_is_named(field, name, axis):
    log = simulate("lee16-e", duration=45, seed=2)
    signal = getattr(log, field).copy()
    signal[1000:, axis] = signal[1000, axis]
    (found,) = stuck_axes(replace(log, **{field: signal}))
    assert found.code == "stuck"
    assert f"The {name}'s {'xyz'[axis]} stands still" in found.message
    assert "25 s from 20 s on" in found.message


def test_a_sensor_without_a_sample_is_not_one_that_hung():
    log = simulate("squat", duration=30, seed=1)
    nothing = np.full((len(log), 3), np.nan)
    assert stuck_axes(replace(log, gyro=nothing)) == []
    assert stuck_axes(replace(log, accel=nothing, gyro=nothing)) == []


def test_coarse_axes_at_rest_are_quiet_not_stuck():
    rest = simulate("rest", duration=120, seed=3)
    coarse = np.round(rest.accel / 0.3) * 0.3  # eight bits on 4 g
    assert (np.ptp(coarse, axis=0) == 0).any()
    assert stuck_axes(replace(rest, accel=coarse)) == []


def test_a_gyro_that_rests_at_zero_hung_only_if_the_device_moves():
    zero = {"gyro": np.zeros((3000, 3))}
    assert stuck_axes(replace(simulate("rest", duration=60, seed=1), **zero)) == []
    assert stuck_axes(replace(simulate("squat", duration=60, seed=1), **zero)) != []


def test_a_few_rows_say_nothing():
    log = Recording(t=[0.0, 20.0], pressure=[1e5, 1e5], accel=np.ones((2, 3)), gyro=np.ones((2, 3)))
    assert dead_barometer(log.t, log.pressure) == []
    assert stuck_axes(log) == []
