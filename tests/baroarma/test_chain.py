"""The aligned chain: three kinds, one meaning of `step` and `run`."""

import math
from dataclasses import replace

import numpy as np
import pytest

from baroarma.chain import _blank_repeats, _hold
from baroarma.estimators.base import UNFELT, UNSEEN_WALK
from baroarma.simulation import BMP085, simulate
from baroarma.tracker import Tracker


def steps(tracker, recording, rows):
    return [
        tracker.step(
            dt=float(recording.t[k] - recording.t[k - 1]),
            pressure=float(recording.pressure[k]),
            accel=None if recording.accel is None else recording.accel[k],
            gyro=None if recording.gyro is None else recording.gyro[k],
        )
        for k in rows
    ]


@pytest.mark.parametrize("kind", ["sg14-b", "baroarma", "zhang12", "pressure alone"])
def test_step_goes_on_where_run_ended(kind):
    recording = simulate("squat", duration=8, seed=2)
    # the barometer is missing around the seam, so that the zero, the hold and the averages carry over
    recording = replace(recording, pressure=np.where(recording.t % 0.3 < 0.1, np.nan, recording.pressure))
    if kind == "pressure alone":
        recording = replace(recording, accel=None, gyro=None)
    preset = kind if kind != "pressure alone" else "baroarma"
    whole = Tracker.preset(preset, noise=BMP085.noise).run(recording)
    tracker = Tracker.preset(preset, noise=BMP085.noise)
    tracker.run(recording.rows(slice(250)))
    there = np.array(steps(tracker, recording, range(250, 400))).T
    expected = [whole.height, whole.velocity, whole.height_sd, whole.velocity_sd, whole.acceleration]
    np.testing.assert_allclose(there, [column[250:] for column in expected], rtol=1e-9, atol=1e-9)


def test_the_acceleration_is_held_where_a_row_has_none():
    recording = simulate("squat", duration=8, seed=3)
    blank = np.arange(400) % 4 == 1
    accel = np.where(blank[:, None], np.nan, recording.accel)
    track = Tracker.preset("lee16").run(replace(recording, accel=accel))
    later = np.flatnonzero(blank & (recording.t > 1.1))
    assert np.array_equal(track.acceleration[later], track.acceleration[later - 1])


def test_without_imu_the_sds_allow_for_peoples_motion():
    recording = simulate("rest", duration=20, seed=4)
    with_imu, without = (
        Tracker(noise=BMP085.noise).run(r) for r in (recording, replace(recording, accel=None, gyro=None))
    )
    assert without.velocity_sd[-1] > 2 * with_imu.velocity_sd[-1]


@pytest.mark.parametrize("preset", ["baroarma", "zhang12"])
def test_after_a_gap_the_velocity_is_as_uncertain_as_it_is_wrong(preset):
    """Three seconds without any sensor, in the middle of squats: nobody knows the velocity then."""
    z = []
    for seed in range(8):
        log = simulate("squat", duration=40, pause=0.0, seed=seed)
        log = log.rows((log.t < 30) | (log.t >= 33))
        track = Tracker.preset(preset, noise=BMP085.noise).run(log)
        after = np.searchsorted(log.t, 33.0)
        assert track.velocity_sd[after] > 5 * track.velocity_sd[after - 1]
        z.append((track.velocity - log.reference_velocity)[after] / track.velocity_sd[after])
    assert np.sqrt(np.mean(np.square(z))) < 2  # eight of them: an honest sd stays below this


def test_a_lost_accelerometer_becomes_a_track_of_pressure_alone():
    log = simulate("rest", duration=60, seed=1)
    accel = np.where((log.t > 20)[:, None], np.nan, log.accel)
    track = Tracker(noise=BMP085.noise).run(replace(log, accel=accel))
    late = log.t > 21
    assert not track.acceleration[late].any()
    assert track.velocity_sd[-1] > 5 * track.velocity_sd[log.t < 20][-1]
    assert np.abs(track.height[late] / track.height_sd[late]).max() < 4


def test_a_long_recording_is_taken_in_parts_with_the_same_numbers(monkeypatch):
    log = simulate("stairs", duration=60, seed=4)
    whole = Tracker(noise=BMP085.noise).run(log)
    monkeypatch.setattr("baroarma.chain.PART", 411)
    parts = Tracker(noise=BMP085.noise).run(log)
    for name in ("height", "velocity", "height_sd", "velocity_sd", "acceleration"):
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name))


@pytest.mark.parametrize("dt", [0.001, 0.02, 0.05])
@pytest.mark.parametrize("missing", [0.05, 0.3, 2.0])
def test_what_was_not_felt_for_long_lets_the_velocity_wander_from_the_last_sample_on(dt, missing):
    n = round(missing / dt)
    acceleration = np.array([3.0, *[np.nan] * n, 3.0])
    used, sd, age, last = [], [], 0.0, 0.0
    for a in acceleration:
        u, s, last, age = _hold(dt, a, age, last)
        used.append(u)
        sd.append(s)
    variance = np.nansum((np.array(sd) * dt) ** 2)
    if missing > UNFELT:
        assert variance == pytest.approx(UNSEEN_WALK**2 * n * dt)
        assert used[n] == 0.0
    else:
        assert variance == 0.0
    assert math.isnan(sd[-1])  # a new sample is the filter's own again


@pytest.mark.parametrize("seed", range(3))
def test_a_barometer_that_hangs_stops_no_lift(seed):
    log = simulate("lift", duration=60, speed=1.0, climb=40.0, seed=seed)
    hangs = (log.t > 20) & (log.t < 25)
    pressure = log.pressure.copy()
    pressure[hangs] = pressure[hangs][0]
    track = Tracker(noise=BMP085.noise).run(replace(log, pressure=pressure))
    # 20 equal altitudes, 0.4 s, say little against what was felt; five seconds of them would be a sure rest
    assert np.abs(track.velocity - log.reference_velocity)[hangs].max() < 0.15


def test_what_comes_again_is_news_until_the_twentieth_time():
    z = np.array([1.0, np.nan, *[2.0] * 15, np.nan, *[2.0] * 10, 3.0])
    news, last, repeats = z.copy(), np.nan, 0
    for part in (slice(0, 12), slice(12, None)):
        last, repeats = _blank_repeats(news[part], last, repeats)
    blank = np.flatnonzero(np.isnan(news) & ~np.isnan(z))
    assert blank.tolist() == [23, 24, 25, 26, 27]
    assert (last, repeats) == (3.0, 0)
