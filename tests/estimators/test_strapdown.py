"""Bourke's method: exact with exact sensors, de-drifted with real ones."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.estimators import strapdown
from baroarma.estimators.strapdown import bourke_track, quasi_static
from baroarma.recording import Recording
from baroarma.simulation import Imu, simulate

PERFECT = Imu(0.0, 0.0, 0.0, 0.0)


def ending_at_rest(recording, seconds=5.0):
    """Append a rest: hold the last whole squat's end, where velocity and tilt are 0."""
    t, v = recording.t, recording.reference_velocity
    stop = np.flatnonzero((t > 8) & (np.abs(v) < 0.02) & (recording.reference > -0.005))[-1] + 1
    count, dt = round(seconds * 50), 0.02
    still = {"accel": recording.accel[:100].mean(axis=0), "gyro": recording.gyro[:100].mean(axis=0)}
    noise = {"accel": recording.accel[:100].std(axis=0), "gyro": recording.gyro[:100].std(axis=0)}
    rng = np.random.default_rng(0)
    tail = {k: still[k] + noise[k] * rng.normal(size=(count, 3)) for k in still}
    return replace(
        recording,
        t=np.concatenate([t[:stop], t[stop - 1] + dt * np.arange(1, count + 1)]),
        pressure=np.concatenate([recording.pressure[:stop], np.full(count, np.nan)]),
        reference=np.concatenate([recording.reference[:stop], np.zeros(count)]),
        reference_velocity=np.concatenate([v[:stop], np.zeros(count)]),
        reference_attitude=None,
        **{k: np.concatenate([getattr(recording, k)[:stop], tail[k]]) for k in tail},
    )


def least_jerk(u):
    """From 0 to 1 within 0 < u < 1, the fifth-order polynomial: share, speed, acceleration."""
    u = np.clip(u, 0, 1)
    share = u**3 * (10 - 15 * u + 6 * u**2)
    return share, 30 * u**2 * (1 - u) ** 2, 60 * u - 180 * u**2 + 120 * u**3


def test_exact_sensors_give_the_exact_motion():
    # rest, a rise of 1 m within 1 s while leaning by 0.4 rad, rest
    t = np.arange(0, 8, 0.005)
    share, speed, acceleration = least_jerk(t - 3)
    lean = Rotation.from_rotvec(np.outer(0.4 * share, (0, 1, 0)))
    recording = Recording(
        t=t,
        pressure=np.full(len(t), np.nan),
        accel=lean.inv().apply(np.outer(acceleration + 9.80665, (0, 0, 1))),
        gyro=np.outer(0.4 * speed, (0, 1, 0)) + np.array([0.02, -0.01, 0.03]),  # a bias that the rests tell
    )
    track = bourke_track(recording)
    # trapezoids: dt²/12 times the change of the jerk, 120 m/s³: 0.25 mm/s
    assert track.velocity == pytest.approx(speed, abs=5e-4)
    assert track.height == pytest.approx(share, abs=5e-4)
    assert not track.findings


def test_a_gentle_start_is_missed_by_no_more_than_the_stated_sd():
    recording = ending_at_rest(simulate("squat", duration=26, seed=1, imu=PERFECT))
    track = bourke_track(recording)
    assert np.all(np.abs(track.velocity - recording.reference_velocity) < 0.1)
    assert np.abs(track.height - recording.reference).max() < 2 * track.height_sd[-1]


@pytest.mark.parametrize("seed", range(4))
def test_real_sensors_stay_within_the_stated_sds(seed):
    recording = ending_at_rest(simulate("squat", duration=26, seed=seed))
    track = bourke_track(recording)
    velocity = np.sqrt(np.mean((track.velocity - recording.reference_velocity) ** 2))
    assert velocity < 0.1  # SG14 quotes 0.1 m/s
    assert np.abs(track.height - recording.reference).max() < 3 * track.height_sd[-1]
    assert track.velocity[-1] == 0


def test_missing_rows_are_bridged():
    recording = ending_at_rest(simulate("squat", duration=18, pause=0.0, seed=3))
    blank = (np.arange(len(recording)) % 10 == 4)[:, None]
    gappy = replace(recording, accel=np.where(blank, np.nan, recording.accel))
    # linear interpolation over 40 ms of a 4 s motion: (pi/2)² / 8 0.04² of 1 m/s², and some noise
    assert bourke_track(gappy).height == pytest.approx(bourke_track(recording).height, abs=0.02)


def test_turning_points_are_no_rests():
    recording = simulate("squat", duration=20, pause=0.0, seed=4)
    static = quasi_static(recording.t, recording.accel, recording.gyro)
    assert static[recording.t < 4.5].all()
    moving = recording.t > 8.5
    assert static[moving].any()  # quiet for a moment, with 0.7 m/s² all the while
    assert not (bourke_track(recording).velocity_sd[moving] < 0.1).any()


