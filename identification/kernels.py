"""Compiled likelihood of white + Gauss-Markov + drift noise at arbitrary sample times.

The height of a motionless barometer is y_k = b_k + sum_i c_{i,k} + u_k: a random walk b, m Gauss-Markov
components c_i and white noise u.  A Kalman filter of m + 1 states gives the innovations and their variances,
hence the exact Gaussian likelihood (prediction-error decomposition) with phi_i = exp(-dt/tau_i) per interval;
gaps and jitter need no special case.  The unknown level has a flat prior, in closed form: the first sample
sets b_0 = y_0 with the covariance of -(c + u).

Sensitivities with respect to the logarithms of the parameters run along, which gives the exact gradient and
the Fisher information (for scoring) in the same pass.  On stretches of equal intervals covariance, gain and
their sensitivities converge; from there on only the states move.

Parameters are ordered white_sd, drift_rate, then sd and tau of each Gauss-Markov component.  A term is
switched off by a 0; its gradient and information are then 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from baroarma.compiled import njit

SAME_INTERVAL = 1e-7  # intervals that differ relatively by less are equal: rounding of time stamps in binary
CONVERGED = 1e-13  # relative change per sample below which gain and variance stand still


def _make_likelihood(components: int) -> Callable[..., Any]:
    """Compile the likelihood for a fixed number of Gauss-Markov components."""

    @njit(cache=True)
    def likelihood(t, y, theta, innovations):  # type: ignore[no-untyped-def]
        d, p, n = components + 1, 2 + 2 * components, len(y)
        store = len(innovations) == n
        white, walk = theta[0] ** 2, theta[1] ** 2
        x, x_new = np.zeros(d), np.zeros(d)
        dx, dx_new = np.zeros((d, p)), np.zeros((d, p))
        P, P_new = np.zeros((d, d)), np.zeros((d, d))
        dP, dP_new = np.zeros((p, d, d)), np.zeros((p, d, d))
        phi, q = np.ones(d), np.zeros(d)
        dphi, dq = np.zeros(d), np.zeros((d, p))
        K, dK, dS, ds, de = np.zeros(d), np.zeros((d, p)), np.zeros(p), np.zeros(p), np.zeros(p)
        PH, dPH = np.zeros(d), np.zeros(d)
        gradient, information = np.zeros(p), np.zeros((p, p))

        # the first sample with a flat prior of the level: b = y - c - u
        x[0] = y[0]
        P[0, 0] = white
        dP[0, 0, 0] = 2 * white
        for i in range(1, d):
            v = theta[2 * i] ** 2
            P[0, 0] += v
            P[0, i] = P[i, 0] = -v
            P[i, i] = v
            dP[2 * i, 0, 0] = 2 * v
            dP[2 * i, 0, i] = dP[2 * i, i, 0] = -2 * v
            dP[2 * i, i, i] = 2 * v

        total, product, S, S_old, inverse, interval = 0.0, 1.0, 1.0, 0.0, 1.0, -1.0
        steady = False
        calm = 0
        for k in range(1, n):
            dt = t[k] - t[k - 1]
            if abs(dt - interval) > SAME_INTERVAL * dt:
                interval, steady, calm = dt, False, 0
                q[0] = walk * dt
                dq[0, 1] = 2 * q[0]
                for i in range(1, d):
                    v, r = theta[2 * i] ** 2, dt / theta[2 * i + 1]
                    phi[i] = math.exp(-r)
                    dphi[i] = phi[i] * r
                    q[i] = -v * math.expm1(-2 * r)
                    dq[i, 2 * i] = 2 * q[i]
                    dq[i, 2 * i + 1] = -2 * v * phi[i] * dphi[i]

            if not steady:
                change = 0.0
                S = white
                for i in range(d):
                    PH[i] = 0.0
                    for j in range(d):
                        P_new[i, j] = phi[i] * phi[j] * P[i, j]
                        PH[i] += P_new[i, j]
                    P_new[i, i] += q[i]
                    PH[i] += q[i]
                    S += PH[i]
                for i in range(d):
                    change = max(change, abs(PH[i] / S - K[i]))
                    K[i] = PH[i] / S
                for j in range(p):
                    s = 2 * white if j == 0 else 0.0
                    for i in range(d):
                        dPH[i] = 0.0
                        for m in range(d):
                            v = phi[i] * phi[m] * dP[j, i, m]
                            if j == 2 * i + 1 and i > 0:
                                v += dphi[i] * phi[m] * P[i, m]
                            if j == 2 * m + 1 and m > 0:
                                v += phi[i] * dphi[m] * P[i, m]
                            dP_new[j, i, m] = v
                            dPH[i] += v
                        dP_new[j, i, i] += dq[i, j]
                        dPH[i] += dq[i, j]
                        s += dPH[i]
                    change = max(change, abs(s - dS[j]) / S)
                    dS[j] = s
                    for i in range(d):
                        v = (dPH[i] - K[i] * s) / S
                        change = max(change, abs(v - dK[i, j]))
                        dK[i, j] = v
                        for m in range(d):
                            dP[j, i, m] = dP_new[j, i, m] - dPH[i] * K[m] - K[i] * dPH[m] + K[i] * K[m] * s
                for i in range(d):
                    for m in range(d):
                        P[i, m] = P_new[i, m] - K[i] * K[m] * S
                calm = calm + 1 if change + abs(S - S_old) / S < CONVERGED and walk > 0 else 0
                steady = calm > 2
                S_old, inverse = S, 1.0 / S
                for j in range(p):
                    ds[j] = 0.5 * dS[j] * inverse

            e = y[k]
            for i in range(d):
                x_new[i] = phi[i] * x[i]
                e -= x_new[i]
            scaled = e * inverse
            for j in range(p):
                s = 0.0
                for i in range(d):
                    v = phi[i] * dx[i, j]
                    if j == 2 * i + 1 and i > 0:
                        v += dphi[i] * x[i]
                    dx_new[i, j] = v
                    s += v
                de[j] = -s
                for i in range(d):
                    dx[i, j] = dx_new[i, j] + dK[i, j] * e - K[i] * s
                gradient[j] += ds[j] * (e * scaled - 1.0) + scaled * s
            for i in range(d):
                x[i] = x_new[i] + K[i] * e
            for j in range(p):
                for m in range(j + 1):
                    information[j, m] += 2 * ds[j] * ds[m] + de[j] * de[m] * inverse

            product *= S
            if product < 1e-200 or product > 1e200:
                total -= 0.5 * math.log(product)
                product = 1.0
            total -= 0.5 * e * scaled
            if store:
                innovations[k] = e / math.sqrt(S)
        total -= 0.5 * (math.log(product) + (n - 1) * math.log(2 * math.pi))
        for j in range(p):
            for m in range(j):
                information[m, j] = information[j, m]
        return total, gradient, information

    return likelihood


LIKELIHOODS = tuple(_make_likelihood(components) for components in range(3))
"""The compiled likelihoods for 0, 1 and 2 Gauss-Markov components."""
