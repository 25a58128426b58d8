"""Rest against motion, outliers against jumps: what the bank decides, and that it can be undone."""

from dataclasses import replace

import numpy as np
import pytest

from baroarma import NoiseModel
from baroarma.atmosphere import altitude_pressure
from baroarma.estimators.base import HeightRun
from baroarma.estimators.height.bank import AT_REST, REJECTED, RESTED, SURE, Bank
from baroarma.estimators.height.coloured_kalman import BIAS_SD, CRUISE_SD, ColouredKalman
from baroarma.estimators.height.linear import steps_of
from baroarma.simulation import BMP085, simulate
from baroarma.testing import height_samples
from baroarma.tracker import Tracker

NOISE = BMP085.noise
WAYS = {
    "plain": {},
    "lag": {"barometer_lag": 0.2},
    "level": {"level_prior_sd": 0.3},
    "floors": {"floors": (-0.1, 3.0, 6.0)},
    "all moving": {"confirm_rest": False},
    "no gate": {"gate": np.inf},
    "everything": {"barometer_lag": 0.1, "level_prior_sd": 0.5, "floors": (0.0, 2.0)},
}


def make(**settings):
    return ColouredKalman(noise=NOISE, dt=0.02, **settings)


def awkward(seed=0, n=400):
    """Uneven, gappy samples with claims of rest, turns, spikes and a step of the pressure."""
    rng = np.random.default_rng(seed)
    samples = {k: v for k, v in height_samples(seed, n).items() if k not in ("accel", "gyro")}
    samples["at_rest"] = (np.arange(n) // 60) % 3 > 0
    samples["acceleration"] *= np.where(samples["at_rest"], 0.05, 1.0)
    samples["altitude"][::37] += 20.0
    samples["altitude"][3 * n // 4 :] += 8.0
    angle = np.cumsum(np.where(samples["at_rest"], 0.0, 0.03))
    samples["up"] = np.stack([np.sin(angle), rng.normal(scale=0.01, size=n), np.cos(angle)], axis=1)
    samples["up"] /= np.linalg.norm(samples["up"], axis=1, keepdims=True)
    return samples


def rows_of(samples, start, stop):
    return {name: values[start:stop] for name, values in samples.items()}


def steps(kf, samples, start):
    """Rows from `start` on, one by one."""
    dt = np.diff(samples["t"], prepend=samples["t"][0])
    rest = [name for name in samples if name != "t"]
    return [kf.step(dt=dt[k], **{name: samples[name][k] for name in rest}) for k in range(start, len(dt))]


@pytest.mark.parametrize("settings", WAYS.values(), ids=WAYS)
def test_one_by_one_it_gives_the_same_numbers_as_all_at_once(settings):
    samples = awkward()
    whole = make(**settings).run(**samples)
    # the order of summation, and F at one interval or at many
    np.testing.assert_allclose(np.transpose(steps(make(**settings), samples, 0)), whole, rtol=0, atol=1e-9)


@pytest.mark.parametrize("split", [1, 59, 60, 61, 100, 170, 181, 300, 340, 399])
def test_it_goes_on_by_steps_where_a_run_ended_at_any_row(split):
    samples, settings = awkward(), WAYS["everything"]
    whole, kf = make(**settings).run(**samples), make(**settings)
    first = kf.run(**rows_of(samples, 0, split))
    together = np.hstack([first, np.transpose(steps(kf, samples, split))])
    np.testing.assert_allclose(together, whole, rtol=0, atol=1e-9)


@pytest.mark.parametrize("split", [61, 100, 170, 181, 185, 240, 300, 305, 340])
def test_a_bank_takes_rows_in_any_portions(split):
    def run(*parts):
        kf = make(floors=(-0.1, 3.0))
        samples = awkward()
        rows = kf._rows(
            steps_of(samples["t"]),
            *(samples[name] for name in ("altitude", "acceleration", "acceleration_sd", "at_rest", "up")),
        )
        bank, x, P = Bank(kf._bank.rules, kf.dim_x), kf.x[:, 0].copy(), kf.P.copy()
        found = []
        for start, stop in parts:
            part = rows._replace(
                **{
                    name: values[start:stop]
                    for name, values in rows._asdict().items()
                    if name not in ("F", "B", "Q", "ends", "columns", "H", "R", "seen", "offset")
                }
            )
            out = np.empty((4, stop - start))
            found.append((bank.run(part, x, P, out), out))
        return found

    ((whole, out),) = run((0, 400))
    parts = run((0, split), (split, 400))
    np.testing.assert_array_equal(np.hstack([o for _, o in parts]), out)
    for name in ("odds", "jump", "floor", "innovation", "innovation_sd"):
        together = np.concatenate([getattr(decisions, name) for decisions, _ in parts])
        np.testing.assert_array_equal(together, getattr(whole, name))
    bits = np.concatenate([decisions.bits for decisions, _ in parts])
    assert np.array_equal(bits & REJECTED, whole.bits & REJECTED)
    # of the first portion's last rows nothing is settled yet: what comes later may extend or undo a rest
    assert np.array_equal(bits[split:] & AT_REST, whole.bits[split:] & AT_REST)


def test_without_rests_and_gate_it_is_filterpys_own_predict_and_update():
    rng = np.random.default_rng(1)
    z, a = NOISE.simulate(300, rng) + 40.0 * (rng.random(300) < 0.02), rng.normal(scale=0.3, size=300)
    settings = {"confirm_rest": False, "gate": np.inf, "unresolved": 0.0, "acceleration_sd": 0.03}
    run = make(**settings).run(np.arange(300) / 50, z, a, at_rest=np.ones(300, bool))
    kf, loop = make(**settings), []
    for k in range(300):
        if k:
            kf.predict(u=(a[k - 1] + a[k]) / 2)
        kf.update(z[k])
        loop.append([*kf.x[:2, 0], *np.sqrt(np.diag(kf.P)[:2])])
    # 0.02 against differences of the clock: the last digit, times P of 1e4 m² at the start
    np.testing.assert_allclose(run, np.transpose(loop), rtol=0, atol=1e-9)


def track(recording, **settings):
    """Behind the true attitude, so that height alone is the question."""
    return Tracker(noise=NOISE, attitude="reference", height_settings=settings).run(recording)


def raised(recording, by):
    return replace(recording, pressure=altitude_pressure(recording.height() + by))


@pytest.fixture(scope="module")
def logs():
    return {motion: simulate(motion, duration=60, seed=5) for motion in ("rest", "squat")}


@pytest.fixture(scope="module")
def tracks(logs):
    return {motion: track(log) for motion, log in logs.items()}


@pytest.mark.parametrize("seed", range(4))
def test_a_minute_of_rest_is_held_within_millimetres(seed):
    found = track(simulate("rest", duration=65, seed=seed))
    # velocities of 1 mm/s that the rest allows, correlated over half a second: 1 mm * sqrt(0.5 * 60) = 5 mm
    assert np.abs(found.height).max() < 5e-3
    assert np.sqrt(np.mean(found.velocity**2)) < 6e-3  # what was asked for


@pytest.mark.parametrize("speed", [0.1, 0.2, 0.5, 1.0])
def test_a_lift_at_constant_speed_is_not_mistaken_for_a_rest(speed):
    squares = []
    for seed in range(3):
        log = simulate("lift", duration=180, speed=speed, seed=seed)
        found = track(log)
        riding = np.abs(log.reference_velocity - speed) < 1e-6
        assert np.abs(found.velocity[riding] - speed).max() < speed / 2  # nowhere taken for 0
        off = [found.height - log.reference, found.velocity - log.reference_velocity]
        squares.append(np.mean(np.square(off), axis=1))
    height, velocity = np.sqrt(np.mean(squares, axis=0))
    assert height < 0.35  # what was asked for
    assert velocity < 0.05


def ride(speed, start=0.0, seed=0, duration=60.0):
    """A climb from 10 s on that begins within `start` seconds; the IMU claims rest throughout.

    With start 0 no accelerometer has noticed anything at all.
    """
    t, rng = np.arange(0, duration, 0.02), np.random.default_rng(seed)
    height = np.maximum(t - 10, 0) * speed
    acceleration = 0.025 * rng.normal(size=len(t))
    if start:
        u = np.clip((t - 10) / start, 0, 1)
        height = speed * (start * u**2 / 2 + np.maximum(t - 10 - start, 0))
        acceleration += np.where((u > 0) & (u < 1), speed / start, 0.0)
    samples = {"t": t, "altitude": height + NOISE.simulate(t, rng), "acceleration": acceleration}
    return height, {**samples, "at_rest": np.ones(len(t), bool)}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("speed", [0.2, 0.5, 1.0])
def test_a_rest_that_turns_out_wrong_is_undone(speed, seed):
    height, samples = ride(speed, start=4.0, seed=seed)  # too soft to be felt: at most 0.25 m/s²
    t, found = samples["t"], make().run(**samples)
    off = found.height - height
    assert np.abs(off[t < 10]).max() < 5e-3
    # the barometer's slope over W seconds is known to 1.2/W^1.5 m/s: 4 sds of 0.2 m/s after W = 8 s
    late = t > 14 + 2 * 8
    # integrated from shortly before the start on: 4 sds, which one of 9 runs in 2000 exceeds
    assert np.abs(off[late] / found.height_sd[late]).max() < 4
    assert found.velocity[late] == pytest.approx(
        speed, abs=0.1
    )  # 2.5 mg over half a minute, 0.02 m/s, and bias


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("speed", [0.2, 0.5, 1.0])
def test_even_a_start_that_nothing_felt_is_found_by_the_barometer(speed, seed):
    height, samples = ride(speed, seed=seed)
    t, odds = samples["t"], make().decide(**samples).odds
    assert odds[t < 10].min() > 0
    # the barometer's slope over W seconds is known to 1.2/W^1.5 m/s: 4 sds of it after W = (4.8/speed)^(2/3),
    # and nine to one for a rest to be made up for
    turned = t[t > 10][np.argmax(odds[t > 10] < 0)] - 10
    assert 0 < turned < 2 * (4.8 / speed) ** (2 / 3)
    assert odds[-1] < 0
    found = make().run(**samples)
    # the height lost is what was climbed in that time
    assert np.abs(found.height - height).max() < 2 * (4.8 / speed) ** (2 / 3) * speed
    assert np.mean(found.velocity[t > 30]) == pytest.approx(speed, rel=0.5)


@pytest.mark.parametrize("seed", range(3))
def test_what_feels_nothing_and_climbs_nothing_stays_believed(seed):
    _, samples = ride(0.0, seed=seed, duration=300.0)
    # odds of nine to one at the start: a minute in ten may be doubted, and hardly is
    assert np.mean(make().decide(**samples).odds < 0) < 0.02
    assert np.abs(make().run(**samples).height).max() < 0.02  # 1 mm/s over half seconds: 12 mm in 300 s


def test_who_may_rest_or_ride_is_as_uncertain_as_both_together():
    # the bank's own prior: nine of ten rest, the others ride at 1 m/s (sd); the velocity is known to 0.5 m/s
    n, trials = 150, 400
    t, errors = 0.02 * np.arange(n), []
    for seed in range(trials):
        rng = np.random.default_rng(seed)
        v = 0.0 if rng.random() < 0.9 else rng.normal(scale=CRUISE_SD)
        kf = make(initial_velocity_sd=0.5, pressure_step=0.0)
        kf.x[1, 0] = v + rng.normal(scale=0.5)
        altitude = v * t + NOISE.simulate(n, rng)
        run = kf.run(t, altitude, rng.normal(scale=0.025, size=n), at_rest=np.ones(n, bool))
        errors.append(((run.velocity - v) / run.velocity_sd) ** 2)
    nees = np.mean(errors, axis=0)
    # few trials are wrong, and by ten sds: the mean of 400 has a standard error of about 0.4.  The believed
    # filter's own sds give 100 to 600.
    assert (nees[25:] > 0.3).all()
    assert (nees[25:] < 3.0).all()


def test_what_goes_on_after_a_doubtful_rest_may_have_been_either():
    # a ride whose velocity a fault has hidden is taken for a rest, until the IMU says that this is over
    t, v = 0.02 * np.arange(100), 0.5
    kf = make(initial_velocity_sd=0.5)
    run = kf.run(t, v * t, np.zeros(100), at_rest=t < 1.2)
    assert run.velocity[55] == pytest.approx(0.0, abs=0.01)
    # what is less than 100 to 1 is off by less than sqrt(100) of its sds; of the rest's own it would be 100
    off = np.abs(run.velocity - v) / run.velocity_sd
    assert off[61:].max() < 10.0


def test_the_odds_are_bounded_so_that_evidence_can_turn():
    for speed in (0.0, 1.0):
        odds = make().decide(**ride(speed)[1]).odds
        assert np.abs(odds).max() <= 10.0
        assert np.abs(odds[-1]) > 5.0


def test_a_rest_is_believed_while_the_odds_are_positive_but_a_refuted_one_only_at_100_to_1():
    too_early = 0
    for seed in range(4):
        _, samples = ride(0.0, seed=seed, duration=120.0)
        t = samples["t"]
        samples["altitude"] += np.where((t > 40) & (t < 60), 1.5, 0.0)  # a gust
        decisions = make(gate=np.inf).decide(**samples)
        refuted, expected = False, []
        for odds in decisions.odds:
            refuted = odds < 0 if abs(odds) > SURE else refuted
            expected.append(odds >= 0 and not refuted)
        np.testing.assert_array_equal(decisions.believed, expected)
        too_early += np.sum(decisions.odds[~decisions.believed] > 0)
    assert too_early > 0  # where the odds alone would say so


def test_what_is_believed_is_what_the_state_is_taken_from_row_by_row():
    _, samples = ride(0.5, seed=1)
    samples["at_rest"][:100] = False
    collected, kf = [], make()
    make(decided=collected.append).run(**samples)
    told = []
    for k, row in enumerate(zip(*samples.values(), strict=True)):
        kf.step(dt=0.02 if k else 0.0, **dict(zip(list(samples)[1:], row[1:], strict=True)))
        told.append(np.array_equal(kf.x[:, 0], kf._bank._filters.x[RESTED]) and row[-1])
    (decisions,) = collected
    np.testing.assert_array_equal(decisions.believed, told)
    assert {*decisions.believed[:500]} == {False, True}  # moving, then at rest


@pytest.mark.parametrize("motion", ["rest", "squat"])
def test_single_spikes_of_any_size_are_as_if_there_had_been_no_sample(motion, logs):
    log = logs[motion]
    at = np.arange(600, 2900, 230)
    spikes, pressure = np.zeros(len(log)), log.pressure.copy()
    spikes[at] = np.geomspace(5, 200, len(at)) * (-1.0) ** np.arange(len(at))
    pressure[at] = np.nan
    spiked, missing = track(raised(log, spikes)), track(replace(log, pressure=pressure))
    # heights to pressures and back cost 1e-10 m
    np.testing.assert_allclose(spiked.height, missing.height, rtol=0, atol=1e-9)
    np.testing.assert_allclose(spiked.velocity, missing.velocity, rtol=0, atol=1e-9)


@pytest.mark.parametrize("size", [5.0, -20.0, 200.0])
@pytest.mark.parametrize("motion", ["rest", "squat"])
def test_a_slammed_door_of_six_tenths_of_a_second_is_ignored(motion, size, logs, tracks):
    log = logs[motion]
    found = track(raised(log, np.where((log.t >= 30) & (log.t < 30.6), size, 0.0)))
    # without a barometer for two seconds the accelerometer alone: 2.5 mg, a few times 2^1.5 * 0.02/sqrt(50)
    assert np.abs(found.height - tracks[motion].height).max() < 0.02
    assert np.abs(found.velocity - tracks[motion].velocity).max() < 0.02


@pytest.mark.parametrize("size", [2.0, -4.0])
@pytest.mark.parametrize("motion", ["rest", "squat"])
def test_a_step_of_a_few_metres_that_nothing_felt_is_the_pressures(motion, size, logs, tracks):
    log = logs[motion]
    stepped = raised(log, np.where(log.t >= 30, size, 0.0))
    off = track(stepped).height - tracks[motion].height
    # two seconds without a barometer, and then an offset learnt anew: 0.27 m of correlated noise at most,
    # of which the height, integrated meanwhile, takes a small part
    assert np.abs(off).max() < 0.1
    followed = track(stepped, pressure_step=0.0).height - tracks[motion].height
    assert np.abs(followed[log.t > 33] - size).max() < 4 * 0.27


def test_a_growing_difference_is_the_heights_however_small(logs):
    """A wrong velocity, as of a lost tilt, is no step of the pressure: the barometer is followed."""
    log = logs["rest"]
    climbing = np.clip(log.t - 30, 0, 20) * 0.5
    found = track(raised(log, climbing))
    assert abs(found.height[log.t > 52][0] - 10) < 1


@pytest.mark.parametrize("size", [10.0, 100.0, -10.0])
@pytest.mark.parametrize("motion", ["rest", "squat"])
def test_a_real_step_is_followed_within_three_seconds(motion, size, logs, tracks):
    log = logs[motion]
    found, t = track(raised(log, np.where(log.t >= 30, size, 0.0))), log.t
    off = found.height - tracks[motion].height - size
    # after 2 s it is believed; then the barometer's correlated noise, averaged over a time constant or two,
    # is 0.27 m, and the filter says so
    assert np.abs(off[t > 33] / found.height_sd[t > 33]).max() < 4
    assert np.abs(off[t > 33]).max() < 4 * 0.27
    change = found.velocity - tracks[motion].velocity
    # a height known to 0.3 m over 3 s is a velocity known to 0.3 m/s at best, of whatever size the step was
    assert np.abs(change[t > 33]).max() < 3 * 0.3
    # and the barometer's slope over W seconds to 1.2/W^1.5 m/s: 2 sds of 7 s
    assert np.abs(change[t > 40]).max() < 2 * 1.2 / 7**1.5


@pytest.mark.parametrize("motion", ["rest", "squat"])
def test_a_minute_without_barometer_costs_little_between_rests(motion):
    log = simulate(motion, duration=120, seed=6)
    lost = replace(log, pressure=np.where((log.t > 30) & (log.t < 90), np.nan, log.pressure))
    found = track(lost)
    off = found.height - log.reference
    # eight squats of 4 s, each integrated between rests: 0.025 m/s² sqrt(4 s/50) 4 s = 0.03 m, sqrt(8) times
    assert np.abs(off).max() < 4 * 0.03 * np.sqrt(8)
    assert np.abs(found.velocity - log.reference_velocity).max() < 0.2
    assert np.abs(off[-1] / found.height_sd[-1]) < 4


def test_without_barometer_and_rest_the_height_gets_lost_and_says_so():
    t = np.arange(3000) / 50
    rng, kf = np.random.default_rng(7), make(confirm_rest=False)
    bias, a = 0.02, rng.normal(scale=0.025, size=len(t))
    found = kf.run(t, np.where(t < 2, NOISE.simulate(t, rng), np.nan), bias + a)
    assert found.height_sd[-1] > 10  # 0.02 m/s² over a minute are 36 m
    assert abs(found.height[-1]) < 4 * found.height_sd[-1]


@pytest.mark.parametrize("frequency_hz", [0.25, 0.5, 1.25])
def test_who_knows_that_the_height_wanders_about_a_level_gains_what_method_b_hides(frequency_hz):
    squares, plain = [], []
    for seed in range(3):
        log = simulate("circle", duration=180, frequency_hz=frequency_hz, seed=seed)
        known, unknown = track(log, level_prior_sd=0.2), track(log)
        off = [known.height - log.reference, known.velocity - log.reference_velocity]
        squares.append(np.mean(np.square(off), axis=1))
        plain.append(np.mean((unknown.height - log.reference) ** 2))
    height, velocity = np.sqrt(np.mean(squares, axis=0))
    assert height < 0.12  # what was asked for
    assert velocity < 0.06
    assert height < np.sqrt(np.mean(plain))


POOR = {"acceleration_sd": 0.25}


def climb(seed=0, rise=3.2):
    """Ten seconds of rest, a storey in 8 s, and rest again, with an accelerometer of 25 mg."""
    t = np.arange(0, 60, 0.02)
    u = np.clip((t - 10) / 8, 0, 1)
    height = rise * u**3 * (10 - 15 * u + 6 * u**2)
    acceleration = rise / 64 * (60 * u - 180 * u**2 + 120 * u**3)
    rng = np.random.default_rng(seed)
    return height, {
        "t": t,
        "altitude": height + NOISE.simulate(t, rng),
        "acceleration": acceleration + rng.normal(scale=0.25, size=len(t)),
        "at_rest": (t < 10) | (t > 18.5),
    }


@pytest.mark.parametrize("seed", range(3))
def test_a_known_floor_is_taken_when_it_is_sure(seed):
    height, samples = climb(seed)
    floors = (-3.2, 0.0, 3.2, 6.4)
    decisions = make(floors=floors, **POOR).decide(**samples)
    assert set(decisions.floor[np.isfinite(decisions.floor)]) == {0.0, 3.2}
    known, unknown = (make(floors=known, **POOR).run(**samples) for known in (floors, ()))
    # floors are known to 5 cm, and rests hold what they begin with
    assert np.abs(known.height[-1] - height[-1]) < 4 * 0.05
    assert known.height_sd[-1] < 0.06 < unknown.height_sd[-1]


@pytest.mark.parametrize("rise", [3.2, 3.15, 3.25])
def test_between_floors_a_hand_apart_none_is_ever_taken(rise):
    _, samples = climb(1, rise)
    between = make(floors=(3.15, 3.25), **POOR).decide(**samples)
    assert np.isnan(between.floor).all()
    known, unknown = (make(floors=floors, **POOR).run(**samples) for floors in ((3.15, 3.25), ()))
    np.testing.assert_array_equal(known.height, unknown.height)


def test_far_from_every_floor_none_is_taken():
    _, samples = climb(2)
    assert np.isnan(make(floors=(-20.0, 1.6, 20.0), **POOR).decide(**samples).floor).all()


def test_a_turn_brings_bias_to_light_and_a_rest_learns_it_again():
    t = np.arange(0, 40, 0.02)
    angle = np.clip((t - 10) / 2, 0, 1) * np.pi / 3
    up = np.stack([np.sin(angle), 0 * t, np.cos(angle)], axis=1)
    still, kf = (t < 10) | (t > 12), make()
    kf.reset()
    bias_sd = np.array(
        [
            (
                kf.step(dt=0.02, altitude=0.0, acceleration=0.0, at_rest=still[k], up=up[k]),
                np.sqrt(kf.P[2, 2]),
            )[1]
            for k in range(len(t))
        ]
    )
    before, turned, after = (bias_sd[np.searchsorted(t, when)] for when in (9.9, 12.0, 39.0))
    # by 60 degrees: the bias differs with the variance 2 (1 - cos 60°) = 1 of its own
    assert turned**2 - before**2 == pytest.approx(BIAS_SD**2, rel=0.05)  # 2 s of its walk, and of altitudes
    assert after < 0.1 * turned


def test_turning_to_and_fro_counts_once():
    t = np.arange(0, 30, 0.02)
    angle = np.where(t > 5, np.pi / 6 * (1 - np.cos(2 * np.pi * (t - 5) / 5)), 0.0)
    up = np.stack([np.sin(angle), 0 * t, np.cos(angle)], axis=1)
    kf = make()
    turned = kf._rows(steps_of(t), 0 * t, 0 * t, None, t < 5, up).turned
    # 60 degrees away and back, five times: 2 (1 - cos 60°) once
    assert turned.sum() == pytest.approx(BIAS_SD**2, rel=1e-3)  # the greatest angle falls between samples


@pytest.mark.parametrize("settings", WAYS.values(), ids=WAYS)
def test_covariances_stay_symmetric_and_positive_semidefinite_in_every_filter(settings):
    samples, kf = awkward(3), make(**settings)
    dt = np.diff(samples["t"], prepend=samples["t"][0])
    for k in range(len(dt)):
        kf.step(dt=dt[k], **{name: v[k] for name, v in samples.items() if name != "t"})
        for P in (kf.P, *kf._bank._filters.P):
            np.testing.assert_allclose(P, P.T, rtol=1e-12, atol=1e-15)  # rounding of v B_i B_j
            # the offset's prior of 1e4 m² leaves 1e-12 of rounding
            assert np.linalg.eigvalsh(P)[0] > -1e-10


@pytest.mark.parametrize(
    "noise",
    [
        NoiseModel(0, 0, 0, rate_hz=50),
        NoiseModel(0.27, 0.75, 0, rate_hz=50),
        NoiseModel(0, 0, 0.46, rate_hz=50),
    ],
    ids=["none", "correlated", "white"],
)
@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"barometer_lag": 0.2},
        {"level_prior_sd": 0.3},
        {"floors": (0.0, 3.0), "floor_sd": 0.0},
        {"offset_sd": 0.0, "bias_sd": 0.0, "bias_walk": 0.0, "acceleration_sd": 0.0},
        {"rest_sd": 0.0, "initial_velocity_sd": 0.0},
    ],
    ids=["plain", "lag", "level", "floors", "certain", "exact rest"],
)
def test_neither_exact_sensors_nor_two_samples_at_once_raise_or_give_nan(noise, settings):
    t = np.repeat(np.arange(60) / 50, 2)
    samples = {"t": t, "altitude": 0 * t, "acceleration": 0 * t, "at_rest": t > 0.3}
    for method in ("run", "smooth"):
        found = getattr(ColouredKalman(noise=noise, dt=0.02, **settings), method)(**samples)
        assert all(np.isfinite(column).all() for column in found)
        np.testing.assert_allclose(found.height, 0.0, atol=1e-12)
    one_by_one = steps(ColouredKalman(noise=noise, dt=0.02, **settings), samples, 0)
    assert np.isfinite(one_by_one).all()


def test_a_claim_of_rest_is_ignored_when_told_so():
    samples = awkward(4)
    claimed = make(confirm_rest=False).run(**{**samples, "up": None})
    np.testing.assert_array_equal(
        claimed, make(confirm_rest=False).run(**{**samples, "up": None, "at_rest": None})
    )
    assert isinstance(claimed, HeightRun)


def test_nothing_is_remembered_after_a_reset():
    samples, kf = awkward(5), make(**WAYS["everything"])
    first = kf.run(**samples)
    evidence = kf.evidence
    kf.reset()
    assert kf.evidence == 0.0
    np.testing.assert_array_equal(kf.run(**samples), first)
    assert kf.evidence == evidence
