"""The errors of a track's heights between rows, against filterpy, sums over all pairs and cases by hand."""

import numpy as np
import pytest

from baroarma.climbing import BELIEVED, climb
from baroarma.simulation import BMP085, simulate
from baroarma.track import Track
from baroarma.tracker import Tracker
from baroarma.turning_points import HeightErrors, turning_points


def known(height, t=None, *, height_sd=0.1, velocity_sd=0.0):
    """A track with sds of its own."""
    height = np.asarray(height, float)
    t = np.arange(float(len(height))) if t is None else t
    full = np.ones(len(height))
    return Track(t, height, 0 * full, height_sd * full, velocity_sd * full, 0 * full, name="made")


def test_the_sd_of_a_change_is_that_of_the_steady_kalman_filter():
    from filterpy.kalman import KalmanFilter
    from scipy.linalg import expm

    kf, dt, q, r = KalmanFilter(2, 1), 0.02, 0.02**2, 0.3**2 / 50  # densities of acceleration and altitude
    kf.F, kf.H = np.array([[1, dt], [0, 1]]), np.array([[1.0, 0]])
    kf.Q, kf.R = q * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]), np.array([[r / dt]])
    for _ in range(20_000):
        kf.predict()
        kf.update(0.0)
    A = np.array([[0, 1], [0, 0]]) - kf.K / dt @ kf.H
    n = 3000
    sd_h, sd_v = np.sqrt(np.diag(kf.P))
    t = dt * np.arange(n)
    errors = HeightErrors(Track(t, 0 * t, 0 * t, np.full(n, sd_h), np.full(n, sd_v), 0 * t))
    for lag in (0.1, 1.0, 5.0, 20.0):
        cov = (expm(A * lag) @ kf.P)[0, 0]
        # the formula is the filter's in continuous time: of order dt times its bandwidth, 0.4 rad/s, 1 %
        exact_sd = np.sqrt(2 * (kf.P[0, 0] - cov))
        assert errors.change_sd(0, round(lag / dt)) == pytest.approx(exact_sd, rel=0.02)


def test_the_sd_of_the_sum_is_that_of_all_pairs():
    log = simulate("lift", seed=0, duration=120.0, speed=0.5)
    track = Tracker(noise=BMP085.noise).run(log)
    found = climb(track)
    errors = HeightErrors(track)
    turns = turning_points(track.height, errors, 0.2, BELIEVED)
    up = np.diff(track.height[turns]) > 0
    w = np.append(0.0, up) - np.append(up, 0.0)
    s, x = errors.sd_now[turns], errors.x[turns]
    lag = np.abs(x[:, None] - x)
    C = np.outer(s, s) * np.exp(-lag) * np.cos(lag) + errors.growth * np.minimum(
        errors.t[turns][:, None], errors.t[turns]
    )
    assert found.ascent_sd == pytest.approx(np.sqrt(w @ C @ w), rel=1e-6)  # lags beyond 20 are left out


def test_the_sd_of_one_swing_is_that_of_the_change():
    t = np.arange(200.0)
    for growth in (0.0, 1e-4):
        hill = Track(
            t,
            10 * np.exp(-(((t - 90) / 20) ** 2)),
            0 * t,
            np.sqrt(0.04 + growth * t),
            np.full(200, 0.001),
            0 * t,
        )
        errors = HeightErrors(hill)
        assert errors.growth == pytest.approx(growth, abs=1e-12)
        turns = np.array([10, 90])
        assert errors.sd(turns, np.array([True])) == pytest.approx(errors.change_sd(10, 90))
        assert errors.sd(turns, np.array([False])) == 0.0
        # x = lag sigma_v/(sqrt 2 sigma_h), sigma_h without its growth
        x = 80 * 0.001 / (np.sqrt(2) * 0.2)
        assert errors.change_sd(10, 90) ** 2 == pytest.approx(
            0.08 * (1 - np.exp(-x) * np.cos(x)) + growth * 80
        )
        assert errors.change_sd(10, 10) == 0.0


def test_errors_far_apart_are_independent():
    errors = HeightErrors(known(np.zeros(400), height_sd=0.1, velocity_sd=0.05))
    assert errors.change_sd(0, 399) == pytest.approx(0.1 * np.sqrt(2))
    # up, down, up, each 100 s: four turning points, of which the sum of the two ups uses all once
    turns = np.array([0, 100, 200, 300])
    assert errors.sd(turns, np.array([True, False, True])) == pytest.approx(0.2)
    assert errors.sd(turns, np.array([True, True, True])) == pytest.approx(0.1 * np.sqrt(2))


def test_growth_is_that_of_the_variance_over_a_minute_and_never_negative():
    t = np.arange(300.0)
    for sd, growth in ((np.sqrt(1 + 0.01 * t), 0.01), (np.sqrt(4 - 0.01 * t), 0.0), (np.ones(300), 0.0)):
        assert HeightErrors(Track(t, 0 * t, 0 * t, sd, sd, 0 * t)).growth == pytest.approx(growth, abs=1e-12)
    short = t[:60]
    sd = np.sqrt(1 + 0.01 * short)
    assert HeightErrors(Track(short, 0 * short, 0 * short, sd, sd, 0 * short)).growth == 0.0
    later = 1e6 + t  # a clock may start anywhere
    sd = np.sqrt(1 + 0.01 * t)
    assert HeightErrors(Track(later, 0 * t, 0 * t, sd, sd, 0 * t)).growth == pytest.approx(0.01)


