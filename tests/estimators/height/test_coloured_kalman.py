"""`coloured-kalman` against the dense joint Gaussian, and the four ways to treat coloured noise."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.stats import chi2

from baroarma import NoiseModel
from baroarma.estimators import height_estimator
from baroarma.estimators.base import Alignment
from baroarma.estimators.height.coloured_kalman import ColouredKalman
from baroarma.testing import HeightEstimatorContract

spec = importlib.util.spec_from_file_location("dense", Path(__file__).with_name("dense.py"))
dense = importlib.util.module_from_spec(spec)
spec.loader.exec_module(dense)

SG13 = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
DRIFTING = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, drift_rate=0.01, rate_hz=50)
NO_GM = NoiseModel(correlated_sd=0, correlation_time=0, white_sd=0.46, drift_rate=0.01, rate_hz=50)
PURE_GM = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0, rate_hz=50)


class TestContract(HeightEstimatorContract):
    def make(self):
        return height_estimator("coloured-kalman", noise=DRIFTING)


class TestContractWithoutGaussMarkov(HeightEstimatorContract):
    def make(self):
        return height_estimator("coloured-kalman", noise=NO_GM, zupt_steps=2, zupt_threshold=0.5)


@pytest.mark.parametrize("smooth", [False, True])
def test_it_is_the_dense_solution_of_the_same_joint_gaussian(smooth):
    rng = np.random.default_rng(0)
    t = np.cumsum(rng.uniform(0.01, 0.2, 60))
    z, a = rng.normal(size=60), rng.normal(size=60)
    z[rng.random(60) < 0.3] = np.nan
    z[20:30] = np.nan
    sd = rng.uniform(0.1, 0.5, 60)
    kf = ColouredKalman(
        noise=DRIFTING,
        dt=0.02,
        bias_sd=0.3,
        bias_walk=0.05,
        offset_sd=2.0,
        initial_height_sd=0.5,
        unresolved=0.0,
        gate=np.inf,
    )
    result = (kf.smooth if smooth else kf.run)(t, z, a, sd)
    expected = dense.solve(
        t,
        z,
        (a[:-1] + a[1:]) / 2,
        DRIFTING,
        smooth=smooth,
        acceleration_sd=sd[1:],
        height_sd=0.5,
        velocity_sd=0.1,
        bias_sd=0.3,
        bias_walk=0.05,
        offset_sd=2.0,
    )
    np.testing.assert_allclose(result, expected, rtol=0, atol=1e-9)  # condition ~1e4 of 60 equations


def test_a_wide_prior_of_the_offset_makes_the_level_of_the_barometer_irrelevant():
    rng = np.random.default_rng(1)
    t, a = np.arange(500) / 50, rng.normal(size=500)
    z = DRIFTING.simulate(t, rng)
    low, high = (height_estimator("coloured-kalman", noise=DRIFTING).run(t, z + level, a) for level in (0, 5))
    # a prior of 100 m against an altitude known to 0.5 m pulls 5 m by (0.5/100)² of it
    assert np.abs(high.height - low.height).max() < 5 * (0.5 / 100) ** 2


def test_with_drift_the_variance_of_the_height_grows_as_the_drifts_and_without_it_stays():
    growth = []
    for noise in (DRIFTING, SG13):
        t = np.arange(0, 600, 0.1)
        run = ColouredKalman(noise=noise, dt=0.1).run(t, np.zeros(len(t)), np.zeros(len(t)))
        growth.append(run.height_sd[-1] ** 2 - run.height_sd[len(t) // 2] ** 2)
    # 300 s of drift; what hasn't settled by then is far below 1 %
    assert growth[0] == pytest.approx(DRIFTING.drift_rate**2 * 300, rel=0.01)
    assert abs(growth[1]) < 0.01 * growth[0]


def test_without_gauss_markov_noise_there_is_no_state_and_it_says_so():
    kf = height_estimator("coloured-kalman", noise=NO_GM)
    assert kf.states == ("height", "velocity", "acceleration_bias", "offset")
    assert "no Gauss-Markov" in kf.note
    assert height_estimator("coloured-kalman", noise=SG13).note == ""


def test_without_a_noise_model_it_says_what_to_do():
    with pytest.raises(ValueError, match="'coloured-kalman' needs a noise model: identify one"):
        height_estimator("coloured-kalman", dt=0.02)


KNOWN = {"bias_sd": 0.0, "bias_walk": 0.0, "offset_sd": 0.0, "midpoint": False, "acceleration_sd": 0.05}
WAYS = {
    "white": ("kalman", {"acceleration_sd": 0.05}),
    "inflated": ("kalman", {"acceleration_sd": 0.05, "correlation": "inflate"}),
    "differenced": ("differenced-kalman", {**KNOWN, "carry_white": False}),
    "augmented": ("coloured-kalman", KNOWN),
}


def consistency(way, noise, runs=100, rows=1000, rows_of_nis=100):
    """Return mean NEES of height and velocity at the end of the runs, and mean NIS of their first rows."""
    name, settings = WAYS[way]
    kf = height_estimator(name, noise=noise, **settings)
    rng = np.random.default_rng(0)
    t, nees, nis = np.arange(rows) / 50, [], []
    for _ in range(runs):
        # at rest but for the initial state and the noise of the filter's own model
        h0, v0 = rng.normal(scale=[1e-3, 0.1])
        a = rng.normal(scale=0.05, size=rows)
        true_v = v0 + np.concatenate([[0], np.cumsum(-a[:-1]) / 50])
        true_h = h0 + np.concatenate([[0], np.cumsum((true_v[1:] + true_v[:-1]) / 2) / 50])
        z = true_h + noise.simulate(t, rng)
        kf.reset()
        for k in range(rows_of_nis):
            if k:
                kf.predict()
            kf.update(z[k])
            nis.append(kf.mahalanobis**2)
        kf.reset()
        kf.run(t, z, np.zeros(rows))
        error = kf.x[:2, 0] - [true_h[-1], true_v[-1]]
        nees.append(error @ np.linalg.solve(kf.P[:2, :2], error))
    return np.mean(nees), np.mean(nis)


def band(mean, count, degrees, tests=1):
    """Whether the mean of `count` chi² variables of so many degrees of freedom lies in its 95 % band.

    The band is that of so many independent tests together.
    """
    low, high = chi2.ppf([0.025 / tests, 1 - 0.025 / tests], count * degrees) / count
    return low < mean < high


def test_in_sg13_noise_only_the_augmented_filter_knows_its_error():
    results = {way: consistency(way, SG13) for way in WAYS}
    nees, nis = results["augmented"]
    assert band(nees, 100, 2)
    assert band(nis, 100 * 100, 1)
    outside = [
        way for way, (nees, nis) in results.items() if not (band(nees, 100, 2) and band(nis, 100 * 100, 1))
    ]
    assert outside == ["white", "inflated", "differenced"]


def test_in_pure_gauss_markov_noise_the_differenced_filter_knows_its_error_too():
    for way in ("differenced", "augmented"):
        nees, nis = consistency(way, PURE_GM)
        assert band(nees, 100, 2)
        assert band(nis, 100 * 100, 1)


def continuous(lag):
    """Return A of x' = A x with x = [height, velocity, bias, low-passed height, offset, correlated, u]."""
    A = np.zeros((7, 7))
    A[0, 1], A[1, 2], A[1, 6] = 1.0, -1.0, 1.0
    A[3, 0], A[3, 3] = 1 / lag, -1 / lag
    A[5, 5] = -1 / DRIFTING.correlation_time
    return A


