"""Compiled loops that the nouns need: recursions that NumPy cannot write as whole-array operations."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import njit


@njit(cache=True)
def gauss_markov(w: NDArray[np.float64], steps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turn unit white noise into unit Gauss-Markov noise; `steps` (n,) are dt/tau, the first unused."""
    out = np.empty_like(w)
    if len(w):
        out[0] = w[0]
    for k in range(1, len(w)):
        out[k] = math.exp(-steps[k]) * out[k - 1] + math.sqrt(-math.expm1(-2.0 * steps[k])) * w[k]
    return out
