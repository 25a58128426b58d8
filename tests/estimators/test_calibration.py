"""Calibration from rests: what was put in comes out, within its sds."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baroarma.estimators.calibration import calibrate
from baroarma.local_gravity import gravity
from baroarma.recording import Recording

SCALE, OFFSET, BIAS = (
    np.array([1.02, 0.985, 1.01]),
    np.array([0.2, -0.35, 0.1]),
    np.array([0.02, -0.01, 0.005]),
)


def turned(seed, *, orientations=12, seconds=4.0, accel_sd=0.03, gyro_sd=0.003):
    """Rests in random orientations with turns of a second between them, seen by wrong sensors."""
    rng = np.random.default_rng(seed)
    poses = Rotation.random(orientations, rng=rng)
    still, turn = round(seconds * 50), 50
    ups, rates = [], []
    for k in range(orientations):
        ups.append(np.tile(poses[k].inv().apply([0, 0, 9.80665]), (still, 1)))
        rates.append(np.zeros((still, 3)))
        if k + 1 < orientations:
            step = (poses[k].inv() * poses[k + 1]).as_rotvec()
            path = [poses[k] * Rotation.from_rotvec(step * s) for s in (np.arange(turn) + 0.5) / turn]
            ups.append(np.array([p.inv().apply([0, 0, 9.80665]) for p in path]))
            rates.append(np.tile(step, (turn, 1)))
    force, rate = np.concatenate(ups), np.concatenate(rates)
    n = len(force)
    accel = (force + OFFSET) / SCALE + accel_sd * rng.normal(size=(n, 3))
    gyro = rate + BIAS + gyro_sd * rng.normal(size=(n, 3))
    return Recording(t=np.arange(n) / 50, pressure=np.full(n, 1e5), accel=accel, gyro=gyro, name="turned")


def test_scale_offset_and_gyro_bias_are_recovered_within_their_sds():
    errors = []
    for seed in range(15):
        found = calibrate(turned(seed))
        # three scales, offsets and biases each; two neighbouring poses may pass for one rest
        assert 10 <= found.rests <= 12
        errors.append(
            np.concatenate(
                [
                    (found.accel_scale - SCALE) / found.accel_scale_sd,
                    (found.accel_offset - OFFSET) / found.accel_offset_sd,
                    (found.gyro_bias - BIAS) / found.gyro_bias_sd,
                ]
            )
        )
    # 135 errors in sds, some correlated: none beyond 3.9 (1 % of the time), their rms near 1; it may stay
    # below, because sds grow with the rests' disagreement but never shrink
    assert np.abs(errors).max() < 3.9
    assert 0.7 < np.sqrt(np.mean(np.square(errors))) < 1.15


def test_eight_orientations_suffice():
    found = calibrate(turned(100, orientations=8))
    assert np.all(np.abs(found.accel_scale - SCALE) < 3 * np.array(found.accel_scale_sd))
    assert np.all(np.abs(found.accel_offset - OFFSET) < 3 * np.array(found.accel_offset_sd))
    assert np.all(np.abs(found.gyro_bias - BIAS) < 3 * np.array(found.gyro_bias_sd))
    assert found.residual_sd < 0.01


def test_applying_it_gives_gravity_in_every_rest():
    recording = turned(3)
    after = calibrate(recording).apply(recording)
    rests = [slice(250 * k, 250 * k + 190) for k in range(12)]  # 4 s of rest, 1 s of turning
    before, now = (
        np.array([np.linalg.norm(r.accel[rest].mean(axis=0)) for rest in rests]) for r in (recording, after)
    )
    assert np.abs(before - 9.80665).max() > 0.2
    # 190 samples of 0.03 m/s²: 0.0022; the largest of 12 stays below 3.5 sd
    assert np.abs(now - 9.80665).max() < 0.008
    assert np.abs(after.gyro[:150].mean(axis=0)).max() < 0.001
    with pytest.raises(ValueError, match="no accelerometer and gyro"):
        calibrate(recording).apply(replace(recording, accel=None))


def test_a_rest_in_one_orientation_is_refused():
    recording = turned(1, orientations=1, seconds=60)
    with pytest.raises(ValueError, match=r"too few rests of 1 s or more, 1; .* at least 6"):
        calibrate(recording)


def test_many_rests_in_one_orientation_are_refused():
    level = turned(1, orientations=1, seconds=30)
    shaken = level.gyro.copy()
    shaken[(level.t % 3) < 0.5] += 1.0  # turned about the vertical: eight rests, one orientation
    with pytest.raises(ValueError, match="too alike to tell scale from offset"):
        calibrate(replace(level, gyro=shaken))


def test_recordings_without_imu_are_refused():
    recording = turned(1, orientations=2)
    with pytest.raises(ValueError, match="no accelerometer and gyro to calibrate"):
        calibrate(replace(recording, gyro=None))
    with pytest.raises(ValueError, match="no complete IMU sample"):
        calibrate(replace(recording, gyro=np.full((len(recording), 3), np.nan)))


def test_rests_that_disagree_make_all_sds_grow():
    recording = turned(5)
    crooked = recording.accel @ (np.eye(3) + 0.02 * np.array([[0, 1, 0], [0, 0, 0], [0, 0, 0]]))  # not square
    assert np.all(
        np.array(calibrate(replace(recording, accel=crooked)).accel_scale_sd)
        > 2 * np.array(calibrate(recording).accel_scale_sd)
    )


def test_it_is_written_as_json_and_as_text():
    found = calibrate(turned(2))
    document = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert document["accel_scale"] == list(found.accel_scale)
    assert document["gyro_bias_sd_rad_s"] == list(found.gyro_bias_sd)
    assert found.summary().startswith(f"{found.rests} rests, residual ")
    assert f"x: scale {found.accel_scale[0]:.5f} ± " in found.summary()


def test_scales_and_offsets_are_proportional_to_the_gravity_that_is_given():
    recording = turned(2)
    standard, polar = calibrate(recording), calibrate(recording, gravity=gravity(90.0))
    ratio = gravity(90.0) / 9.80665
    # the model is homogeneous of degree one; 1e-6 is what the solver leaves, a thousandth of the scales' sds
    assert np.allclose(polar.accel_scale, ratio * np.array(standard.accel_scale), rtol=1e-6)
    assert np.allclose(polar.accel_offset, ratio * np.array(standard.accel_offset), rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    ("field", "factor", "says"),
    [
        ("accel", 1 / 9.80665, "not about 9.8: the accelerometer's unit is wrong"),
        ("accel", 0.0, "gravity was taken out"),
        ("gyro", 180 / np.pi, "looks like deg/s"),
    ],
)
def test_another_unit_is_no_matter_of_calibration(field, factor, says):
    log = turned(1, gyro_sd=1e-4)
    with pytest.raises(ValueError, match=says):
        calibrate(replace(log, **{field: getattr(log, field) * factor}))
