"""The compiled loop of the complementary filter: the state, and the covariance of its error.

The error e = [height, velocity] follows the filter's own equation, with the noise n of the sample it used:

    e_k = (A - g [1, 0]) e_{k-1} + g n_{k-1} + [T/2, 1]' T w_{k-1}

P is the covariance of [e (2), Gauss-Markov noise, drift and zero offset, n of the last sample].
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from baroarma.estimators.height.kernels import sandwich

Signal = NDArray[np.float64]


@njit(cache=True)
def complementary_rows(
    x: Signal,
    P: Signal,
    barometer: Signal,
    started: bool,
    rows: tuple[Signal, Signal, Signal, Signal, NDArray[np.bool_]],
    K: Signal,
    hold: bool,
    longest: float,
    noise: tuple[float, float, float, float],
    rest_variance: float,
    out: Signal,
) -> None:
    """Take all rows in place: state x (2,), its error covariance P (5, 5) and the barometer's memory (3,)."""
    dt, z, u, w, at_rest = rows
    correlated, rate, white, drift = noise
    A, work = np.eye(5), np.empty((5, 5))
    take_sample = np.eye(5)
    take_sample[4] = np.array([0.0, 0.0, 1.0, 1.0, 0.0])
    for k in range(len(dt)):
        if (started or k > 0) and dt[k] > 0:
            T = dt[k]
            barometer[2] += T
            weight = 0.0
            if hold and not math.isnan(barometer[0]):
                weight = T
            elif barometer[1] > 0:
                weight = min(barometer[2], longest)
            if barometer[1] > 0:
                barometer[1], barometer[2] = 0.0, 0.0
            g_h, g_v = (K[0] + weight / 2 * K[1]) * weight, K[1] * weight
            residual = barometer[0] - x[0] if weight > 0 else 0.0
            x[0] += T * x[1] + g_h * residual + T * T / 2 * u[k]
            x[1] += g_v * residual + T * u[k]
            phi = math.exp(-T * rate)
            A[0, 0], A[0, 1], A[0, 4] = 1 - g_h, T, g_h
            A[1, 0], A[1, 4], A[2, 2] = -g_v, g_v, phi
            sandwich(A, P, work)
            P[0, 0] += (w[k] * T * T / 2) ** 2
            P[0, 1] += w[k] ** 2 * T**3 / 2
            P[1, 0] += w[k] ** 2 * T**3 / 2
            P[1, 1] += (w[k] * T) ** 2
            P[2, 2] += correlated * (1 - phi**2)
            P[3, 3] += drift * T
        if at_rest[k]:
            x[1] = 0.0
            P[1, :] = 0.0
            P[:, 1] = 0.0
            P[1, 1] = rest_variance
        if not math.isnan(z[k]):
            barometer[0], barometer[1] = z[k], 1.0
            sandwich(take_sample, P, work)
            P[4, 4] += white
        out[0, k], out[1, k] = x[0], x[1]
        out[2, k], out[3, k] = math.sqrt(P[0, 0]), math.sqrt(P[1, 1])
