"""95 % intervals of a structural fit.

Parameters that the model has: Wald intervals on the log scale from the observed information, which keeps
them positive; [0, upper] for an sd that was asked for but vanishes.  The drift's log-likelihood is far from a
parabola near 0, so its interval is where the profile likelihood (all other parameters refitted) lies within
chi²(0.95)/2 of the maximum.  A term that the model lacks gets [0, upper], the upper end from the profile
likelihood of the model with that term added; for a Gauss-Markov term, over correlation times from two
sampling intervals to a tenth of the log: shorter ones can't be told from white noise, longer ones not from
drift.
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Final

import numpy as np

from baroarma.identification.problem import Problem, Signal, Term, free_parameters
from baroarma.identification.scoring import maximise
from baroarma.identification.structural import StructuralFit, fit_terms
from baroarma.noise_model import Interval

Z95: Final = NormalDist().inv_cdf(0.975)
"""Two-sided 95 % quantile of the normal distribution."""
CHI95: Final = Z95**2
"""95 % quantile of the chi-squared distribution with one degree of freedom."""
TERM_ORDER: Final[tuple[Term, ...]] = ("white", "drift", "gm")


def intervals(problem: Problem, fit: StructuralFit) -> dict[str, Interval]:
    """Return the 95 % interval of each of the four parameters by name.

    Parameters
    ----------
    problem : Problem
        The samples.
    fit : StructuralFit
        A fit with at most one Gauss-Markov term.

    Returns
    -------
    dict
        ``{"white_sd": (low, high), "drift_rate": ..., "correlated_sd": ..., "correlation_time": ...}``, in
        the fields' units.
    """
    sd = log_sd(problem, fit)
    profile = _Profile(problem, fit)
    found = {}
    for j in fit.free:
        name = _NAMES[j]
        if name == "drift_rate":
            found[name] = profile.limit(j, -1, sd[j]), profile.limit(j, +1, sd[j])
        elif name != "correlation_time" and fit.theta[j] <= 1.01 * profile.low[j]:
            found[name] = 0.0, profile.limit(j, +1, sd[j])  # asked for, but not in the data
        else:
            found[name] = _log_interval(float(fit.theta[j]), float(sd[j]))
    for term in TERM_ORDER:
        if term not in fit.terms:
            found[_NAMES[free_parameters((term,))[0]]] = 0.0, _upper_if_added(problem, fit, term)
    if "gm" not in fit.terms:
        found["correlation_time"] = 0.0, problem.duration / 10
    return found


_NAMES: Final = {0: "white_sd", 1: "drift_rate", 2: "correlated_sd", 3: "correlation_time"}
"""Fields of `NoiseModel` by their place in theta."""


def log_sd(problem: Problem, fit: StructuralFit) -> Signal:
    """Return the standard deviations of the log parameters; 0 for those that the model lacks.

    A prior of sd 5 (a factor of 150) keeps them finite where the data know nothing about a parameter.
    """
    information = observed_information(problem, fit.theta, fit.free)
    sd = np.zeros(len(fit.theta))
    sd[fit.free] = np.sqrt(np.diag(np.linalg.inv(information + np.eye(len(fit.free)) / 25)))
    return sd


def observed_information(problem: Problem, theta: Signal, free: list[int]) -> Signal:
    """Return minus the Hessian of the log-likelihood in log parameters, from the exact gradient.

    Where the maximum lies on the edge of the range the Hessian is not positive definite; the Fisher
    information then takes its place.
    """
    step = 1e-4
    hessian = np.empty((len(free), len(free)))
    for i, j in enumerate(free):
        gradients = []
        for sign in (+1, -1):
            moved = theta.copy()
            moved[j] *= math.exp(sign * step)
            gradients.append(problem.evaluate(moved)[1][free])
        hessian[i] = (gradients[1] - gradients[0]) / (2 * step)
    hessian = 0.5 * (hessian + hessian.T)
    if np.linalg.eigvalsh(hessian)[0] <= 0:
        return problem.evaluate(theta)[2][np.ix_(free, free)]
    return hessian


class _Profile:
    """The profile likelihood of one fit: hold a parameter, refit the others."""

    def __init__(self, problem: Problem, fit: StructuralFit) -> None:
        self.problem, self.fit = problem, fit
        self.low, self.high = problem.bounds(len(fit.theta))

    def limit(self, j: int, sign: int, log_sd: float) -> float:
        """Return where twice the fall of log-likelihood reaches CHI95; 0 if it never does downwards."""
        theta, log_best = self.fit.theta.copy(), math.log(self.fit.theta[j])
        edge = math.log((self.low if sign < 0 else self.high)[j])
        inside, outside = (log_best, -CHI95), (edge, math.inf)
        x = log_best + sign * Z95 * min(max(log_sd, 0.01), 0.5)
        for _ in range(30):
            x = min(max(x, min(log_best, edge)), max(log_best, edge))
            theta[j] = math.exp(x)
            excess, theta = self._excess(theta, j)
            if abs(excess) < 0.01 * CHI95:
                return math.exp(x)
            if excess > 0:
                outside = (x, excess)
            elif x == edge:
                return 0.0 if sign < 0 else math.exp(edge)
            else:
                inside = (x, excess)
            x = self._next(log_best, inside, outside, sign)
        return math.exp(x)

    def _next(
        self, log_best: float, inside: tuple[float, float], outside: tuple[float, float], sign: int
    ) -> float:
        """Interpolate the square root of the fall, nearly linear; outside an open bracket, step on."""
        if math.isinf(outside[1]):
            return inside[0] + sign * max(0.5, abs(inside[0] - log_best))
        r_in, r_out = math.sqrt(max(inside[1] + CHI95, 0)), math.sqrt(outside[1] + CHI95)
        share = (Z95 - r_in) / (r_out - r_in)
        return inside[0] + min(max(share, 0.05), 0.95) * (outside[0] - inside[0])

    def _excess(self, theta: Signal, j: int) -> tuple[float, Signal]:
        others = [i for i in self.fit.free if i != j]
        theta, value = maximise(self.problem, theta, others, enough=1e-3)
        return 2 * (self.fit.log_likelihood - value) - CHI95, theta


def _upper_if_added(problem: Problem, fit: StructuralFit, term: Term) -> float:
    """Return the upper profile limit of a term's size in the model that has it."""
    terms = tuple(t for t in TERM_ORDER if t in fit.terms or t == term)
    bounded = _GaussMarkovRange(problem.t, problem.y) if term == "gm" else problem
    larger = fit_terms(bounded, terms)
    return _Profile(bounded, larger).limit(free_parameters((term,))[0], +1, 0.5)


class _GaussMarkovRange(Problem):
    """The same samples, with correlation times only where a Gauss-Markov term is one of its own."""

    def bounds(self, size: int) -> tuple[Signal, Signal]:
        low, high = super().bounds(size)
        low[3::2], high[3::2] = 2 * self.step, self.duration / 10
        return low, high


def _log_interval(value: float, log_sd: float) -> Interval:
    factor = math.exp(Z95 * log_sd)
    return value / factor, value * factor
