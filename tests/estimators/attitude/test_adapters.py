"""VQF and Fusion behind our interface, and all attitude filters beside VQF on real recordings."""

import copy
import pickle
import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.estimators.attitude.accelerometer_norm import AccelerometerNorm
from baroarma.estimators.attitude.adapters import ImufusionAttitude, VqfAttitude
from baroarma.estimators.attitude.alignment import align
from baroarma.estimators.attitude.quaternion_ekf import QuaternionEkf
from baroarma.estimators.attitude.tilt_kalman import TiltKalman
from baroarma.estimators.base import Alignment
from baroarma.rotation import angle_between
from baroarma.testing import AttitudeEstimatorContract

PACKAGES = {VqfAttitude: "vqf", ImufusionAttitude: "imufusion"}

# What `rocking` (at most 1 rad/s, 20 ms on average) may cost, rad.  VQF gets exact angles; its own estimate
# of gyro bias adds some 1e-6, while uncorrected intervals would add 1e-3 in a single step.  Fusion compares
# the force with the attitude of one sample earlier and so settles up to 1 rad/s times 20 ms ahead.
ALLOWED = {VqfAttitude: 1e-4, ImufusionAttitude: 0.02}


@pytest.fixture(params=list(PACKAGES), ids=list(PACKAGES.values()))
def adapter(request):
    pytest.importorskip(PACKAGES[request.param], exc_type=ImportError)
    return request.param


def rocking(t, mount=None):
    """A turn to and fro by 1 rad about x with the accelerometer in the axis: specific force is gravity only.

    The gyro gives the mean rate since the previous sample, as an integrating one does.
    """
    angle = 1 - np.cos(np.clip(t - 1, 0, None))
    up = np.column_stack([0 * t, np.sin(angle), np.cos(angle)])
    rate = np.append(0.0, np.diff(angle) / np.diff(t))
    turn = np.eye(3) if mount is None else mount.as_matrix()
    gyro = np.column_stack([rate, 0 * t, 0 * t])
    return t, STANDARD_GRAVITY * up @ turn.T, gyro @ turn.T, up @ turn.T


def jittery(n=1500, seed=1):
    return np.cumsum(np.random.default_rng(seed).uniform(0.004, 0.036, n))


def test_the_angle_turned_is_right_in_every_mounting_and_rhythm(adapter):
    for mount in Rotation.random(4, rng=1):
        t, accel, gyro, up = rocking(jittery(), mount)
        estimator = adapter()
        estimator.reset(align(t, accel, gyro + 0.02))
        run = estimator.run(t, accel, gyro + 0.02)
        assert angle_between(run.up, up).max() < ALLOWED[adapter]
        # g (1 - cos error), and rounding in single precision
        assert np.abs(run.acceleration).max() < STANDARD_GRAVITY * (ALLOWED[adapter] ** 2 / 2 + 1e-6)


def test_an_alignment_upside_down_is_taken_over_at_once(adapter):
    estimator = adapter()
    estimator.reset(Alignment(up=(0.0, 0.0, -1.0), gravity=9.9))
    pushed = np.array([3.0, 0.0, -9.9])  # 17° off: the start is the alignment's, not this sample's
    state = estimator.step(dt=0.02, accel=pushed, gyro=np.zeros(3))
    # in one sample of 20 ms the slower of the two, Fusion with gain 0.5, may turn by 0.5 sin(17°) 0.02 rad
    assert angle_between(state.up, [0, 0, -1]) < 0.5 * 0.29 * 0.02 * 1.1
    assert state.acceleration == pytest.approx(0, abs=3.0 * 0.003)


def test_the_run_is_the_step_repeated_with_gaps_and_missing_samples(adapter):
    rng = np.random.default_rng(3)
    t, accel, gyro, _ = rocking(jittery(600))
    t[300:] += 3.0
    accel = accel + 0.3 * rng.normal(size=accel.shape)
    accel[rng.random(600) < 0.2] = np.nan
    gyro[rng.random(600) < 0.2] = np.nan
    gyro[100:160] = np.nan
    one, all_ = adapter(), adapter()
    run = all_.run(t, accel, gyro)
    dt = np.diff(t, prepend=t[0] - 99.0)  # the first interval has no effect
    states = [one.step(dt=dt[k], accel=accel[k], gyro=gyro[k]) for k in range(600)]
    for by_step, column in zip(zip(*states, strict=True), run, strict=True):
        np.testing.assert_allclose(column, np.array(by_step), rtol=0, atol=1e-9)
    np.testing.assert_array_equal(np.isnan(run.acceleration), np.isnan(accel[:, 0]))
    assert np.isfinite(run.up).all()


def test_after_a_gap_the_tilt_is_levelled_anew(adapter):
    t, accel, gyro, up = rocking(jittery())
    gap = (t > 5) & (t < 7.5)
    run = adapter().run(t[~gap], accel[~gap], gyro[~gap])
    assert angle_between(run.up, up[~gap]).max() < ALLOWED[adapter]