def test_what_is_missing_is_said():
    squat = simulate("squat", duration=20, pause=0.0, seed=5)
    assert [f.code for f in bourke_track(squat).findings] == ["no-rest"]
    assert "end" in bourke_track(squat).findings[0].message
    with pytest.raises(ValueError, match="squat has no quasi-static period"):
        bourke_track(squat.between(8, 20))
    with pytest.raises(ValueError, match="no complete IMU sample"):
        bourke_track(replace(squat, gyro=np.full((len(squat), 3), np.nan)))


def test_a_recording_that_starts_in_motion_is_carried_backwards():
    recording = ending_at_rest(simulate("squat", duration=18, seed=6, imu=PERFECT)).between(8, 99)
    track = bourke_track(recording)
    assert "start" in track.findings[0].message
    # without a rest before, the velocity comes from the end alone; still exact with exact sensors
    assert np.abs(track.velocity - recording.reference_velocity).max() < 0.04


def test_from_rest_to_rest_the_velocity_is_0_at_both_ends():
    """Whatever the noise: rows of rest have no velocity, all others between have one."""
    squat = ending_at_rest(simulate("squat", duration=26, seed=7), seconds=8.0)
    recording = replace(squat, t=squat.t + 100.0)  # the clock's zero is no matter
    track = bourke_track(recording)
    at_rest = track.velocity_sd < strapdown.VELOCITY_SD
    assert len(strapdown.periods(~at_rest)) == 2  # two squats, and the pause between them
    assert (track.velocity[at_rest] == 0).all()
    assert (track.velocity[~at_rest] != 0).all()
    assert (track.velocity_sd[at_rest] == 0.01).all()  # a tenth of what SG14 quotes for motion
    assert (track.velocity_sd[~at_rest] == 0.1).all()
    # the error of 0.1 m/s keeps its sign for 1 s: after T s in motion the height's variance is 0.1² 1 T
    moving = np.cumsum(np.diff(track.t, prepend=track.t[0]) * ~at_rest)
    assert track.height_sd == pytest.approx(np.hypot(1e-3, 0.1 * np.sqrt(moving)), rel=1e-9)
    assert (track.preset, track.name) == ("bourke08", squat.name)


def two_rises(lean, *, until=14.0):
    """Rest, and two rises of 1 m within 1 s, swinging sideways by 0.2 m, leaning by `lean` rad each time."""
    t = np.arange(0, until, 0.005)
    one, two = least_jerk(t - 4), least_jerk(t - 9)
    share, speed, acceleration = (a + b for a, b in zip(one, two, strict=True))
    force = np.stack([0.2 * acceleration, 0 * t, acceleration + STANDARD_GRAVITY], axis=1)
    tilt = Rotation.from_rotvec(np.outer(lean * share, (0, 1, 0)))
    gyro = np.outer(lean * speed, (0, 1, 0))
    recording = Recording(t=t, pressure=np.full(len(t), np.nan), accel=tilt.inv().apply(force), gyro=gyro)
    return recording, share, speed, acceleration


def test_each_rest_has_its_own_tilt():
    recording, share, speed, acceleration = two_rises(0.3)
    track = bourke_track(recording)
    # trapezoids: dt²/12 times the change of the jerk, 120 m/s³, is 0.25 mm/s; of the angle, 0.3 rad, a third
    assert track.velocity == pytest.approx(speed, abs=5e-4)
    assert track.height == pytest.approx(share, abs=1e-3)
    assert track.acceleration == pytest.approx(acceleration, abs=1e-2)


def test_the_vertical_is_the_mean_of_the_whole_rest():
    recording, _, _, acceleration = two_rises(0.0)
    shake = np.where(np.arange(len(recording)) % 2 == 0, 0.1, -0.1)
    shaken = replace(recording, accel=recording.accel + np.outer(shake, (1, 0, 0)))
    # a single sample is tilted by 0.1/9.8 rad, which takes 1 % of the 1.2 m/s² sideways for vertical;
    # of the mean of 100 or more a hundredth of that at most is left, and 0.5 mm/s² of a too long gravity
    assert bourke_track(shaken).acceleration == pytest.approx(acceleration, abs=2e-3)


def test_the_gyro_bias_comes_from_the_rests():
    recording, _, _, acceleration = two_rises(0.3, until=8.0)
    biased = replace(recording, gyro=recording.gyro + np.array([0.02, -0.05, 0.03]))
    for start, stop in ((0, 4.7), (4.3, 8)):  # without a rest at the end, or at the start, a bias shows
        part = bourke_track(biased.between(start, stop))
        rows = (recording.t >= start) & (recording.t < stop)
        assert part.acceleration == pytest.approx(acceleration[rows], abs=1e-2)


