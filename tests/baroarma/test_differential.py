"""Differential barometry: the weather cancels, the motion stays, the clocks are found."""

from dataclasses import replace

import numpy as np
import pytest

from baroarma.atmosphere import altitude_pressure
from baroarma.clocks import LONGEST_LAG, find_lag
from baroarma.differential import difference_noise
from baroarma.noise_model import NoiseModel
from baroarma.recording import Recording

MOVING = NoiseModel(0.0, 0.0, 0.13, rate_hz=25)  # an MS5611, and a better one beside the window
STILL = NoiseModel(0.0, 0.0, 0.10, rate_hz=10)
DRIFT = 0.05


def pair(seed, *, duration=600.0, offset=3.2, noise=MOVING, reference_noise=STILL, climb=0.0):
    """Two barometers in the same weather on clocks `offset` apart, and the first one's true height."""
    rng = np.random.default_rng(seed)
    grid = np.arange(-40, duration + 40, 0.02)
    weather = np.cumsum(rng.normal(0, DRIFT * 0.02**0.5, len(grid)))
    t, still_t = (
        np.arange(0, duration, 1 / noise.rate_hz),
        np.arange(0, duration, 1 / reference_noise.rate_hz),
    )
    truth = climb * np.clip((t - 200) / 60, 0, 1)
    own = truth + np.interp(t, grid, weather) + noise.simulate(t, rng)
    other = np.interp(still_t, grid, weather) + reference_noise.simulate(still_t, rng)
    return (
        Recording(t=t, pressure=altitude_pressure(100 + own), name="walk"),
        Recording(t=still_t + offset, pressure=altitude_pressure(40 + other), name="window"),
        truth,
    )


def test_the_clocks_offset_is_found_with_an_honest_sd():
    found = [find_lag(*pair(seed)[:2]) for seed in range(12)]
    errors = np.array([lag.seconds - 3.2 for lag in found])
    assert np.abs(errors).max() < 0.2
    # chi-square of 12: 95 % of the time between 4.4 and 23.3
    assert 4.4 < np.sum((errors / [lag.sd for lag in found]) ** 2) < 23.3


@pytest.mark.parametrize("offset", [-12.0, 0.0, 25.0])
def test_either_clock_may_be_ahead(offset):
    assert find_lag(*pair(1, offset=offset)[:2]).seconds == pytest.approx(offset, abs=0.2)


def test_common_weather_cancels_and_the_level_stays():
    walk, window, _ = pair(3)
    difference = walk.relative_to(window)
    height = difference.height()
    known = np.isfinite(height)
    assert np.std(walk.height()) > 0.4
    # white 0.13 m and the 0.03 m that the note names; n = 15 000: 3 sd of an sd are 2 %
    expected = np.hypot(0.13, 0.029)
    assert np.std(height[known]) == pytest.approx(expected, rel=0.03)
    # the clocks' 3.2 s cost as many seconds of the first recording, no more
    assert np.count_nonzero(~known) < (3.2 + 0.5) * 25
    assert height[known][0] == pytest.approx(walk.height()[known][0], abs=1e-9)
    assert [note.code for note in difference.notes] == ["clocks", "difference-noise"]
    assert np.array_equal(difference.t, walk.t)


def test_the_notes_noise_is_that_of_the_difference():
    walk, window, _ = pair(4, offset=0.0)
    quiet, _, _ = pair(4, offset=0.0, noise=replace(MOVING, white_sd=1e-6))
    added = np.nanstd(quiet.relative_to(window, lag=0.0).height())
    message = walk.relative_to(window, lag=0.0).notes[-1].message
    named = float(message.split("adds ")[1].split(" m")[0])
    # the smoothed noise has about 600 s / 2 T = 500 independent values: 3 sd are 10 %, rounding 2 %
    assert named == pytest.approx(added, rel=0.12)
    assert "0.13 m of each sample" in message


