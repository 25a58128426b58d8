"""Tuned gains are better, nothing near is better still, and the tracker takes them."""

import numpy as np
import pytest

import baroarma as ba
from baroarma.simulation import BMP085, simulate

NOISE = BMP085.noise


@pytest.fixture(scope="module")
def tuned():
    return ba.tune("sg14-a", NOISE, "simple", duration=60.0)


def test_nothing_near_the_optimum_is_better(tuned):
    for factor in (0.5, 0.8, 1.25, 2.0):
        other = tuned.height_settings | {"acceleration_sd": factor * tuned.height_settings["acceleration_sd"]}
        near = ba.predict_accuracy(NOISE, "simple", "sg14-a", 60.0, height_settings=other)
        assert near.velocity_rms > tuned.after.velocity_rms
    assert tuned.after.velocity_rms < tuned.before.velocity_rms / 2


def test_the_tracker_with_these_settings_errs_as_predicted(tuned):
    """80 recordings of a minute know the rms to 4 %; 3.5 of these."""
    squares = {"tuned": [], "preset": []}
    for seed in range(80):
        recording = simulate("rest", duration=60, seed=seed)
        for name, settings in (("tuned", tuned.height_settings), ("preset", None)):
            tracker = ba.Tracker(preset="sg14-a", noise=NOISE, attitude="reference", height_settings=settings)
            squares[name].append(np.mean(tracker.run(recording).velocity ** 2))
    for name, predicted in (("tuned", tuned.after), ("preset", tuned.before)):
        mean = np.mean(squares[name])
        error = np.std(squares[name]) / np.sqrt(80) / mean
        assert error < 0.1
        assert mean / predicted.velocity_rms**2 == pytest.approx(1, abs=3.5 * error)


def test_a_kalman_filter_is_tuned_likewise():
    found = ba.tune("zihajehzadeh15", NOISE, "simple", duration=20.0)
    assert found.after.velocity_rms < found.before.velocity_rms
    for factor in (0.5, 2.0):
        other = found.height_settings | {"acceleration_sd": factor * found.height_settings["acceleration_sd"]}
        near = ba.predict_accuracy(NOISE, "simple", "zihajehzadeh15", 20.0, height_settings=other)
        assert near.velocity_rms > found.after.velocity_rms


def test_height_that_counts_is_better_height_for_worse_velocity():
    noise = ba.NoiseModel(0.05, 20.0, 0.1, rate_hz=20)  # slow noise: height and velocity disagree
    imu = ba.ImuNoise(0.01, rate_hz=20)
    found = [ba.tune("sg14-a", noise, imu, duration=60.0, height_weight=w).after for w in (0.0, 10.0)]
    assert found[1].height_rms < found[0].height_rms
    assert found[1].velocity_rms > found[0].velocity_rms


def test_there_is_nothing_to_tune_where_gains_follow_from_the_noise():
    found = ba.tune("baroarma", NOISE, "simple", duration=10.0)
    assert found.height_settings == {}
    assert found.after is found.before
    assert "nothing to tune" in found.summary()


def test_a_search_that_ends_at_its_end_says_so():
    """An accelerometer without noise for 10 s: the barometer only harms."""
    found = ba.tune(
        "sg14-a", ba.NoiseModel(0.27, 0.75, 0.46, rate_hz=50), ba.ImuNoise(1e-6, rate_hz=50), duration=10.0
    )
    assert "no best gain" in found.notes[0]


def test_it_tells_its_story(tuned):
    assert repr(tuned).startswith("<Tuning of sg14-a: velocity 0.08")
    assert f"acceleration_sd = {tuned.height_settings['acceleration_sd']:.6g}" in tuned.summary()
    document = tuned.to_dict()
    assert document["height_settings"] == tuned.height_settings
    assert document["after"]["velocity_rms_m_s"] < document["before"]["velocity_rms_m_s"]


def test_wrong_requests_are_refused():
    with pytest.raises(ValueError, match="height_weight is a number of 1/s, 0 or more, but it is -1"):
        ba.tune("sg14-a", NOISE, height_weight=-1)
    with pytest.raises(ValueError, match="errors of 'zhang12' depend on the motion"):
        ba.tune("zhang12", NOISE)
