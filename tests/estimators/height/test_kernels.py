"""The compiled steps of the linear height filters against plain matrices, one by one."""

import numpy as np
import pytest

from baroarma.estimators.height import kernels as kernel

M = 5
SIZE = (0,) * M
NAN = float("nan")


class Filter:
    """Two filters of five states in the kernels' stacks; what is done to one leaves the other alone."""

    def __init__(self, seed=0):
        rng = np.random.default_rng(seed)
        root = rng.normal(size=(2, M, M))
        self.x, self.P = rng.normal(size=(2, M)), root @ root.transpose(0, 2, 1)
        self.gain, self.work = np.full(M, NAN), np.full((M + 1, M), NAN)
        self.other = self.x[0].copy(), self.P[0].copy()

    def of(self, x, P):
        """Hold the second one against x and P, and the first against itself."""
        np.testing.assert_allclose(self.x[1], x, rtol=1e-12, atol=1e-12)  # some ten roundings
        np.testing.assert_allclose(self.P[1], P, rtol=1e-12, atol=1e-12)
        np.testing.assert_array_equal(self.P[1], self.P[1].T)
        np.testing.assert_array_equal(self.x[0], self.other[0])
        np.testing.assert_array_equal(self.P[0], self.other[1])

    def copies(self):
        return self.x[1].copy(), self.P[1].copy()


def tables(seed=1):
    """Three transitions with zeros in the same places, their inputs and noises."""
    rng = np.random.default_rng(seed)
    F = rng.normal(size=(3, M, M)) * (rng.random((M, M)) < 0.5)
    root = rng.normal(size=(3, M, M))
    return F, rng.normal(size=(3, M)), root @ root.transpose(0, 2, 1)


def motion_tables(seed=2):
    """Transitions of [h, v, bias, two states that decay or stay], with diagonal noises."""
    rng = np.random.default_rng(seed)
    F = np.zeros((3, M, M)) + np.eye(M)
    dt = rng.uniform(0.1, 1, 3)
    F[:, 0, 1], F[:, 0, 2], F[:, 1, 2] = dt, -(dt**2) / 2, -dt
    F[:, 3, 3] = rng.uniform(0.2, 0.9, 3)
    B = np.zeros((3, M))
    B[:, 0], B[:, 1] = dt**2 / 2, dt
    return F, B, np.array([np.diag(q) for q in rng.random((3, M))])


@pytest.mark.parametrize("t", [0, 2])
def test_a_prediction_is_that_of_the_matrices(t):
    F, B, Q = tables()
    filters = Filter()
    x, P = filters.copies()
    ends, columns = kernel.entries(F)
    kernel.predict(1, filters.x, filters.P, F, B, Q, t, ends, columns, 0.7, 0.4, filters.work, SIZE)
    filters.of(F[t] @ x + B[t] * 0.7, F[t] @ P @ F[t].T + Q[t] + 0.4 * np.outer(B[t], B[t]))


@pytest.mark.parametrize("t", [0, 2])
def test_a_motion_is_predicted_as_by_the_matrices(t):
    F, B, Q = motion_tables()
    filters = Filter()
    x, P = filters.copies()
    kernel.predict_motion(1, filters.x, filters.P, F, B, Q, t, 0.7, 0.4, filters.work, SIZE)
    filters.of(F[t] @ x + B[t] * 0.7, F[t] @ P @ F[t].T + Q[t] + 0.4 * np.outer(B[t], B[t]))


def test_the_entries_are_those_that_any_transition_has():
    F = tables()[0]
    F[0, 1] = 0.0  # others have them
    ends, columns = kernel.entries(F)
    used = [columns[ends[a] : ends[a + 1]].tolist() for a in range(M)]
    assert used == [np.flatnonzero(F[:, a].any(axis=0)).tolist() for a in range(M)]
    assert ends.dtype == columns.dtype == np.int64


def joseph(x, P, h, r, z):
    """Update in Joseph's form."""
    s = h @ P @ h + r
    K = P @ h / s if s > 0 else np.zeros(M)
    A = np.eye(M) - np.outer(K, h)
    return x + K * (z - h @ x), A @ P @ A.T + r * np.outer(K, K), (z - h @ x, s), K


