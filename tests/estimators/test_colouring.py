"""A coloured filter against the joint Gaussian of all samples, written down densely."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from scipy.linalg import block_diag, solve_discrete_lyapunov
from scipy.stats import multivariate_normal

from baroarma import ArmaModel, NoiseModel
from baroarma.estimators import colour_measurement, height_estimator
from baroarma.estimators.colouring import block_diagonal, noise_states

N, DT = 60, 0.1
GM = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, drift_rate=0.1, rate_hz=10)
MODELS = {
    "gm + white + drift": GM,
    "gm alone": NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0, rate_hz=10),
    "white": NoiseModel(correlated_sd=0, correlation_time=0, white_sd=0.46, rate_hz=10),
    "arma(1,1)": ArmaModel((-0.86,), (-0.52,), 0.27, DT),
    "arma(3,1)": ArmaModel((-0.5, 0.2, -0.1), (0.4,), 0.3, DT),
    "arma(1,3)": ArmaModel((-0.7,), (0.5, -0.3, 0.2), 0.3, DT),
    "ar(2)": ArmaModel((-1.2, 0.5), (), 0.3, DT),
    "ma(2)": ArmaModel((), (0.9, 0.4), 0.3, DT),
    "arma(0,0)": ArmaModel((), (), 0.3, DT),
}


def user_filter(column=True):
    """Position and velocity of somebody who never heard of coloured noise."""
    kf = KalmanFilter(dim_x=2, dim_z=1, dim_u=1)
    kf.x = np.array([[1.0], [0.5]]) if column else np.array([1.0, 0.5])
    kf.F = np.array([[1.0, DT], [0.0, 1.0]])
    kf.B = np.array([[DT**2 / 2], [DT]]) if column else np.array([DT**2 / 2, DT])
    kf.H = np.array([[1.0, 0.0]])
    kf.P, kf.Q = np.diag([2.0, 1.0]), 0.04 * np.array([[DT**4 / 4, DT**3 / 2], [DT**3 / 2, DT**2]])
    kf.R = np.array([[7.0]])
    return kf


def covariance_of(noise):
    """Covariance of N samples of the noise, from its autocovariance."""
    k = np.arange(N)
    lag = np.abs(k[:, None] - k)
    if isinstance(noise, ArmaModel):
        return noise.autocovariance(N)[lag]
    drift = noise.drift_rate**2 * np.minimum(k[:, None], k) * DT
    return noise.autocovariance(lag * DT) + drift


def dense_solution(kf, noise, z, u):
    """Mean and covariance of the last state given all samples, and the samples' log-likelihood."""
    powers = [np.linalg.matrix_power(kf.F, k) for k in range(N)]
    means, x = [], kf.x.reshape(2)
    for k in range(N):
        means.append(x if k == 0 else kf.F @ means[-1] + kf.B.reshape(2) * u)
    covariances = [kf.P]
    for _ in range(N - 1):
        covariances.append(kf.F @ covariances[-1] @ kf.F.T + kf.Q)
    cross = np.array(  # of states k and j
        [[powers[k - j] @ covariances[j] if k >= j else covariances[k] @ powers[j - k].T for j in range(N)]
         for k in range(N)]
    )  # fmt: skip
    seen = np.isfinite(z)
    S = (cross[:, :, 0, 0] + covariance_of(noise))[np.ix_(seen, seen)]
    mean_z = np.array(means)[seen, 0]
    gain = np.linalg.solve(S, cross[-1][seen][:, :, 0]).T
    mean = means[-1] + gain @ (z[seen] - mean_z)
    covariance = covariances[-1] - gain @ cross[-1][seen][:, :, 0]
    return mean, covariance, multivariate_normal(mean_z, S).logpdf(z[seen])


@pytest.mark.parametrize("column", [True, False], ids=["x (2, 1)", "x (2,)"])
@pytest.mark.parametrize("name", MODELS)
def test_it_is_the_dense_solution_of_the_joint_gaussian(name, column):
    rng = np.random.default_rng(0)
    z = rng.normal(size=N)
    z[rng.random(N) < 0.2] = np.nan
    kf, noise, u = user_filter(column), MODELS[name], 0.3
    mine = colour_measurement(kf, noise, DT)
    log_likelihood = 0.0
    for k in range(N):
        if k:
            mine.predict(u=u)
        if np.isfinite(z[k]):
            mine.update(z[k])
            log_likelihood += mine.log_likelihood
    mean, covariance, expected = dense_solution(kf, noise, z, u)
    np.testing.assert_allclose(mine.x.reshape(-1)[:2], mean, atol=1e-9)
    np.testing.assert_allclose(mine.P[:2, :2], covariance, atol=1e-9)
    assert log_likelihood == pytest.approx(expected, abs=1e-7)  # a sum of 50 terms of about 1


@pytest.mark.parametrize("name", MODELS)
def test_noise_states_start_in_their_steady_state(name):
    noise = MODELS[name]
    states = noise_states(noise, DT)
    stationary = states if not getattr(noise, "drift_rate", 0) else None
    if stationary is None:  # the drift (first) has none
        states = states._replace(F=states.F[1:, 1:], Q=states.Q[1:, 1:], P=states.P[1:, 1:])
    if len(states.P):
        np.testing.assert_allclose(states.P, solve_discrete_lyapunov(states.F, states.Q), atol=1e-12)


def test_the_given_filter_stays_as_it_was():
    kf, untouched = user_filter(), user_filter()
    mine = colour_measurement(kf, GM, DT)
    mine.predict(u=1.0)
    mine.update(0.5)
    for name in ("x", "P", "F", "Q", "H", "R", "B"):
        assert np.array_equal(getattr(kf, name), getattr(untouched, name))
    assert (mine.dim_x, kf.dim_x) == (4, 2)


