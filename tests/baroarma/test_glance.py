"""A glance sees what the whole shows, at little cost."""

import numpy as np
import pytest

from baroarma.glance import (
    BUSIEST_ROWS,
    ENOUGH_ROWS,
    busiest_part,
    column_ranges,
    greatest,
    some_rows,
    some_values,
    usual_interval,
)
from baroarma.recording import Recording


@pytest.mark.parametrize("n", [1, 255, ENOUGH_ROWS, ENOUGH_ROWS + 1, 10**6 + 7])
def test_some_rows_are_rows_once_each_from_the_first_to_the_last(n):
    rows = some_rows(n)
    assert len(rows) == min(n, ENOUGH_ROWS)
    assert rows[0] == 0
    assert rows[-1] == n - 1
    if n <= ENOUGH_ROWS or n > 2 * ENOUGH_ROWS:  # chunks overlap only where they must
        assert (np.diff(rows) > 0).all()


def test_a_sensor_in_every_fifth_row_is_seen_whatever_the_stride():
    signal = np.full(10**6, np.nan)
    signal[::5] = np.random.default_rng(1).normal(10, 1, 200_000)
    some = some_values(signal)
    assert len(some) == pytest.approx(ENOUGH_ROWS / 5, rel=0.01)
    assert np.median(some) == pytest.approx(10, abs=4 * 1.25 / np.sqrt(len(some)))  # the sd of a median


@pytest.mark.parametrize("n", [0, 1, 63, 64, 1000])
def test_extremes_are_those_of_numpy(n):
    signal = np.random.default_rng(n).normal(size=(n, 3))
    signal[::7, 1] = np.nan
    if n > 1:
        np.testing.assert_array_equal(column_ranges(signal), [np.nanmax(signal, 0), np.nanmin(signal, 0)])
    assert greatest(signal) == (np.nanmax(np.abs(signal)) if n else 0.0)


def test_the_usual_interval_is_the_median_and_gaps_do_not_matter():
    t = np.cumsum(np.r_[np.full(50_000, 0.02), 1000.0, np.full(50_000, 0.02)])
    assert usual_interval(t) == pytest.approx(0.02)
    assert usual_interval(t[:1]) == 0.0


def test_the_busiest_part_is_where_it_tilts():
    n = 200_000
    t = np.arange(n) / 50
    accel = np.tile([0.0, 0.0, 9.8], (n, 1))
    moving = slice(150_000, 160_000)
    accel[moving, 0] = 3 * np.sin(t[moving])
    log = Recording(t=t, pressure=np.full(n, 1e5), accel=accel)
    part = busiest_part(log)
    assert len(part) == BUSIEST_ROWS
    assert part.t[0] <= t[150_000]
    assert part.t[-1] >= t[159_999]
    short = log.rows(slice(1000))
    assert busiest_part(short) is short
