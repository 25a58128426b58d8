"""The Cramér-Rao bound by Whittle's integral against the Kalman filter's Fisher information."""

import numpy as np
import pytest

from baroarma import NoiseModel
from baroarma.identification.bound import cramer_rao_bound
from baroarma.identification.problem import Problem


@pytest.mark.parametrize(
    "noise", [NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50), NoiseModel(0.3, 2, 0.2, rate_hz=20)]
)
def test_whittles_bound_is_that_of_the_exact_likelihood(noise):
    theta = np.array([noise.white_sd, noise.drift_rate, noise.correlated_sd, noise.correlation_time])
    free = np.flatnonzero(theta)
    t = np.arange(30_000) / noise.rate_hz
    fisher = np.mean([Problem(t, noise.simulate(t, seed)).evaluate(theta)[2] for seed in range(40)], axis=0)
    exact = np.sqrt(np.diag(np.linalg.inv(fisher[np.ix_(free, free)]))) * theta[free]
    names = np.array(["white_sd", "drift_rate", "correlated_sd", "correlation_time"])[free]
    bound = cramer_rao_bound(noise, 30_000 / noise.rate_hz)
    # asymptotic against finite: edge effects of relative size tau/duration, and 40 random terms of the mean
    assert [bound[name] for name in names] == pytest.approx(exact, rel=0.05)


def test_four_times_the_duration_halves_the_bound():
    noise = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)
    short, long = cramer_rao_bound(noise, 600), cramer_rao_bound(noise, 2400)
    assert all(short[name] == pytest.approx(2 * long[name]) for name in short)


def test_white_noise_alone_has_the_textbook_bound():
    assert cramer_rao_bound(NoiseModel(0, 0, 0.4, rate_hz=10), 100)["white_sd"] == pytest.approx(
        0.4 / np.sqrt(2000)
    )