def test_a_copy_and_a_saved_one_go_on_with_the_same_numbers(adapter):
    rng = np.random.default_rng(4)
    t, accel, gyro, _ = rocking(jittery(400))
    accel = accel + 0.3 * rng.normal(size=accel.shape)
    first = adapter()
    first.run(t[:200], accel[:200], gyro[:200])
    others = [copy.deepcopy(first), pickle.loads(pickle.dumps(first))]
    expected = first.run(t[200:], accel[200:], gyro[200:])
    for other in others:
        for column, again in zip(expected, other.run(t[200:], accel[200:], gyro[200:]), strict=True):
            np.testing.assert_array_equal(again, column)


def test_the_sd_is_tilt_times_horizontal_force_plus_noise(adapter):
    estimator = adapter(accel_noise_sd=0.1, tilt_sd=0.05)
    accel = np.array([2.0, 0.0, 9.0])
    state = estimator.step(dt=0.02, accel=accel, gyro=np.zeros(3))
    horizontal = np.linalg.norm(accel - (accel @ state.up) * state.up)
    assert state.acceleration_sd == pytest.approx(np.hypot(0.05 * horizontal, 0.1), rel=1e-6)


def test_a_missing_package_is_a_sentence_with_its_remedy(adapter, monkeypatch):
    name = PACKAGES[adapter]
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ValueError, match=rf"needs the package {name}.*pip install 'baroarma\[{name}\]'"):
        adapter()


def test_the_settings_reach_the_libraries():
    pytest.importorskip("vqf", exc_type=ImportError)
    assert VqfAttitude(rate_hz=90, time_constant=2.5)._filter.params["tauAcc"] == 2.5
    assert VqfAttitude(rate_hz=90)._filter.coeffs["gyrTs"] == 1 / 90
    pytest.importorskip("imufusion", exc_type=ImportError)
    leaning, still = np.array([3.0, 0.0, 9.0]), np.zeros(3)
    turned = []
    for gain in (0.5, 1.0):
        estimator = ImufusionAttitude(gain=gain)
        for _ in range(2):
            state = estimator.step(dt=0.02, accel=leaning, gyro=still)
        turned.append(float(angle_between(state.up, [0, 0, 1])))
    assert turned[1] == pytest.approx(2 * turned[0], rel=0.02)  # it pulls with the gain times the angle left


def stampfly(folder):
    data = np.genfromtxt(folder / "stampfly_tof_handheld" / "tilt_e.csv.gz", delimiter=",", skip_header=1)
    return data[:, 0], np.ascontiguousarray(data[:, 1:4]), np.ascontiguousarray(data[:, 4:7])


def elevator(folder):
    """The two streams of the elevator ride on one clock, NaN where the other sensor has a sample."""
    streams = [
        np.genfromtxt(
            folder / "srp_altimu10_elevator_rocket" / f"elevator_{s}.csv.gz", delimiter=",", skip_header=1
        )
        for s in ("acc", "gyr")
    ]
    t = np.union1d(streams[0][:, 0], streams[1][:, 0])
    accel, gyro = np.full((2, len(t), 3), np.nan)
    for rows, stream in zip((accel, gyro), streams, strict=True):
        rows[np.searchsorted(t, stream[:, 0])] = stream[:, 1:]
    return t, accel, gyro


@pytest.mark.parametrize("recording", [stampfly, elevator])
@pytest.mark.parametrize("estimator", [QuaternionEkf, TiltKalman, ImufusionAttitude])
def test_on_real_recordings_all_filters_agree_with_vqf(recording, estimator, shared_data):
    """Filters differ by what they take for gravity: the horizontal acceleration, more or less averaged.

    The rms of that, as an angle, is what the accelerometer alone is off by (2.6° and 4.8° here); a filter
    that uses the gyro must halve it.  In one moment it may be off by no more than SG14's gate lets through,
    asin(150 mg) = 8.6°.
    """
    for package in PACKAGES.values():
        pytest.importorskip(package, exc_type=ImportError)
    t, accel, gyro = recording(shared_data)
    start = align(t, accel, gyro)
    runs = {}
    for other in (VqfAttitude(rate_hz=(len(t) - 1) / (t[-1] - t[0])), estimator(), AccelerometerNorm()):
        other.reset(start)
        runs[type(other)] = other.run(t, accel, gyro)
    vqf = runs[VqfAttitude]
    assert angle_between(vqf.up, start.up).max() > 0.6  # there is something to follow: 36° and 96°
    off, alone = (np.degrees(angle_between(runs[kind].up, vqf.up)) for kind in (estimator, AccelerometerNorm))
    assert np.sqrt(np.mean(off**2)) < 0.5 * np.sqrt(np.mean(alone**2))
    assert off.max() < 8.6


class TestVqfKeepsTheContract(AttitudeEstimatorContract):
    def make(self):
        pytest.importorskip("vqf", exc_type=ImportError)
        return VqfAttitude()


class TestImufusionKeepsTheContract(AttitudeEstimatorContract):
    def make(self):
        pytest.importorskip("imufusion", exc_type=ImportError)
        return ImufusionAttitude()