@pytest.mark.parametrize("lag", [0.02, 0.2, 5.0])
@pytest.mark.parametrize("dt", [1e-3, 0.02, 1.0])
def test_a_late_barometer_is_the_matrix_exponential_of_the_low_pass_behind_the_motion(lag, dt):
    kf = ColouredKalman(noise=DRIFTING, dt=0.02, barometer_lag=lag)
    assert kf.states[3] == "low_passed"
    exact = expm(continuous(lag) * dt)
    # where dt is short against the lag, dt²/2 - lag dt + lag² (1 - exp(-dt/lag)) loses lag²/dt³ of its digits
    np.testing.assert_allclose(kf.transition(dt), exact[:6, :6], rtol=1e-9, atol=1e-15 * lag**2)
    np.testing.assert_allclose(kf.input_matrix(dt)[:, 0], exact[:6, 6], rtol=1e-9, atol=4e-15 * lag**2)


def test_a_late_barometers_filter_is_a_plain_kalman_filter_of_the_exact_matrices():
    rng = np.random.default_rng(2)
    lag, n = 0.15, 200
    t = np.cumsum(rng.uniform(0.01, 0.05, n))
    z, a = rng.normal(size=n), rng.normal(size=n)
    z[rng.random(n) < 0.3] = np.nan
    sds = {"bias_sd": 0.3, "bias_walk": 0.05, "offset_sd": 2.0, "acceleration_sd": 0.2}
    kf = ColouredKalman(noise=DRIFTING, dt=0.02, barometer_lag=lag, unresolved=0.0, gate=np.inf, **sds)
    found = kf.run(t, z, a)
    P = np.diag([1e-3, 0.1, 0.3, 1e-3, 2.0, 0.27]) ** 2
    P[0, 3] = P[3, 0] = 1e-6  # the same height
    x, h, rows = np.zeros(6), np.array([0.0, 0, 0, 1, 1, 1]), []
    for k in range(n):
        if k:
            dt = t[k] - t[k - 1]
            E = expm(continuous(lag) * dt)
            F, B = E[:6, :6], E[:6, 6]
            x = F @ x + B * (a[k] + a[k - 1]) / 2
            correlated = 0.27**2 * (1 - np.exp(-2 * dt / 0.75))
            Q = np.diag([0, 0, 0.05**2 * dt, 0, DRIFTING.drift_rate**2 * dt, correlated])
            P = F @ P @ F.T + Q + 0.2**2 * np.outer(B, B)
        if np.isfinite(z[k]):
            gain = P @ h / (h @ P @ h + DRIFTING.white_sd**2)
            x, P = x + gain * (z[k] - h @ x), P - np.outer(gain, h @ P)
        rows.append([*x[:2], *np.sqrt(np.diag(P)[:2])])
    np.testing.assert_allclose(
        found, np.transpose(rows), rtol=0, atol=1e-9
    )  # Joseph against plain, 1e4 apart


