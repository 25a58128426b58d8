"""What makes the linear filters filterpy filters: its guests accept them and its loops give our numbers."""

import warnings

import numpy as np
import pytest
from filterpy.common import Saver
from filterpy.kalman import IMMEstimator, KalmanFilter, MMAEFilterBank

from baroarma import NoiseModel
from baroarma.estimators import height_estimator
from baroarma.estimators.height.linear import steps_of, unseen_variance
from baroarma.testing import height_samples

NOISE = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, drift_rate=0.01, rate_hz=50)
NAMES = ["kalman", "coloured-kalman", "differenced-kalman"]
T = np.arange(100) / 50
Z = np.random.default_rng(0).normal(scale=0.5, size=100)


def make(name, **settings):
    return height_estimator(name, noise=NOISE, **settings)


def steps(kf, z=Z):
    """The same as a filterpy loop, by `step`: no acceleration."""
    return np.array([kf.step(dt=0.02, altitude=value, acceleration=0.0) for value in z])


@pytest.mark.parametrize("name", NAMES)
def test_predict_without_input_is_no_acceleration(name):
    kf, other = make(name), make(name)
    assert isinstance(kf, KalmanFilter)
    assert kf.B.shape == (kf.dim_x, kf.dim_u) == (len(kf.states), 1)
    kf.predict()
    other.predict(u=0.0)
    assert np.array_equal(kf.x, other.x)
    other.predict(u=2.0)
    assert other.x[1, 0] == pytest.approx(0.04)


