"""Lee16's tilt filter: step = run, honest covariance, and why the exponential."""

import numpy as np
import pytest
from filterpy.common import Saver
from filterpy.kalman import KalmanFilter
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.estimators.attitude.alignment import align
from baroarma.estimators.attitude.tilt_kalman import TiltKalman
from baroarma.estimators.base import Alignment
from baroarma.rotation import angle_between
from baroarma.testing import AttitudeEstimatorContract


def spin(*, turns_hz, lever, duration=60.0, mount=None):
    """One second of rest, then a steady turn about a horizontal axis, at the end of a lever; exact, 50 Hz."""
    t = np.arange(0, duration, 0.02)
    rate = 2 * np.pi * turns_hz * (t >= 1)
    angle = rate * (t - 1)
    up = np.column_stack([0 * t, np.sin(angle), np.cos(angle)])
    gyro = np.column_stack([rate, 0 * t, 0 * t])
    accel = STANDARD_GRAVITY * up - np.column_stack([0 * t, 0 * t, lever * rate**2])  # centripetal
    turn = np.eye(3) if mount is None else mount.as_matrix()
    return t, accel @ turn.T, gyro @ turn.T, up @ turn.T


def rough(n=1500, seed=2):
    """Jittery times with a gap of 3 s, and missing samples of both sensors."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.004, 0.04, n))
    t[n // 2 :] += 3.0
    accel = Rotation.random(rng=rng).apply([0.0, 0.0, 9.8]) + rng.normal(size=(n, 3))
    gyro = np.cumsum(rng.normal(size=(n, 3)), axis=0) / 30
    accel[rng.random(n) < 0.15, 2] = np.nan
    gyro[rng.random(n) < 0.15] = np.nan
    gyro[n // 4 : n // 4 + 60] = np.nan  # more than a second
    return t, accel, gyro


@pytest.mark.parametrize("settings", [{}, {"transition": "first-order", "acceleration_memory": 0.8}])
def test_the_compiled_run_is_filterpys_step_by_step(settings):
    t, accel, gyro = rough()
    start = align(t, accel, gyro)
    one, all_ = TiltKalman(**settings), TiltKalman(**settings)
    one.reset(start)
    all_.reset(start)
    run = all_.run(t, accel, gyro)
    dt = np.diff(t, prepend=t[0] - 99.0)  # the first interval has no effect
    states = [one.step_by_filterpy(dt=dt[k], accel=accel[k], gyro=gyro[k]) for k in range(len(t))]
    for by_step, column in zip(zip(*states, strict=True), run, strict=True):
        np.testing.assert_allclose(column, np.array(by_step), rtol=0, atol=1e-9)
    np.testing.assert_allclose(all_.P, one.P, rtol=0, atol=1e-12)  # it is of the order 1e-5
    np.testing.assert_allclose(all_.external, one.external, rtol=0, atol=1e-9)


def test_rest_and_a_turning_lever_keep_tilt_however_it_is_mounted():
    expected = TiltKalman().run(*spin(turns_hz=0.2, lever=0.3, duration=20)[:3])
    for mount in Rotation.random(5, rng=5):
        t, accel, gyro, up = spin(turns_hz=0.2, lever=0.3, duration=20, mount=mount)
        tilt = TiltKalman()
        tilt.reset(align(t, accel, gyro))
        run = tilt.run(t, accel, gyro)
        np.testing.assert_allclose(run.up[t <= 1], up[t <= 1], atol=1e-12)  # rounding
        np.testing.assert_allclose(run.up, expected.up @ mount.as_matrix().T, atol=1e-9)
        np.testing.assert_allclose(run.acceleration, expected.acceleration, atol=1e-9)
        np.testing.assert_allclose(run.acceleration_sd, expected.acceleration_sd, atol=1e-9)


def test_the_first_order_transition_falls_short_by_a_third_of_the_angles_cube():
    angle = 2 * np.pi / 50
    missing = {}
    for transition in ("exponential", "first-order"):
        tilt = TiltKalman(transition=transition)
        for _ in range(2):
            state = tilt.step(dt=0.02, accel=np.full(3, np.nan), gyro=np.array([angle / 0.02, 0.0, 0.0]))
        missing[transition] = angle - float(angle_between(state.up, [0.0, 0.0, 1.0]))
    assert missing["exponential"] == pytest.approx(0, abs=1e-15)
    assert missing["first-order"] == pytest.approx(angle**3 / 3, rel=angle**2)  # the next term: 3/5 angle²


def test_at_one_turn_a_second_only_the_exponential_knows_where_up_is():
    # method: tens of degrees, 48 in its trial (with settings that it does not give)
    t, accel, gyro, up = spin(turns_hz=1, lever=0.1)
    late = t > 30
    first, exact = (
        np.degrees(angle_between(TiltKalman(transition=kind).run(t, accel, gyro).up, up))[late]
        for kind in ("first-order", "exponential")
    )
    assert first.mean() > 20
    # the centripetal force of 4 m/s² turns with the body and so averages out: at most
    # R-weighted gain / (turns per sample) of its 0.4 rad; the trial's own remainder was 6°
    assert exact.max() < 6


def test_the_covariance_is_honest_for_the_noise_that_it_assumes():
    runs, n = 300, 400
    rng = np.random.default_rng(8)
    settings = {
        "gyro_noise_sd": 0.01,
        "accel_noise_sd": 0.1,
        "acceleration_memory": 0.0,
        "initial_tilt_sd": 0.03,
    }
    nees, spread = 0.0, []
    for _ in range(runs):
        x, y = 0.03 * rng.normal(size=2)
        tilt = TiltKalman(**settings)
        tilt.reset(Alignment(up=tuple(np.array([x, y, 1.0]) / np.sqrt(1 + x * x + y * y))))
        accel = STANDARD_GRAVITY * np.array([0, 0, 1.0]) + 0.1 * rng.normal(size=(n, 3))
        run = tilt.run(np.arange(n) * 0.02, accel, 0.01 * rng.normal(size=(n, 3)))
        error = run.up[-1, :2]
        nees += error @ np.linalg.solve(tilt.P[:2, :2], error)
        spread.append(run.acceleration[-1] / run.acceleration_sd[-1])
    low, high = chi2.ppf([0.005, 0.995], 2 * runs)
    assert low < nees < high
    low, high = chi2.ppf([0.005, 0.995], runs)
    assert low < np.sum(np.square(spread)) < high


def test_after_a_gap_the_tilt_is_levelled_anew_and_the_covariance_is_sound():
    t, accel, gyro, up = spin(turns_hz=0.2, lever=0.0)
    t = np.where(t > 3, t + 1000.0, t)
    tilt = TiltKalman()
    run = tilt.run(t, accel, gyro)
    assert np.degrees(angle_between(run.up, up)).max() < 1e-6  # there is no acceleration to mislead it
    np.testing.assert_allclose(tilt.P, tilt.P.T, atol=1e-18)
    assert np.linalg.eigvalsh(tilt.P).min() > -1e-18  # positive semidefinite, up to rounding


def test_an_acceleration_makes_the_next_sample_count_less():
    def correction(push):
        tilt = TiltKalman()
        tilt.step(dt=0.02, accel=np.array([0.0, 0.0, STANDARD_GRAVITY + push]), gyro=np.zeros(3))
        return tilt.step(dt=0.02, accel=np.array([0.5, 0.0, STANDARD_GRAVITY]), gyro=np.zeros(3)).up[0]

    assert 0 < correction(5.0) < 0.2 * correction(0.0)


def test_it_is_a_filterpy_filter_whose_history_can_be_saved():
    _, accel, gyro = rough(40)
    tilt = TiltKalman()
    assert isinstance(tilt, KalmanFilter)
    saver = Saver(tilt)
    for k in range(40):
        (tilt.step if k % 2 else tilt.step_by_filterpy)(dt=0.02, accel=accel[k], gyro=gyro[k])
        saver.save()
    saver.to_array()
    assert saver.x.shape == (40, 3)
    np.testing.assert_array_equal(saver.x, saver.x_post)
    np.testing.assert_allclose(np.linalg.norm(saver.x, axis=1), 1, atol=1e-14)


def test_an_unknown_transition_is_refused():
    with pytest.raises(ValueError, match="'euler' is unknown; choose 'exponential' or 'first-order'"):
        TiltKalman(transition="euler")


class TestTiltKalmanKeepsTheContract(AttitudeEstimatorContract):
    def make(self):
        return TiltKalman()
