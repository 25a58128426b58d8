"""The structural likelihood, its gradient and its information against dense matrices."""

import time

import numpy as np
import pytest
from scipy.linalg import cholesky, solve, solve_triangular

from baroarma.identification.kernels import LIKELIHOODS

THETAS = {
    "white drift": (0.3, 0.2),
    "white": (0.46, 0.0),
    "white drift gm": (0.46, 0.1, 0.27, 0.75),
    "drift gm": (0.0, 0.1, 0.27, 0.75),
    "white gm": (0.3, 0.0, 0.27, 0.75),
    "all": (0.3, 0.1, 0.27, 0.75, 0.5, 0.1),
}
EVEN = 1.5 * np.arange(45)
TIMES = {
    "uneven": np.cumsum(np.random.default_rng(0).uniform(0.02, 0.6, 30)),
    # after some twenty equal intervals the filter stands still to thirteen digits
    "even": EVEN,
    "seconds": np.arange(20.0),
    "gap": np.concatenate([EVEN, EVEN[-1] + 4.0 + 1.1 * np.arange(30)]),
}
every_theta = pytest.mark.parametrize("theta", THETAS.values(), ids=THETAS)
every_time = pytest.mark.parametrize("t", TIMES.values(), ids=TIMES)


def evaluate(t, y, theta, innovations=()):
    return LIKELIHOODS[len(theta) // 2 - 1](t, y, np.array(theta), np.array(innovations))


def terms_of(t, theta):
    """Return, for each parameter, its term's share of the covariance and that share's slope by its logarithm.

    The samples' differences from the first are what an unknown level leaves.
    """
    differences = np.hstack([-np.ones((len(t) - 1, 1)), np.eye(len(t) - 1)])
    apart = np.abs(t[:, None] - t)
    white = theta[0] ** 2 * np.eye(len(t))
    drift = theta[1] ** 2 * np.minimum.outer(t - t[0], t - t[0])
    shares, slopes = [white, drift], [2 * white, 2 * drift]
    for sd, tau in zip(theta[2::2], theta[3::2], strict=True):
        gm = sd**2 * np.exp(-apart / tau)
        shares.append(gm)
        slopes += [2 * gm, gm * apart / tau]
    return differences @ sum(shares) @ differences.T, [differences @ s @ differences.T for s in slopes]


def samples(t, seed=1):
    """Return samples of an arbitrary level; the likelihood is right for any."""
    return 3.0 + np.random.default_rng(seed).normal(size=len(t))


@every_theta
@every_time
def test_the_likelihood_and_the_innovations_are_the_dense_gaussians(t, theta):
    y, innovations = samples(t), np.zeros(len(t))
    value = LIKELIHOODS[len(theta) // 2 - 1](t, y, np.array(theta), innovations)[0]
    root = cholesky(terms_of(t, theta)[0], lower=True)
    white = solve_triangular(root, y[1:] - y[0], lower=True)
    dense = -0.5 * white @ white - np.sum(np.log(np.diag(root))) - 0.5 * len(white) * np.log(2 * np.pi)
    assert value == pytest.approx(dense, rel=1e-10)  # the dense side's rounding
    np.testing.assert_allclose(innovations[1:], white, rtol=1e-8, atol=1e-9)
    assert evaluate(t, y, theta)[0] == value  # with nowhere to write them, there are no innovations


@every_theta
@every_time
def test_the_gradient_is_the_dense_gaussians(t, theta):
    y = samples(t)
    covariance, slopes = terms_of(t, theta)
    a = solve(covariance, y[1:] - y[0])
    dense = [0.5 * (a @ slope @ a - np.trace(solve(covariance, slope))) for slope in slopes]
    # rounding of sums whose parts cancel, here of up to a thousand
    np.testing.assert_allclose(evaluate(t, y, theta)[1], dense, rtol=1e-8, atol=1e-7)


@every_theta
@pytest.mark.parametrize("name", ["uneven", "even"])
def test_the_information_has_fishers_for_its_mean(name, theta):
    """It is quadratic in the samples; its mean is thus the sum over a root of their covariance, exactly."""
    t = TIMES[name]
    covariance, slopes = terms_of(t, theta)
    columns = [np.concatenate([[0.0], column]) for column in cholesky(covariance, lower=True).T]
    without = evaluate(t, np.zeros(len(t)), theta)[2]
    mean = without + sum(evaluate(t, column, theta)[2] - without for column in columns)
    parts = [solve(covariance, slope) for slope in slopes]
    fisher = [[0.5 * np.sum(one * other.T) for other in parts] for one in parts]
    np.testing.assert_allclose(mean, fisher, rtol=1e-8, atol=1e-8)


@every_theta
@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_another_unit_only_shifts_the_likelihood(unit, theta):
    """300 variances of 1e-12 multiplied are no number any more."""
    t = 0.5 * np.arange(300)
    y = samples(t)
    scaled = np.where(np.arange(len(theta)) % 2 * (np.arange(len(theta)) > 1), 1.0, unit) * theta  # not tau
    value, gradient, information = evaluate(t, y, theta)
    other = evaluate(t, y * unit, scaled)
    assert other[0] == pytest.approx(value - 299 * np.log(unit), rel=1e-12)
    np.testing.assert_allclose(other[1], gradient, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(other[2], information, rtol=1e-9, atol=1e-9)


@every_theta
@pytest.mark.parametrize("name", ["uneven", "even"])
def test_another_unit_of_time_changes_nothing(name, theta):
    t, unit = TIMES[name], 1e-6
    y, other = samples(t), np.array(theta)
    other[1] /= np.sqrt(unit)
    other[3::2] *= unit
    for one, two in zip(evaluate(t, y, theta), evaluate(t * unit, y, other), strict=True):
        np.testing.assert_allclose(two, one, rtol=1e-9, atol=1e-9)


def test_equal_intervals_take_less_time():
    """The covariance and its slopes, most of the work, stand still after some twenty rows."""
    even = 1.5 * np.arange(1500)
    uneven = even + np.where(np.arange(1500) % 2, 1e-5, 0.0)

    def seconds(t, trials=5):
        times = []
        for _ in range(trials):
            start = time.process_time()
            evaluate(t, 0 * t, THETAS["white drift gm"])
            times.append(time.process_time() - start)
        return min(times)

    # a quarter where it was measured, compiled or not; a busy machine may double the one and not the other
    assert seconds(even) < 0.6 * seconds(uneven)
