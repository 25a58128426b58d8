import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import trim_mean

from baroarma.identification.preprocessing import (
    WindowSettings,
    condition,
    detrend,
    moving_average,
    stretches,
    trimmed_mean,
)

RATE = 50.0


def grid(seconds, rate=RATE):
    return np.arange(round(seconds * rate)) / rate


def test_detrending_leaves_no_mean_in_any_minute():
    t = grid(180)
    x = detrend(t, np.random.default_rng(0).normal(size=len(t)) + 0.1 * t, 60.0)
    # Sums of 3000 numbers of size 5 lose at most about 3000 * 5 * 2e-16.
    np.testing.assert_allclose(x.reshape(3, -1).mean(1), 0, atol=1e-11)


def test_detrending_by_one_endless_block_removes_the_mean():
    x = np.random.default_rng(0).normal(size=1000)
    np.testing.assert_allclose(detrend(grid(20), x, np.inf), x - x.mean(), atol=1e-14)


def test_the_moving_average_is_the_causal_filter_once_it_is_full():
    x = np.random.default_rng(0).normal(size=200)
    expected = lfilter(np.full(4, 0.25), 1, x)[3:]
    np.testing.assert_allclose(moving_average(x, 4), expected, atol=1e-14)


def test_fifty_hertz_gets_the_paper_s_recipe():
    assert WindowSettings.for_rate(50) == WindowSettings(average=4, decimate=5, window=300, detrend_s=60)


@pytest.mark.parametrize("rate", [1, 6.8, 8.7, 10, 11.9, 12, 15, 20, 25, 50, 60, 80, 100, 371, 1000])
def test_other_rates_decimate_towards_a_tenth_of_a_second(rate):
    s = WindowSettings.for_rate(rate)
    if rate < 12:
        assert (s.average, s.decimate) == (1, 1)
    else:
        assert abs(s.decimate - 0.1 * rate) <= 0.5  # the nearest whole number of samples
        assert s.average < s.decimate or s.average == s.decimate == 1


def test_windows_are_what_the_recipe_says_step_by_step():
    t, x = grid(600), np.random.default_rng(1).normal(size=30000)
    cut = condition(t, x)
    level = np.repeat(x.reshape(10, 3000).mean(1), 3000)
    averaged = lfilter(np.full(4, 0.25), 1, x - level)[3::5]
    np.testing.assert_allclose(cut.windows.ravel(), averaged[: 20 * 300], atol=1e-12)
    assert (cut.gaps, cut.skipped, cut.rate_hz) == (0, 0, pytest.approx(50.0))
    assert cut.dt == pytest.approx(0.1)
    np.testing.assert_allclose(cut.start, t[3::5][::300][:20])


def test_no_window_contains_a_gap_and_the_lost_ones_are_counted():
    t, x = grid(600), np.random.default_rng(2).normal(size=30000)
    keep = (t < 100) | (t > 103)
    cut = condition(t[keep], x[keep])
    parts = [condition(t[part], x[part]) for part in (t < 100, t > 103)]
    np.testing.assert_allclose(cut.windows, np.concatenate([p.windows for p in parts]), atol=1e-12)
    assert len(cut.windows) == 3 + 16  # of 100 s and of 497 s
    assert (cut.gaps, cut.skipped) == (1, 1)


def test_one_missing_sample_is_a_gap_and_so_is_a_surplus_one():
    t = grid(10)
    assert len(stretches(np.delete(t, 200))) == 2
    assert len(stretches(np.sort(np.append(t, t[200] + 0.004)))) == 2  # intervals of 4 and 16 ms
    assert len(stretches(np.sort(np.append(t, t[200] + 0.010)))) == 3  # twice 10 ms


def test_jitter_is_tolerated_and_measured():
    rng = np.random.default_rng(3)
    t = np.cumsum(0.02 * (1 + rng.uniform(-0.3, 0.3, 6000)))
    cut = condition(t, rng.normal(size=6000))
    assert cut.gaps == 0
    # The RMS of a uniform deviation of 0.3 is 0.3/sqrt(3); its relative sd over 6000 intervals is 0.6 %.
    assert cut.jitter == pytest.approx(0.3 / np.sqrt(3), rel=0.02)


def test_rows_without_a_new_sample_change_nothing():
    t, x = grid(120), np.random.default_rng(4).normal(size=6000)
    rows = np.sort(np.concatenate([t, t + 0.007]))
    height = np.full(12000, np.nan)
    height[::2] = x
    np.testing.assert_array_equal(condition(rows, height).windows, condition(t, x).windows)


def test_the_whitening_filter_works_on_detrended_raw_samples():
    t, x = grid(60), np.random.default_rng(5).normal(size=3000)
    np.testing.assert_allclose(
        condition(t, x, whitening=lambda y: -2 * y).windows, -2 * condition(t, x).windows, atol=1e-13
    )


@pytest.mark.parametrize("n", [5, 10, 20, 21, 120])
def test_ten_percent_trimming_is_five_per_end(n):
    x = np.random.default_rng(n).standard_t(2, size=n)
    # MATLAB rounds the number of values per end to the nearest integer, a half downwards.
    k = {5: 0, 10: 0, 20: 1, 21: 1, 120: 6}[n]
    kept = np.sort(x)[k : n - k]
    got = trimmed_mean(x, 0.10)
    assert got.mean == pytest.approx(kept.mean(), abs=1e-14)
    assert got.sd == pytest.approx(kept.std(ddof=1), abs=1e-14)
    if n in (20, 120):
        assert got.mean == pytest.approx(trim_mean(x, 0.05), abs=1e-14)


def test_the_trimmed_sd_of_normal_values_is_79_percent_of_the_plain_one():
    x = np.random.default_rng(6).normal(size=40000)
    # Variance of a normal cut at its 5 % quantiles z: 1 - 2 z phi(z)/0.9.  An sd of 36 000 values: 0.4 %.
    z, phi = 1.6448536, 0.1031356
    assert trimmed_mean(x).sd == pytest.approx(np.sqrt(1 - 2 * z * phi / 0.9), rel=0.012)


def test_the_interval_of_a_trimmed_mean_covers_the_truth_in_95_percent():
    rng = np.random.default_rng(7)
    intervals = np.array([trimmed_mean(rng.normal(size=20)).ci95 for _ in range(3000)])
    covered = np.mean((intervals[:, 0] < 0) & (intervals[:, 1] > 0))
    assert 0.938 < covered < 0.962  # 3 binomial sds


def test_few_values_have_a_mean_but_no_sd():
    got = trimmed_mean([1.0, np.nan, 3.0])
    assert (got.mean, got.sd, got.ci95, got.n) == (2.0, None, None, 2)
    assert np.isnan(trimmed_mean([np.nan]).mean)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"window": 12}, "window of 12 samples is too short"),
        ({"average": 0}, "at least 1"),
        ({"trim": 1.0}, "trim"),
        ({"jitter": 2.0}, "jitter"),
        ({"detrend_s": 0.0}, "detrend_s"),
    ],
)
def test_impossible_settings_are_refused_with_their_value(change, words):
    with pytest.raises(ValueError, match=words):
        WindowSettings(**change)


def test_a_clock_that_runs_backwards_is_refused():
    with pytest.raises(ValueError, match="time must increase"):
        condition([0.0, 0.1, 0.05], [1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match="at least 2"):
        condition([0.0, 0.1], [1.0, np.nan])