@pytest.mark.parametrize(
    ("force", "rate", "quiet"),
    [(0.13, 0.0, True), (0.17, 0.0, False), (0.0, 0.09, True), (0.0, 0.11, False)],
)
def test_quiet_is_less_than_three_twentieths_of_a_metre_a_second_squared_and_a_tenth_of_a_radian(
    force, rate, quiet
):
    """An even number of alternating samples around 0 has their size for its sd; 51 have it but for 1/51²."""
    t, sign = np.arange(400) / 100, (-1.0) ** np.arange(400)
    accel = np.outer(STANDARD_GRAVITY + force * sign, (0, 0, 1))
    gyro = np.outer(rate * sign, (1, 0, 0)) + np.array([0.2, -0.3, 0.1])  # a bias that the median tells
    assert (quasi_static(t, accel, gyro) == quiet)[25:-25].all()


@pytest.mark.parametrize(("quiet", "rests"), [(8, False), (9, True)])
def test_the_longest_rest_lasts_half_a_second(quiet, rests):
    """At 8 Hz the window has 5 samples: from first to last, n quiet ones are quasi-static for (n - 5)/8 s."""
    t = np.arange(60) / 8
    shake = 3.0 * (-1.0) ** np.arange(60)
    shake[20 : 20 + quiet] = 0.0
    accel = np.outer(STANDARD_GRAVITY + shake, (0, 0, 1))
    assert strapdown._rests(t, accel, np.zeros((60, 3)))[0].any() == rests


def test_what_never_rests_is_refused():
    t = np.arange(100) / 50
    accel = np.outer(STANDARD_GRAVITY + 3.0 * (-1.0) ** np.arange(100), (0, 0, 1))
    shaken = Recording(t=t, pressure=np.full(100, np.nan), accel=accel, gyro=np.zeros((100, 3)))
    with pytest.raises(ValueError, match=r"^the recording has no quasi-static period"):
        bourke_track(shaken)


def test_a_rest_of_less_than_a_tenth_of_a_second_is_none():
    t = 5.0 + np.arange(20) / 25
    static = np.zeros(20, np.bool_)
    static[2:5] = static[8:12] = True  # 80 ms and 120 ms from the first row to the last
    assert strapdown.periods(strapdown._long_enough(t, static)) == [(8, 12)]


def test_the_window_is_half_a_second_and_never_less_than_three_samples():
    x = np.random.default_rng(8).normal(size=50)
    for rate_hz, half in ((100, 25), (20, 5), (1, 1)):
        assert strapdown._half_window(np.arange(50) / rate_hz) == half
        means = [x[max(k - half, 0) : k + half + 1].mean() for k in range(50)]
        np.testing.assert_allclose(strapdown._moving_mean(x, half), means, atol=1e-14)  # sums of 50 numbers


def a_turning_device():
    """Uneven times, rates of some rad/s, and two verticals that do not fit each other."""
    rng = np.random.default_rng(9)
    t = 50 + np.cumsum(rng.uniform(0.005, 0.015, 100))
    gyro, verticals = rng.normal(size=(100, 3)), rng.normal(size=(2, 3))
    return t, gyro, verticals / np.linalg.norm(verticals, axis=1)[:, None]


def test_the_vertical_turns_against_the_gyro():
    t, gyro, (before, after) = a_turning_device()
    turns = 0.5 * (gyro[1:] + gyro[:-1]) * np.diff(t)[:, None]
    forwards, backwards = [before], [after]
    for turn in turns:
        forwards.append(Rotation.from_rotvec(-turn).apply(forwards[-1]))
    for turn in turns[::-1]:
        backwards.append(Rotation.from_rotvec(turn).apply(backwards[-1]))
    # a hundred rotations in double precision
    np.testing.assert_allclose(strapdown._carry(t, gyro, before, None), forwards, atol=1e-13)
    np.testing.assert_allclose(strapdown._carry(t, gyro, None, after), backwards[::-1], atol=1e-13)


def test_what_the_gyro_misses_at_the_next_rest_is_spread_evenly_over_time():
    t, gyro, (before, after) = a_turning_device()
    carried, alone = strapdown._carry(t, gyro, before, after), strapdown._carry(t, gyro, before, None)
    np.testing.assert_allclose(carried[[0, -1]], [before, after], atol=1e-13)
    whole, _ = Rotation.align_vectors(after[None], alone[-1:])
    shares = (t - t[0]) / (t[-1] - t[0])
    spread = [
        Rotation.from_rotvec(s * whole.as_rotvec()).apply(v) for s, v in zip(shares, alone, strict=True)
    ]
    np.testing.assert_allclose(carried, spread, atol=1e-12)  # SciPy finds the rotation by an SVD
    still = strapdown._carry(t, np.zeros((100, 3)), before, before)  # nothing is missed
    np.testing.assert_array_equal(still, np.tile(before, (100, 1)))


@pytest.mark.parametrize(
    ("rests", "said"), [("0110", ["start and end"]), ("1110", ["end"]), ("0111", ["start"]), ("1001", [])]
)
def test_the_ends_without_a_rest_are_named(rests, said):
    findings = strapdown._findings(np.array([rest == "1" for rest in rests]))
    assert [f.message.split(":")[0] for f in findings] == [f"There is no rest at the {ends}" for ends in said]
    assert all(f.severity == "warning" for f in findings)
