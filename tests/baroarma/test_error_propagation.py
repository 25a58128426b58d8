"""The covariance of the errors: against dense superposition, against Riccati, against runs."""

import numpy as np
import pytest

from baroarma import ImuNoise, NoiseModel
from baroarma.error_propagation import propagate
from baroarma.error_sources import LEVELLING, MOTION, Errors, tilt_variances
from baroarma.estimators import height_estimator
from baroarma.estimators.conditioning import Conditioner, sg14_whitening
from baroarma.imu_noise import WANDER_TIME

NOISE = NoiseModel(0.27, 0.75, 0.46, 0.05, rate_hz=20)
IMU = ImuNoise(0.01, 2e-3, 0.02, 3e-3, 5e-3, rate_hz=20)
OPEN = {"gate": np.inf, "unresolved": 0.0, "confirm_rest": False}
CHAINS = {
    "complementary": ("complementary", {}, 1, False, True, 20),
    "averaged": ("complementary", {"midpoint": True}, 4, False, True, 20),
    "whitened": ("complementary", {}, 4, True, True, 20),
    "slow barometer": ("complementary", {}, 4, True, True, 10),
    "held barometer": ("complementary", {"slow_barometer": "hold"}, 1, False, True, 5),
    "first sample is zero": ("complementary", {}, 1, False, False, 10),
    "kalman": ("kalman", {}, 4, True, True, 10),
    "coloured": ("coloured-kalman", OPEN, 1, False, False, 20),
    "lagging": ("coloured-kalman", OPEN | {"barometer_lag": 0.2}, 1, False, False, 10),
}


def errors_of(chain, *, noise=NOISE, imu=IMU, horizontal_acceleration=2.0):
    name, settings, average, whitened, captured, rate = CHAINS[chain]
    noise = NoiseModel(
        noise.correlated_sd, noise.correlation_time, noise.white_sd, noise.drift_rate, rate_hz=rate
    )
    whitening = sg14_whitening(noise, rate) if whitened else None
    errors = Errors(noise, imu, average, whitening, captured, 1.0, horizontal_acceleration)
    return errors, height_estimator(name, noise=noise, dt=errors.dt, **settings)


def dense_covariance(errors, height, rows):
    """Variances of height and velocity by pushing every unit of noise through conditioner and filter."""
    t = np.arange(rows) * errors.dt
    new, start = errors.new_samples(rows), errors.aligned_rows
    at = t[new]
    early = at < 1 - 1e-9
    noise = errors.noise

    def run(z, a):
        height.reset()
        found = height.run(t[start:], z, a)
        return np.stack([found.height, found.velocity])

    def altitude(n):
        zero = n[early].mean() if errors.captured else n[0]
        conditioner = Conditioner(average=errors.average, whitening=errors.whitening)
        z = np.full(rows, np.nan)
        z[new] = conditioner.run(n - zero)
        return z[start:]

    nothing = np.where(new, 0.0, np.nan)[start:]
    by_noise = np.stack([run(altitude(unit), np.zeros(rows - start)) for unit in np.eye(len(at))], axis=-1)
    by_accel = np.stack([run(nothing, unit) for unit in np.eye(rows - start)], axis=-1)
    apart = np.abs(at[:, None] - at)
    N = noise.correlated_sd**2 * np.exp(-apart / noise.correlation_time)
    N += noise.white_sd**2 * np.eye(len(at)) + noise.drift_rate**2 * np.minimum(at[:, None], at)
    return np.einsum("qki,ij,qkj->qk", by_noise, N, by_noise) + accel_variance(errors, by_accel, t, start)


def accel_variance(errors, by_accel, t, start):
    imu, late = errors.imu, t[start:]
    white = imu.accel_sd**2 * (np.eye(len(late)) + 1 / start)
    wander = np.exp(-np.abs(np.subtract.outer(t[start - 1 :], t[start - 1 :])) / WANDER_TIME)
    wander = wander[1:, 1:] - wander[:1, 1:] - wander[1:, :1] + 1
    white += imu.accel_wander_sd**2 * wander
    rest, swayed = tilt_variances(imu, errors.alignment)
    apart = np.abs(late[:, None] - late)
    tilt = rest * np.exp(-apart / MOTION) + swayed * np.exp(-apart * (1 / MOTION + 1 / LEVELLING))
    A = white + errors.horizontal_acceleration**2 * tilt
    return np.einsum("qki,ij,qkj->qk", by_accel, A, by_accel)