@pytest.mark.parametrize("name", NAMES)
def test_filterpys_loop_gives_what_step_gives(name):
    kf = make(name)
    loop = []
    for k, z in enumerate(Z):
        if k:
            kf.predict()
        kf.update(z)
        loop.append([kf.x[0, 0], kf.x[1, 0]])
    # 0.02 and the differences of the clock differ in the last digit
    np.testing.assert_allclose(loop, steps(make(name))[:, :2], atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_saver_saves_it(name):
    kf = make(name)
    saver = Saver(kf)
    for z in Z[:10]:
        kf.predict()
        kf.update(z)
        saver.save()
    kf.step(dt=0.02, altitude=np.nan, acceleration=0.0, at_rest=True)
    saver.save()
    saver.to_array()
    assert saver.x.shape == (11, kf.dim_x, 1)
    assert np.array_equal(saver.x[-1], kf.x)


@pytest.mark.parametrize("name", NAMES)
def test_batch_filter_and_rts_smoother_give_what_run_and_smooth_give(name):
    kf = make(name)
    kf.update(Z[0])
    first = kf.x.copy(), kf.P.copy()
    means, covariances, _, _ = kf.batch_filter(Z[1:])
    assert kf.x.shape == (kf.dim_x, 1)
    run = make(name).run(T, Z, np.zeros(100))
    np.testing.assert_allclose(means[:, 0, 0], run.height[1:], atol=1e-9)
    means = np.concatenate([[first[0]], means])
    covariances = np.concatenate([[first[1]], covariances])
    smooth = make(name).smooth(T, Z, np.zeros(100))
    x, P, _, _ = kf.rts_smoother(means, covariances)
    # filterpy inverts predicted covariances of condition ~1e12 (offset 1e4 m² against height 1e-6 m²)
    np.testing.assert_allclose(smooth.height, x[:, 0, 0], atol=1e-5)
    np.testing.assert_allclose(smooth.height_sd, np.sqrt(P[:, 0, 0]), atol=1e-5)


@pytest.mark.parametrize("name", NAMES)
def test_imm_without_switching_weighs_two_tunings_by_their_likelihoods(name):
    imm = IMMEstimator([make(name), make(name, acceleration_sd=5.0)], mu=[0.5, 0.5], M=np.eye(2))
    alone = [make(name), make(name, acceleration_sd=5.0)]
    log_likelihoods = np.zeros(2)
    for z in Z[:30]:
        imm.predict()
        imm.update(z)
        for i, kf in enumerate(alone):
            kf.predict()
            kf.update(z)
            log_likelihoods[i] += kf.log_likelihood
    weights = np.exp(log_likelihoods - log_likelihoods.max())
    np.testing.assert_allclose(imm.mu, weights / weights.sum(), rtol=1e-9)
    mixture = sum(w * kf.x for w, kf in zip(imm.mu, alone, strict=True))
    np.testing.assert_allclose(imm.x, mixture, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_imm_that_switches_between_equals_is_the_one_filter(name):
    imm = IMMEstimator([make(name), make(name)], mu=[0.3, 0.7], M=np.array([[0.9, 0.1], [0.2, 0.8]]))
    alone = make(name)
    for z in Z[:30]:
        for kf in (imm, alone):
            kf.predict(u=0.5)
            kf.update(z)
    np.testing.assert_allclose(imm.x, alone.x, atol=1e-9)
    np.testing.assert_allclose(imm.P, alone.P, rtol=1e-9, atol=1e-12)


def test_mmae_bank_weighs_noise_models():
    white = NoiseModel(correlated_sd=0, correlation_time=0, white_sd=1.5, rate_hz=50)
    filters = [height_estimator("kalman", noise=noise) for noise in (NOISE, white)]
    bank = MMAEFilterBank(filters, [0.5, 0.5], dim_x=2, H=None)
    for z in NOISE.simulate(200, 3):
        bank.predict()
        bank.update(z)
    assert bank.p[0] > 0.99


@pytest.mark.parametrize("name", NAMES)
def test_mmae_bank_of_equals_is_the_one_filter(name):
    alone = make(name)
    bank = MMAEFilterBank([make(name), make(name)], [0.5, 0.5], dim_x=alone.dim_x)
    for z in Z[:30]:
        for kf in (bank, alone):
            kf.predict()
            kf.update(z)
    np.testing.assert_allclose(bank.x, alone.x, atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_smoothing_knows_more_than_filtering_and_ends_in_it(name):
    samples = {key: v for key, v in height_samples(0).items() if key not in ("accel", "gyro")}
    at_rest = np.arange(200) % 50 == 48  # over at the end: a rest's sds are those of both possibilities
    run, smooth = (getattr(make(name), method)(**samples, at_rest=at_rest) for method in ("run", "smooth"))
    assert (smooth.height_sd <= run.height_sd + 1e-9).all()
    assert smooth.height_sd.mean() < 0.9 * run.height_sd.mean()
    np.testing.assert_allclose([v[-1] for v in smooth], [v[-1] for v in run], atol=1e-12)


def test_smoothed_errors_have_the_smoothed_sd():
    rng, ratios = np.random.default_rng(4), []
    for _ in range(100):
        t = np.arange(300) / 50
        v0, bias, offset = rng.normal(scale=[0.1, 0.05, 1.0])
        a = rng.normal(scale=0.05, size=300)
        velocity = v0 + np.concatenate([[0], np.cumsum(a[:-1]) / 50])
        height = np.concatenate([[0], np.cumsum((velocity[1:] + velocity[:-1]) / 100)])
        settings = {"acceleration_sd": 0.05, "bias_walk": 0.0, "offset_sd": 1.0, "midpoint": False}
        measured = a + bias + rng.normal(scale=0.05, size=300)
        smooth = make("coloured-kalman", **settings).smooth(
            t, height + offset + NOISE.simulate(t, rng), measured
        )
        ratios.append((smooth.height - height)[150] / smooth.height_sd[150])
    # chi²/100 has sd 0.14: 3.5 of them
    assert np.mean(np.square(ratios)) == pytest.approx(1, abs=0.5)


def test_a_run_of_many_rows_is_fast_and_quiet():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        t = np.arange(100_000) / 50
        run = make("coloured-kalman").run(t, np.zeros(100_000), np.zeros(100_000))
    assert np.isfinite(run.height_sd).all()


@pytest.mark.parametrize("name", NAMES)
def test_matrices_of_many_intervals_are_those_of_each(name):
    kf, dt = make(name), np.array([0.01, 0.02, 3.1])
    for function in (kf.transition, kf.input_matrix, kf.wander, unseen_variance):
        stack = function(dt)
        for k, one in enumerate(dt):
            assert np.array_equal(stack[k], function(one))
    assert np.array_equal(kf.F, make(name).F)


def uneven_rows(n=300):
    """Intervals that all differ, some 0, some long; samples that are missing, far off, or still; turns."""
    rng = np.random.default_rng(7)
    dt = np.where(rng.random(n) < 0.05, 0.0, rng.uniform(0.001, 0.05, n))
    dt[::70] = rng.uniform(0.6, 3.0, len(dt[::70]))  # nothing is felt for so long
    z = np.where(rng.random(n) < 0.3, np.nan, rng.normal(scale=0.5, size=n) + 8.0 * (np.arange(n) > 200))
    a = np.where(rng.random(n) < 0.1, np.nan, rng.normal(scale=0.3, size=n))
    sd = np.where(rng.random(n) < 0.5, np.nan, 0.05)
    still, up = np.arange(n) % 100 > 60, rng.normal([0.0, 0.0, 1.0], 0.1, size=(n, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    return dt, z, a, sd, still, up


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("kalman", {"zupt_steps": 2, "zupt_threshold": 0.2}),
        ("coloured-kalman", {}),
        ("coloured-kalman", {"barometer_lag": 0.2}),
        ("coloured-kalman", {"level_prior_sd": 0.3, "confirm_rest": False}),
        ("coloured-kalman", {"floors": (0.0, 3.0), "offset_sd": 1.0, "rest_sd": 0.02}),
        ("differenced-kalman", {}),
    ],
    ids=["kalman", "coloured", "lagged", "level", "floors", "differenced"],
)
def test_steps_of_a_jittering_clock_are_runs_of_one_row(name, settings):
    """`step` builds its rows in plain numbers and changes its matrices in place, `run` builds arrays."""
    dt, z, a, sd, still, up = uneven_rows()
    if name == "differenced-kalman":  # where a second sample at the same instant is none
        dt = np.maximum(dt, 1e-3)
    one, many = make(name, **settings), make(name, **settings)
    stepped, run = [], []
    for k in range(len(dt)):
        sample = {"altitude": z[k], "acceleration": a[k], "acceleration_sd": sd[k]}
        stepped.append(one.step(dt=dt[k], **sample, at_rest=bool(still[k]), up=up[k]))
        rows = {key: np.array([value]) for key, value in sample.items()}
        since = dt[k] if k else 0.0  # before the first row there was none
        run.append(many.run(np.zeros(1), **rows, at_rest=still[k : k + 1], up=up[k : k + 1], dt=since))
    np.testing.assert_array_equal(stepped, np.array(run)[:, :, 0])
    np.testing.assert_array_equal(one.P, many.P)
    if name == "coloured-kalman":
        assert one.evidence == pytest.approx(many.evidence, rel=1e-9)


@pytest.mark.parametrize("name", NAMES[:2])
def test_a_step_takes_the_matrices_as_they_stand(name):
    """Whoever changes H, R, x or P of a filterpy filter means it, by `step`, too."""
    kf, same = make(name), make(name)
    for filter_ in (kf, same):
        steps(filter_, Z[:5])
        filter_.H, filter_.R = 2.0 * filter_.H, np.array([[0.5]])
        filter_.x[0, 0], filter_.P[0, 0] = 1.0, 4.0
    kf.predict(u=0.0)
    kf.update(Z[5])
    state = same.step(dt=0.02, altitude=Z[5], acceleration=0.0)
    # the order of the sums differs
    np.testing.assert_allclose(same.x, kf.x, rtol=1e-12, atol=1e-12)
    assert state.height_sd == pytest.approx(np.sqrt(kf.P[0, 0]), rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_a_step_leaves_states_that_were_taken_from_the_filter_alone(name):
    kf = make(name)
    steps(kf, Z[:3])
    x, P = kf.x, kf.P
    before = x.copy(), P.copy()
    steps(kf, Z[3:6])
    assert np.array_equal(x, before[0])
    assert np.array_equal(P, before[1])
    assert not np.array_equal(kf.P, P)


@pytest.mark.parametrize("gap", [1e3, 1e5, 1e9])
@pytest.mark.parametrize("name", NAMES)
def test_after_a_gap_however_long_the_height_is_unknown_but_a_number(name, gap):
    t = np.arange(400) / 50
    t[200:] += gap
    still, altitude = np.zeros(400, np.bool_), np.zeros(400)
    altitude[200] = np.nan
    for at_rest in (still, ~still):
        found = make(name, dt=0.02).run(t, altitude, np.zeros(400), at_rest=at_rest)
        assert np.isfinite(found).all()
        assert found.height_sd[199] < 3 < found.height_sd[200]
        assert found.height_sd[-1] < 200  # the offset's 100 m, and what it was before


def plainly(t, z, a, sd, at_rest, *, midpoint=False, quiet_steps=0, quiet=0.1, unresolved=0.0):
    """The two-state filter in matrices, with the numbers of its docstrings once more: rows of h, v, sds."""
    x, P, found = np.zeros(2), np.diag([1e-3, 0.1]) ** 2, []
    small = np.abs(a) < quiet
    for k in range(len(t)):
        if k and t[k] > t[k - 1]:
            dt = min(t[k] - t[k - 1], 600.0)
            u = (a[k] + a[k - 1]) / 2 if midpoint else a[k - 1]
            missed = unresolved * max(abs(a[k] - a[k - 1]) - 5 * sd[k], 0.0)
            F, B = np.array([[1, dt], [0, 1]]), np.array([dt**2 / 2, dt])
            stale = dt > 0.5 + 1e-6
            x = F @ x + B * (0.0 if stale else u)
            P = F @ P @ F.T + (sd[k] ** 2 + missed**2) * np.outer(B, B)
            P[0, 0] += 0.5**2 * dt**3 / 12 if stale else 0.0
        resting = at_rest[k] or (0 < quiet_steps <= k and small[k - quiet_steps : k + 1].all())
        rest = [(np.array([0.0, 1.0]), 0.01**2, 0.0)] if resting else []
        sample = [(np.array([1.0, 0.0]), 0.3**2, z[k])] if np.isfinite(z[k]) else []
        for h, r, value in (*rest, *sample):
            K = P @ h / (h @ P @ h + r)
            x, P = x + K * (value - h @ x), P - np.outer(K, h @ P)
        found.append([*x, *np.sqrt(np.diag(P))])
    return np.array(found)


def plain_rows(n=200):
    rng = np.random.default_rng(8)
    dt = rng.choice([0.0, 0.02, 0.03, 0.5, 2.0, 1e4], n, p=[0.05, 0.5, 0.4, 0.03, 0.015, 0.005])
    z = np.where(rng.random(n) < 0.3, np.nan, rng.normal(scale=0.3, size=n))
    a = np.where(rng.random(n) < 0.9, rng.normal(scale=0.04, size=n), rng.normal(scale=2.0, size=n))
    return 3 + np.cumsum(dt), z, a, np.where(rng.random(n) < 0.5, 0.15, 0.3), rng.random(n) < 0.05


@pytest.mark.parametrize(
    ("settings", "same"),
    [
        ({}, {}),
        ({"midpoint": True}, {"midpoint": True}),
        ({"zupt_steps": 3}, {"quiet_steps": 3}),
        ({"zupt_steps": 2, "zupt_threshold": 0.05}, {"quiet_steps": 2, "quiet": 0.05}),
        ({"unresolved": 0.4}, {"unresolved": 0.4}),
    ],
    ids=["plain", "midpoint", "quiet", "quieter", "unresolved"],
)
def test_rows_and_steps_are_the_two_state_filter_in_matrices(settings, same):
    t, z, a, sd, at_rest = plain_rows()
    expected = plainly(t, z, a, sd, at_rest, **same)
    given = np.where(sd == 0.15, np.nan, sd)  # NaN: the setting
    settings = {"dt": 0.02, "acceleration_sd": 0.15, "altitude_sd": 0.3} | settings
    one, many = (height_estimator("kalman", **settings) for _ in range(2))
    run = many.run(t, z, a, given, at_rest=at_rest)
    samples = {"dt": np.diff(t, prepend=t[0]), "altitude": z, "acceleration": a, "acceleration_sd": given}
    stepped = [
        one.step(**{name: values[k] for name, values in samples.items()}, at_rest=bool(at_rest[k]))
        for k in range(len(t))
    ]
    # the covariance after 10 000 s is 1e7 m²: what then meets a barometer of 0.3 m keeps eight digits
    np.testing.assert_allclose(np.array(run).T, expected, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(stepped, expected, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("name", NAMES)
def test_a_run_without_rows_starts_nothing(name):
    kf, new = make(name), make(name)
    kf.run(np.empty(0), np.empty(0), np.empty(0))
    sample = {"dt": 5.0, "altitude": 0.1, "acceleration": 0.0}
    assert kf.step(**sample) == new.step(**sample)


@pytest.mark.parametrize("name", NAMES)
def test_no_acceleration_at_all_is_none_and_whole_numbers_are_numbers(name):
    whole = np.arange(5), np.array([0, 1, 0, 2, 1])
    run = make(name).run(*whole)
    np.testing.assert_array_equal(run, make(name).run(*(v.astype(float) for v in whole), np.zeros(5)))


def test_a_smoother_that_knows_no_later_sample_is_the_filter():
    kf, same = make("kalman"), make("kalman")
    smooth, run = kf.smooth(T, Z, np.ones(100), lag=0.0), same.run(T, Z, np.ones(100))
    np.testing.assert_allclose(smooth, run, atol=1e-12)
    half = make("kalman").smooth(T, Z, np.ones(100), lag=0.5)
    assert (half.height_sd[:50] < run.height_sd[:50]).any()
    for lag in (-0.1, float("nan")):
        with pytest.raises(ValueError, match=f"the lag is a time in s, 0 or more, but it is {lag}"):
            kf.smooth(T, Z, lag=lag)


@pytest.mark.parametrize("dt", [0.0, 0.25])
def test_steps_are_the_differences_of_the_clock_in_double(dt):
    t = np.array([16777216, 16777217, 16777219])  # the second is no number of single precision
    steps = steps_of(t, dt)
    np.testing.assert_array_equal(steps, [dt or np.nan, 1.0, 2.0])
    assert steps_of(t.astype(np.float32), dt).dtype == float


def test_a_smoother_knows_of_turns_what_the_filter_knows():
    turning = np.stack([np.sin(T), 0 * T, np.cos(T)], axis=1)
    kf, same, upright = (make("coloured-kalman") for _ in range(3))
    smooth, run = kf.smooth(T, Z, np.zeros(100), up=turning), same.run(T, Z, np.zeros(100), up=turning)
    np.testing.assert_allclose([v[-1] for v in smooth], [v[-1] for v in run], atol=1e-12)
    assert smooth.height_sd[-1] > upright.smooth(T, Z, np.zeros(100)).height_sd[-1]  # the bias turns, too
