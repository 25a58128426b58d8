"""What the accelerometer says about the heights: sign, unit and clock, and nothing about honest ones."""

from dataclasses import replace

import numpy as np
import pytest

from baroarma import read
from baroarma.atmosphere import altitude_pressure
from baroarma.climb_evidence import _changes, climb_findings
from baroarma.recording import Recording
from baroarma.simulation import MOTIONS, simulate


@pytest.fixture(scope="module")
def climbs():
    return simulate("lee16-c", duration=45, device="gy-87", seed=1)


def with_height(log, change):
    """Change the height above the first one."""
    height = log.height()
    return replace(log, pressure=altitude_pressure(100 + change(height - height[log.is_new][0])))


def shifted(log, seconds):
    """Let the barometer come later by some seconds."""
    rows = np.flatnonzero(log.is_new)
    to = rows + round(seconds * 50)
    inside = (to >= 0) & (to < len(log))
    pressure = np.full(len(log), np.nan)
    pressure[to[inside]] = log.pressure[rows[inside]]
    return replace(log, pressure=pressure)


@pytest.mark.parametrize("span", [4, 8])
def test_both_changes_are_equal_for_a_smooth_climb_without_noise(span):
    t = np.arange(6000) / 50
    height, push = 2 * np.sin(0.5 * t), -0.5 * np.sin(0.5 * t)
    accel = np.stack([0 * t, 0 * t, 9.8 + push], axis=1)
    changes = _changes(Recording(t=t, pressure=altitude_pressure(height), accel=accel), span)
    # but for the median of the force; means over 1/4 s lie up to half a row off the middle, which is 0.01 s
    # of a wave of 12.6 s, or 0.5 %
    pushed, risen = changes.pushed - changes.pushed.mean(), changes.risen - changes.risen.mean()
    np.testing.assert_allclose(pushed, risen, rtol=0, atol=0.005 * risen.max())
    assert float(pushed @ risen / (pushed @ pushed)) == pytest.approx(1.0, abs=0.005)


def test_a_height_that_counts_downwards_is_told(climbs):
    (found,) = climb_findings(with_height(climbs, np.negative))
    assert found.code == "axes"
    assert "counts the other way" in found.message


def test_feet_are_told_and_a_tenth_more_is_not(climbs):
    (found,) = climb_findings(with_height(climbs, lambda h: h / 0.3048))
    assert found.code == "units"
    assert "look like feet" in found.message
    assert climb_findings(with_height(climbs, lambda h: 1.1 * h)) == []


@pytest.mark.parametrize("seconds", [-2.0, -1.0, 1.0, 2.0])
def test_a_clock_that_is_off_is_measured_to_a_quarter_of_a_second(climbs, seconds):
    (found,) = climb_findings(shifted(climbs, seconds))
    assert found.code == "clocks"
    told = float(found.message.split("comes about ")[1].split(" s ")[0])
    assert told == pytest.approx(abs(seconds), abs=0.25)
    assert f"s {'after' if seconds > 0 else 'before'} the accelerometer" in found.message


def test_a_barometers_own_lag_is_left_to_who_measures_it(climbs):
    assert climb_findings(shifted(climbs, 0.2)) == []


def test_two_recordings_that_both_move_are_told_apart(climbs):
    rng = np.random.default_rng(3)
    other = 6 * np.cumsum(rng.normal(size=len(climbs))) / 50  # wanders by metres, as nothing pushes it
    slow = np.convolve(np.repeat(rng.normal(0, 5, len(climbs) // 50 + 1), 50), np.ones(50) / 50, "same")
    found = climb_findings(with_height(climbs, lambda h: slow[: len(climbs)] + other))
    assert [finding.code for finding in found] == ["clocks"]


@pytest.mark.parametrize("device", ["simple", "bmp390-bmi270"])
@pytest.mark.parametrize("motion", MOTIONS)
def test_no_honest_motion_is_accused(motion, device):
    assert climb_findings(simulate(motion, duration=60, device=device, seed=8)) == []


def test_a_real_ride_agrees_and_its_faults_are_named(shared_data):
    folder = shared_data / "srp_altimu10_elevator_rocket"
    ride = read(*(folder / f"elevator_{stream}.csv.gz" for stream in ("baro", "acc", "gyr")))
    assert climb_findings(ride) == []
    assert climb_findings(with_height(ride, np.negative))[0].code == "axes"
    assert "look like feet" in climb_findings(with_height(ride, lambda h: h / 0.3048))[0].message


def test_without_an_accelerometer_or_enough_of_it_nothing_is_said(climbs):
    assert climb_findings(replace(climbs, accel=None)) == []
    assert climb_findings(climbs.between(0, 5)) == []
    assert climb_findings(replace(climbs, accel=np.full_like(climbs.accel, np.nan))) == []
    assert climb_findings(replace(climbs, pressure=np.full(len(climbs), np.nan))) == []
