"""The golden ride: what it exercises, at any rate."""

import numpy as np
import pytest

from baroarma.export.golden import golden_ride


@pytest.mark.parametrize("rate_hz", [4.0, 30.0, 50.0, 400.0])
def test_the_alignment_is_complete_and_later_each_sensor_misses_samples(rate_hz):
    ride = golden_ride(rate_hz)
    early = ride.t < 1
    assert early.sum() == rate_hz
    for signal in (ride.pressure, ride.accel[:, 0], ride.gyro[:, 0]):
        assert np.isfinite(signal[early]).all()
        assert np.isnan(signal[~early]).any() or rate_hz < 10  # with 14 rows left not all of them
    assert np.isnan(ride.pressure[~early]).any()


def test_it_moves_and_turns_more_than_filters_like():
    ride = golden_ride(50.0)
    assert np.nanmax(np.abs(np.linalg.norm(ride.accel, axis=1) - 9.8)) > 3
    assert np.nanmax(np.abs(ride.gyro)) > 0.5


def test_inputs_are_decimals_that_c_reads_exactly():
    ride = golden_ride(50.0)
    values = np.concatenate([ride.accel.ravel(), ride.gyro.ravel(), ride.pressure])
    assert all(float(f"{x:.7g}") == x for x in values[np.isfinite(values)])