def test_a_climb_is_left_alone_and_the_clocks_then_taken_as_they_are():
    walk, window, truth = pair(1, climb=12.0, offset=0.0)
    difference = walk.relative_to(window)
    assert "taken as they are" in difference.notes[0].message
    assert difference.notes[0].severity == "warning"
    off = difference.height() - truth
    assert np.nanstd(off) == pytest.approx(np.hypot(0.13, 0.029), rel=0.03)


def test_unrelated_or_too_noisy_barometers_do_not_tell_the_lag():
    for seed in range(10):
        assert find_lag(pair(seed)[0], pair(seed + 100)[1]).sd == np.inf
    coloured = NoiseModel(0.27, 0.75, 0.46, rate_hz=25)
    walk, window, _ = pair(0, noise=coloured, reference_noise=coloured)
    assert find_lag(walk, window).sd == np.inf
    assert find_lag(*pair(0, duration=60)[:2]) is None
    far = pair(0, offset=LONGEST_LAG + 10)
    assert find_lag(*far[:2]).sd == np.inf


def test_a_known_lag_is_used_as_given():
    walk, window, _ = pair(2)
    given = walk.relative_to(window, lag=3.2)
    assert "taken to be +3.2 s ahead" in given.notes[0].message
    wrong = walk.relative_to(window, lag=-20.0)
    assert np.nanstd(given.height()) < np.nanstd(wrong.height())


def test_a_reference_elsewhere_in_time_or_empty_is_refused():
    walk, window, _ = pair(0, duration=30)
    with pytest.raises(ValueError, match=r"walk .* and window \(1003\.2 to .* do not overlap"):
        walk.relative_to(replace(window, t=window.t + 1000))
    empty = replace(window, pressure=np.full(len(window), np.nan))
    with pytest.raises(ValueError, match="window has fewer than 2 pressure samples"):
        walk.relative_to(empty)


def test_rows_without_a_sample_stay_without():
    walk, window, _ = pair(5, duration=150)
    blank = np.where(np.arange(len(walk)) % 3 == 1, np.nan, walk.pressure)
    difference = replace(walk, pressure=blank).relative_to(window)
    assert np.isnan(difference.pressure[np.isnan(blank)]).all()


@pytest.mark.parametrize("smoothing", [0.0, 2.0])
def test_the_differences_model_has_its_variance_and_density(smoothing):
    noise = NoiseModel(0.2, 0.5, 0.3, 0.05, rate_hz=25)
    reference = NoiseModel(0.1, 2.0, 0.2, 0.02, rate_hz=10)
    model = difference_noise(noise, reference, smoothing=smoothing)
    # numerically: spectra of both, the second through the kernel's 1/(1 + w² T²), the common drift through
    # what that kernel takes away
    w = np.geomspace(1e-6, 1e5, 400_001)
    gain = 1 / (1 + (w * smoothing) ** 2)
    correlated = (2 * 0.04 * 0.5 / (1 + (0.5 * w) ** 2)) + gain**2 * 2 * 0.01 * 2.0 / (1 + (2.0 * w) ** 2)
    if smoothing:
        correlated += gain**2 * reference.white_density + (1 - gain) ** 2 * 0.02**2 / w**2
    variance = np.trapezoid(correlated, w) / np.pi
    assert model.correlated_sd**2 == pytest.approx(variance, rel=1e-3)  # the grid's trapezoids
    density = 2 * model.correlated_sd**2 * model.correlation_time
    expected = correlated[0] + (2 * (0.02**2 * smoothing / 4) * smoothing if smoothing else 0.0)
    assert density == pytest.approx(expected, rel=1e-3)
    assert model.white_density == pytest.approx(noise.white_density + (0 if smoothing else 0.004))
    assert model.drift_rate == pytest.approx(np.sqrt(0.05**2 - 0.02**2))


def test_two_white_barometers_differ_by_white_noise():
    model = difference_noise(MOVING, STILL)
    assert not model.has_gauss_markov
    assert model.white_density == pytest.approx(MOVING.white_density + STILL.white_density)
