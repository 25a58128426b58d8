"""Our tilt filter: step = run = filterpy, and a tilt that survives squats, rods, rides, falls and gaps."""

import math

import numpy as np
import pytest
from filterpy.common import Saver
from filterpy.kalman import KalmanFilter
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from baroarma.atmosphere import STANDARD_GRAVITY as G
from baroarma.estimators import attitude_estimator
from baroarma.estimators.attitude.alignment import align
from baroarma.estimators.attitude.robust import ACCEL_NOISE_SD, GYRO_NOISE_SD, RobustAttitude
from baroarma.estimators.attitude.robust_kernels import ROUNDING, UNUSUAL, VELOCITY_VARIANCE, WAY
from baroarma.estimators.base import UNSEEN_WALK, Alignment
from baroarma.noise_model import NoiseModel
from baroarma.rotation import angle_between, up_from_quaternion
from baroarma.simulation import simulate
from baroarma.simulation.motions import move
from baroarma.testing import AttitudeEstimatorContract

UP = np.array([0.0, 0.0, 1.0])


def ideal(motion, duration=60.0, seed=1, **options):
    """A motion as ideal sensors see it at 50 Hz: t, accel, gyro, true vertical."""
    truth = move(motion, np.arange(0, duration, 0.02), np.random.default_rng(seed), **options)
    return truth.t, truth.force, truth.rate, up_from_quaternion(truth.attitude)


