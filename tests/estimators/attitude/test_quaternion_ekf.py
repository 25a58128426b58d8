"""SG14's quaternion EKF: its matrices, its gate, its weakness, and step = run."""

import numpy as np
import pytest
from filterpy.common import Saver
from filterpy.kalman import ExtendedKalmanFilter
from scipy.spatial.transform import Rotation

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.estimators.attitude.alignment import align
from baroarma.estimators.attitude.quaternion_ekf import QuaternionEkf, expected_force, measurement_jacobian
from baroarma.estimators.base import Alignment
from baroarma.rotation import angle_between
from baroarma.testing import AttitudeEstimatorContract

BIAS_P0_LARGE = np.sqrt(1e-3)


def squats(n, *, depth=0.3, tilt=0.4, period=2.0, mount=None):
    """Two seconds of rest, then `n` squats that tilt the trunk about its x axis; exact, 50 Hz, noise-free."""
    t = np.arange(0, 2 + n * period, 0.02)
    w, moving = 2 * np.pi / period, t >= 2
    phase = w * (t - 2) * moving
    angle, rate = tilt * (1 - np.cos(phase)) / 2, moving * tilt * w * np.sin(phase) / 2
    acceleration = -0.5 * moving * depth * w**2 * np.cos(phase)
    up = np.column_stack([0 * t, np.sin(angle), np.cos(angle)])
    gyro = np.column_stack([rate, 0 * t, 0 * t])
    turn = np.eye(3) if mount is None else mount.as_matrix()
    up, gyro = up @ turn.T, gyro @ turn.T
    return t, (STANDARD_GRAVITY + acceleration)[:, None] * up, gyro, up, acceleration


