"""Where to start the climb: the model that matches the structure function.

The mean squared height difference at lag l is 2 sigma_u² + 2 sigma_c² (1 - exp(-l/tau)) + q² l: linear in the
variances, which non-negative least squares finds for each tau of a grid.
"""

from __future__ import annotations

import math

import numpy as np

from baroarma.identification.problem import PARAMETERS_OF, Problem, Signal, Terms


def structure_starts(problem: Problem, terms: Terms, grid: int = 12) -> list[Signal]:
    """Return up to two starting points, the best of a local minimum of the misfit over tau each.

    Parameters
    ----------
    problem : Problem
        The samples.
    terms : tuple of str
        The model's terms; at most one Gauss-Markov term.
    grid : int
        Number of correlation times tried, from one sampling interval to a tenth of the log.

    Returns
    -------
    list of ndarray
        Vectors theta, the best first.
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


def _structure_function(problem: Problem) -> tuple[Signal, Signal, Signal]:
    """Return mean lags (s), mean squared differences (m²) and weights (their inverse relative errors)."""
    n = len(problem.y)
    steps = np.unique(np.geomspace(1, max(n // 4, 2), 16).astype(int))
    lags, differences, weight = np.empty((3, len(steps)))
    for i, k in enumerate(steps):
        lags[i] = np.mean(problem.t[k:] - problem.t[:-k])
        differences[i] = max(float(np.mean((problem.y[k:] - problem.y[:-k]) ** 2)), 1e-24)
        weight[i] = math.sqrt(n / k) / differences[i]
    return lags, differences, weight


def _from_variances(problem: Problem, terms: Terms, variances: Signal, tau: float) -> Signal:
    """Arrange the structure function's variances as theta, none so small that scoring could not move it."""
    floor = 1e-3 * float(np.var(problem.y)) + 1e-24
    order = sorted(terms, key=lambda term: term == "gm")  # the Gauss-Markov term stands last
    theta = np.zeros(4 if "gm" in terms else 2)
    for term, variance in zip(order, variances, strict=True):
        least = floor / problem.duration if term == "drift" else floor
        theta[PARAMETERS_OF[term][0]] = math.sqrt(max(variance, least))
    if "gm" in terms:
        theta[3] = tau
    return theta
