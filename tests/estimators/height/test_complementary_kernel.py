"""The compiled complementary filter: its covariance against plain matrices, its memory against one row."""

import numpy as np
import pytest

from baroarma.estimators.height import complementary_kernel as kernel

CORRELATED, RATE, WHITE, DRIFT = NOISE = (0.07, 1.3, 0.2, 1e-3)


def a_covariance(seed):
    root = np.random.default_rng(seed).normal(size=(5, 5))
    return root @ root.T


def dense(covariance):
    P = np.full((5, 5), np.nan)
    kernel._store(covariance, P)
    return P


def test_what_is_stored_is_what_was_loaded():
    P = a_covariance(0)
    upper = kernel._load(P)
    np.testing.assert_array_equal(dense(upper), P)
    names = [f"{a}{b}" for i, a in enumerate("hvcdn") for b in "hvcdn"[i:]]
    assert list(upper._fields) == names


@pytest.mark.parametrize("rate", [RATE, 0.4, 0.0])
def test_a_step_of_the_covariance_is_the_matrix_equation(rate):
    P, dt, variance, g = a_covariance(1), 0.3, 0.4, (0.25, 0.6)
    phi = np.exp(-rate * dt)  # without a Gauss-Markov noise there is nothing to forget, and nothing new
    A = np.diag([1 - g[0], 1.0, phi, 1.0, 1.0])
    A[0, 1], A[0, 4], A[1, 0], A[1, 4] = dt, g[0], -g[1], g[1]
    drive = np.array([dt**2 / 2, dt, 0, 0, 0])
    Q = variance * np.outer(drive, drive) + np.diag([0, 0, CORRELATED * (1 - phi**2), DRIFT * dt, 0])
    found = kernel._spread(kernel._load(P), *g, dt, variance, (CORRELATED, rate, WHITE, DRIFT))
    np.testing.assert_allclose(dense(found), A @ P @ A.T + Q, rtol=1e-12)  # some ten roundings


def test_a_sample_has_the_noise_of_its_moment():
    P = a_covariance(2)
    A = np.eye(5)
    A[4] = (0, 0, 1, 1, 0)  # n = c + d + white noise
    found = kernel._take_sample(kernel._load(P), WHITE)
    np.testing.assert_allclose(dense(found), A @ P @ A.T + np.diag([0, 0, 0, 0, WHITE]), rtol=1e-12)


def test_rest_forgets_the_velocity():
    P = a_covariance(3)
    expected = P.copy()
    expected[1], expected[:, 1] = 0, 0
    expected[1, 1] = 0.03
    np.testing.assert_array_equal(dense(kernel._rest(kernel._load(P), 0.03)), expected)


def rows_of(n, seed, *, missing=0.6):
    """Uneven times, some of them twice; altitudes with gaps; accelerations and some sds; some rest."""
    rng = np.random.default_rng(seed)
    dt = rng.uniform(0.01, 0.5, n)
    dt[rng.random(n) < 0.2] = 0.0
    z = np.where(rng.random(n) < missing, np.nan, rng.normal(size=n))
    w = np.where(rng.random(n) < 0.5, np.nan, rng.uniform(0.1, 1, n))
    return 7 + np.cumsum(dt), z, rng.normal(size=n), w, rng.random(n) < 0.1


def run(rows, x, P, barometer, before, *, hold, longest=0.4):
    out = np.empty((4, len(rows[0])))
    K = (1.1, 0.6)
    kernel.complementary_rows(x, P, barometer, before, rows, K, hold, longest, NOISE, 0.3, 0.02, out)
    return out


def plain(rows, *, hold, longest=0.4):
    """The same filter in vectors and matrices: K of the docstring, the error's covariance beside it."""
    t, z, u, w, at_rest = rows
    x, P, (last, fresh, used) = np.array([0.5, -0.2]), a_covariance(4), (np.nan, False, t[0])
    found = []
    for k, dt in enumerate(np.diff(t, prepend=t[0])):
        if dt > 0:
            weight = 0.0
            if hold and np.isfinite(last):
                weight = min(dt, longest)
            elif fresh and not hold:
                weight, fresh, used = min(t[k] - used, longest), False, t[k]
            g = np.array([[1, weight / 2], [0, 1]]) @ np.array([1.1, 0.6]) * weight
            x = np.array([[1, dt], [0, 1]]) @ x + g * (last - x[0] if weight else 0.0)
            x += np.array([dt / 2, 1]) * dt * u[k]
            sd = 0.3 if np.isnan(w[k]) else w[k]
            P = dense(kernel._spread(kernel._load(P), *g, dt, sd**2, NOISE))
        if at_rest[k]:
            x[1], P = 0.0, dense(kernel._rest(kernel._load(P), 0.02))
        if np.isfinite(z[k]):
            last, fresh = z[k], True
            P = dense(kernel._take_sample(kernel._load(P), WHITE))
        found.append([*x, *np.sqrt(np.diag(P)[:2])])
    return np.array(found).T, x, P, (last, fresh, t[-1] - used)


@pytest.mark.parametrize("hold", [True, False])
@pytest.mark.parametrize("missing", [0.2, 0.6, 1.0])
def test_the_rows_are_the_plain_filter(hold, missing):
    rows = rows_of(60, 5, missing=missing)
    x, P, barometer = np.array([0.5, -0.2]), a_covariance(4), np.array([np.nan, 0.0, 0.0])
    out = run(rows, x, P, barometer, rows[0][0], hold=hold)
    expected, last_x, last_P, memory = plain(rows, hold=hold)
    np.testing.assert_allclose(out, expected, rtol=1e-9, atol=1e-12)  # sixty steps' rounding
    np.testing.assert_allclose(x, last_x, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(P, last_P, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(barometer[1:], memory[1:], rtol=1e-9)
    assert barometer[0] == memory[0] or missing == 1.0


@pytest.mark.parametrize("hold", [True, False])
def test_in_parts_it_is_the_same(hold):
    rows = rows_of(60, 6)
    whole = run(rows, np.zeros(2), a_covariance(7), np.array([np.nan, 0.0, 0.0]), 6.9, hold=hold)
    x, P, barometer, before, parts = np.zeros(2), a_covariance(7), np.array([np.nan, 0.0, 0.0]), 6.9, []
    for start in range(0, 60, 7):
        part = tuple(row[start : start + 7] for row in rows)
        parts.append(run(part, x, P, barometer, before, hold=hold))
        before = part[0][-1]
    np.testing.assert_array_equal(np.hstack(parts), whole)
