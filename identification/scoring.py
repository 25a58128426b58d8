"""Climb a likelihood: damped Fisher scoring in the logarithms of the parameters."""

from __future__ import annotations

from typing import Final

import numpy as np

from baroarma.identification.problem import Problem, Signal

ENOUGH: Final = 1e-8
"""Expected gain of log-likelihood at which scoring stops: parameters are then right to 1e-4 of their sd."""


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
