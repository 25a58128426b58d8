"""What the accelerometer's tilts say about the gyro: wrong axes and units by name, honest ones nothing."""

from dataclasses import replace

import numpy as np
import pytest

from baroarma import read
from baroarma.simulation import MOTIONS, simulate
from baroarma.tilt_evidence import _TURNS, tilt_findings


@pytest.fixture(scope="module")
def tumble():
    """A log that turns about all axes."""
    return simulate("lee16-e", duration=45, device="gy-87", seed=1)


def read_as(finding, who):
    """Return the axes that the sentence gives for a sensor, as a matrix."""
    text = finding.message.split(f"{who} as (")[1].split(")")[0]
    rows = []
    for name in text.split(", "):
        row = np.zeros(3)
        row["xyz".index(name[-1])] = -1.0 if name.startswith("-") else 1.0
        rows.append(row)
    return np.array(rows)


@pytest.mark.parametrize("fault", _TURNS[1:], ids=lambda turn: "".join(f"{v:+.0f}" for v in turn[turn != 0]))
def test_each_signed_permutation_is_undone_by_what_the_sentence_says(tumble, fault):
    (found,) = tilt_findings(replace(tumble, gyro=tumble.gyro @ fault.T))
    assert (found.code, found.severity) == ("axes", "warning")
    np.testing.assert_array_equal(read_as(found, "gyro's columns are read") @ fault, np.eye(3))


@pytest.mark.parametrize(
    "fault", [turn for turn in _TURNS if not np.array_equal(np.abs(turn), np.eye(3))][::5]
)
def test_the_cure_of_the_accelerometer_is_one(tumble, fault):
    broken = replace(tumble, accel=tumble.accel @ fault.T)
    (found,) = tilt_findings(broken)
    cure = read_as(found, "or the accelerometer's")
    assert tilt_findings(replace(broken, accel=broken.accel @ cure.T)) == []


def test_a_sign_that_all_axes_of_the_accelerometer_share_says_nothing(tumble):
    assert tilt_findings(replace(tumble, accel=-tumble.accel)) == []


@pytest.mark.parametrize(
    ("factor", "unit"),
    [(180 / np.pi, "deg/s under the label rad/s"), (np.pi / 180, "rad/s under the label deg/s")],
)
def test_units_are_named_and_axes_with_them(tumble, factor, unit):
    (found,) = tilt_findings(replace(tumble, gyro=factor * tumble.gyro))
    assert found.code == "units"
    assert f"it looks like {unit}: rename" in found.message
    (found,) = tilt_findings(replace(tumble, gyro=-factor * tumble.gyro))
    assert f"it looks like {unit}, but by" in found.message


@pytest.mark.parametrize("seconds", [-3.0, -0.5, 0.5, 3.0])
def test_a_clock_that_is_off_is_measured_to_a_tenth(tumble, seconds):
    gyro = np.stack([np.interp(tumble.t - seconds, tumble.t, axis) for axis in tumble.gyro.T], axis=1)
    (found,) = tilt_findings(replace(tumble, gyro=gyro))
    assert found.code == "clocks"
    assert f"The gyro comes about {abs(seconds):g} s {'after' if seconds > 0 else 'before'}" in found.message


def test_a_gyro_that_takes_no_part_is_told_so():
    tilts = simulate("lee16-a", duration=50, seed=1)
    noise = np.random.default_rng(1).normal(0, 0.01, tilts.gyro.shape)
    (found,) = tilt_findings(replace(tilts, gyro=noise))
    assert "do not belong together" in found.message


@pytest.mark.parametrize("device", ["simple", "gy-87"])
@pytest.mark.parametrize("motion", MOTIONS)
def test_no_honest_motion_is_accused(motion, device):
    assert tilt_findings(simulate(motion, duration=45, device=device, seed=7)) == []


def test_a_real_tilt_agrees_and_its_faults_are_named(shared_data):
    tilt = read(shared_data / "stampfly_tof_handheld" / "tilt_e.csv.gz")
    assert tilt_findings(tilt) == []
    (found,) = tilt_findings(replace(tilt, gyro=tilt.gyro[:, [1, 0, 2]]))
    assert "read as (y, x, z)" in found.message
    assert tilt_findings(replace(tilt, gyro=np.rad2deg(tilt.gyro)))[0].code == "units"


def test_what_a_carried_device_feels_is_evidence_too(shared_data):
    folder = shared_data / "srp_altimu10_elevator_rocket"
    ride = read(*(folder / f"elevator_{stream}.csv.gz" for stream in ("baro", "acc", "gyr")))
    assert tilt_findings(ride) == []
    (found,) = tilt_findings(replace(ride, gyro=-ride.gyro))
    assert "read as (-x, -y, -z)" in found.message


def test_without_both_sensors_or_tilts_nothing_is_said(tumble):
    assert tilt_findings(replace(tumble, gyro=None)) == []
    assert tilt_findings(tumble.between(0, 2)) == []
    assert tilt_findings(replace(tumble, accel=np.full_like(tumble.accel, np.nan))) == []
    assert tilt_findings(replace(tumble, accel=np.zeros_like(tumble.accel))) == []