def still(duration, seed=1, sideways=None):
    """A level sensor of method.md's noise at rest, or pushed sideways (m/s², function of time)."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, duration, 0.02)
    accel = G * UP + rng.normal(scale=0.025, size=(len(t), 3))
    if sideways is not None:
        accel[:, 0] += sideways(t)
    return t, accel, rng.normal(scale=math.radians(0.15), size=(len(t), 3))


def rough(n=1500, seed=2):
    """Jittery times with a gap of 3 s, and missing samples of both sensors."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.004, 0.04, n))
    t[n // 2 :] += 3.0
    accel = Rotation.random(rng=rng).apply([0.0, 0.0, 9.8]) + rng.normal(size=(n, 3))
    gyro = np.cumsum(rng.normal(size=(n, 3)), axis=0) / 30
    accel[rng.random(n) < 0.15, 2] = np.nan
    accel[n // 8 : n // 8 + 60] = np.nan  # more than a second
    gyro[rng.random(n) < 0.15] = np.nan
    gyro[n // 4 : n // 4 + 60] = np.nan
    return t, accel, gyro


def tracked(t, accel, gyro, **settings):
    """The filter after its run from the alignment of the first second, and the run."""
    tilt = RobustAttitude(**settings)
    tilt.reset(align(t, accel, gyro))
    return tilt, tilt.run(t, accel, gyro)


def two_seconds(motion):
    """A levelling's rows out of a motion, and the alignment that knows the tilt before them."""
    t, accel, gyro, up = ideal(motion, duration=10.0)
    rows = slice(300, 401)
    return (t[rows], accel[rows], gyro[rows]), Alignment(up=tuple(up[300]))


def levelled(samples, start, **settings):
    tilt = RobustAttitude(**settings)
    tilt.reset(start)
    tilt.run(*samples)
    return tilt


def unlevelled(samples, start, *, state=0, change=0.0):
    """The pure strapdown, with one of its estimates changed before."""
    tilt = RobustAttitude(interval=1e9)
    tilt.reset(start)
    tilt.estimate[state] += change
    tilt.run(*samples)
    return tilt


def test_the_run_is_the_step_repeated_with_gaps_and_missing_samples():
    t, accel, gyro = rough()
    one, all_ = RobustAttitude(), RobustAttitude()
    run = all_.run(t, accel, gyro)
    dt = np.diff(t, prepend=t[0] - 99.0)  # the first interval has no effect
    states = [one.step(dt=dt[k], accel=accel[k], gyro=gyro[k]) for k in range(len(t))]
    for by_step, column in zip(zip(*states, strict=True), run, strict=True):
        np.testing.assert_allclose(column, np.array(by_step), rtol=0, atol=1e-12)  # rounding
    np.testing.assert_allclose(all_.P, one.P, rtol=0, atol=1e-12 * all_.P.max())


def test_a_levelling_is_filterpys_update_and_predict():
    samples, start = two_seconds("walk")
    before, after = unlevelled(samples, start), levelled(samples, start)
    oracle = KalmanFilter(dim_x=10, dim_z=2)
    oracle.x, oracle.P = np.zeros(10), before.P.copy()
    oracle.F, oracle.Q, oracle.H, oracle.R = after.F, after.Q, after.H, after.R
    oracle.update(-before.sums[WAY : WAY + 2] / before.age[2])
    oracle.predict()
    assert np.abs(oracle.x).max() > 1e-3  # there was something to correct
    np.testing.assert_allclose(after.x, oracle.x, rtol=0, atol=1e-9)
    np.testing.assert_allclose(after.P, oracle.P, rtol=0, atol=1e-9)
    np.testing.assert_allclose(after.estimate, before.estimate + oracle.x[2:], rtol=0, atol=1e-9)


@pytest.mark.parametrize("state", range(4, 10))
def test_the_transition_is_the_strapdown_differentiated(state):
    samples, start = two_seconds("squat")  # its only force is vertical: heading, which F lacks, plays no part
    small = 1e-6
    plain, bent = unlevelled(samples, start), unlevelled(samples, start, state=state - 2, change=small)
    level = levelled(samples, start)
    tilt = (Rotation.from_quat(bent.q) * Rotation.from_quat(plain.q).inv()).as_rotvec()[:2] / small
    velocity = (bent.estimate[:2] - plain.estimate[:2]) / small
    mean = (bent.sums[WAY : WAY + 2] - plain.sums[WAY : WAY + 2]) / small / plain.age[2]
    for found, expected in ((level.F[:2], tilt), (level.F[2:4], velocity), (level.H, mean)):
        scale = np.abs(found[:, 4:]).max()
        # each of the two integrals is a sum over 100 rows, half a row or a whole one late
        np.testing.assert_allclose(found[:, state], expected, rtol=0, atol=0.03 * scale)


def test_any_mounting_gives_the_same_acceleration():
    log = simulate("walk", duration=40, seed=3)
    _, expected = tracked(log.t, log.accel, log.gyro, scale_sd=0.0)
    accel, gyro = np.array(log.accel), np.array(log.gyro)
    for mount in Rotation.random(5, rng=5):
        _, run = tracked(log.t, mount.apply(accel), mount.apply(gyro), scale_sd=0.0)
        np.testing.assert_allclose(run.acceleration, expected.acceleration, atol=1e-9)
        np.testing.assert_allclose(run.acceleration_sd, expected.acceleration_sd, atol=1e-9)
        np.testing.assert_allclose(run.up, mount.apply(expected.up), atol=1e-9)


def test_axes_may_be_swapped_though_each_has_a_scale():
    # a scale belongs to an axis, so that with it only the turns of a cube leave everything as it was
    log = simulate("circle", duration=30, seed=3, device="wimu")
    _, expected = tracked(log.t, log.accel, log.gyro)
    accel, gyro = np.array(log.accel), np.array(log.gyro)
    for mount in list(Rotation.create_group("O"))[1:24:5]:
        _, run = tracked(log.t, mount.apply(accel), mount.apply(gyro))
        np.testing.assert_allclose(run.acceleration, expected.acceleration, atol=1e-8)  # of up to 5 m/s²


def test_the_covariance_is_honest_for_the_world_that_it_assumes():
    sd, n, runs = {"tilt_sd": 5e-3, "bias_sd": 5e-4, "gyro_noise_sd": 0.003, "velocity_sd": 1.0}, 3000, 60
    rng, t, nees = np.random.default_rng(8), np.arange(3000) * 0.02, 0.0
    for _ in range(runs):
        tilt = RobustAttitude(**sd, velocity_time=1.0, rate_error=0.0, force_error=0.0, bias_walk=0.0)
        wrong = Rotation.from_rotvec([*rng.normal(scale=sd["tilt_sd"], size=2), 0.0])
        tilt.reset(Alignment(up=tuple(wrong.apply(UP))))
        wander = NoiseModel(sd["velocity_sd"], 1.0, 0.0, rate_hz=50.0)  # Gauss-Markov, as the prior says
        velocity = np.column_stack([wander.simulate(t, rng), wander.simulate(t, rng), 0 * t])
        velocity *= -np.expm1(-t)[:, None]  # from rest
        accel = G * UP + np.diff(velocity, axis=0, prepend=0 * velocity[:1]) / 0.02
        noise = sd["gyro_noise_sd"] * rng.normal(size=(n, 3)) + sd["bias_sd"] * rng.normal(size=3)
        up = tilt.run(t, accel, noise).up[-1]  # what is up is the body's z, and the world's
        error = np.cross(up, UP)[:2]
        nees += error @ np.linalg.solve(tilt.P[:2, :2], error)
    low, high = chi2.ppf([0.005, 0.995], 2 * runs)
    assert low < nees < high


@pytest.mark.parametrize("motion", ["rest", "squat", "stairs", "walk", "lee16-e"])
def test_in_peoples_motions_its_sd_is_not_too_small(motion):
    seeds, nees = range(20), 0.0
    for seed in seeds:
        log = simulate(motion, duration=40, seed=seed)
        tilt, run = tracked(log.t, log.accel, log.gyro)
        true = Rotation.from_quat(log.reference_attitude[-1]).apply(run.up[-1])  # world axes: nearly z
        variance = tilt.P[:2, :2] + (tilt.settings.accel_bias_sd / G) ** 2 * np.eye(2)
        nees += true[:2] @ true[:2] / (np.trace(variance) / 2)
    assert nees < chi2.ppf(0.995, 2 * len(seeds))


def test_ten_squats_with_a_lean_do_not_tilt_it():
    # method.md, Sec. 3: SG14's filter is off by 7° after one and by 16° after ten
    log = simulate("squat", duration=46, seed=1, tilt=0.4, count=10)
    _, run = tracked(log.t, log.accel, log.gyro)
    error = angle_between(run.up, up_from_quaternion(log.reference_attitude))
    # the 2 mg of accelerometer bias, three sds about two axes, as the alignment sees them, and turned by 0.4
    assert error.max() < 3 * math.sqrt(2) * 2e-3 * 1.4
    true = np.gradient(log.reference_velocity, log.t)
    assert abs(np.mean((run.acceleration - true)[250:])) < 0.02  # the filter of SG14: -0.25 m/s²


@pytest.mark.parametrize("frequency", [0.25, 0.5, 0.75, 1.0, 1.25])
def test_a_rod_that_turns_for_a_minute_does_not_tilt_it(frequency):
    t, accel, gyro, up = ideal("circle", frequency_hz=frequency)
    _, run = tracked(t, accel, gyro)
    wrong = run.acceleration - (np.einsum("ij,ij->i", accel, up) - G)
    assert abs(np.mean(wrong)) < 0.02  # as an accelerometer bias of 2 mg, which height filters know
    # of the 0.05 m/s that velocity may be wrong behind it a fifth, so that it adds 2 % to the rest
    assert np.std(wrong) / (2 * math.pi * frequency) < 0.01


def test_a_gyro_scale_of_one_percent_is_learnt_from_the_first_turns():
    frequency = 1.0
    t, accel, gyro, up = ideal("circle", frequency_hz=frequency, duration=60.0)
    tilt, run = tracked(t, accel, 1.01 * gyro)
    error = angle_between(run.up, up)
    assert error.max() < 0.3  # 0.063 rad/s, unknown for the 4 s of the first levellings
    assert error[t > 30].max() < 0.02
    rate, wrong = gyro[-1], 0.01 * gyro[-1]
    explained = tilt.estimate[2:5] + tilt.estimate[5:] * 1.01 * rate
    axis = rate / np.linalg.norm(rate)
    assert explained @ axis == pytest.approx(wrong @ axis, rel=0.05)
    _, ignorant = tracked(t, accel, 1.01 * gyro, scale_sd=0.0)
    assert angle_between(ignorant.up, up)[t > 10].max() > 3 * error[t > 10].max()


def test_a_car_tilts_it_far_less_than_its_acceleration_does():
    speed, start = 15.0, 20.0
    push = speed / 6.0  # 2.5 m/s² for 6 s, two minutes at 15 m/s, 2.5 m/s² back

    def sideways(t):
        faster = (t >= start) & (t < start + 6)
        return push * faster - push * ((t >= start + 126) & (t < start + 132))

    t, accel, gyro = still(240.0, sideways=sideways)
    _, run = tracked(t, accel, gyro)
    error = angle_between(run.up, UP)
    apparent = math.atan(push / G)
    assert error.max() < apparent / 2
    assert error[t > 225].max() < 0.02  # and comes back within a quarter of a minute or so
    assert np.abs(run.acceleration - (accel[:, 2] - G)).max() < 0.1 * push


def test_a_wrong_tilt_is_found_when_the_velocity_is_absurd():
    wrong, top = 0.5, 80.0
    t, accel, gyro = still(40.0)
    tilt = RobustAttitude(top_speed=top)
    tilt.reset(Alignment(up=(0.0, math.sin(wrong), math.cos(wrong))))
    error = angle_between(tilt.run(t, accel, gyro).up, UP)
    found = top / (G * math.sin(wrong)) + 2 * tilt.settings.interval  # seconds
    assert error[t < 5].min() > 0.4
    assert error[t > found].max() < 0.02


@pytest.mark.parametrize("wrong", [2.5, math.pi])
def test_upside_down_is_found_at_the_first_levelling(wrong):
    t, accel, gyro = still(6.0)
    tilt = RobustAttitude()
    tilt.reset(Alignment(up=(0.0, math.sin(wrong), math.cos(wrong))))
    error = angle_between(tilt.run(t, accel, gyro).up, UP)
    assert error[t > tilt.settings.interval].max() < 0.01


def test_a_fall_keeps_the_tilt():
    t, accel, gyro, up = ideal("free-fall", duration=20.0)
    _, run = tracked(t, accel, gyro)
    assert angle_between(run.up, up).max() < 0.02  # 15 g in 0.1 s, seen at 50 Hz
    falling = np.linalg.norm(accel, axis=1) < 0.5
    assert falling.sum() > 20
    assert run.acceleration[falling] == pytest.approx(-G, abs=0.5)


def test_without_any_force_there_is_no_vertical_to_take_and_nothing_breaks():
    t = np.arange(0, 20, 0.02)
    accel = np.where((t < 2)[:, None], G * UP, 0.0)
    # six zeros would be a restart; after 8.5 s the tilt is lost in free fall
    gyro = np.where((t < 8)[:, None], 1e-3 * UP, np.nan)
    _, run = tracked(t, accel, gyro)
    np.testing.assert_allclose(run.up, np.tile(UP, (len(t), 1)), atol=1e-9)
    np.testing.assert_allclose(run.acceleration[t > 2], -G, atol=1e-9)


def test_after_a_gap_the_next_force_gives_the_tilt():
    t, accel, gyro, up = ideal("squat", duration=30.0)
    t = np.where(t > 12, t + 100.0, t)  # in the middle of a squat, and it goes on as if nothing had been
    tilt, run = tracked(t, accel, gyro)
    assert angle_between(run.up, up).max() < 1e-3  # its only force is vertical
    jump = int(np.argmax(np.diff(t))) + 1
    tilt, _ = tracked(t[: jump + 1], accel[: jump + 1], gyro[: jump + 1])
    assert np.sqrt(tilt.P[0, 0]) == pytest.approx(0.1)


def test_missing_gyro_samples_are_made_up_for():
    t, accel, gyro, _ = ideal("squat", duration=20.0, seed=4)
    _, expected = tracked(t[::3], accel[::3], gyro[::3])
    sparse, forces = np.full_like(gyro, np.nan), np.full_like(accel, np.nan)
    sparse[::3], forces[::3] = gyro[::3], accel[::3]
    _, run = tracked(t, forces, sparse)
    # rows without samples are as no rows, but that levellings see other means; and turns do not commute
    np.testing.assert_allclose(run.up[::3], expected.up, atol=1e-3)


def test_without_accelerometer_the_gyro_goes_on_and_the_velocity_is_doubted():
    t, accel, gyro, up = ideal("squat", duration=30.0)
    accel[(t > 10) & (t < 20)] = np.nan
    _, run = tracked(t, accel, gyro)
    assert angle_between(run.up, up).max() < 5e-3
    assert np.array_equal(np.isnan(run.acceleration), np.isnan(accel[:, 0]))
    gone = t <= 19.9
    blind, _ = tracked(t[gone], accel[gone], gyro[gone])
    assert blind.Q[2, 2] == pytest.approx(UNSEEN_WALK**2 * blind.settings.interval)


def test_whatever_comes_the_state_is_finite_and_the_covariance_sound():
    rng = np.random.default_rng(7)
    for scale in (0.0, 1.0, 160.0):
        t, accel, gyro = rough(seed=int(scale))
        accel, gyro = (
            accel + scale * rng.normal(size=accel.shape),
            gyro + scale / 5 * rng.normal(size=gyro.shape),
        )
        tilt = RobustAttitude(gyro_noise_sd=0.01)
        run = tilt.run(t, accel, gyro)
        assert np.isfinite(run.up).all()
        np.testing.assert_allclose(np.linalg.norm(run.up, axis=1), 1, atol=1e-12)
        assert np.isfinite(tilt.estimate).all()
        assert np.array_equal(tilt.P, tilt.P.T)
        assert np.linalg.eigvalsh(tilt.P).min() > -1e-12 * tilt.P.max()  # rounding


def test_latency_puts_a_turning_rods_acceleration_right_in_time():
    late, t = 0.011, np.arange(0, 40, 0.02)
    delayed = move("circle", t - late, np.random.default_rng(1), frequency_hz=1.0)
    true = move("circle", t, np.random.default_rng(1), frequency_hz=1.0).acceleration

    def error(latency):
        wrong = tracked(t, delayed.force, delayed.rate, latency=latency)[1].acceleration - true
        return np.std(wrong[t > 15])  # a mean is a bias, which height filters know

    # what stays is the outward pull in body axes, which no latency changes, and (omega late)² / 2
    assert error(late) < 0.15 * error(0.0)


def test_the_alignments_noise_is_taken_unless_it_is_set():
    noisy = Alignment(accel_sd=0.07, gyro_sd=0.01)
    tilt = RobustAttitude()
    assert (tilt.settings.accel_noise_sd, tilt.settings.gyro_noise_sd) == (ACCEL_NOISE_SD, GYRO_NOISE_SD)
    tilt.reset(noisy)
    assert (tilt.settings.accel_noise_sd, tilt.settings.gyro_noise_sd) == (0.07, 0.01)
    state = tilt.step(dt=0.02, accel=G * UP, gyro=np.zeros(3))
    assert state.acceleration_sd == pytest.approx(0.07)
    tilt = RobustAttitude(accel_noise_sd=0.05, gyro_noise_sd=0.02)
    tilt.reset(noisy)
    assert (tilt.settings.accel_noise_sd, tilt.settings.gyro_noise_sd) == (0.05, 0.02)


def test_a_velocity_beyond_three_sds_weighs_by_its_square():
    def variance(speed):
        tilt = RobustAttitude()
        tilt.estimate[0] = speed
        tilt.run(*still(2.0 + 2 * ROUNDING + 0.02)[:3])
        return tilt.R[0, 0], UNUSUAL * math.sqrt(1 + 0.1**2)

    usual, limit = variance(1.0)
    assert usual == pytest.approx(2 * 1.0**2 * 4.0 / 2.0)
    # half of the noise's own integral over 2 s: 0.025 sqrt(2 * 0.02) = 5 mm/s
    assert variance(20.0)[0] == pytest.approx(usual * (20.0 / limit) ** 2, rel=2 * 3 * 5e-3 / 20)


def test_it_is_a_filterpy_filter_by_name_whose_history_can_be_saved():
    t, accel, gyro = still(5.0)
    tilt = attitude_estimator("robust")
    assert isinstance(tilt, RobustAttitude)
    assert isinstance(tilt, KalmanFilter)
    saver = Saver(tilt)
    for k in range(len(t)):
        tilt.step(dt=0.02, accel=accel[k], gyro=gyro[k])
        saver.save()
    saver.to_array()
    assert saver.x.shape == (len(t), 10)


@pytest.mark.parametrize("name", ["interval", "velocity_sd", "velocity_time"])
def test_an_impossible_setting_is_refused(name):
    with pytest.raises(ValueError, match=f"{name} must be positive, but it is 0"):
        RobustAttitude(**{name: 0})


class TestRobustAttitudeKeepsTheContract(AttitudeEstimatorContract):
    def make(self):
        return RobustAttitude()


def spiked(signal, rows, value):
    out = signal.copy()
    out[rows] = value
    return out


def test_a_single_wild_rate_is_passed_over():
    t, accel, gyro, up = ideal("squat", duration=20.0)
    # one sample of 2000 °/s, believed, would turn by 40 degrees; passed over, the trapezoid spans 40 ms
    _, run = tracked(t, accel, spiked(gyro, slice(400, 1000, 50), [0.0, 35.0, 0.0]))
    assert angle_between(run.up, up).max() < math.radians(1)


def test_a_rate_that_is_seen_twice_is_believed():
    t, accel, gyro = still(10.0)
    turned = slice(300, 310)
    gyro[turned, 0] += math.radians(90) / 0.2  # 90 degrees in ten samples: 7.9 rad/s at once
    accel[310:] = accel[310:] @ Rotation.from_rotvec([math.radians(90), 0, 0]).as_matrix()
    _, run = tracked(t, accel, gyro)
    # late by a sample at the start and at the end, which is made up for
    assert angle_between(run.up[320], Rotation.from_rotvec([-math.radians(90), 0, 0]).apply(UP)) < 0.02


def test_shaking_is_believed_though_it_jumps_from_sample_to_sample():
    t, accel, gyro = still(20.0)
    gyro[200:, 1] += np.where(np.arange(len(t) - 200) % 2, 4.0, -4.0)  # to and fro at half the rate
    _, run = tracked(t, accel, gyro)
    # were only one half believed, it would turn by 4 rad/s; one sample's turn is 0.08 rad, either way
    assert angle_between(run.up, UP).max() < 0.2


def test_a_single_wild_force_leaves_the_velocity_alone_and_makes_it_doubtful():
    t, accel, gyro = still(10.0)
    t, accel, gyro = t[:311], accel[:311], gyro[:311]  # levelled at the 301st row
    plain, _ = tracked(t, accel, gyro)
    tilt, _ = tracked(t, spiked(accel, 305, [150.0, 0.0, 0.0]), gyro)
    # 150 m/s² over 20 ms are 3 m/s
    assert abs(tilt.estimate[0] - plain.estimate[0]) < 0.01
    grown = tilt.sums[VELOCITY_VARIANCE] - plain.sums[VELOCITY_VARIANCE]
    assert grown == pytest.approx((150 * 0.02) ** 2, rel=0.01)


def test_a_sensor_that_restarts_reads_six_zeros_and_is_not_falling():
    t, accel, gyro = still(10.0)
    off = slice(300, 320)
    _, run = tracked(t, spiked(accel, off, 0.0), spiked(gyro, off, 0.0))
    assert np.isnan(run.acceleration[off]).all()
    assert angle_between(run.up, UP).max() < math.radians(1)


@pytest.mark.parametrize("duration", [1.0, 30.0])
def test_a_tilt_taken_anew_while_walking_is_right_after_a_second(duration):
    """A single force lies askew by up to 20 degrees in a walk; the mean of a second's does not."""
    t, accel, gyro, up = ideal("walk", duration=60.0, seed=3)
    worst = []
    for start in (20.0, 21.13, 23.3):
        gone = (t > start) & (t < start + duration)
        _, run = tracked(t, accel, np.where(gone[:, None], np.nan, gyro))
        later = t > start + duration + 1.1
        worst.append(angle_between(run.up, up)[later].max())
    # a walker who turns is accelerated by 1.4 m/s² for 1.5 s
    assert max(worst) < 0.15


def stuck(t, accel, gyro, start, stop):
    """The samples of `start` s again and again until `stop`."""
    rows = (t >= start) & (t < stop)
    for samples in accel, gyro:
        samples[rows] = samples[rows][0]
    return rows


@pytest.mark.parametrize("start", [8.4, 9.0, 18.5])
def test_a_noisy_sensor_that_repeats_itself_while_it_moves_is_stuck(start):
    truth, accel, gyro, up = ideal("squat", duration=25.0, tilt=0.5)
    rng = np.random.default_rng(3)
    accel = accel + rng.normal(scale=0.025, size=accel.shape)
    gyro = gyro + rng.normal(scale=0.0026, size=gyro.shape)
    rows = stuck(truth, accel, gyro, start, start + 0.4)
    _, run = tracked(truth, accel, gyro)
    missing = np.isnan(run.acceleration)
    # the first of 20 rows is new, and five more are a tenth of a second
    assert missing.sum() == 14
    assert missing[rows][6:].all()
    # up to 1 rad/s is held for 0.4 s, and half of that is made up for by the next sample
    assert angle_between(run.up, up)[truth > start + 0.4].max() < 0.2


def test_who_repeats_itself_at_rest_is_believed():
    t, accel, gyro = still(10.0)
    stuck(t, accel, gyro, 4.0, 8.0)
    _, run = tracked(t, accel, gyro)
    assert np.isfinite(run.acceleration).all()


def test_an_ideal_sensor_may_repeat_itself_in_motion():
    t = np.arange(0, 5, 0.02)
    accel = G * UP + np.where(t > 2, 1.0, 0.0)[:, None] * UP
    _, run = tracked(t, accel, np.zeros((len(t), 3)))
    np.testing.assert_allclose(run.acceleration[t > 2.01], 1.0, atol=1e-9)
