"""The problem that maximum likelihood solves: samples of a rest recording, and models to hold against them.

A model is a vector theta: white_sd (m), drift_rate (m/sqrt(s)), then sd (m) and correlation time (s) of each
Gauss-Markov term; 0 switches a term off.  Derivatives are with respect to the logarithms.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from baroarma.identification.kernels import LIKELIHOODS

Term = Literal["white", "drift", "gm", "gm2"]
Terms = tuple[Term, ...]
Signal = NDArray[np.float64]

PARAMETERS_OF: Final[dict[Term, tuple[int, ...]]] = {
    "white": (0,),
    "drift": (1,),
    "gm": (2, 3),
    "gm2": (4, 5),
}
"""Where the parameters of each term stand in theta."""


def free_parameters(terms: Terms) -> list[int]:
    """Return the indices in theta of the parameters that the terms bring with them."""
    return sorted(j for term in terms for j in PARAMETERS_OF[term])


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

    @cached_property
    def step(self) -> float:
        """Median sampling interval, s."""
        return float(np.median(np.diff(self.t)))

    @cached_property
    def duration(self) -> float:
        """Time from first to last sample, s."""
        return float(self.t[-1] - self.t[0])

    @cached_property
    def scale(self) -> float:
        """Standard deviation of the heights, m; never 0."""
        return max(float(np.std(self.y)), 1e-12)

    def bounds(self, size: int) -> tuple[Signal, Signal]:
        """Return the least and greatest theta that this log can tell from 0 and from infinity.

        A correlation time below the sampling interval would be white noise in disguise.
        """
        scale = self.scale
        least = [1e-4 * scale, 1e-4 * scale / math.sqrt(self.duration)]
        most = [1e2 * scale, 1e2 * scale / math.sqrt(self.step)]
        pairs = size // 2 - 1
        return (
            np.array(least + [1e-4 * scale, self.step] * pairs),
            np.array(most + [1e2 * scale, self.duration] * pairs),
        )


def _likelihood(theta: Signal):  # type: ignore[no-untyped-def]  # numba's dispatcher has no type
    return LIKELIHOODS[len(theta) // 2 - 1]
