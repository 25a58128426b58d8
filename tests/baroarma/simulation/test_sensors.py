"""Sensors add what their description says, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from baroarma.atmosphere import altitude_pressure, pressure_altitude
from baroarma.noise_model import NoiseModel
from baroarma.simulation import BMP085, WIMU, Barometer, Clock, Imu, Triad, simulate
from baroarma.simulation.motions import mount

T = np.arange(3000) / 50
PERFECT = Imu(0.0, 0.0, 0.0, 0.0)
SILENT = NoiseModel(0, 0, 0, 0, rate_hz=50)


@pytest.fixture(scope="module")
def circle():
    return mount("circle", np.random.default_rng(0), frequency_hz=1.0)


def felt(imu, motion, seed=0):
    return imu.sample(motion, T, np.random.default_rng(seed))


def pressure_of(barometer, height_at, seed=0):
    return barometer.sample(height_at, T, np.random.default_rng(seed))


def test_perfect_sensors_say_the_truth(circle):
    accel, gyro = felt(PERFECT, circle)
    assert np.array_equal(accel, circle(T).force)
    assert np.array_equal(gyro, circle(T).rate)
    pressure = pressure_of(Barometer(SILENT, quantum=0), lambda t: 100 + t)
    assert np.array_equal(pressure, altitude_pressure(100 + T))


def test_the_simple_imu_adds_white_noise_and_a_constant_bias(circle):
    accel, gyro = felt(WIMU, circle)
    for error, sd in ((accel - circle(T).force, WIMU.accel_sd), (gyro - circle(T).rate, WIMU.gyro_sd)):
        # the variance of 9000 normal numbers is known to sqrt(2/9000) = 1.5 %, the sd to half of it; 4 sigma
        assert np.sqrt(error.var(axis=0).mean()) == pytest.approx(sd, rel=0.03)
        lag1 = np.mean(error[1:] * error[:-1], axis=0) - error.mean(axis=0) ** 2
        assert np.abs(lag1).max() < 4 * sd**2 / np.sqrt(len(T))


def test_biases_and_scales_spread_as_described():
    rest = mount("rest", np.random.default_rng(0))
    unit = Imu(0.0, 0.0, 0.2, 0.03, accel=Triad(scale_sd=0.05))
    t = T[:1]
    samples = [unit.sample(rest, t, np.random.default_rng(seed)) for seed in range(1000)]
    accel, gyro = (np.array([s[i][0] for s in samples]) for i in range(2))
    force = rest(t).force[0]
    # sd of 1000 normal numbers: 1/sqrt(2000) = 2.2 %; 4 sigma
    assert gyro.std(axis=0) == pytest.approx(np.full(3, 0.03), rel=0.09)
    # each axis of each sensor has its own: correlations of 1000 pairs are known to 3.2 %; 4 sigma
    assert np.abs(np.corrcoef(accel.T, gyro.T) - np.eye(6)).max() < 0.13
    assert accel.std(axis=0) == pytest.approx(np.hypot(0.2, 0.05 * np.hypot(force, 0.2)), rel=0.09)


def test_a_scale_error_is_one_factor_per_axis(circle):
    accel, gyro = felt(replace(PERFECT, accel=Triad(scale_sd=0.05)), circle)
    factors = accel / circle(T).force
    assert factors == pytest.approx(np.tile(factors[0], (len(T), 1)), rel=1e-12)
    assert np.abs(factors[0] - 1).min() > 0
    assert np.array_equal(gyro, circle(T).rate)


def test_the_drifting_bias_is_a_gauss_markov_process():
    rest = mount("rest", np.random.default_rng(0))
    unit = replace(PERFECT, gyro=Triad(drift_sd=0.01, drift_time=2.0))
    drifts = np.concatenate([felt(unit, rest, seed)[1] for seed in range(20)], axis=1)
    # 60 records of 60 s, each worth about 60 / (2 2) = 15 independent values, 900 in all: the variance is
    # known to sqrt(2/900) = 5 %; 4 sigma
    assert drifts.var() == pytest.approx(1e-4, rel=0.2)
    assert np.mean(drifts[100:] * drifts[:-100]) / drifts.var() == pytest.approx(np.exp(-1), abs=0.15)


def test_beyond_its_range_a_sensor_saturates():
    fall = mount("free-fall", np.random.default_rng(0))
    limit = 4 * 9.80665
    accel, _ = felt(replace(PERFECT, accel=Triad(limit=limit)), fall)
    assert np.array_equal(accel, np.clip(fall(T).force, -limit, limit))
    assert np.abs(fall(T).force).max() > limit  # or the test shows nothing
    deep = pressure_of(Barometer(SILENT, quantum=0, lowest=9e4, highest=1.1e5), lambda t: 100 * t - 3000)
    assert (deep.min(), deep.max()) == (9e4, 1.1e5)


def test_quantised_samples_are_multiples_and_err_by_half_a_step(circle):
    quantum = 0.01
    accel, _ = felt(replace(PERFECT, accel=Triad(quantum=quantum)), circle)
    assert accel / quantum == pytest.approx(np.round(accel / quantum), abs=1e-9)
    error = (accel - circle(T).force)[300:]
    assert np.abs(error).max() <= quantum / 2 + 1e-12
    # one turn is 50 samples, so the errors repeat: 150 different ones in all.  The mean square of uniform
    # numbers is then known to 0.9/sqrt(150) = 7 %, the sd to half of it; 4 sigma
    assert error.std() == pytest.approx(quantum / np.sqrt(12), rel=0.15)


def test_bandwidth_attenuates_what_turns_with_the_rod(circle):
    accel, _ = felt(replace(PERFECT, accel=Triad(bandwidth_hz=1.0, order=1)), circle)
    steady = T >= 20  # whole turns
    turning = accel[steady] - accel[steady].mean(axis=0)
    true = circle(T).force[steady] - circle(T).force[steady].mean(axis=0)
    # at its cut-off a filter leaves 1/sqrt(2); gravity turns, the centripetal part is constant
    assert turning.std(axis=0) == pytest.approx(true.std(axis=0) / np.sqrt(2), rel=1e-6)
    assert accel[steady].mean(axis=0) == pytest.approx(circle(T).force[steady].mean(axis=0), abs=1e-6)


def test_another_clock_shows_another_instant(circle):
    clock = Clock(offset=0.1, skew=200e-6)
    accel, gyro = felt(replace(PERFECT, clock=clock), circle)
    then = circle(T * (1 + 200e-6) + 0.1)
    assert accel == pytest.approx(then.force, abs=1e-12)
    assert gyro == pytest.approx(then.rate, abs=1e-12)
    late = pressure_of(Barometer(SILENT, quantum=0, clock=Clock(offset=-0.5)), lambda t: 3 * t)
    assert late == pytest.approx(altitude_pressure(3 * (T - 0.5)))


@pytest.mark.parametrize("held", [True, False])
def test_a_slow_imu_in_a_fast_log_repeats_itself_or_leaves_rows_out(circle, held):
    accel, gyro = felt(replace(PERFECT, rate_hz=10.0, held=held), circle)
    assert accel[::5] == pytest.approx(circle(T[::5]).force, abs=1e-12)
    between = gyro[1::5] == gyro[::5] if held else np.isnan(gyro[1::5])
    assert between.all()


def test_the_recursive_filter_is_that_of_the_data_sheet():
    noisy = Barometer(NoiseModel(0.3, 1.0, 0.5, rate_hz=50), quantum=0)
    raw, filtered = (pressure_of(b, np.sin) for b in (noisy, replace(noisy, iir=4.0)))
    expected = [raw[0]]
    for x in raw[1:]:
        expected.append(expected[-1] + (x - expected[-1]) / 4)
    assert filtered == pytest.approx(np.array(expected), rel=1e-13)


def test_a_recursive_filter_that_amplifies_is_refused():
    with pytest.raises(ValueError, match=r"must be at least 1, but it is 0\.5"):
        pressure_of(Barometer(SILENT, iir=0.5), np.sin)


def test_a_slow_barometer_has_the_noise_of_its_own_samples():
    slow = Barometer(BMP085.noise, rate_hz=12.5)
    pressure = pressure_of(slow, np.zeros_like)
    new = np.isfinite(pressure)
    assert np.array_equal(np.flatnonzero(new), np.arange(0, 3000, 4))
    noise = BMP085.noise.simulate(np.arange(750) / 12.5, np.random.default_rng(0))
    assert pressure[new] == pytest.approx(np.round(altitude_pressure(noise)))


def test_a_barometers_offset_is_constant_in_a_recording_and_spreads_over_units():
    unit = Barometer(SILENT, quantum=0, offset_sd=100.0)
    offsets = np.array(
        [pressure_of(unit, np.zeros_like, seed) - altitude_pressure(0.0) for seed in range(300)]
    )
    assert np.ptp(offsets, axis=1).max() == 0
    # sd of 300 normal numbers: 4.1 %; 3.5 sigma
    assert offsets[:, 0].std() == pytest.approx(100, rel=0.15)


def test_pressure_is_quantised_and_noisy_as_the_preset_says():
    recording = simulate("rest", duration=600, seed=2, imu=None)
    assert np.all(recording.pressure == np.round(recording.pressure))
    white = np.std(np.diff(pressure_altitude(recording.pressure))) / np.sqrt(2)
    expected = np.hypot(BMP085.noise.white_sd, 0.0843 / np.sqrt(12))
    # first differences also hold the GM's: 2 sigma_c^2 (1 - e^(-dt/tau)); 1/sqrt(2 n) = 0.4 %
    assert white == pytest.approx(np.hypot(expected, 0.27 * np.sqrt(0.02 / 0.75)), rel=0.02)
