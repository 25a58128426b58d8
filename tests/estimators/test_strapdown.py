"""Bourke's method: exact with exact sensors, de-drifted with real ones."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

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


def test_exact_sensors_give_the_exact_motion():
    # rest, a rise of 1 m within 1 s while leaning by 0.4 rad, rest: the fifth-order polynomial of least jerk
    t = np.arange(0, 8, 0.005)
    u = np.clip(t - 3, 0, 1)
    share, speed, acceleration = (
        u**3 * (10 - 15 * u + 6 * u**2),
        30 * u**2 * (1 - u) ** 2,
        60 * u - 180 * u**2 + 120 * u**3,
    )
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
