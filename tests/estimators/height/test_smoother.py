"""The smoother: fixed-interval, fixed-lag, and given the bank's decisions."""

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest

from baroarma.estimators import height_estimator
from baroarma.estimators.height.bank import AT_REST, REJECTED
from baroarma.estimators.height.coloured_kalman import ColouredKalman
from baroarma.estimators.height.kernels import JUMP_TIME
from baroarma.simulation import BMP085, simulate
from baroarma.testing import height_samples
from baroarma.tracker import Tracker

spec = importlib.util.spec_from_file_location("dense", Path(__file__).with_name("dense.py"))
dense = importlib.util.module_from_spec(spec)
spec.loader.exec_module(dense)

NOISE = BMP085.noise
NAMES = ["kalman", "coloured-kalman", "differenced-kalman"]


def make(name="coloured-kalman", **settings):
    moving = {"confirm_rest": False} if name == "coloured-kalman" else {}
    return height_estimator(name, noise=NOISE, **{**moving, **settings})


def awkward(seed=0, n=200):
    """Uneven, gappy samples with spikes."""
    samples = {k: v for k, v in height_samples(seed, n).items() if k not in ("accel", "gyro")}
    samples["altitude"][::41] += 30.0
    return samples


def until(samples, stop):
    return {name: values[samples["t"] <= stop] for name, values in samples.items()}


@pytest.mark.parametrize("name", NAMES)
def test_an_infinite_lag_is_the_fixed_interval_and_no_lag_the_filter(name):
    samples = awkward()
    fixed = make(name).smooth(**samples)
    np.testing.assert_array_equal(make(name).smooth(**samples, lag=math.inf), fixed)
    # a lag beyond the record's end is as good as infinite, but sums each row's way anew
    np.testing.assert_allclose(make(name).smooth(**samples, lag=1e6), fixed, rtol=0, atol=1e-9)
    np.testing.assert_allclose(make(name).smooth(**samples, lag=0.0), make(name).run(**samples), atol=1e-12)


@pytest.mark.parametrize("lag", [0.1, 0.77, 3.5])
@pytest.mark.parametrize("name", [*NAMES, "lagged"])
def test_a_fixed_lag_is_the_fixed_interval_of_the_record_that_ends_so_much_later(name, lag):
    def new():
        return make(barometer_lag=0.2, level_prior_sd=0.5) if name == "lagged" else make(name)

    samples = awkward(1)
    found = np.transpose(new().smooth(**samples, lag=lag))
    for k in range(0, 200, 7):
        cut = new().smooth(**until(samples, samples["t"][k] + lag))
        # the definition, but for the order of summation
        np.testing.assert_allclose(found[k], [column[k] for column in cut], rtol=0, atol=1e-9)


def test_after_smoothing_the_filter_stands_where_a_run_would_have_led_it():
    samples = awkward(2)
    run, smoothed = make(confirm_rest=True), make(confirm_rest=True)
    samples["at_rest"] = np.arange(200) % 80 > 30
    run.run(**samples)
    smoothed.smooth(**samples, lag=0.5)
    np.testing.assert_array_equal(smoothed.x, run.x)
    np.testing.assert_array_equal(smoothed.P, run.P)
    again = [kf.step(dt=0.02, altitude=0.3, acceleration=0.1, at_rest=True) for kf in (run, smoothed)]
    assert again[0] == again[1]


def test_the_longer_the_lag_the_smaller_the_error():
    lags, squares = (0.0, 0.2, 1.0, math.inf), []
    for seed in range(4):
        log = simulate("circle", duration=30, seed=seed)
        tracker = Tracker(noise=NOISE, attitude="reference", height_settings={"confirm_rest": False})
        tracks = [tracker.smooth(log, lag=lag) for lag in lags]
        squares.append(
            [
                [np.mean((x.height - log.reference)[300:] ** 2) for x in tracks],
                [np.mean((x.velocity - log.reference_velocity)[300:] ** 2) for x in tracks],
                [x.height_sd[1000] ** 2 for x in tracks],
                [x.velocity_sd[1000] ** 2 for x in tracks],
            ]
        )
    height, velocity, height_sd, velocity_sd = np.sqrt(np.mean(squares, axis=0))
    assert (np.diff(height_sd) < 0).all()
    assert (np.diff(velocity_sd) < 0).all()
    # what the sds promise to shrink by half or more does shrink; one step of a lag may be luck
    assert velocity[-1] < velocity[2] < velocity[0]
    assert height[-1] < height[0]


