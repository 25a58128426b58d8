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


def plainly(dt, f, w, alignment):
    """What the module says, in vectors; all of its numbers once more."""
    accel_sd = min(alignment.accel_sd, 0.2) if np.isfinite(alignment.accel_sd) else 0.04
    gyro_sd = min(alignment.gyro_sd, 0.05) if np.isfinite(alignment.gyro_sd) else 0.003
    reference = force = last = alignment.gravity * np.array(alignment.up)
    turning, age, silence, square, found = np.zeros(3), 1.0, 0.0, accel_sd**2, []
    for step, f_k, w_k in zip(dt, f, w - alignment.gyro_bias, strict=True):
        age, silence = age + step, silence + step
        if np.linalg.norm(f_k) < 1000 and np.linalg.norm(w_k + alignment.gyro_bias) < 100:
            share, part = step / (0.1 + step), step / min(age, 2.0) if age else 0.0
            force, turning = force + share * (f_k - force), turning + share * (w_k - turning)
            spread = np.sqrt(share / (2 - share) + part)
            disturbed = (
                np.linalg.norm(f_k - reference) > max(1.0, 6 * accel_sd)
                or np.linalg.norm(w_k) > max(0.3, 6 * gyro_sd)
                or np.linalg.norm(force - reference) > max(0.3, 4 * spread * accel_sd)
                or np.linalg.norm(turning) > max(0.15, 4 * spread * gyro_sd)
                or abs(np.linalg.norm(reference) - alignment.gravity) > 0.3
            )
            reference = reference + part * (f_k - reference)
            if disturbed or silence > 0.5:
                reference, force, turning, age = f_k, f_k, w_k, 0.0
            if age >= 0.5:
                square += silence / 10 * (np.sum((f_k - last) ** 2) / 6 - square)
            last, silence = f_k, 0.0
        shakes = square > (1.2 * accel_sd) ** 2
        found.append((age >= 0.5 and silence <= 0.5, np.sqrt(square) if shakes else np.nan))
    return np.array(found).T


def an_unquiet_life(seed, n=1500):
    """Noise with knocks, soft starts and wild samples about the limits, at intervals exact in binary."""
    rng = np.random.default_rng(seed)
    known = Alignment(
        up=(0.6, 0.0, 0.8),
        gyro_bias=(0.05, -0.1, 0.08),
        gravity=rng.choice([0.9, 9.7, 9.9]),
        accel_sd=rng.choice([0.03, 0.15, 0.5, np.nan]),
        gyro_sd=rng.choice([0.003, 0.05, 0.5, np.nan]),
    )
    dt = rng.choice([0.0, 1, 2, 4, 8, 40], n, p=[0.05, 0.5, 0.3, 0.1, 0.045, 0.005]) / 64
    scatter = np.repeat(rng.choice([0.2, 1.0, 2.0], n // 100), 100)[:, None]
    f = known.gravity * np.array(known.up) + 0.1 * scatter * rng.normal(size=(n, 3))
    w = np.array(known.gyro_bias) + 0.02 * scatter * rng.normal(size=(n, 3))

    def direction():
        vector = rng.normal(size=3)
        return vector / np.linalg.norm(vector)

    for start in range(100, n - 60, 60):  # each of these needs its half second, and some more, to be noticed
        which, count = rng.integers(5), rng.integers(1, 15)
        if which == 0:
            f[start] += rng.uniform(0.8, 1.6) * direction()
        elif which == 1:
            w[start] += rng.uniform(0.2, 0.5) * direction()
        elif which == 2:
            f[start : start + 2 * count] += rng.uniform(0.2, 0.8) * direction()
        elif which == 3:
            w[start : start + 2 * count] += rng.uniform(0.1, 0.3) * direction()
        else:
            f[start : start + 20] = np.nan
        f[start + 30] = rng.choice([500.0, 999.5, 1000.5, np.nan]) * direction()
    w[70::240] = np.outer(rng.choice([50.0, 99.5, 100.5], len(w[70::240])), direction())
    return dt, f, w, known


@pytest.mark.parametrize("seed", range(12))
def test_it_feels_what_its_definition_says(seed):
    dt, f, w, known = an_unquiet_life(seed)
    t = np.cumsum(dt)
    found = Stillness(known).run(t, f, w, dt[0])
    still, shaking = plainly(dt, f, w, known)
    np.testing.assert_array_equal(found.still, still)
    np.testing.assert_allclose(found.shaking, shaking, rtol=1e-9)  # a thousand roundings


@pytest.mark.parametrize("seed", range(12))
def test_small_steps_are_measured_from_the_mean_of_the_last_two_seconds(seed):
    """Or of a shorter period, to which the alignment has added a second; none of the steps is a knock."""
    rng = np.random.default_rng(seed)
    sideways = np.repeat(rng.uniform(-0.4, 0.4, 24), rng.integers(10, 120, 24))
    f, dt = upright(sideways) + along(0, sideways), np.full(len(sideways), 1 / 64)
    found = Stillness(Alignment(gyro_sd=0.003)).run(np.cumsum(dt), f, np.zeros_like(f), dt[0])
    np.testing.assert_array_equal(found.still, plainly(dt, f, np.zeros_like(f), Alignment(gyro_sd=0.003))[0])
    assert 0.1 < found.still.mean() < 0.99


def test_among_unquiet_lives_there_is_all_to_feel():
    lives = [Stillness(known).run(np.cumsum(dt), f, w) for dt, f, w, known in map(an_unquiet_life, range(12))]
    assert 0.2 < np.mean([life.still for life in lives]) < 0.8
    assert 0.2 < np.mean([np.isfinite(life.shaking) for life in lives]) < 0.8


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
        still = np.hstack([f.still for f in found])
        assert still.dtype == bool
        assert np.array_equal(still, whole.still)
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
