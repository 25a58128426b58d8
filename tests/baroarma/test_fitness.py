"""What a recording lacks is refused, what weakens a track is said."""

from dataclasses import replace

import numpy as np
import pytest

import baroarma as ba
from baroarma.finding import Finding
from baroarma.fitness import refuse_unfit
from baroarma.presets import PRESETS
from baroarma.simulation import BMP085, simulate
from baroarma.tracker import Tracker


@pytest.fixture(scope="module")
def squat():
    return simulate("squat", duration=8, seed=1)


def codes(recording, preset="baroarma", noise=BMP085.noise):
    return [finding.code for finding in Tracker.preset(preset, noise=noise).run(recording).findings]


def test_a_fit_recording_needs_no_words(squat):
    for preset in PRESETS.values():
        refuse_unfit(squat, preset)
    assert codes(squat) == []


@pytest.mark.parametrize(
    ("preset", "changes", "says"),
    [
        ("sg14-a", {"accel": None}, "walk has no accelerometer and gyro, which the preset sg14-a needs"),
        ("bourke08", {"gyro": None}, "take the preset baroarma"),
        ("baroarma", {"pressure": np.full(400, np.nan)}, "walk: there is no pressure sample"),
        ("baroarma", {"notes": (Finding("units", "error", "It is hPa."),)}, "walk: It is hPa"),
    ],
)
def test_what_is_missing_is_told(squat, preset, changes, says):
    with pytest.raises(ValueError, match=says):
        refuse_unfit(replace(squat, name="walk", **changes), PRESETS[preset])


def test_what_reading_noticed_is_repeated_unless_it_is_harmless(squat):
    notes = (Finding("a", "info", "Fine."), Finding("b", "warning", "Look."))
    for preset in ("baroarma", "bourke08"):
        assert codes(replace(squat, notes=notes), preset)[0] == "b"
        assert "a" not in codes(replace(squat, notes=notes), preset)


def test_a_default_noise_and_noise_of_another_rate_are_named(squat):
    assert codes(squat, noise=None) == ["default-noise"]
    assert codes(squat, "sg14-a", noise=None) == []
    assert codes(squat, "sg14-a", noise=BMP085.noise.at_rate(10)) == ["noise-rate"]


def test_what_an_estimator_leaves_out_of_the_noise_is_named(squat):
    found = Tracker(noise=BMP085.noise, height="kalman").run(squat).findings
    assert [(f.code, f.severity) for f in found] == [("left-out", "info")]


def test_a_barometer_that_comes_late_is_named(squat):
    late = replace(squat, pressure=np.where(squat.t < 2.5, np.nan, squat.pressure))
    assert codes(late) == ["late-barometer"]


def test_an_alignment_while_walking_is_named(shared_data):
    folder = shared_data / "srp_altimu10_elevator_rocket"
    ride = ba.read(*(folder / f"elevator_{stream}.csv.gz" for stream in ("baro", "acc", "gyr")))
    assert codes(ride.between(0, 5), "sg14-a", None) == []
    assert codes(ride.between(9, 15), "sg14-a", None) == ["not-at-rest"]


def test_a_track_that_leaves_the_barometer_says_where():
    log = simulate("lift", duration=60, seed=1)
    tilted = np.where((log.t > 20)[:, None], log.accel * 1.05, log.accel)  # half a m/s² from then on
    found = {
        f.code: f
        for f in Tracker.preset("tanigawa08", noise=BMP085.noise).run(replace(log, accel=tilted)).findings
    }
    assert "first after 20 s" in found["diverged"].message or "first after 25 s" in found["diverged"].message


@pytest.mark.parametrize("preset", ["baroarma", "sg14-a", "sg14-b", "lee16"])
def test_a_lift_ride_alone_is_no_divergence(preset):
    # sg14-b reports it too small by design and says "dc-gain" instead
    track = Tracker.preset(preset, noise=BMP085.noise).run(simulate("lift", duration=120, seed=2))
    assert "diverged" not in {f.code for f in track.findings}


def test_real_hand_motions_follow_the_barometer_and_a_rocket_does_not(shared_data):
    lift = ba.read(shared_data / "stampfly_tof_handheld" / "lift30cm_a.csv.gz")
    rocket = shared_data / "srp_altimu10_elevator_rocket"
    flight = ba.read(*(rocket / f"rocket_{stream}.csv.gz" for stream in ("baro", "acc", "gyr")))
    noise = ba.NoiseModel(0.143, 0.26, 0.211, 0.097, rate_hz=10)
    assert "diverged" not in {f.code for f in Tracker(noise=noise).run(lift).findings}
    # the accelerometer clips in the boost, the gyro after separation
    assert "diverged" in {f.code for f in Tracker(noise=noise).run(flight).findings}
