"""Errors against a reference, and how late the reference is."""

from dataclasses import replace

import numpy as np
import pytest

import baroarma as ba
from baroarma.metrics import errors, estimate_reference_lag, reference_at
from baroarma.recording import Recording
from baroarma.simulation import BMP085, simulate
from baroarma.track import Track
from baroarma.tracker import Tracker


def tracked(recording, height, velocity=None):
    n = len(recording)
    zeros = np.zeros(n) if velocity is None else velocity
    return Track(recording.t, height, zeros, np.ones(n), np.ones(n), np.zeros(n))


def make(n=500, **signals):
    return Recording(t=np.arange(n) / 50, pressure=np.full(n, 1e5), **signals)


def test_errors_are_taken_after_zeroing_over_the_first_second():
    # track 7 m and reference -3 m off; both start at rest; from 5 s on the track is 0.4 m too high
    t = np.arange(500) / 50
    off = np.where(t < 5, 0.0, 0.4)
    found = errors(tracked(make(), 7 + off), make(reference=np.full(500, -3.0)))
    assert found.height_rmse == pytest.approx(0.4 * np.sqrt(0.5))
    assert found.height_bias == pytest.approx(0.2)
    assert found.velocity_rmse == 0
    assert found.closure == pytest.approx(7.4)


def test_a_reference_that_comes_later_is_zeroed_over_its_own_first_second():
    t = np.arange(500) / 50
    reference = np.where(t < 4, np.nan, 0.0)
    found = errors(tracked(make(), 0.1 * t), make(reference=reference))
    assert found.height_bias == pytest.approx(0.1 * (t[t >= 4].mean() - t[(t >= 4) & (t < 5)].mean()))


def test_without_a_reference_only_closure_is_known():
    recording = make()
    blank = replace(recording, reference=np.full(500, np.nan))
    for without in (recording, blank):
        found = errors(tracked(without, np.full(500, 0.3)), without)
        assert (found.height_rmse, found.velocity_rmse, found.height_bias) == (None, None, None)
        assert found.closure == pytest.approx(0.3)
    gone = errors(tracked(recording, np.zeros(500)), make(reference=np.zeros(500)), reference_lag=100)
    assert gone.height_rmse is None


def test_a_true_velocity_is_taken_and_else_the_heights_slope():
    t = np.arange(500) / 50
    sine = make(reference=np.sin(t))
    _, slope = reference_at(sine, t, 0.0)
    inside = np.isfinite(slope)
    # a chord over 0.2 s flattens a sine by sin(0.1)/0.1 = 1 - 0.0017; interpolation adds 1e-4
    assert np.abs(slope - np.cos(t))[inside].max() < 0.0025
    given = replace(sine, reference_velocity=np.full(500, 0.25))
    assert reference_at(given, t, 0.0)[1] == pytest.approx(np.full(500, 0.25))


@pytest.mark.parametrize("lag", [-0.13, 0.0, 0.217, 0.4])
@pytest.mark.parametrize("with_velocity", [True, False])
def test_the_lag_of_a_delayed_reference_is_found_within_10_ms(lag, with_velocity):
    recording = simulate("squat", duration=60, seed=5)
    t = recording.t
    late = replace(
        recording,
        reference=np.interp(t - lag, t, recording.reference),
        reference_velocity=np.interp(t - lag, t, recording.reference_velocity) if with_velocity else None,
    )
    # `baroarma` integrates by the midpoint; Euler's half-sample would show as 10 ms
    found = estimate_reference_lag(Tracker(noise=BMP085.noise).run(late), late)
    assert found == pytest.approx(lag, abs=0.010)


def test_a_reference_that_rests_or_moves_otherwise_has_no_lag():
    rest = simulate("rest", duration=20, seed=1)
    assert estimate_reference_lag(Tracker(noise=BMP085.noise).run(rest), rest) is None
    squat = simulate("squat", duration=20, seed=1)
    track = Tracker(noise=BMP085.noise).run(squat)
    wrong = replace(squat, reference=-squat.reference, reference_velocity=-squat.reference_velocity)
    assert estimate_reference_lag(track, wrong) is None
    assert estimate_reference_lag(track, replace(squat, reference=None)) is None


@pytest.mark.parametrize("name", ["lift30cm_a", "lift30cm_b"])
def test_the_laser_of_the_lifts_is_a_fifth_of_a_second_late(name, shared_data):
    recording = ba.read(shared_data / "stampfly_tof_handheld" / f"{name}.csv.gz")
    # its README, from accelerations: 0.20 to 0.22 s; presets differ by 0.02 s, hence the wider band
    found = estimate_reference_lag(Tracker().run(recording), recording)
    assert 0.19 < found < 0.25


def test_a_slow_motion_says_nothing_about_a_lag():
    """A rest, or a lift at constant speed behind a noisy filter, fits its reference as well a bit later."""
    lift = simulate("lift", duration=120, seed=3)
    rest = simulate("rest", duration=120, seed=3)
    for preset, log in (("baroarma", rest), ("sg14-a", rest), ("sg14-a", lift)):
        track = Tracker.preset(preset, noise=BMP085.noise).run(log)
        assert estimate_reference_lag(track, log) is None
