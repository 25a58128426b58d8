"""Structural maximum likelihood: white + Gauss-Markov + random-walk drift on the raw samples.

No detrending, averaging, decimating or windows: the exact likelihood of `kernels` takes the samples at the
times they have.  `fit_terms` starts from the structure function (`starts`) and climbs the likelihood over the
logarithms of the parameters (`scoring`).

Which terms the data support is decided among all combinations by BIC, and against a second Gauss-Markov term
(`select_terms`).  Intervals are in `intervals`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from baroarma.identification.problem import Problem, Signal, Terms, free_parameters
from baroarma.identification.scoring import ENOUGH, maximise
from baroarma.identification.starts import structure_starts

SUBSETS: Final[tuple[Terms, ...]] = (
    ("white", "drift", "gm"),
    ("white", "gm"),
    ("drift", "gm"),
    ("gm",),
    ("white", "drift"),
    ("drift",),
    ("white",),
)
"""Combinations of terms that `select_terms` compares, the largest first."""
ENOUGH_TO_COMPARE: Final = 0.05
"""Expected gain at which scoring stops where only the likelihood is wanted, next to penalties of log(n)."""


@dataclass(frozen=True, eq=False)
class StructuralFit:
    """Hold one maximum-likelihood fit.

    Parameters
    ----------
    terms : tuple of str
        The model's terms: "white", "drift", "gm", and "gm2" for a second Gauss-Markov term.
    theta : ndarray, shape (2 + 2 m,)
        white_sd (m), drift_rate (m/sqrt(s)), then sd (m) and correlation time (s) of each Gauss-Markov
        term; 0 where the model lacks the term.
    log_likelihood : float
        Exact Gaussian log-likelihood, given a flat prior of the level.
    n : int
        Number of samples.

    Examples
    --------
    BIC is k log(n - 1) - 2 log-likelihood; here k = 1 and n - 1 = 100:

    >>> fit = StructuralFit(("white",), np.array([0.46, 0.0]), log_likelihood=-60.0, n=101)
    >>> fit.free, round(fit.bic - math.log(100), 9)
    ([0], 120.0)
    """

    terms: Terms
    theta: Signal
    log_likelihood: float
    n: int

    @property
    def free(self) -> list[int]:
        """Indices in theta of the model's parameters."""
        return free_parameters(self.terms)

    @property
    def bic(self) -> float:
        """Bayesian information criterion: smaller is better."""
        return len(self.free) * math.log(self.n - 1) - 2 * self.log_likelihood


def select_terms(problem: Problem) -> tuple[StructuralFit, list[StructuralFit]]:
    """Choose among all combinations of terms by BIC.

    A combination whose BIC could not win even with the likelihood of a larger one is not fitted.

    Parameters
    ----------
    problem : Problem
        The samples.

    Returns
    -------
    best : StructuralFit
        The combination with the smallest BIC that has at most one Gauss-Markov term.
    fits : list of StructuralFit
        All that were fitted, the best first; one with "gm2" among them when `best` has "gm".
    """
    best = fit_terms(problem, SUBSETS[0])
    fits = [best]
    for terms in SUBSETS[1:]:
        if _least_bic(terms, fits) < best.bic:
            fits.append(fit_terms(problem, terms, fits[0].theta))
            best = min(fits, key=lambda fit: fit.bic)
    if "gm" in best.terms:
        fits.append(fit_second_gauss_markov(problem, best))
    return best, sorted(fits, key=lambda fit: fit.bic)


def fit_terms(problem: Problem, terms: Terms, start: Signal | None = None) -> StructuralFit:
    """Fit the given terms by maximum likelihood.

    Parameters
    ----------
    problem : Problem
        The samples.
    terms : tuple of str
        The model's terms.
    start : ndarray, optional
        A point to start from besides those of the structure function, such as a larger model's optimum.

    Returns
    -------
    StructuralFit
        The best optimum found.
    """
    starts = structure_starts(problem, terms)
    if start is not None:
        starts.append(_on_terms(start, terms))
    return _best_of(problem, terms, starts)


def fit_second_gauss_markov(problem: Problem, fit: StructuralFit) -> StructuralFit:
    """Fit the model with a second Gauss-Markov term, started a factor of 6 to either side of the first."""
    starts = []
    for factor in (1 / 6, 6.0):
        theta = np.append(fit.theta, (0.5 * fit.theta[2], factor * fit.theta[3]))
        theta[2] *= math.sqrt(0.75)
        starts.append(theta)
    return _best_of(problem, (*fit.terms, "gm2"), starts, ENOUGH_TO_COMPARE)


def _least_bic(terms: Terms, fits: list[StructuralFit]) -> float:
    """Bound the BIC of a combination from below: it can't be likelier than a larger one."""
    ceiling = min(fit.log_likelihood for fit in fits if set(terms) < set(fit.terms))
    return len(free_parameters(terms)) * math.log(fits[0].n - 1) - 2 * ceiling


def _best_of(problem: Problem, terms: Terms, starts: list[Signal], enough: float = ENOUGH) -> StructuralFit:
    """Climb from the highest start, and from the others unless they are close to where that led."""
    free = free_parameters(terms)
    low, high = problem.bounds(len(starts[0]))
    clipped = []
    for start in starts:
        start[free] = np.clip(start[free], low[free], high[free])
        clipped.append((problem.evaluate(start)[0], start))
    clipped.sort(key=lambda c: c[0], reverse=True)
    tops: list[tuple[Signal, float]] = []
    for _, start in clipped:
        if all(np.abs(np.log(start[free] / top[free])).max() > 0.7 for top, _ in tops):
            tops.append(maximise(problem, start, free, enough=enough))
    theta, value = max(tops, key=lambda top: top[1])
    return StructuralFit(terms, theta, value, len(problem.y))


def _on_terms(theta: Signal, terms: Terms) -> Signal:
    """Keep the parameters of the given terms and switch the others off."""
    free = free_parameters(terms)
    out = np.zeros(4 if "gm" in terms else 2)
    out[free] = theta[free]
    return out
