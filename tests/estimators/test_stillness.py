"""What an IMU feels, and what it does not."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.estimators.attitude.alignment import align
from baroarma.estimators.base import Alignment
from baroarma.estimators.stillness import GRAVITY_ERROR, LONGEST_SILENCE, SETTLED, Stillness
from baroarma.simulation import DEVICES

WIMU = DEVICES["simple"].imu
BIAS = (0.01, -0.02, 0.015)
KNOWN = Alignment(gyro_bias=BIAS, accel_sd=WIMU.accel_sd, gyro_sd=WIMU.gyro_sd)


def feel(force, rate=None, *, duration=10.0, noise=1.0, seed=0, rate_hz=50, alignment=KNOWN):
    """Run over samples of force(t) and rate(t), functions that return (n, 3); noise times the WIMU's."""
    t, rng = np.arange(round(duration * rate_hz)) / rate_hz, np.random.default_rng(seed)
    accel = force(t) + noise * WIMU.accel_sd * rng.normal(size=(len(t), 3))
    gyro = np.array(BIAS) + WIMU.gyro_sd * rng.normal(size=(len(t), 3))
    gyro += 0.0 if rate is None else rate(t)
    return t, Stillness(alignment).run(t, accel, gyro)


def upright(t):
    return np.tile([0.0, 0.0, STANDARD_GRAVITY], (len(t), 1))


def along(axis, values):
    return np.outer(values, np.eye(3)[axis])


@pytest.mark.parametrize("split", [1, 30, 77, 199])
def test_one_sample_at_a_time_or_in_two_runs_it_feels_the_same(split):
    rng = np.random.default_rng(1)
    dt = rng.uniform(0.0, 0.04, 400)
    dt[:3], dt[150], dt[220] = 0.0, 0.7, 0.0  # samples at the same instant, and a silence
    t = np.cumsum(dt)
    accel, gyro = upright(t) + 0.03 * rng.normal(size=(400, 3)), 0.003 * rng.normal(size=(400, 3))
    accel[100] += 5.0
    accel[rng.random(400) < 0.1] = np.nan
    accel[300:340] = np.nan
    whole = Stillness(KNOWN).run(t, accel, gyro, dt[0])
    one, two = Stillness(KNOWN), Stillness(KNOWN)
    steps = [one.step(dt=dt[k], accel=accel[k], gyro=gyro[k]) for k in range(400)]
    parts = [two.run(t[:split], accel[:split], gyro[:split], dt[0])]
    parts.append(two.run(t[split:], accel[split:], gyro[split:], dt[split]))
    assert 100 < whole.still.sum() < 350  # it feels stillness, and its end
    for found in (steps, parts):
        assert np.array_equal(np.hstack([f.still for f in found]), whole.still)
        # intervals given, and differences of times, differ in the last digit
        shaking = np.hstack([f.shaking for f in found])
        np.testing.assert_allclose(shaking, whole.shaking, rtol=1e-9)


@pytest.mark.parametrize("rate_hz", [10, 50, 200])
def test_ten_minutes_on_a_table_are_still_at_any_rate(rate_hz):
    mounting = Rotation.random(rng=1)
    t, felt = feel(lambda t: mounting.apply(upright(t)), duration=600, rate_hz=rate_hz)
    # the smallest shift of a mean, 0.3 m/s², is 12 sds of a single sample here
    assert felt.still[t > SETTLED + 1e-9].all()
    assert np.isnan(felt.shaking).all()


@pytest.mark.parametrize(
    ("force", "rate"),
    [
        (lambda t: along(2, np.where(np.arange(len(t)) == 250, 2.0, 0.0)), None),  # a knock of one sample
        (lambda t: along(2, np.where((t >= 5) & (t < 5.4), 0.5, 0.0)), None),  # a start too soft for that
        (lambda t: along(0, np.where((t >= 5) & (t < 5.4), 0.5, 0.0)), None),  # sideways
        (None, lambda t: along(0, np.where(np.arange(len(t)) == 250, 0.6, 0.0))),  # a jerk of the hand
        (None, lambda t: along(2, np.where((t >= 5) & (t < 5.4), 0.25, 0.0))),  # a slow turn
    ],
    ids=["knock", "soft start", "sideways", "jerk", "turn"],
)
def test_what_is_felt_is_felt_within_a_fifth_of_a_second_and_settles(force, rate):
    t, felt = feel(lambda t: upright(t) + (0.0 if force is None else force(t)), rate)
    assert felt.still[(t > 0.6) & (t < 5)].all()
    # a short mean of 0.1 s has gone 86 % of the way after 0.2 s, more than half of which is a disturbance
    assert not felt.still[np.searchsorted(t, 5.2)]
    # a shift of 0.4 s ends 5.4 s, decays for ln(0.5/0.3) 0.1 s, shifts back; then half a second
    assert felt.still[t > 6.6].all()