@pytest.mark.parametrize("r", [0.3, 0.0])
def test_a_measurement_is_absorbed_in_josephs_form(r):
    H = np.random.default_rng(3).normal(size=(2, M))
    filters = Filter()
    x, P, (y, s), K = joseph(*filters.copies(), H[1], r, 0.9)
    stacks = filters.x, filters.P, H, 1, r
    found = kernel.innovate(1, *stacks, 0.9, filters.gain, SIZE)
    assert found == pytest.approx((y, s), rel=1e-12)
    kernel.absorb(1, *stacks, *found, filters.gain, filters.work, SIZE)
    np.testing.assert_allclose(filters.gain, K, rtol=1e-12)
    filters.of(x, P)


@pytest.mark.parametrize("state", [0, 1, 4])
@pytest.mark.parametrize("variance", [0.3, 0.0])
def test_a_pinned_state_is_a_measurement_of_it(state, variance):
    filters = Filter()
    x, P, innovation, K = joseph(*filters.copies(), np.eye(M)[state], variance, -0.4)
    stacks = filters.x, filters.P, state
    found = kernel.pin(1, *stacks, -0.4, variance, filters.gain, filters.work, SIZE)
    assert found == pytest.approx(innovation, rel=1e-12)
    np.testing.assert_allclose(filters.gain, K, rtol=1e-12)
    filters.of(x, P)


def test_what_is_known_exactly_learns_nothing_from_an_exact_measurement():
    for which in ("absorb", "pin"):
        filters = Filter()
        filters.P[1, 2], filters.P[1, :, 2] = 0.0, 0.0
        x, P = filters.copies()
        if which == "pin":
            kernel.pin(1, filters.x, filters.P, 2, 7.0, 0.0, filters.gain, filters.work, SIZE)
        else:
            stacks = filters.x, filters.P, np.eye(M), 2, 0.0
            found = kernel.innovate(1, *stacks, 7.0, filters.gain, SIZE)
            kernel.absorb(1, *stacks, *found, filters.gain, filters.work, SIZE)
        filters.of(x, P)


@pytest.mark.parametrize("turned", [0.0, 0.2])
@pytest.mark.parametrize("jump", [0.0, 1.5, -1.5])
@pytest.mark.parametrize("startled", [0.0, 0.6])
def test_loosened_are_the_bias_the_height_or_the_offset_and_the_velocity(turned, jump, startled):
    filters = Filter()
    x, P = filters.copies()
    # a height that has jumped by 1.5 m may be moving at 0.5 m/s; a negative jump is the offset's, state 4
    up, aside = max(jump, 0.0), max(-jump, 0.0)
    more = [up**2, startled + (up / 3) ** 2, turned, 0.0, aside**2]
    kernel.loosen(1, filters.P, turned, jump, startled, 4)
    filters.of(x, P + np.diag(more))


def test_reported_are_height_velocity_and_their_sds():
    filters, out = Filter(), np.full((4, 3), NAN)
    filters.P[1, 0, 0], filters.P[1, 1, 1] = 4.0, 9.0
    kernel.report(1, 1, filters.x, filters.P, out)
    np.testing.assert_array_equal(out[:, 1], [*filters.x[1, :2], 2.0, 3.0])
    filters.P[1, 0, 0], filters.P[1, 1, 1] = -1e-18, -1e-17  # rounding of what is known exactly
    kernel.report(2, 1, filters.x, filters.P, out)
    np.testing.assert_array_equal(out[2:, 2], 0.0)
    assert np.isnan(out[:, 0]).all()


