"""Clipped signals are named; peaks, coarse steps and held samples are not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baroarma.estimators.calibration import Calibration
from baroarma.recording import Recording
from baroarma.saturation import saturation_findings

G = 9.80665


def swinging(peak, *, seed=0, quantum=0.001, rate_hz=100, hertz=0.7, seconds=30):
    """An accelerometer at rest in z and swinging in x."""
    t = np.arange(seconds * rate_hz) / rate_hz
    noise = np.random.default_rng(seed).normal(0, 0.02, (len(t), 3))
    accel = np.stack([peak * np.sin(2 * np.pi * hertz * t), 0 * t, G + 0 * t], axis=1) + noise
    return Recording(t=t, pressure=np.full(len(t), 1e5), accel=np.round(accel / quantum) * quantum)


def clipped(log, low, high):
    return replace(log, accel=np.clip(log.accel, low, high))


@pytest.mark.parametrize("limit", [2, 4, 8, 16])
@pytest.mark.parametrize("side", [-1, 1])
def test_every_range_is_named_by_its_g_on_either_side(limit, side):
    log = swinging(1.2 * limit * G)
    low, high = (-limit * G, np.inf) if side < 0 else (-np.inf, limit * G)
    (found,) = saturation_findings(clipped(log, low, high))
    assert (found.code, found.severity) == ("saturation", "warning")
    assert f"The accelerometer's x stands at {side * limit * G:.4g} m/s²" in found.message
    assert f"the end of its range ({limit} g)" in found.message


def test_a_range_that_nobody_makes_is_found_and_not_named():
    (found,) = saturation_findings(clipped(swinging(60.0), -45.0, 45.0))
    assert "the end of its range, in" in found.message


def test_rows_and_the_first_time_are_those_of_the_plateaus():
    log = clipped(swinging(30.0), -np.inf, 20.0)
    at = np.flatnonzero(log.accel[:, 0] == 20.0)
    (found,) = saturation_findings(log)
    assert f"in {len(at)} rows, first at {log.t[at[0]]:.4g} s" in found.message


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("quantum", [0.001, 0.15, 0.6])
def test_a_peak_is_no_plateau_however_coarse(quantum, seed):
    assert saturation_findings(swinging(15.0, seed=seed, quantum=quantum, hertz=0.3)) == []


def test_a_peak_that_the_logger_repeats_is_none():
    log = swinging(15.0, hertz=3.0)
    held = np.repeat(log.accel[::5], 5, axis=0)
    assert saturation_findings(replace(log, accel=held)) == []


def test_a_rest_has_no_end_of_range():
    assert saturation_findings(swinging(0.0)) == []
    assert saturation_findings(Recording(t=[0.0], pressure=[1e5], gyro=[[9.0, 0.0, 0.0]])) == []


def gravity_out_and_in(accel):
    """Return what a phone's acceleration and its gravity give together."""
    tilt = np.linspace(0, 0.3, len(accel))
    gravity = G * np.stack([np.sin(tilt), 0 * tilt, np.cos(tilt)], axis=1)
    return (accel - gravity) + gravity


def turned(accel):
    """Return the axes after quarter turns, with their rounding: the cosine of 90 degrees is 6e-17."""
    return accel @ Rotation.from_euler("yx", [90, 90], degrees=True).as_matrix()


def calibrated(accel):
    """Return what a calibration makes of it: 1 % of scale and 0.2 m/s² stay within `CLOSE` of the range."""
    zero = (0.0, 0.0, 0.0)
    change = Calibration((1.01, 0.99, 1.0), (0.2, -0.1, 0.0), zero, zero, (0.01,) * 3, zero, 6, 0.01)
    t = np.arange(len(accel)) / 100
    return change.apply(Recording(t=t, pressure=np.full(len(t), 1e5), accel=accel, gyro=0 * accel)).accel


@pytest.mark.parametrize("changed", [gravity_out_and_in, turned, calibrated])
def test_arithmetic_that_keeps_the_axes_does_not_hide_a_plateau(changed):
    log = clipped(swinging(30.0), -2 * G, 2 * G)
    rows = np.count_nonzero(np.abs(log.accel[:, 0]) == 2 * G)
    (found,) = saturation_findings(replace(log, accel=changed(log.accel)))
    assert f"the end of its range (2 g), in {rows} rows" in found.message