@pytest.mark.parametrize("chain", CHAINS)
def test_the_recursion_is_the_dense_superposition(chain):
    """An identity; rounding leaves 1e-7 of the variances."""
    errors, height = errors_of(chain)
    found = propagate(height, errors, 60)
    expected = dense_covariance(errors, height, 60)
    start = errors.aligned_rows
    assert found.height_sd[start:] ** 2 == pytest.approx(expected[0], rel=1e-7, abs=1e-12)
    assert found.velocity_sd[start:] ** 2 == pytest.approx(expected[1], rel=1e-7, abs=1e-12)
    assert not found.height_sd[:start].any()


def test_for_the_matched_model_it_is_the_filters_own_riccati():
    """GM noise that fades within the alignment leaves an independent offset: then the model is the truth."""
    noise = NoiseModel(0.3, 0.02, 0.4, rate_hz=50)
    imu = ImuNoise(0.004, rate_hz=50)
    height = height_estimator(
        "coloured-kalman",
        noise=noise,
        acceleration_sd=imu.accel_sd,
        bias_sd=imu.accel_sd / np.sqrt(50),
        bias_walk=0.0,
        offset_sd=0.5,
        initial_height_sd=0.0,
        initial_velocity_sd=0.0,
        midpoint=False,
        **OPEN,
    )
    found = propagate(height, Errors(noise, imu, 1, None, False, 1.0, 0.0), 500)
    height.reset()
    own = height.run(np.arange(450) / 50, np.zeros(450), np.zeros(450))
    assert found.height_sd[50:] == pytest.approx(own.height_sd, rel=1e-6)
    assert found.velocity_sd[50:] == pytest.approx(own.velocity_sd, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("chain", ["complementary", "whitened", "slow barometer", "kalman"])
def test_the_steady_state_is_where_the_sds_end(chain):
    noise = NoiseModel(0.27, 0.75, 0.46, rate_hz=20)
    errors, height = errors_of(chain, noise=noise)
    found = propagate(height, errors, 20 * 100)
    later = propagate(height, errors, 20 * 1000)
    # the wander of 100 s has not ended after 100 s, but after 1000 s it has, to 1 - e^-10
    assert found.steady_velocity_sd == pytest.approx(later.velocity_sd[-1], rel=1e-3)
    assert found.steady_height_sd == pytest.approx(later.height_sd[-1], rel=1e-3)


def test_with_drift_the_height_has_no_steady_state_but_the_velocity_has():
    errors, height = errors_of("complementary")
    found = propagate(height, errors, 2000)
    assert found.steady_height_sd is None
    assert found.steady_velocity_sd == pytest.approx(found.velocity_sd[-1], rel=0.01)


def test_a_filter_whose_gains_still_change_has_no_steady_state():
    noise = NoiseModel(0.27, 0.75, 0.46, rate_hz=20)
    errors, height = errors_of("kalman", noise=noise)
    assert propagate(height, errors, 40).steady_velocity_sd is None


def test_a_barometer_out_of_step_has_no_steady_state():
    errors, height = errors_of("complementary", imu=ImuNoise(0.01, rate_hz=33))
    assert errors.new_samples(331).sum() == 201  # of 20 Hz in 10 s, both ends included
    assert propagate(height, errors, 330).steady_velocity_sd is None


def test_a_tilt_that_brings_the_horizontal_acceleration_in_is_a_product_of_two_processes():
    """2000 runs; 4 standard errors, and 2 % because the runs have no alignment before them."""
    rng = np.random.default_rng(5)
    imu = ImuNoise(1e-9, gyro_density=0.02, gyro_bias_sd=0.01, accel_bias_sd=0.1, rate_hz=20)
    errors, height = errors_of("complementary", noise=NoiseModel(0.0, 0.0, 1e-9, rate_hz=20), imu=imu)
    rest, swayed = tilt_variances(imu, 1.0)

    def fading(variance, time, shape):
        return NoiseModel(np.sqrt(variance), time, 0.0, rate_hz=20).simulate(shape, rng)

    squares = []
    t = np.arange(200) / 20
    for _ in range(2000):
        tilt = np.sqrt(rest) * rng.normal() + fading(swayed, LEVELLING, 200)
        a = fading(errors.horizontal_acceleration**2, MOTION, 200) * tilt
        height.reset()
        squares.append(height.run(t, np.zeros(200), a).velocity[1:] ** 2)
    predicted = propagate(height, errors, 220).velocity_sd[21:]
    squares = np.array(squares)
    error = np.std(squares.mean(axis=1)) / np.sqrt(2000) / squares.mean()
    assert error < 0.05
    assert squares.mean() / np.mean(predicted**2) == pytest.approx(1, abs=4 * error + 0.02)
