"""The papers' tests: equal variances (Bartlett), signed ranks (Wilcoxon), asterisks.

Bartlett's name stands for two tests: here it is the one of equal variances [SG14, Sec. 2.3], not that of the
cumulative periodogram [SG13, Sec. 2.5].
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def equal_variance_p(first: ArrayLike, second: ArrayLike) -> float:
    """Return the p-value of Bartlett's test that two samples have one variance; NaN for fewer than 2 each.

    Examples
    --------
    >>> equal_variance_p([1.0, 2.0, 3.0, 4.0], [1.0, 9.0, 17.0, 25.0]) < 0.05
    True
    """
    from scipy.stats import bartlett

    samples = _finite(first), _finite(second)
    if min(map(len, samples)) < 2 or not min(map(np.ptp, samples)) > 0:
        return float("nan")
    return float(bartlett(*samples).pvalue)


def paired_p(first: ArrayLike, second: ArrayLike) -> float:
    """Return the two-sided p-value of Wilcoxon's signed-rank test that pairs don't differ; NaN without pairs.

    Ten pairs cannot give less than 2/1024.

    Examples
    --------
    >>> paired_p(range(10), range(1, 11))
    0.001953125
    """
    return signed_rank_p(np.asarray(first, float) - np.asarray(second, float), 0.0)


def signed_rank_p(sample: ArrayLike, median: float) -> float:
    """Return the two-sided p-value of Wilcoxon's test that a sample has this median; NaN without values."""
    from scipy.stats import wilcoxon

    difference = _finite(sample) - median
    if not np.any(difference):
        return float("nan") if not len(difference) else 1.0
    return float(wilcoxon(difference).pvalue)


def asterisks(p: float) -> str:
    """Return the papers' mark: * p < 0.05, ** p < 0.01 [SG14, Sec. 3.1].

    SG14 also prints ***, which it does not define and which ten pairs cannot reach at p < 0.001.

    Examples
    --------
    >>> asterisks(0.03), asterisks(0.002), asterisks(0.2)
    ('*', '**', '')
    """
    return "**" if p < 0.01 else "*" if p < 0.05 else ""


def _finite(sample: ArrayLike) -> NDArray[np.float64]:
    x: NDArray[np.float64] = np.asarray(sample, float)
    return x[np.isfinite(x)]
