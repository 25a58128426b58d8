"""A filter's rows are what the filter itself does."""

import numpy as np
import pytest

from baroarma import NoiseModel
from baroarma.estimators import height_estimator
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


@pytest.mark.parametrize("every", [1, 3])
@pytest.mark.parametrize("name", FILTERS)
def test_rows_give_the_numbers_of_run(name, every):
    """To rounding: 1e-9 of metres, after 100 rows."""
    kind, settings = FILTERS[name]
    height = height_estimator(kind, noise=NOISE, dt=0.05, **settings)
    rng = np.random.default_rng(1)
    n = 100
    new = np.arange(n) % every == min(1, every - 1)
    z, a, t = np.where(new, rng.normal(size=n), np.nan), rng.normal(size=n), np.arange(n) / 20
    expected = height.run(t, z, a)
    u = (np.r_[0, a[:-1]] + a) / 2 if height.drive.midpoint else np.r_[0, a[:-1]]
    held = np.nan_to_num(z)
    for k in range(1, n):
        held[k] = z[k] if new[k] else held[k - 1]
    x = 0.0
    for k, row in enumerate(filter_rows(height, 0.05, new)):
        before = held[k - 1] if k else 0.0
        x = (
            row.L @ (x if k else np.zeros(len(row.b)))
            + row.before * before
            + row.now * held[k]
            + row.b * u[k]
        )
        assert x[:2] == pytest.approx([expected.height[k], expected.velocity[k]], abs=1e-9)
    assert abs(expected.height).max() > 0.1