def rows_of(n=40, seed=4):
    """Rows with all that may happen in them, now and then."""
    rng = np.random.default_rng(seed)
    F, B, Q = tables(seed)

    def now_and_then(values, nothing):
        return np.where(rng.random(n) < 0.3, values, nothing)

    transition = rng.integers(-1, 3, n)
    return kernel.Rows(
        0.3 * F, B, Q, *kernel.entries(F), transition,
        rng.normal(size=(2, M)), rng.random(2), rng.integers(0, 2, n), now_and_then(rng.normal(size=n), NAN),
        rng.random(n), rng.normal(size=n), rng.random(n), rng.random(n) < 0.3, rng.random(n),
        now_and_then(rng.normal(size=n), NAN), rng.random(n), now_and_then(rng.normal(size=n), 0.0),
        now_and_then(rng.random(n), 0.0), now_and_then(rng.random(n), 0.0), 3,
    )  # fmt: skip


def test_the_rows_are_filtered_in_the_order_of_the_docstring():
    rows, start = rows_of(), Filter(5)
    x, P, found = start.x[1], start.P[1], []
    eye = np.eye(M)
    for k, t in enumerate(rows.transition):
        if t >= 0:
            x = rows.F[t] @ x + rows.B[t] * rows.u[k]
            noise = rows.acceleration_variance[k] * np.outer(rows.B[t], rows.B[t])
            P = rows.F[t] @ P @ rows.F[t].T + rows.Q[t] + noise
        jump = rows.jump[k]
        P = P + np.diag([max(jump, 0) ** 2, (max(jump, 0) / 3) ** 2, rows.turned[k], min(jump, 0) ** 2, 0])
        P = P + rows.startled[k] * np.outer(eye[1], eye[1])
        if rows.at_rest[k]:
            x, P, _, _ = joseph(x, P, eye[1], rows.rest_variance[k], 0.0)
        if np.isfinite(rows.level[k]):
            x, P, _, _ = joseph(x, P, eye[0], rows.level_variance[k], rows.level[k])
        if np.isfinite(rows.z[k]):
            j = rows.measurement[k]
            x, P, _, _ = joseph(x, P, rows.H[j], rows.R[j], rows.z[k])
        found.append([*x[:2], *np.sqrt(np.diag(P)[:2])])
    out, last = np.empty((4, 40)), (start.x[1:].copy(), start.P[1:].copy())
    kernel.filter_rows(rows, SIZE, *last, out)
    np.testing.assert_allclose(out.T, found, rtol=1e-9, atol=1e-12)  # forty rows' rounding
    np.testing.assert_allclose(last[0][0], x, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(last[1][0], P, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("first", [False, True])
def test_one_row_in_plain_numbers_is_a_run_of_one_row(seed, first):
    rng, start = np.random.default_rng(seed), Filter(seed)
    F, B, Q = (table[:1] for table in tables(seed))
    if seed == 5:
        F = np.where(F == 0.0, 0.1, F)  # no entry is 0
    H = rng.normal(size=(1, M))
    z, level = (np.where(rng.random(2) < 0.7, rng.normal(size=2), NAN)).tolist()
    row = kernel.Row(z, *rng.random(3).tolist(), bool(seed % 2), 0.2, level, 0.4, 0.6 * (seed > 2), 4)
    index = np.array([-1 if first else 0])
    rows = kernel.Rows(
        F, B, Q, *kernel.entries(F), index, H, np.array([0.3]), np.zeros(1, np.int64),
        *(np.array([value]) for value in row[:8]),
        np.zeros(1), np.array([row.turned]), np.zeros(1), row.offset,
    )  # fmt: skip
    out, many = np.empty((4, 1)), (start.x[1:].copy(), start.P[1:].copy())
    kernel.filter_rows(rows, SIZE, *many, out)
    one = start.copies()
    found = kernel.filter_row(F, B, Q, H, 0.3, first, *row, SIZE, *one)
    assert found == tuple(out[:, 0])
    np.testing.assert_array_equal(one[0], many[0][0])
    np.testing.assert_array_equal(one[1], many[1][0])
    made = kernel.one_row(kernel.Tables(F, B, Q), H, 0.3, first, row)
    for name, one_of, other in zip(kernel.Rows._fields, made, rows, strict=True):
        length = len(other) if name == "columns" else None  # what lies beyond the last end is not read
        np.testing.assert_array_equal(one_of[:length] if length is not None else one_of, other, err_msg=name)
