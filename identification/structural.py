"""Structural maximum likelihood: white + Gauss-Markov + random-walk drift on the raw samples.

No detrending, averaging, decimating or windows: the exact likelihood of `kernels` takes the samples at the
times they have.  `fit_terms` maximises it over the logarithms of the parameters by Fisher scoring, started
from the structure function (mean squared height difference against lag), which is linear in the variances
for a given time constant.

Which terms the data support is decided among all combinations by BIC, and against a second Gauss-Markov term
(`select_terms`).  Intervals are in `intervals`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from baroarma.identification.kernels import LIKELIHOODS

Term = Literal["white", "drift", "gm", "gm2"]
Terms = tuple[Term, ...]
Signal = NDArray[np.float64]

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
PARAMETERS_OF: Final[dict[Term, tuple[int, ...]]] = {
    "white": (0,),
    "drift": (1,),
    "gm": (2, 3),
    "gm2": (4, 5),
}
"""Where the parameters of each term stand in theta."""
ENOUGH: Final = 1e-8
"""Expected gain of log-likelihood at which scoring stops: parameters are then right to 1e-4 of their sd."""
ENOUGH_TO_COMPARE: Final = 0.05
"""The same where only the likelihood is wanted, to compare it with penalties of log(n)."""


@dataclass(frozen=True, eq=False)
class Problem:
    """Hold the samples of one rest recording and evaluate models on them.

    Parameters
    ----------
    t, y : ndarray, shape (n,)
        Times in s and heights in m of the new samples.
    """

    t: Signal
    y: Signal

    def evaluate(self, theta: Signal) -> tuple[float, Signal, Signal]:
        """Return log-likelihood, its gradient and the Fisher information, both in log parameters."""
        value, gradient, information = _likelihood(theta)(self.t, self.y, theta, np.empty(0))
        return float(value), gradient, information

    def innovations(self, theta: Signal) -> Signal:
        """Return the standardised one-step prediction errors, shape (n - 1,)."""
        out = np.zeros(len(self.y))
        _likelihood(theta)(self.t, self.y, theta, out)
        return out[1:]

    @property
    def step(self) -> float:
        """Median sampling interval, s."""
        return float(np.median(np.diff(self.t)))

    @property
    def duration(self) -> float:
        """Time from first to last sample, s."""
        return float(self.t[-1] - self.t[0])

    def bounds(self, size: int) -> tuple[Signal, Signal]:
        """Return the least and greatest theta that this log can tell from 0 and from infinity.

        A correlation time below the sampling interval would be white noise in disguise.
        """
        scale = max(float(np.std(self.y)), 1e-12)
        least = [1e-4 * scale, 1e-4 * scale / math.sqrt(self.duration)]
        most = [1e2 * scale, 1e2 * scale / math.sqrt(self.step)]
        pairs = size // 2 - 1
        return (
            np.array(least + [1e-4 * scale, self.step] * pairs),
            np.array(most + [1e2 * scale, self.duration] * pairs),
        )


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


def free_parameters(terms: Terms) -> list[int]:
    """Return the indices in theta of the parameters that the terms bring with them."""
    return sorted(j for term in terms for j in PARAMETERS_OF[term])


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


def maximise(
    problem: Problem, theta: Signal, free: list[int], *, enough: float = ENOUGH, steps: int = 60
) -> tuple[Signal, float]:
    """Climb the log-likelihood by damped Fisher scoring in the logarithms of the free parameters.

    Parameters
    ----------
    problem : Problem
        The samples.
    theta : ndarray
        Where to start; parameters that are not free stay as they are.
    free : list of int
        Indices of the parameters to move.
    enough : float
        Stop when one more step is expected to gain less log-likelihood than this.
    steps : int
        Limit of the number of evaluations.

    Returns
    -------
    theta : ndarray
        The optimum, inside `Problem.bounds`.
    value : float
        Its log-likelihood.
    """
    low, high = problem.bounds(len(theta))
    theta = theta.copy()
    theta[free] = np.clip(theta[free], low[free], high[free])
    value, gradient, information = problem.evaluate(theta)
    damping = 1e-4
    for _ in range(steps):
        stuck = ((theta <= low) & (gradient < 0)) | ((theta >= high) & (gradient > 0))
        move = [j for j in free if not stuck[j]]
        if not move:
            break
        slope, curvature = gradient[move], information[np.ix_(move, move)]
        ridge = np.diag(damping * np.diag(curvature) + 1e-9)
        step = np.linalg.solve(curvature + ridge, slope)
        if 0.5 * float(slope @ step) < enough:
            break
        trial = theta.copy()
        trial[move] = np.clip(theta[move] * np.exp(np.clip(step, -1.5, 1.5)), low[move], high[move])
        new = problem.evaluate(trial)
        if new[0] >= value:
            theta, (value, gradient, information) = trial, new
            damping = max(0.1 * damping, 1e-9)
        elif damping > 1e6:
            break
        else:
            damping = max(10 * damping, 1e-3)
    return theta, value


def structure_starts(problem: Problem, terms: Terms, grid: int = 12) -> list[Signal]:
    """Return up to two starting points that match the structure function.

    The mean squared difference at lag l is 2 sigma_u² + 2 sigma_c² (1 - exp(-l/tau)) + q² l: linear in the
    variances, which non-negative least squares finds for each tau of a grid.
    """
    from scipy.optimize import nnls

    lags, differences, weight = _structure_function(problem)
    columns = {"white": 2 * np.ones_like(lags), "drift": lags}
    plain = [columns[term] for term in terms if term in columns]
    taus = np.geomspace(problem.step, problem.duration / 10, grid) if "gm" in terms else np.zeros(1)
    found = []
    for tau in taus:
        shapes = [*plain, 2 * -np.expm1(-lags / tau)] if tau else plain
        variances, misfit = nnls(weight[:, None] * np.stack(shapes, axis=1), weight * differences)
        found.append((misfit, tau, variances))
    starts = []
    for i, (misfit, tau, variances) in enumerate(found):
        neighbours = [found[j][0] for j in (i - 1, i + 1) if 0 <= j < len(found)]
        if all(misfit <= other for other in neighbours):
            starts.append((misfit, _from_variances(problem, terms, variances, tau)))
    starts.sort(key=lambda s: s[0])
    return [theta for _, theta in starts[:2]]


def _least_bic(terms: Terms, fits: list[StructuralFit]) -> float:
    """Bound the BIC of a combination from below: it can't be likelier than a larger one."""
    ceiling = min(fit.log_likelihood for fit in fits if set(terms) < set(fit.terms))
    return len(free_parameters(terms)) * math.log(fits[0].n - 1) - 2 * ceiling


