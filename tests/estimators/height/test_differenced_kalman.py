import numpy as np
import pytest

from baroarma import NoiseModel
from baroarma.estimators import height_estimator
from baroarma.estimators.height.coloured_kalman import ColouredKalman
from baroarma.estimators.height.differenced_kalman import DifferencedKalman
from baroarma.testing import HeightEstimatorContract, height_samples

DRIFTING = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, drift_rate=0.01, rate_hz=50)
PURE_GM = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0, rate_hz=50)
NO_GM = NoiseModel(correlated_sd=0, correlation_time=0, white_sd=0.46, drift_rate=0.01, rate_hz=50)


class TestContract(HeightEstimatorContract):
    def make(self):
        return height_estimator("differenced-kalman", noise=DRIFTING)


class TestContractWhiteIgnored(HeightEstimatorContract):
    def make(self):
        return height_estimator("differenced-kalman", noise=DRIFTING, carry_white=False)


class TestContractPureGaussMarkov(HeightEstimatorContract):
    def make(self):
        return height_estimator("differenced-kalman", noise=PURE_GM)


@pytest.mark.parametrize("noise", [DRIFTING, PURE_GM, NO_GM], ids=["all", "gm", "no gm"])
@pytest.mark.parametrize("method", ["run", "smooth"])
def test_it_is_the_augmented_filter_in_other_words(noise, method):
    samples = {name: v for name, v in height_samples(0).items() if name not in ("accel", "gyro")}
    settings = {"noise": noise, "dt": 0.02, "offset_sd": 2.0}
    plain = {"gate": np.inf, "unresolved": 0.0}
    augmented = getattr(ColouredKalman(**settings, **plain), method)(**samples)
    differenced = getattr(DifferencedKalman(**settings), method)(**samples)
    # without white noise the augmented filter's R is 0, and rounding of P (4 m²) shows as its root in an sd
    np.testing.assert_allclose(differenced[:2], augmented[:2], atol=1e-9)
    np.testing.assert_allclose(differenced[2:], augmented[2:], atol=1e-8)


def test_filterpys_own_loop_differences_for_itself():
    rng = np.random.default_rng(0)
    z = rng.normal(size=50)
    kf, stepped = (DifferencedKalman(noise=PURE_GM, dt=0.02, midpoint=False) for _ in range(2))
    for k in range(50):
        if k:
            kf.predict()
        if k % 7:
            kf.update(z[k])
        stepped.step(dt=0.02, altitude=z[k] if k % 7 else np.nan, acceleration=0.0)
    np.testing.assert_allclose(kf.x, stepped.x, atol=1e-12)
    np.testing.assert_allclose(kf.P, stepped.P, atol=1e-12)


def test_a_second_sample_at_the_same_instant_is_no_new_sample():
    once, twice = (DifferencedKalman(noise=PURE_GM, dt=0.02) for _ in range(2))
    for kf in (once, twice):
        kf.update(0.5)
        kf.predict()
        kf.update(0.2)
    twice.update(0.7)
    assert np.array_equal(once.x, twice.x)
    t, z = np.arange(5) / 50, np.arange(5.0)
    late = once.run(t, np.where(t == 0, np.nan, z)), twice.run(t, z)
    np.testing.assert_array_equal(*late)


def test_it_says_what_it_ignores():
    ignoring = DifferencedKalman(noise=DRIFTING, dt=0.02, carry_white=False)
    r0, r1, r2 = DRIFTING.autocovariance([0.0, 0.02, 0.04])
    phi = np.exp(-0.02 / 0.75)
    lag1 = ((1 + phi**2) * r1 - phi * (r0 + r2)) / ((1 + phi**2) * r0 - 2 * phi * r1)
    assert f"0.46 m a moving average (lag-1 correlation {lag1:.2f})" in ignoring.note
    assert DifferencedKalman(noise=DRIFTING, dt=0.02).note == ""
    assert DifferencedKalman(noise=PURE_GM, dt=0.02, carry_white=False).note == ""
    assert "nothing to difference" in DifferencedKalman(noise=NO_GM, dt=0.02).note


def test_treating_differenced_white_noise_as_white_costs_accuracy():
    rng = np.random.default_rng(1)
    t, squares = np.arange(1500) / 50, []
    for _ in range(30):
        z, a = DRIFTING.simulate(t, rng), rng.normal(scale=0.025, size=1500)
        runs = [
            DifferencedKalman(noise=DRIFTING, dt=0.02, carry_white=carry, bias_sd=0.0, bias_walk=0.0)
            for carry in (True, False)
        ]
        squares.append([np.mean(kf.run(t, z, a).height ** 2) for kf in runs])
    exact, ignoring = np.sqrt(np.mean(squares, axis=0))
    assert ignoring > 1.5 * exact  # method.md: 0.476 m against 0.186 m over 3 min


def test_without_a_noise_model_it_says_what_to_do():
    with pytest.raises(ValueError, match="'differenced-kalman' needs a noise model"):
        height_estimator("differenced-kalman", dt=0.02)
