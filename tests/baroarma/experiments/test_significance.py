"""The papers' tests against definitions."""

import math
from itertools import product

import numpy as np
import pytest
from scipy.stats import chi2

from baroarma.experiments.significance import asterisks, equal_variance_p, paired_p, signed_rank_p


def test_signed_ranks_are_counted_exactly():
    x = np.array([0.3, -0.1, 0.7, 1.1, -0.2, 0.9])
    ranks = np.argsort(np.argsort(np.abs(x))) + 1
    plus = min(ranks[x > 0].sum(), ranks[x < 0].sum())
    sums = [min(s := float(np.dot(signs, ranks)), 21 - s) for signs in product((0, 1), repeat=6)]
    assert signed_rank_p(x, 0.0) == pytest.approx(np.mean(np.array(sums) <= plus))
    assert signed_rank_p(x + 5, 5.0) == pytest.approx(signed_rank_p(x, 0.0))


def test_ten_pairs_cannot_reach_three_asterisks():
    a = np.arange(10.0)
    assert paired_p(a, a + 1 + 0.1 * a) == pytest.approx(2 / 2**10)  # > 0.001


def test_equal_variances_follow_bartletts_formula():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=10), rng.normal(scale=3, size=10)
    va, vb = np.var(a, ddof=1), np.var(b, ddof=1)
    statistic = (18 * np.log((va + vb) / 2) - 9 * (np.log(va) + np.log(vb))) / (1 + (2 / 9 - 1 / 18) / 3)
    assert equal_variance_p(a, b) == pytest.approx(chi2.sf(statistic, 1))


def test_without_data_there_is_no_p():
    assert math.isnan(equal_variance_p([1.0], [2.0]))
    assert math.isnan(equal_variance_p([1.0, 1.0], [1.0, 2.0]))
    assert math.isnan(paired_p([], []))
    assert math.isnan(paired_p([np.nan], [1.0]))
    assert paired_p([1.0, 2.0], [1.0, 2.0]) == 1.0


def test_asterisks_are_the_papers():
    assert [asterisks(p) for p in (0.0001, 0.0099, 0.01, 0.049, 0.05)] == ["**", "**", "*", "*", ""]
