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


def test_closure_is_the_mean_of_the_last_second_both_ends_included():
    t = np.arange(41) / 4  # times that floats hold exactly
    found = errors(tracked(Recording(t, np.full(41, 1e5)), t), Recording(t, np.full(41, 1e5)))
    assert found.closure == np.mean([9.0, 9.25, 9.5, 9.75, 10.0])


def test_zeroed_is_over_the_first_second_its_end_excluded():
    t = np.arange(41) / 4
    step = np.where(t < 1, 0.0, 0.5)
    recording = Recording(t, np.full(41, 1e5), reference=np.zeros(41), reference_velocity=np.full(41, 0.25))
    found = errors(tracked(recording, step), recording)
    assert found.height_bias == pytest.approx(0.5 * 37 / 41)
    assert found.velocity_rmse == 0.25


def test_a_reference_too_short_for_a_slope_has_no_velocity_error():
    t = np.arange(500) / 50
    blink = np.where((t > 4.95) & (t < 5.05), 1.0, np.nan)
    found = errors(tracked(make(), np.zeros(500)), make(reference=blink))
    assert found.velocity_rmse is None
    assert found.height_rmse == 0


def test_the_slope_is_a_chord_over_a_fifth_of_a_second_and_unknown_at_the_ends():
    t = np.arange(500) / 50
    _, slope = reference_at(make(reference=np.sin(t)), t, 0.0)
    inside = (t > 0.11) & (t < 9.87)
    assert slope[inside] == pytest.approx(np.cos(t[inside]) * np.sin(0.1) / 0.1, abs=1e-12)  # rounding
    assert np.isnan(slope[(t < 0.09) | (t > 9.89)]).all()


@pytest.mark.parametrize("lag", [-0.3, 0.0, 0.3])
def test_beyond_its_times_a_reference_is_unknown_and_a_late_one_is_shifted_back(lag):
    t = np.arange(500) / 50
    middle = np.where((t > 2.99) & (t < 7.01), 3 * t, np.nan)
    given = make(reference=middle, reference_velocity=np.full(500, 3.0))
    height, velocity = reference_at(given, t, lag)
    known = (t > 2.99 - lag) & (t < 7.01 - lag)
    assert height[known] == pytest.approx(3 * (t[known] + lag))
    assert velocity[known] == pytest.approx(3.0)
    assert np.isnan(height[~known]).all()
    assert np.isnan(velocity[~known]).all()


TONES = np.array([0.31, 0.47, 0.73, 0.97])  # Hz


def motion(t):
    """Height and velocity of a hand that goes up and down as it likes."""
    phase = 2 * np.pi * TONES[:, None] * t + np.arange(4)[:, None]
    return 0.1 * np.sin(phase).sum(axis=0), 0.1 * (2 * np.pi * TONES[:, None] * np.cos(phase)).sum(axis=0)


def late_by(lag, n=1500, size=1.0):
    t = np.arange(n) / 50
    height, velocity = motion(t)
    late, slope = motion(t - lag)
    recording = make(n, reference=size * late, reference_velocity=size * slope)
    return tracked(recording, height, velocity), recording


@pytest.mark.parametrize("lag", [-0.595, -0.59, -0.1234, 0.0, 0.0017, 0.59, 0.595])
def test_a_lag_between_the_grids_lags_is_found_exactly(lag):
    # what the parabola leaves of a step of 5 ms, and what linear interpolation does to 1 Hz at 50 Hz: 0.2 %
    assert estimate_reference_lag(*late_by(lag)) == pytest.approx(lag, abs=2e-4)


def test_a_lag_longer_than_the_longest_is_not_found():
    late = late_by(0.7)
    assert estimate_reference_lag(*late) is None
    assert estimate_reference_lag(*late, longest=0.8) == pytest.approx(0.7, abs=2e-4)
    assert estimate_reference_lag(*late, longest=0.7) is None
    assert estimate_reference_lag(*late_by(-0.7), longest=0.7) is None
    assert estimate_reference_lag(*late_by(-0.7), longest=0.8) == pytest.approx(-0.7, abs=2e-4)


def test_a_reference_that_hardly_moves_has_no_lag():
    _, velocity = motion(np.arange(1500) / 50)
    for sd, found in ((0.009, False), (0.011, True)):
        lag = estimate_reference_lag(*late_by(0.1, size=sd / np.std(velocity)))
        assert (lag is not None) == found
        track, recording = late_by(0.1)
        small = replace(track, velocity=track.velocity * sd / np.std(velocity))
        assert (estimate_reference_lag(small, recording) is not None) == found


@pytest.mark.parametrize(("correlation", "found"), [(0.65, False), (0.75, True)])
def test_a_reference_that_correlates_too_little_has_no_lag(correlation, found):
    track, recording = late_by(0.1)
    other = np.random.default_rng(1).normal(size=len(track.t))
    other *= np.std(track.velocity) / np.std(other) * np.sqrt(1 / correlation**2 - 1)
    lag = estimate_reference_lag(replace(track, velocity=track.velocity + other), recording)
    assert (lag is not None) == found


@pytest.mark.parametrize(("sharpness", "found"), [(1.01, False), (1.06, True)])
def test_a_motion_that_fits_about_as_well_beside_its_lag_has_none(sharpness, found):
    # a sine of angular rate w under white noise correlates by r at its lag and r cos(w/10) beside, so that
    # (1 - r² cos²)/(1 - r²) is the sharpness
    t, r2 = np.arange(6000) / 50, 0.85
    w = 10 * np.arccos(np.sqrt((1 - sharpness * (1 - r2)) / r2))
    noise = np.random.default_rng(2).normal(size=len(t))
    sine = np.sin(w * t)
    velocity = sine + noise * np.std(sine) / np.std(noise) * np.sqrt(1 / r2 - 1)
    recording = make(6000, reference=-np.cos(w * t) / w, reference_velocity=sine)
    lag = estimate_reference_lag(tracked(recording, np.zeros(6000), velocity), recording)
    assert (lag is not None) == found


@pytest.mark.parametrize("side", [-0.1, 0.1])
def test_a_motion_that_comes_twice_within_a_tenth_of_a_second_has_no_lag(side):
    # white noise with a knot every 0.05 s and a slow swell: 0.1 s later it correlates by some 0.2; with a
    # second one almost as large on one side the fit there is almost as good, on the other side it is bad
    t, knots = np.arange(6000) / 200, np.random.default_rng(3).normal(size=640)

    def velocity(t):
        return np.interp(t, 0.05 * np.arange(-20, 620), knots) + 0.6 * np.sin(np.pi * t)

    recording = Recording(t, np.full(6000, 1e5), reference=0 * t, reference_velocity=velocity(t))
    for second, found in ((0.0, True), (0.99, False)):
        track = tracked(recording, 0 * t, velocity(t) + second * velocity(t + side))
        assert (estimate_reference_lag(track, recording) is not None) == found


def test_lags_at_which_nothing_is_left_to_compare_count_for_nothing():
    """A reference that moves in its first 0.3 s only: shifted by more, it rests."""
    t = np.arange(2000) / 200
    jolt = np.where(t < 0.3, np.sin(np.pi * t / 0.3) ** 2, 0.0)
    late = np.interp(t - 0.1011, t, jolt)
    recording = Recording(t, np.full(2000, 1e5), reference=0 * t, reference_velocity=late)
    # what the parabola leaves of a step of 5 ms
    assert estimate_reference_lag(tracked(recording, 0 * t, jolt), recording) == pytest.approx(
        0.1011, abs=1e-3
    )
