"""The complementary filter against the papers' equation written out, and its sds against simulation."""

import numpy as np
import pytest

from baroarma import NoiseModel
from baroarma.estimators import height_estimator
from baroarma.estimators.height.complementary import Complementary, mean_variance
from baroarma.testing import HeightEstimatorContract

SG13 = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, drift_rate=0.01, rate_hz=50)
RATE = 50


class TestContract(HeightEstimatorContract):
    def make(self):
        return height_estimator("complementary")


class TestContractWithEverything(HeightEstimatorContract):
    def make(self):
        return height_estimator(
            "complementary",
            noise=SG13,
            midpoint=True,
            slow_barometer="hold",
            zupt_steps=3,
            zupt_threshold=0.5,
        )


def sg14_equation_24(z, a, T, sigma_w, sigma_v):
    """SG14 Eq. 24 with the positive gain, as printed otherwise."""
    x, out = np.zeros(2), []
    K = np.array([np.sqrt(2 * sigma_w / sigma_v), sigma_w / sigma_v])
    for z_k, a_k in zip(z, a, strict=True):
        out.append(x)
        correction = np.array([[1, T / 2], [0, 1]]) @ K * T * (z_k - x[0])
        x = np.array([[1, T], [0, 1]]) @ x + correction + np.array([T / 2, 1]) * T * a_k
    return np.array(out).T


@pytest.mark.parametrize("slow_barometer", ["weight", "hold"])
def test_at_the_barometers_own_rate_it_is_the_papers_equation(slow_barometer):
    rng = np.random.default_rng(0)
    z, a = rng.normal(size=(2, 500))
    cf = Complementary(acceleration_sd=0.2, altitude_sd=0.3, slow_barometer=slow_barometer)
    run = cf.run(np.arange(500) / RATE, z, a)
    expected = sg14_equation_24(z, a, 1 / RATE, 0.2, 0.3)
    np.testing.assert_allclose([run.height, run.velocity], expected, rtol=0, atol=1e-12)  # rounding


def test_midpoint_integrates_a_circle_without_the_half_sample_lag():
    t = np.arange(1000) / RATE
    w = 2 * np.pi * 1.25
    height = 0.15 * (1 - np.cos(w * t))
    errors = []
    for midpoint in (False, True):
        cf = Complementary(midpoint=midpoint)
        run = cf.run(t, height, 0.15 * w**2 * np.cos(w * t))
        errors.append(np.sqrt(np.mean((run.velocity - 0.15 * w * np.sin(w * t))[500:] ** 2)))
    lag = w**2 * 0.15 * (1 / RATE / 2) / np.sqrt(2)  # rms of acceleration times T/2
    assert errors[0] == pytest.approx(lag, rel=0.1)  # the barometer corrects a part of it
    assert errors[1] < 0.05 * lag


def test_a_barometer_at_a_fifth_of_the_rate_keeps_the_answer_to_a_step():
    t = np.arange(1000) / RATE
    step = np.ones(1000)
    slow = np.where(np.arange(1000) % 5 == 0, step, np.nan)
    full = Complementary().run(t, step, np.zeros(1000)).height
    for slow_barometer in ("weight", "hold"):
        fifth = Complementary(slow_barometer=slow_barometer).run(t, slow, np.zeros(1000)).height
        # a delay of up to 5 samples times the steepest slope of the answer, K[0] = 1/s
        assert np.abs(fifth - full).max() < 5 / RATE


@pytest.mark.parametrize("slow_barometer", ["weight", "hold"])
def test_a_long_step_does_not_overshoot(slow_barometer):
    t = np.concatenate([np.arange(100), np.arange(250, 400)]) / RATE
    run = Complementary(slow_barometer=slow_barometer).run(t, np.ones(250), np.zeros(250))
    assert run.height.max() < 2  # K T of 3 s would be 5 times the residual


def test_a_sample_after_a_gap_does_not_overshoot():
    t = np.arange(1000) / RATE
    z = np.where((t > 4) & (t < 12), np.nan, 0.0)
    z[600:] = 1.0
    run = Complementary().run(t, z, np.zeros(1000))
    undisturbed = Complementary().run(t, np.where(t < 4, 0.0, 1.0), np.zeros(1000))
    assert run.height.max() <= undisturbed.height.max() + 0.1


@pytest.mark.parametrize("every", [1, 5])
@pytest.mark.parametrize("slow_barometer", ["weight", "hold"])
def test_sds_are_the_errors_sds_in_coloured_noise(slow_barometer, every):
    n, runs = 1000, 200
    rng = np.random.default_rng(every)
    t = np.arange(n) / RATE
    initial = {"initial_height_sd": 0.1, "initial_velocity_sd": 0.1}
    errors = []
    for _ in range(runs):
        # the 1 s of rest whose mean is subtracted has noise of its own: that is what the sds assume
        z = SG13.simulate(t, rng) - SG13.simulate(RATE, rng).mean()
        h0, v0 = rng.normal(scale=0.1, size=2)
        z = np.where(np.arange(n) % every == 0, z + h0 + v0 * t, np.nan)
        a = rng.normal(scale=0.147, size=n)
        cf = Complementary(noise=SG13, slow_barometer=slow_barometer, acceleration_sd=0.147, **initial)
        run = cf.run(t, z, a)
        errors.append([run.height - h0 - v0 * t, run.velocity - v0])
    ratio = np.mean(np.square(errors), axis=0) / np.square([run.height_sd, run.velocity_sd])
    # mean of squares of 200 unit normals: chi²/200 has sd 0.1; 5 sd for the worst of a thousand rows
    assert np.abs(ratio[:, 5:] - 1).max() < 0.5
    assert abs(ratio[:, 5:].mean() - 1) < 0.1


def test_zero_velocity_rule_stops_the_velocity():
    t = np.arange(200) / RATE
    a = np.where(t < 1, 0.5, 0.0)
    run = Complementary(zupt_steps=12).run(t, np.full(200, np.nan), a)
    assert run.velocity[50] == pytest.approx(0.5, abs=0.011)  # one Euler step of 0.01 m/s
    assert (run.velocity[50 + 12 :] == 0).all()
    assert (run.velocity[:50][1:] > 0).all()


def test_told_to_be_at_rest_it_has_no_velocity():
    t = np.arange(50) / RATE
    run = Complementary(rest_sd=0.02).run(t, np.zeros(50), np.ones(50), at_rest=np.arange(50) > 20)
    assert (run.velocity[21:] == 0).all()
    assert np.allclose(run.velocity_sd[21:], 0.02)


def test_variance_of_a_mean_is_that_of_simulated_means():
    rng = np.random.default_rng(3)
    noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=RATE)
    means = [noise.simulate(RATE, rng).mean() for _ in range(2000)]
    # chi²/2000 has sd 0.032; the integral stands for a sum of 50: 1 %
    assert np.var(means) / mean_variance(noise, 1.0) == pytest.approx(1, abs=0.1)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"slow_barometer": "often"}, "often.*weight"),
        ({"altitude_sd": 0.0}, "positive sds"),
    ],
)
def test_impossible_settings_are_refused(settings, words):
    with pytest.raises(ValueError, match=words):
        Complementary(**settings)
