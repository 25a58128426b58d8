"""A filter's rows are what the filter itself does."""

import numpy as np
import pytest

from baroarma import NoiseModel
from baroarma.estimators import height_estimator
from baroarma.estimators.base import Alignment
from baroarma.filter_rows import filter_rows

NOISE = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=20)
FILTERS = {
    "complementary": ("complementary", {}),
    "complementary, held": ("complementary", {"slow_barometer": "hold"}),
    "complementary, stiff": ("complementary", {"acceleration_sd": 20.0}),
    "kalman": ("kalman", {}),
    "kalman, midpoint": ("kalman", {"midpoint": True}),
    "coloured": ("coloured-kalman", {"gate": np.inf, "unresolved": 0.0}),
    "coloured, lagging": ("coloured-kalman", {"gate": np.inf, "unresolved": 0.0, "barometer_lag": 0.2}),
}


def check_rows(height, new, alignment=None, dt=0.05):
    """Repeat `run` with the rows, to rounding: 1e-9 of metres, after 100 rows."""
    rng = np.random.default_rng(1)
    n = len(new)
    z, a, t = np.where(new, rng.normal(size=n), np.nan), rng.normal(size=n), dt * np.arange(n)
    height.reset(alignment)
    expected = height.run(t, z, a)
    u = (np.r_[0, a[:-1]] + a) / 2 if height.drive.midpoint else np.r_[0, a[:-1]]
    held = np.nan_to_num(z)
    for k in range(1, n):
        held[k] = z[k] if new[k] else held[k - 1]
    rows = list(filter_rows(height, dt, new, alignment))
    assert len(rows) == n
    x = np.zeros(len(rows[0].b))
    for k, row in enumerate(rows):
        x = row.L @ x + row.before * (held[k - 1] if k else 0.0) + row.now * held[k] + row.b * u[k]
        assert x[:2] == pytest.approx([expected.height[k], expected.velocity[k]], abs=1e-9)
    assert abs(expected.height).max() > 0.1


@pytest.mark.parametrize("every", [1, 3])
@pytest.mark.parametrize("name", FILTERS)
def test_rows_give_the_numbers_of_run(name, every):
    kind, settings = FILTERS[name]
    height = height_estimator(kind, noise=NOISE, dt=0.05, **settings)
    check_rows(height, np.arange(100) % every == min(1, every - 1))


@pytest.mark.parametrize("name", FILTERS)
def test_a_barometer_that_comes_late_or_falls_silent_makes_no_difference(name):
    kind, settings = FILTERS[name]
    k = np.arange(100)
    check_rows(
        height_estimator(kind, noise=NOISE, dt=0.05, **settings), (k > 6) & ((k < 40) | (k > 90)) & (k != 20)
    )


def test_what_the_filter_is_reset_to_counts():
    height = height_estimator("coloured-kalman", noise=NOISE, dt=0.05, gate=np.inf, unresolved=0.0)
    check_rows(height, np.ones(100, bool), Alignment(gravity_sd=0.2, accel_sd=0.1))


@pytest.mark.parametrize("name", FILTERS)
def test_the_interval_of_the_rows_counts_and_not_the_filters_own(name):
    kind, settings = FILTERS[name]
    check_rows(height_estimator(kind, noise=NOISE, dt=0.02, **settings), np.ones(100, bool))