def joint(t, jump, startled, **sds):
    """Return what `dense.joint` does; after a jump a height and a velocity of its own are added."""
    hh, vv, vh, samples = dense.joint(t, NOISE, **sds)
    for j in np.flatnonzero((jump > 0) | (startled > 0)):
        after = (np.arange(len(t)) >= j).astype(float)
        since, speed = after * (t - t[j]), (jump[j] / JUMP_TIME) ** 2 + startled[j]
        hh = hh + jump[j] ** 2 * np.outer(after, after) + speed * np.outer(since, since)
        vv = vv + speed * np.outer(after, after)
        vh = vh + speed * np.outer(after, since)
    return hh, vv, vh, samples


def solve(t, z, u, decided, **sds):
    """Return smoothed height, velocity and their sds, given what was decided: one big linear solve."""
    rest = decided.bits & AT_REST > 0
    seen = np.isfinite(z) & (decided.bits & REJECTED == 0)
    loose = np.where(rest, decided.startled, 0.0) + decided.released
    hh, vv, vh, samples = joint(t, decided.jump, loose, **sds)
    to_height, to_velocity = dense.motion_maps(t)
    S = np.block(
        [
            [(hh + samples)[np.ix_(seen, seen)], vh.T[np.ix_(seen, rest)]],
            [vh[np.ix_(rest, seen)], vv[np.ix_(rest, rest)] + np.diag(decided.rest_variance[rest])],
        ]
    )
    innovation = np.concatenate([(z - to_height @ u)[seen], -(to_velocity @ u)[rest]])
    across = np.block([[hh[:, seen], vh.T[:, rest]], [vh[:, seen], vv[:, rest]]])
    gains = np.linalg.solve(S, across.T).T
    mean = np.concatenate([to_height @ u, to_velocity @ u]) + gains @ innovation
    variance = np.concatenate([np.diag(hh), np.diag(vv)]) - np.sum(gains * across, axis=1)
    return (*np.split(mean, 2), *np.split(np.sqrt(variance), 2))


def test_with_rests_outliers_and_a_jump_it_is_the_dense_solution_given_the_same_decisions():
    rng = np.random.default_rng(5)
    n = 300
    t = np.cumsum(rng.uniform(0.03, 0.07, n))
    at_rest = (np.arange(n) % 100) > 50
    u = np.where(at_rest, 0.0, 0.5 * np.sin(t)) + 0.05 * rng.normal(size=n)
    z = NOISE.simulate(t, rng)
    z[20:200:23] += 25.0
    z[170:] += 12.0  # really
    z[rng.random(n) < 0.1] = np.nan
    sds = {"bias_sd": 0.1, "bias_walk": 0.01, "offset_sd": 2.0}
    settings = {**sds, "initial_height_sd": 0.1, "acceleration_sd": 0.2, "unresolved": 0.0, "rest_sd": 0.05}
    samples = {"t": t, "altitude": z, "acceleration": u, "at_rest": at_rest}
    decided = ColouredKalman(noise=NOISE, dt=0.05, **settings).decide(**samples)
    # every kind of decision was taken
    assert (decided.bits & AT_REST).sum() > 50
    assert (decided.bits & REJECTED).sum() > 5
    assert np.nanmax(decided.jump) > 5
    found = ColouredKalman(noise=NOISE, dt=0.05, **settings).smooth(**samples)
    expected = solve(
        t, z, (u[:-1] + u[1:]) / 2, decided, acceleration_sd=0.2, height_sd=0.1, velocity_sd=0.1, **sds
    )
    # condition about 1e6 of some 400 equations
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)


@pytest.mark.parametrize("name", NAMES)
def test_smoothed_sds_are_never_larger_and_never_imaginary(name):
    samples = awkward(4)
    run, smooth = make(name).run(**samples), make(name).smooth(**samples, lag=1.0)
    for filtered, smoothed in zip(run[2:], smooth[2:], strict=True):
        assert np.isfinite(smoothed).all()
        assert (smoothed >= 0).all()
        assert (smoothed <= filtered + 1e-9).all()


@pytest.mark.parametrize("lag", [-1.0, float("nan")])
def test_a_lag_that_can_not_be_is_refused_with_its_value(lag):
    with pytest.raises(ValueError, match=f"the lag is a time in s, 0 or more, but it is {lag}"):
        make().smooth(**awkward(), lag=lag)