def test_a_barometer_without_lag_is_the_limit_of_a_short_one():
    rng = np.random.default_rng(3)
    t, a = np.arange(500) / 50, rng.normal(size=500)
    z = DRIFTING.simulate(t, rng)
    without, short = (
        ColouredKalman(noise=DRIFTING, dt=0.02, barometer_lag=lag).run(t, z, a) for lag in (0.0, 1e-6)
    )
    # a microsecond at speeds of a few m/s
    np.testing.assert_allclose(short, without, rtol=0, atol=1e-5)


def test_what_it_reports_is_what_linear_trials_of_its_own_model_have():
    noise, runs, dt = DRIFTING.at_rate(10), 400, 0.1
    rng, t = np.random.default_rng(0), np.arange(0, 180, 0.1)
    sds = {"bias_sd": 0.03, "bias_walk": 3e-4, "offset_sd": 1.0, "acceleration_sd": 0.03}
    kf = ColouredKalman(
        noise=noise, dt=dt, midpoint=False, confirm_rest=False, gate=np.inf, unresolved=0.0, **sds
    )
    errors, nees, at = [], [], [10, 100, 600, 1799]
    for _ in range(runs):
        v0, bias, offset = rng.normal(scale=[0.1, 0.03, 1.0])
        biases = bias + 3e-4 * np.cumsum(np.sqrt(dt) * rng.normal(size=len(t)))
        felt = biases + 0.03 * rng.normal(size=len(t))  # of a body that moves with v0
        height = v0 * t + 1e-3 * rng.normal()
        kf.reset()
        found = kf.run(t, height + offset + noise.simulate(t, rng), felt)
        errors.append([found.height - height, found.velocity - v0])
    errors = np.array(errors)
    sd = np.array([found.height_sd, found.velocity_sd])  # the same in all runs
    for k in (0, 1):
        # 400 runs whose errors keep for a minute or so: 1/sqrt(2 x 400 x 3) = 2 % of the rms
        assert np.sqrt(np.mean(errors[:, k] ** 2)) == pytest.approx(np.sqrt(np.mean(sd[k] ** 2)), rel=0.05)
        for when in at:
            assert band(np.mean((errors[:, k, when] / sd[k, when]) ** 2), runs, 1, tests=12)
    for when in at:
        kf.reset()
        kf.run(t[: when + 1], np.zeros(when + 1), np.zeros(when + 1))
        P, e = kf.P[:2, :2], errors[:, :, when]
        nees.append(np.mean(np.sum(e * np.linalg.solve(P, e.T).T, axis=1)))
    assert all(band(mean, runs, 2, tests=12) for mean in nees)


def test_the_alignments_noise_counts_until_the_next_reset():
    kf = ColouredKalman(noise=DRIFTING, dt=0.02)
    before = kf.acceleration_sd, kf.bias_sd, kf.Q.copy(), kf.P.copy()
    kf.reset(Alignment(gravity=9.9, accel_sd=0.1, gravity_sd=0.02))
    assert kf.acceleration_sd == 0.1
    assert kf.bias_sd == pytest.approx(np.hypot(0.03, 9.9 - 9.80665))
    assert kf.Q[1, 1] == pytest.approx(0.1**2 * 0.02**2)
    kf.reset()
    assert (kf.acceleration_sd, kf.bias_sd) == before[:2]
    np.testing.assert_array_equal(kf.Q, before[2])
    np.testing.assert_array_equal(kf.P, before[3])


def test_what_the_user_says_beats_the_alignment_zeros_included():
    kf = ColouredKalman(noise=DRIFTING, dt=0.02, acceleration_sd=0.0, bias_sd=0.0)
    for alignment in (None, Alignment(accel_sd=0.1, gravity_sd=0.02)):
        kf.reset(alignment)
        assert (kf.acceleration_sd, kf.bias_sd) == (0.0, 0.0)
    kf.reset()
    assert kf.P[2, 2] == 0.0