def test_the_alignments_gyro_bias_is_no_turn_but_another_one_of_fifteen_degrees_a_second_is():
    turning = lambda t: along(1, np.full(len(t), 0.26))  # noqa: E731 -- one value of a parameter
    t, felt = feel(upright, turning)
    assert not felt.still[t > 0.2].any()  # once the short mean of 0.1 s has followed
    biased = Alignment(gyro_bias=(BIAS[0], BIAS[1] + 0.26, BIAS[2]), gyro_sd=WIMU.gyro_sd)
    assert feel(upright, turning, alignment=biased)[1].still[26:].all()


@pytest.mark.parametrize("force", [0.0, STANDARD_GRAVITY + 2 * GRAVITY_ERROR])
def test_neither_free_fall_nor_an_even_acceleration_is_still_however_long(force):
    t, felt = feel(lambda t: along(2, np.full(len(t), force)))
    assert not felt.still[t > 0.2].any()


def test_gravity_is_the_recordings_own():
    heavy = Alignment(gyro_bias=BIAS, gravity=10.2)
    assert feel(lambda t: upright(t) * 10.2 / STANDARD_GRAVITY, alignment=heavy)[1].still[26:].all()


def test_without_samples_nothing_is_known_after_half_a_second_and_half_a_second_after_they_return():
    t = np.arange(300) / 50
    accel, gyro = upright(t), np.tile(BIAS, (300, 1))
    gyro[(t > 2 - 1e-9) & (t < 4 - 1e-9)] = np.nan
    still = Stillness(KNOWN).run(t, accel, gyro).still
    last = t[np.searchsorted(t, 2 - 1e-9) - 1]
    assert still[(t > SETTLED + 1e-9) & (t < last + LONGEST_SILENCE - 1e-9)].all()
    assert not still[(t > last + LONGEST_SILENCE + 1e-9) & (t < 4 + SETTLED - 1e-9)].any()
    assert still[t > 4 + SETTLED + 1e-9].all()


def test_what_shakes_is_still_and_tells_how_much():
    t, felt = feel(upright, duration=60, noise=4.0, seed=2)
    # until the reference is a mean of many samples, the next ones may differ from it by 0.3 m/s²
    assert felt.still[t > 3].all()
    # from the mean of 3 x 50 squared differences a second over 10 s, of which neighbours share a sample:
    # 1500 x 2 of them at 2/3 of their worth, 1.8 % of the sd
    assert felt.shaking[t > 40] == pytest.approx(4 * WIMU.accel_sd, rel=4 * 0.018)


def test_shaking_ebbs_when_it_ends():
    t, felt = feel(
        lambda t: upright(t) + np.where(t < 30, 0.1, 0.0)[:, None] * (-1) ** np.arange(len(t))[:, None],
        duration=120,
    )
    assert np.isfinite(felt.shaking[(t > 20) & (t < 30)]).all()
    # e^-6 of its square, (0.1/0.025)² times the noise's, is left after six time constants
    assert np.isnan(felt.shaking[t > 90]).all()


def test_the_alignment_tells_the_noise_of_a_sample():
    rng = np.random.default_rng(3)
    t = np.arange(50) / 50
    start = align(t, upright(t) + 0.03 * rng.normal(size=(50, 3)), 0.002 * rng.normal(size=(50, 3)))
    # 147 degrees of freedom: 1/sqrt(2 x 147) = 6 % of the sd
    assert start.accel_sd == pytest.approx(0.03, rel=3 * 0.06)
    assert start.gyro_sd == pytest.approx(0.002, rel=3 * 0.06)
    few = align(t[:7], upright(t[:7]), np.zeros((7, 3)))
    assert np.isnan([few.accel_sd, few.gyro_sd]).all()


def test_without_a_noise_and_with_far_too_much_of_it_there_is_a_usual_one():
    for accel_sd, gyro_sd in ((float("nan"), float("nan")), (3.0, 1.0)):
        alignment = Alignment(gyro_bias=BIAS, accel_sd=accel_sd, gyro_sd=gyro_sd)
        t, felt = feel(lambda t: upright(t) + along(2, np.where(t > 5, 3.0, 0.0)), alignment=alignment)
        assert felt.still[(t > 0.6) & (t < 5)].all()
        # 3 m/s² more than gravity are felt even if the alignment was no rest
        assert not felt.still[t > 5.02].any()


def test_inputs_stay_untouched():
    accel, gyro = np.tile([0.0, 0.0, STANDARD_GRAVITY], (50, 1)), np.zeros((50, 3))
    accel.flags.writeable = gyro.flags.writeable = False
    Stillness(KNOWN).run(np.arange(50) / 50, accel, gyro)
    assert (accel[:, 2] == STANDARD_GRAVITY).all()
