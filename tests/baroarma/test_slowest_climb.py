"""How slow a climb may be: the tracker's own numbers, a straight line, and statistics over runs."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import baroarma as ba
from baroarma.simulation import BMP085, simulate
from baroarma.slowest_climb import (
    REST,
    SPEEDS,
    Climbs,
    add_climb,
    simulate_rests,
    slowest_climb,
    try_climbs,
    watch,
)

NOISE = BMP085.noise
CALM = ba.NoiseModel(0.0, 0.0, 0.05, 1e-4, rate_hz=50)
DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "rest.md"


@pytest.fixture(scope="module")
def rests():
    return simulate_rests(NOISE, "simple", duration=REST + 60.0, runs=6, seed=1)


def test_what_is_watched_is_the_track_after_its_alignment(rests, monkeypatch):
    climb = add_climb(rests[0], 0.3)
    seen, track = watch(climb, NOISE), ba.Tracker(noise=NOISE, attitude="reference").run(climb)
    np.testing.assert_array_equal(seen.t, climb.t[climb.t - climb.t[0] > 0.99])
    np.testing.assert_array_equal(seen.height, track.height[-len(seen.t) :])
    monkeypatch.setattr("baroarma.chain.PART", 1000)  # a long recording is tracked in parts
    in_parts = watch(climb, NOISE)
    np.testing.assert_array_equal(in_parts.believed, seen.believed)
    np.testing.assert_array_equal(in_parts.t, seen.t)


def test_a_climb_adds_a_straight_line_to_the_altitude_and_its_push_to_the_specific_force(rests):
    rest = rests[0]
    climb = add_climb(rest, 0.5, start=40.0, ease=2.0)
    later = rest.t > 42.0
    line = 0.5 * (rest.t - 41.0)  # half of the ease is lost
    np.testing.assert_allclose((climb.reference - rest.reference)[later], line[later], rtol=0, atol=1e-9)
    # altitude -> pressure -> altitude rounds in the 12th digit of 10^5 Pa
    np.testing.assert_allclose((climb.height() - rest.height())[later], line[later], rtol=0, atol=1e-6)
    push = np.linalg.norm(climb.accel - rest.accel, axis=1)
    assert np.trapezoid(push, rest.t) == pytest.approx(0.5, abs=1e-4)  # 50 Hz, 100 rows of a parabola
    np.testing.assert_array_equal(add_climb(rest, 0.5, felt=False).accel, rest.accel)


def test_a_felt_start_at_half_a_metre_per_second_is_recognised_at_once(rests):
    climbs = try_climbs(rests, NOISE, 0.5)
    assert climbs.recognised == 1.0
    assert max(climbs.seconds) < 1.5  # before the lift has its speed


def test_a_rest_is_believed_throughout(rests):
    for rest in rests:
        assert watch(rest, NOISE).believed.all()


def test_what_the_drift_would_do_too_is_taken_for_rest(rests):
    speed = 1e-3  # 6 cm in a minute, where the drift's sd is 8 cm
    climbs = try_climbs(rests, NOISE, speed)
    assert climbs.recognised == 0.0
    # all of the climb is lost, and what a rest itself is off by: 1 cm
    assert np.allclose(climbs.lost, speed * (60.0 - 0.75), rtol=0, atol=0.01)


def test_a_calmer_barometer_tells_slower_climbs():
    options = {"within": 10.0, "runs": 2, "felt": False}
    calm, usual = slowest_climb(CALM, **options), slowest_climb(NOISE, **options)
    assert calm.speed < usual.speed
    assert calm.recognised == usual.recognised == 1.0
    assert calm.speed in SPEEDS


def test_the_same_seed_gives_the_same_answer():
    first, again = (slowest_climb(NOISE, within=3.0, runs=1, seed=3) for _ in range(2))
    assert first == again


def test_climbs_say_what_became_of_them():
    climbs = Climbs(0.2, seconds=(1.0, 3.0, np.inf, 2.0), lost=(0.1, 0.2, 0.3, 0.4), left=(0.0,) * 4)
    assert climbs.recognised == 0.75
    assert "75% of 4 recognised" in repr(climbs)


def test_a_recording_without_imu_is_refused(rests):
    with pytest.raises(ValueError, match="no accelerometer"):
        watch(replace(rests[0], accel=None, gyro=None), NOISE)


@pytest.mark.parametrize(("name", "value"), [("runs", 0), ("within", 0.0)])
def test_what_makes_no_climb_is_refused(name, value):
    with pytest.raises(ValueError, match="positive"):
        slowest_climb(NOISE, **{name: value})


def test_a_climb_that_nobody_can_tell_in_time_is_named():
    with pytest.raises(ValueError, match="give it more time"):
        slowest_climb(NOISE, felt=False, within=0.1, runs=1)


def test_a_simulated_lift_is_recognised_like_an_added_climb():
    lift = simulate("lift", speed=0.5, climb=12.0, duration=25.0, seed=1)
    seen = watch(lift, NOISE)
    riding = (seen.t > 5.0 + 1.5) & (seen.t < 5.0 + 12.0 / 0.5)
    assert not seen.believed[riding].any()


def test_the_documents_examples_run():
    blocks = re.findall(r"```python\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)
    names = {}
    for block in blocks:
        exec(block, names)
    assert names["found"].recognised >= 0.95
    assert "confirm_rest" in DOCUMENT.read_text()