def rough(n=1500, seed=1):
    """Jittery times with a gap of 3 s, missing samples of both sensors, forces on both sides of the gate."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.004, 0.04, n))
    t[n // 2 :] += 3.0
    accel = Rotation.random(rng=rng).apply([0.0, 0.0, 9.8]) + rng.normal(size=(n, 3))
    gyro = np.cumsum(rng.normal(size=(n, 3)), axis=0) / 30
    accel[rng.random(n) < 0.15] = np.nan
    gyro[rng.random(n) < 0.15, 1] = np.nan
    gyro[n // 4 : n // 4 + 60] = np.nan  # more than a second
    return t, accel, gyro


def steps_by_filterpy(ekf, t, accel, gyro):
    dt = np.diff(t, prepend=t[0] - 99.0)  # the first interval has no effect
    states = [ekf.step_by_filterpy(dt=dt[k], accel=accel[k], gyro=gyro[k]) for k in range(len(t))]
    return [np.array(column) for column in zip(*states, strict=True)]


def tilt_error_deg(run, up):
    return np.degrees(angle_between(run.up, up))


def test_the_jacobian_is_the_finite_difference_of_the_expected_force():
    x = np.append(Rotation.random(rng=3).as_quat(), [0.1, -0.2, 0.3])
    step = 1e-5 * np.eye(7)
    difference = [expected_force(x + d, 9.8) - expected_force(x - d, 9.8) for d in step]
    np.testing.assert_allclose(measurement_jacobian(x, 9.8), np.transpose(difference) / 2e-5, atol=1e-6)


def test_the_expected_force_at_rest_points_up_in_the_body():
    rotation = Rotation.random(rng=4)
    force = expected_force(np.append(rotation.as_quat(), [0.1, 0.2, 0.3]), 9.8)
    np.testing.assert_allclose(rotation.apply(force - [0.1, 0.2, 0.3]), [0, 0, 9.8], atol=1e-13)


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"bias_decay": 0.1, "gate": 0.5, "initial_bias_sd": 0.03},
        {"gate": np.inf, "initial_quaternion_sd": 0.1, "accel_noise_sd": 0.01},  # S is 40 000 R at the start
    ],
    ids=["the paper's", "decay", "wide"],
)
def test_the_compiled_run_is_filterpys_step_by_step(settings):
    t, accel, gyro = rough()
    start = align(t, accel, gyro)
    one, all_ = QuaternionEkf(**settings), QuaternionEkf(**settings)
    one.reset(start)
    all_.reset(start)
    run = all_.run(t, accel, gyro)
    for by_step, column in zip(steps_by_filterpy(one, t, accel, gyro), run, strict=True):
        np.testing.assert_allclose(column, by_step, rtol=0, atol=1e-9)
    np.testing.assert_allclose(all_.x, one.x, rtol=0, atol=1e-9)
    np.testing.assert_allclose(all_.P, one.P, rtol=0, atol=1e-12)  # it is of the order 1e-4
    np.testing.assert_array_equal(np.isnan(run.acceleration), ~np.isfinite(accel).all(axis=1))


def test_samples_are_read_where_they_are_and_in_any_layout():
    t, accel, gyro = rough(200)
    expected = QuaternionEkf().run(t, accel, gyro)
    for change in (np.asfortranarray, lambda v: v.tolist(), lambda v: np.repeat(v, 2, axis=0)[::2]):
        run = QuaternionEkf().run(t, change(accel), change(gyro))
        np.testing.assert_array_equal(run.up, expected.up)
    assert accel.flags.writeable


def test_rest_keeps_tilt_and_gives_no_acceleration_however_it_is_mounted():
    for mount in Rotation.random(5, rng=5):
        t, accel, gyro, up, _ = squats(10, depth=0, tilt=0, mount=mount)
        ekf = QuaternionEkf()
        ekf.reset(align(t, accel, gyro + 0.02))
        run = ekf.run(t, accel, gyro + 0.02)
        np.testing.assert_allclose(run.up, up, atol=1e-12)  # rounding
        np.testing.assert_allclose(run.acceleration, 0, atol=1e-11)
        np.testing.assert_allclose(run.acceleration_sd, 0.01 * STANDARD_GRAVITY, rtol=1e-9)


def test_the_mounting_does_not_matter_while_no_component_is_rejected():
    gentle = {"depth": 0.1, "period": 3.0}  # 0.22 m/s², inside the gate of 1.47 m/s²
    expected = QuaternionEkf().run(*squats(3, **gentle)[:3])
    for mount in Rotation.random(5, rng=6):
        t, accel, gyro, _, _ = squats(3, **gentle, mount=mount)
        ekf = QuaternionEkf()
        ekf.reset(align(t, accel, gyro))
        run = ekf.run(t, accel, gyro)
        # renormalising q and leaving P costs the square of the corrections, which are as large as P0's 0.01
        np.testing.assert_allclose(run.up, expected.up @ mount.as_matrix().T, atol=1e-4)
        np.testing.assert_allclose(run.acceleration, expected.acceleration, atol=1e-4)
        np.testing.assert_allclose(run.acceleration_sd, expected.acceleration_sd, atol=1e-4)


def test_a_component_beyond_the_gate_corrects_nothing_and_the_others_do():
    still, pushed = QuaternionEkf(), QuaternionEkf()
    still.step(dt=0.02, accel=np.array([0.3, np.nan, 9.8]), gyro=np.zeros(3))
    pushed.step(dt=0.02, accel=np.array([3.0, 3.0, 3.0]), gyro=np.zeros(3))
    np.testing.assert_array_equal(pushed.x, still.x)
    np.testing.assert_array_equal(pushed.P, still.P)
    one = QuaternionEkf()
    one.step(dt=0.02, accel=np.array([0.3, 3.0, 3.0]), gyro=np.zeros(3))
    assert one.x[1] < 0  # the force leans to x, so the body has turned about -y ...
    assert one.x[4] > 0  # ... or x is biased
    np.testing.assert_array_equal(one.x[[0, 2, 5, 6]], 0.0)


def test_squats_with_a_wide_bias_prior_turn_the_tilt_away_and_with_ours_they_do_not():
    # method: 7° after one squat with P0 = 1e-3, 1.3° over several with 1e-6; which squat it was is not said,
    # so each is asked to lie within a factor of 1.5
    t, accel, gyro, up, acceleration = squats(1)
    loose = QuaternionEkf(initial_bias_sd=BIAS_P0_LARGE).run(t, accel, gyro)
    assert 7 / 1.5 < tilt_error_deg(loose, up)[-1] < 7 * 1.5
    t, accel, gyro, up, acceleration = squats(10)
    loose, ours = (QuaternionEkf(**kw).run(t, accel, gyro) for kw in ({"initial_bias_sd": BIAS_P0_LARGE}, {}))
    assert tilt_error_deg(loose, up)[-1] > 16 / 1.5
    assert tilt_error_deg(ours, up).max() < 1.3 * 1.5
    assert (loose.acceleration - acceleration)[-50:].mean() < -0.1  # leaning: g (cos 10° - 1) = -0.15 m/s²
    assert abs((ours.acceleration - acceleration)[-50:].mean()) < 0.01


def test_after_a_gap_the_covariance_is_sound_and_the_tilt_is_levelled_anew():
    t, accel, gyro, up, _ = squats(5, depth=0.05)
    t = np.where(t > 3, t + 1000.0, t)  # in the middle of a squat
    ekf = QuaternionEkf()
    run = ekf.run(t, accel, gyro)
    after = np.argmax(t > 1000)
    assert tilt_error_deg(run, up)[after] < 1e-6  # this motion has no horizontal acceleration
    assert tilt_error_deg(run, up).max() < 2
    np.testing.assert_allclose(ekf.P, ekf.P.T, atol=1e-18)
    assert np.linalg.eigvalsh(ekf.P).min() > -1e-18  # positive semidefinite, up to rounding
    assert np.linalg.norm(ekf.x[:4]) == pytest.approx(1, abs=1e-12)


def test_without_any_sample_the_state_stays_sound():
    n = 5000
    run = QuaternionEkf().run(np.arange(n) * 0.02, *np.full((2, n, 3), np.nan))
    np.testing.assert_allclose(run.up, np.tile([0.0, 0.0, 1.0], (n, 1)), atol=1e-12)
    assert np.isnan(run.acceleration).all()
    assert np.isnan(run.acceleration_sd).all()


def test_the_gravity_and_the_bias_of_the_alignment_are_used():
    ekf = QuaternionEkf()
    ekf.reset(Alignment(up=(0.0, 1.0, 0.0), gyro_bias=(0.1, 0.2, 0.3), gravity=9.9))
    for _ in range(3):
        state = ekf.step(dt=0.02, accel=np.array([0.0, 9.9, 0.0]), gyro=np.array([0.1, 0.2, 0.3]))
    np.testing.assert_allclose(state.up, [0, 1, 0], atol=1e-12)
    assert state.acceleration == pytest.approx(0, abs=1e-12)


def test_it_is_a_filterpy_filter_whose_history_can_be_saved():
    _, accel, gyro = rough(40)
    ekf = QuaternionEkf()
    assert isinstance(ekf, ExtendedKalmanFilter)
    saver = Saver(ekf)
    for k in range(40):
        (ekf.step if k % 2 else ekf.step_by_filterpy)(dt=0.02, accel=accel[k], gyro=gyro[k])
        saver.save()
    saver.to_array()
    assert saver.x.shape == (40, 7)
    assert saver.P_post.shape == (40, 7, 7)
    np.testing.assert_array_equal(saver.x, saver.x_post)


def test_filterpys_own_predict_and_update_work_on_it():
    ekf = QuaternionEkf()
    ekf.step_by_filterpy(dt=0.02, accel=np.array([0.0, 0.0, 9.8]), gyro=np.array([0.1, 0.0, 0.0]))
    ekf.predict()
    ekf.update(
        np.array([0.0, 0.1, 9.8]), lambda x: measurement_jacobian(x, 9.8), lambda x: expected_force(x, 9.8)
    )
    assert np.isfinite(ekf.log_likelihood)


class TestQuaternionEkfKeepsTheContract(AttitudeEstimatorContract):
    def make(self):
        return QuaternionEkf()
