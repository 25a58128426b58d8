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
    """Take all rows in place: state x (2,), covariance P (5, 5) and the barometer's memory (3,).

    Parameters
    ----------
    x, P, barometer : ndarray
        State, covariance, and [last sample, whether it is new, time since one was used].
    started : bool
        Whether there was a row before the first.
    rows : tuple of ndarray
        Intervals, altitudes, driving accelerations, their sds and 'at rest', each (n,).
    K : ndarray, shape (2,)
        Gains, 1/s and 1/s².
    hold : bool
        Use the last sample again and again instead of a new one once.
    longest : float
        Most that a sample weighs, s.
    noise : tuple of float
        Variance and 1/tau of the Gauss-Markov noise, white variance, growth of the drift's variance.
    rest_variance : float
        Variance of 'v = 0'.
    out : ndarray, shape (4, n)
        Gets height, velocity and their sds.
    """
    dt, z, u, w, at_rest = rows
    A, work, take_sample = np.eye(5), np.empty((5, 5)), np.eye(5)
    take_sample[4, 2], take_sample[4, 3], take_sample[4, 4] = 1.0, 1.0, 0.0
    for k in range(len(dt)):
        if (started or k > 0) and dt[k] > 0:
            weight = min(_time_of_sample(barometer, dt[k], hold), longest)
            g_h, g_v = (K[0] + weight / 2 * K[1]) * weight, K[1] * weight
            residual = barometer[0] - x[0] if weight > 0 else 0.0
            x[0] += dt[k] * x[1] + g_h * residual + dt[k] ** 2 / 2 * u[k]
            x[1] += g_v * residual + dt[k] * u[k]
            _spread(P, A, work, g_h, g_v, dt[k], w[k] ** 2, noise)
        if at_rest[k]:
            x[1], P[1, :], P[:, 1] = 0.0, 0.0, 0.0
            P[1, 1] = rest_variance
        if not math.isnan(z[k]):
            barometer[0], barometer[1] = z[k], 1.0
            sandwich(take_sample, P, work)
            P[4, 4] += noise[2]
        out[0, k], out[1, k] = x[0], x[1]
        out[2, k], out[3, k] = math.sqrt(P[0, 0]), math.sqrt(P[1, 1])


@njit(cache=True)
def _time_of_sample(barometer: Signal, dt: float, hold: bool) -> float:
    """Time in s that the last sample stands for in this step; 0: none."""
    barometer[2] += dt
    if hold:
        return 0.0 if math.isnan(barometer[0]) else dt
    if barometer[1] == 0.0:
        return 0.0
    elapsed = float(barometer[2])
    barometer[1], barometer[2] = 0.0, 0.0
    return elapsed


@njit(cache=True)
def _spread(
    P: Signal,
    A: Signal,
    work: Signal,
    g_h: float,
    g_v: float,
    dt: float,
    variance: float,
    noise: tuple[float, float, float, float],
) -> None:
    """Propagate the covariance of the error by one step; A is the identity but for what is set here."""
    correlated, rate, _, drift = noise
    phi = math.exp(-dt * rate)
    A[0, 0], A[0, 1], A[0, 4] = 1 - g_h, dt, g_h
    A[1, 0], A[1, 4], A[2, 2] = -g_v, g_v, phi
    sandwich(A, P, work)
    P[0, 0] += variance * dt**4 / 4
    P[0, 1] += variance * dt**3 / 2
    P[1, 0] += variance * dt**3 / 2
    P[1, 1] += variance * dt**2
    P[2, 2] += correlated * (1 - phi**2)
    P[3, 3] += drift * dt
