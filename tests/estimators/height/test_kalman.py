import numpy as np
import pytest

from baroarma import NoiseModel
from baroarma.estimators import height_estimator
from baroarma.estimators.height.complementary import Complementary
from baroarma.estimators.height.kalman import Kalman
from baroarma.testing import HeightEstimatorContract

SG13 = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)


class TestContract(HeightEstimatorContract):
    def make(self):
        return height_estimator("kalman", dt=0.02)


class TestContractWithRestRule(HeightEstimatorContract):
    def make(self):
        return height_estimator("kalman", noise=SG13, zupt_steps=2, zupt_threshold=0.5, midpoint=True)


def steady_gain(dt):
    """The gain after so many steps that it no longer changes."""
    kf = Kalman(dt=dt)
    for _ in range(round(60 / dt)):
        kf.predict()
        kf.update(0.0)
    return kf.K[:, 0]


def test_its_steady_gain_over_dt_tends_to_higgins_gain():
    higgins = Complementary().gain
    # method.md, Sec. 4: 0.990 of it at 50 Hz with SG14's tuning, 0.952 at 10 Hz (3 printed digits)
    assert steady_gain(0.02)[0] / 0.02 / higgins[0] == pytest.approx(0.990, abs=5e-4)
    assert steady_gain(0.1)[0] / 0.1 / higgins[0] == pytest.approx(0.952, abs=5e-4)
    # the deviation is of first order in dt: extrapolated to 0 it leaves second order, (dt/time constant)²
    coarse, fine = (steady_gain(dt) / dt for dt in (0.02, 0.01))
    np.testing.assert_allclose(2 * fine - coarse, higgins, rtol=(0.02 / 1.43) ** 2)


def test_its_steady_gain_solves_the_riccati_equation():
    from scipy.linalg import solve_discrete_are

    kf = Kalman(dt=0.02)
    prior = solve_discrete_are(kf.F.T, kf.H.T, kf.Q, kf.R)
    gain = prior @ kf.H.T / (kf.H @ prior @ kf.H.T + kf.R)
    np.testing.assert_allclose(steady_gain(0.02), gain[:, 0], rtol=1e-8)  # 42 time constants of decay


def test_process_noise_is_filterpys_discrete_white_noise():
    from filterpy.common import Q_discrete_white_noise

    kf = Kalman(dt=0.05, acceleration_sd=0.3)
    np.testing.assert_allclose(kf.Q, Q_discrete_white_noise(2, 0.05, 0.3**2), rtol=1e-12)
    np.testing.assert_allclose(kf.process_noise(0.1, 0.2), Q_discrete_white_noise(2, 0.1, 0.2**2), rtol=1e-12)


def test_a_given_acceleration_sd_overrides_the_setting():
    t, z = np.arange(20) / 50, np.zeros(20)
    told = Kalman(dt=0.02, acceleration_sd=9.0).run(t, z, z, np.full(20, 0.1))
    assert np.array_equal(told.height_sd, Kalman(dt=0.02, acceleration_sd=0.1).run(t, z, z).height_sd)


def test_measurement_noise_follows_from_the_noise_model_and_says_what_it_ignores():
    ignored, inflated = (
        height_estimator("kalman", noise=SG13, correlation=how) for how in ("ignore", "inflate")
    )
    assert ignored.R[0, 0] == pytest.approx(0.46**2 + 0.27**2)
    # the density at frequency 0, one-sided, is 2 dt times the variance of white noise
    assert inflated.R[0, 0] * 2 * 0.02 == pytest.approx(
        SG13.psd(1e-6), rel=1e-3
    )  # sampled against continuous
    assert "treated as white" in ignored.note
    assert height_estimator("kalman", noise=SG13, altitude_sd=1.0).R[0, 0] == 1.0


def test_white_noise_is_nothing_to_ignore():
    white = NoiseModel(correlated_sd=0, correlation_time=0, white_sd=0.3, rate_hz=50)
    assert height_estimator("kalman", noise=white).note == ""


def test_rest_updates_pin_the_height():
    t = np.arange(3000) / 50
    rng = np.random.default_rng(0)
    z, a = SG13.simulate(t, rng), rng.normal(scale=0.02, size=3000)
    free, pinned = (Kalman(dt=0.02, zupt_steps=steps).run(t, z, a) for steps in (0, 12))
    assert np.abs(pinned.height[1500:]).max() < 0.2 * np.abs(free.height[1500:]).max()
    assert pinned.velocity_sd[-1] < 0.01
    told = Kalman(dt=0.02).run(t, z, a, at_rest=np.arange(3000) >= 12)
    np.testing.assert_allclose(told.height, pinned.height, atol=1e-12)


def test_an_unknown_treatment_is_refused():
    with pytest.raises(ValueError, match=r"'whiten' is unknown.*'inflate'"):
        height_estimator("kalman", noise=SG13, correlation="whiten")


def test_without_an_interval_it_says_what_is_missing():
    with pytest.raises(ValueError, match="give dt= in s, or noise="):
        Kalman()
    with pytest.raises(ValueError, match=r"positive number of seconds, but it is -0\.1"):
        Kalman(dt=-0.1)


def test_it_starts_as_uncertain_as_it_is_told():
    kf = Kalman(dt=0.02, initial_height_sd=3.0, initial_velocity_sd=0.5)
    np.testing.assert_allclose(kf.P, np.diag([9.0, 0.25]))
    assert kf.states == ("height", "velocity")