def test_white_noise_is_that_of_one_raw_sample_whatever_the_interval():
    for dt in (0.1, 0.02):
        assert colour_measurement(user_filter(), GM, dt).R[0, 0] == pytest.approx(0.46**2)
    averaged = colour_measurement(user_filter(), GM.at_rate(2), 0.5)
    assert averaged.R[0, 0] == pytest.approx(0.46**2 / 5)


def test_filterpys_loops_run_on_it():
    mine = colour_measurement(user_filter(), GM, DT)
    z = GM.simulate(50, 1)
    means, covariances, _, _ = mine.batch_filter(z)
    x, P, _, _ = mine.rts_smoother(means, covariances)
    assert x.shape == (50, 4, 1)
    assert (P[:-1, 0, 0] < covariances[:-1, 0, 0]).all()


def test_a_scalar_process_noise_a_missing_input_and_fading_memory_are_kept():
    kf = KalmanFilter(dim_x=1, dim_z=1)
    kf.H, kf.Q, kf.alpha = np.array([[1.0]]), 0.5, 1.02
    mine = colour_measurement(kf, MODELS["gm alone"], DT)
    assert mine.Q[0, 0] == 0.5
    assert mine.B is None
    assert mine.alpha == pytest.approx(1.02)
    mine.predict()
    mine.update(1.0)
    assert np.isfinite(mine.x).all()


def test_colouring_our_own_two_state_filter_is_the_coloured_one():
    noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    plain = height_estimator("kalman", noise=noise, acceleration_sd=0.05)
    mine = colour_measurement(plain, noise, dt=0.02)
    ours = height_estimator(
        "coloured-kalman", noise=noise, acceleration_sd=0.05, bias_sd=0.0, bias_walk=0.0, offset_sd=0.0
    )
    for z in noise.simulate(50, 2):
        for kf in (mine, ours):
            kf.predict(u=0.1)
            kf.update(z)
    np.testing.assert_allclose(mine.x[:2], ours.x[:2], atol=1e-12)
    np.testing.assert_allclose(mine.P[:2, :2], ours.P[:2, :2], atol=1e-12)


def test_a_vector_measurement_and_a_foreign_interval_are_refused():
    with pytest.raises(ValueError, match="has 2 components; a scalar one is needed"):
        colour_measurement(KalmanFilter(dim_x=2, dim_z=2), GM, DT)
    with pytest.raises(ValueError, match=r"every 0\.1 s, but the filter steps every 0\.02 s"):
        colour_measurement(user_filter(), MODELS["ar(2)"], 0.02)


@pytest.mark.parametrize("name", ["gm + white + drift", "gm alone", "white"])
@pytest.mark.parametrize("offset_sd", [0.0, 0.5])
def test_states_of_many_intervals_are_those_of_each(name, offset_sd):
    dt = np.array([0.02, 0.1, 3.0])
    stack = noise_states(MODELS[name], dt, offset_sd=offset_sd)
    for k, interval in enumerate(dt):
        one = noise_states(MODELS[name], interval, offset_sd=offset_sd)
        assert np.array_equal(stack.F[k], one.F)
        assert np.array_equal(stack.Q[k], one.Q)
        assert all(np.array_equal(getattr(stack, name), getattr(one, name)) for name in "HRP")


def test_an_unknown_offset_is_where_the_drift_starts():
    states = noise_states(MODELS["gm alone"], DT, offset_sd=0.5)
    assert np.array_equal(states.P, np.diag([0.25, 0.27**2]))
    assert (states.F[0, 0], states.Q[0, 0]) == (1.0, 0.0)  # an offset that does not drift


def test_intervals_in_single_precision_give_states_in_double():
    single = np.array([0.02, 0.1], np.float32)
    for one, other in zip(noise_states(GM, single), noise_states(GM, single.astype(float)), strict=True):
        assert np.array_equal(one, other)


def test_a_block_diagonal_of_stacks_is_scipys_of_each():
    rng = np.random.default_rng(5)
    first, second = rng.normal(size=(5, 1, 2, 2)), rng.normal(size=(3, 4, 4))
    for one, two in ((first, second), (second, first), (first[0, 0], second), (first, second[0])):
        both = block_diagonal(one, two)
        shape = both.shape[:-2]
        one, two = (np.broadcast_to(each, (*shape, *each.shape[-2:])) for each in (one, two))
        assert all(np.array_equal(both[k], block_diag(one[k], two[k])) for k in np.ndindex(shape))


def test_a_row_of_numbers_and_a_second_input_are_taken_as_filterpy_takes_them():
    kf = KalmanFilter(dim_x=2, dim_z=1, dim_u=2)
    kf.H, kf.B, kf.Q = np.array([1.0, 0.0]), np.eye(2), 0.5
    mine = colour_measurement(kf, MODELS["gm alone"], DT)
    assert np.array_equal(mine.H, [[1.0, 0.0, 1.0]])
    assert np.array_equal(mine.Q[:2, :2], 0.5 * np.eye(2))
    assert mine.dim_u == 2
    mine.predict(u=np.array([[0.3], [0.4]]))
    assert np.array_equal(mine.x[:, 0], [0.3, 0.4, 0.0])


@pytest.mark.parametrize("dt", [1e-3, 0.1])
def test_an_arma_models_interval_is_its_own_to_a_millionth(dt):
    model = ArmaModel((-0.86,), (-0.52,), 0.27, dt)
    assert len(noise_states(model, dt * (1 + 5e-7)).P) == 2
    with pytest.raises(ValueError, match="but the filter steps every"):
        noise_states(model, dt * (1 + 5e-6))