def _likelihood(theta: Signal):  # type: ignore[no-untyped-def]  # numba's dispatcher has no type
    return LIKELIHOODS[len(theta) // 2 - 1]


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


def _structure_function(problem: Problem) -> tuple[Signal, Signal, Signal]:
    """Return mean lags (s), mean squared differences (m²) and weights (their inverse relative errors)."""
    n = len(problem.y)
    steps = np.unique(np.geomspace(1, max(n // 4, 2), 16).astype(int))
    lags, differences, weight = np.empty((3, len(steps)))
    for i, k in enumerate(steps):
        lags[i] = np.mean(problem.t[k:] - problem.t[:-k])
        differences[i] = max(np.mean((problem.y[k:] - problem.y[:-k]) ** 2), 1e-24)
        weight[i] = math.sqrt(n / k) / differences[i]
    return lags, differences, weight


def _from_variances(problem: Problem, terms: Terms, variances: Signal, tau: float) -> Signal:
    """Arrange the structure function's variances as theta, none so small that scoring could not move it."""
    floor = 1e-3 * float(np.var(problem.y)) + 1e-24
    order = [term for term in terms if term in ("white", "drift")] + (["gm"] if "gm" in terms else [])
    theta = np.zeros(4 if "gm" in terms else 2)
    for term, variance in zip(order, variances, strict=True):
        least = floor / problem.duration if term == "drift" else floor
        theta[PARAMETERS_OF[term][0]] = math.sqrt(max(variance, least))
    if "gm" in terms:
        theta[3] = tau
    return theta