def test_a_plateau_ends_where_it_is_broken():
    # the second time at 5 m, after a dip to 3 m that is no swing of 2.5 m, is not of the same plateau
    height = np.array([0, 0, 5.0, 5.1, 3.0, 5.0, 5.0, 0, 0])
    errors = HeightErrors(known(height, height_sd=0.1, velocity_sd=100.0))
    assert errors.level(height, 0, 3, 8) == pytest.approx(5.05)
    assert errors.level(height, 3, 3, 8) == pytest.approx(5.1)
    assert errors.level(height, 0, 0, 3) == 0.0
    assert errors.level(height, 4, 8, 8) == 0.0


def test_a_height_turns_where_it_has_come_back_by_the_threshold():
    errors = HeightErrors(known([0, 2, 1.5, 3, 0], height_sd=0.0))
    height = np.array([0, 2, 1.5, 3, 0])
    assert turning_points(height, errors, 0.5, 0.0).tolist() == [0, 1, 2, 3, 4]
    assert turning_points(height, errors, 0.6, 0.0).tolist() == [0, 3, 4]
    assert turning_points(height, errors, 4.0, 0.0).tolist() == []
    uncertain = HeightErrors(known(height, height_sd=0.1, velocity_sd=100.0))  # a change's sd is 0.14 m
    assert turning_points(height, uncertain, 0.5, 3.0).tolist() == [0, 1, 2, 3, 4]
    assert turning_points(height, uncertain, 0.5, 4.0).tolist() == [0, 3, 4]


def test_within_two_sds_of_the_change_a_row_is_of_the_plateau():
    errors = HeightErrors(known(np.zeros(4), height_sd=0.1, velocity_sd=100.0))
    assert errors.level(np.array([0, 5.0, 4.75, 0]), 0, 1, 3) == pytest.approx(4.875)  # 1.8 sds
    assert errors.level(np.array([0, 5.0, 4.65, 0]), 0, 1, 3) == 5.0  # 2.5 sds


def test_growth_is_known_from_a_minute_on():
    for rows, growth in ((60, 0.0), (61, 0.01)):
        t = np.arange(float(rows))
        sd = np.sqrt(1 + 0.01 * t)
        assert HeightErrors(Track(t, 0 * t, 0 * t, sd, sd, 0 * t)).growth == pytest.approx(growth, abs=1e-12)


def drifting(n=120, start=0.0, seed=5):
    """A track whose sds differ from row to row and grow as a barometer drifts."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.5, 2.0, n))
    height_sd = np.sqrt(rng.uniform(0.02, 0.06, n) + 1e-3 * t)
    return Track(start + t, 0 * t, 0 * t, height_sd, rng.uniform(0.01, 0.05, n), 0 * t)


def test_a_plateau_reaches_as_far_as_the_sd_of_the_change_says():
    rng, errors = np.random.default_rng(6), HeightErrors(drifting())
    assert errors.growth > 0
    for _ in range(60):
        before, turn, after = rng.integers(110) + np.sort(rng.choice(8, 3, replace=False))
        height = 0.3 * rng.normal(size=120)

        def near(k, turn=turn, height=height):
            return abs(height[k] - height[turn]) <= 2 * errors.change_sd(min(k, turn), max(k, turn))

        first, last = turn, turn
        while first > before and near(first - 1):
            first -= 1
        while last < after and near(last + 1):
            last += 1
        assert errors.level(height, before, turn, after) == pytest.approx(height[first : last + 1].mean())


def test_the_sd_of_a_change_counts_both_ends_and_not_the_clock():
    t = np.arange(100.0)
    sds = np.linspace(0.1, 0.4, 100)[::-1]  # the variance shrinks: there is no drift
    far = HeightErrors(Track(t, 0 * t, 0 * t, sds, np.full(100, 100.0), 0 * t))
    assert far.change_sd(3, 90) == pytest.approx(np.hypot(sds[3], sds[90]))  # independent
    early, late = HeightErrors(drifting()), HeightErrors(drifting(start=1e4))
    np.testing.assert_allclose(late.sd_now, early.sd_now, rtol=1e-9)  # of 1e4 + t, not exact in binary
    assert late.change_sd(5, 80) == pytest.approx(early.change_sd(5, 80), rel=1e-9)


def test_what_is_all_drift_still_has_the_error_of_its_velocity():
    t = np.arange(300.0)
    track = Track(t, 0 * t, 0 * t, np.sqrt(1e-8 + 0.01 * t), np.full(300, 0.05), 0 * t)
    assert HeightErrors(track).sd_now[[0, 10, 200]] == pytest.approx([1e-4, 0.05, 0.05], rel=1e-3)
