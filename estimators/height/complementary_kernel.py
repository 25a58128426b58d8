"""The compiled loop of the complementary filter: the state, and the covariance of its error.

The error e = [height, velocity] follows the filter's own equation, with the noise n of the sample it used:

    e_k = (A - g [1, 0]) e_{k-1} + g n_{k-1} + [T/2, 1]' T w_{k-1}

P is the covariance of [h, v (the error), c (Gauss-Markov noise), d (drift and zero offset), n (noise of the
last sample)]; in the code `P.hv` is that of h and v.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import njit

Signal = NDArray[np.float64]
_inlined = njit(cache=True, error_model="numpy", inline="always")


class Covariance(NamedTuple):
    """The upper triangle of P, as numbers in registers."""

    hh: float
    hv: float
    hc: float
    hd: float
    hn: float
    vv: float
    vc: float
    vd: float
    vn: float
    cc: float
    cd: float
    cn: float
    dd: float
    dn: float
    nn: float


@njit(cache=True, error_model="numpy")
def complementary_rows(
    x: Signal,
    P: Signal,
    barometer: Signal,
    before: float,
    rows: tuple[Signal, Signal, Signal, Signal, NDArray[np.bool_]],
    K: tuple[float, float],
    hold: bool,
    longest: float,
    noise: tuple[float, float, float, float],
    acceleration_sd: float,
    rest_variance: float,
    out: Signal,
) -> None:
    """Take all rows in place: state x (2,), covariance P (5, 5) and the barometer's memory (3,).

    Parameters
    ----------
    x, P, barometer : ndarray
        State, covariance, and [last sample, whether it is new, time since one was used].
    before : float
        Time of the row before the first, s; that of the first itself if there was none.
    rows : tuple of ndarray
        Times, altitudes, driving accelerations, their sds (NaN: `acceleration_sd`) and 'at rest', each (n,).
    K : tuple of float
        Gains, 1/s and 1/s².
    hold : bool
        Use the last sample again and again instead of a new one once.
    longest : float
        Most that a sample weighs, s.
    noise : tuple of float
        Variance and 1/tau of the Gauss-Markov noise, white variance, growth of the drift's variance.
    acceleration_sd : float
        m/s².
    rest_variance : float
        Variance of 'v = 0'.
    out : ndarray, shape (4, n)
        Gets height, velocity and their sds.
    """
    t, z, u, w, at_rest = rows
    height, velocity = x[0], x[1]
    last, fresh, since = barometer[0], barometer[1] != 0.0, barometer[2]
    c = _load(P)
    for k in range(len(t)):
        dt = t[k] - before
        before = t[k]
        if dt > 0:
            since += dt
            weight = 0.0
            if hold:
                weight = 0.0 if math.isnan(last) else min(dt, longest)
            elif fresh:
                weight, fresh, since = min(since, longest), False, 0.0
            g_h, g_v = (K[0] + weight / 2 * K[1]) * weight, K[1] * weight
            residual = last - height if weight > 0 else 0.0
            height += dt * velocity + g_h * residual + dt * dt / 2 * u[k]
            velocity += g_v * residual + dt * u[k]
            sd = acceleration_sd if math.isnan(w[k]) else w[k]
            c = _spread(c, g_h, g_v, dt, sd * sd, noise)
        if at_rest[k]:
            velocity, c = 0.0, _rest(c, rest_variance)
        if not math.isnan(z[k]):
            last, fresh, c = z[k], True, _take_sample(c, noise[2])
        out[0, k], out[1, k] = height, velocity
        out[2, k], out[3, k] = math.sqrt(c.hh), math.sqrt(c.vv)
    x[0], x[1] = height, velocity
    barometer[0], barometer[1], barometer[2] = last, 1.0 if fresh else 0.0, since
    _store(c, P)


@_inlined
def _spread(
    c: Covariance,
    g_h: float,
    g_v: float,
    dt: float,
    variance: float,
    noise: tuple[float, float, float, float],
) -> Covariance:
    """Propagate by one step: P = A P A' and what w, the Gauss-Markov noise and the drift add.

    A in words: h = h + dt v + g_h (n - h),   v = v + g_v (n - h),   c = phi c,   d = d,   n = n.
    """
    correlated, rate, _, drift = noise
    phi = math.exp(-dt * rate) if rate > 0 else 1.0
    # A P: its rows h and v
    hh, hv = c.hh + dt * c.hv + g_h * (c.hn - c.hh), c.hv + dt * c.vv + g_h * (c.vn - c.hv)
    hc, hd = c.hc + dt * c.vc + g_h * (c.cn - c.hc), c.hd + dt * c.vd + g_h * (c.dn - c.hd)
    hn = c.hn + dt * c.vn + g_h * (c.nn - c.hn)
    vh, vv = c.hv + g_v * (c.hn - c.hh), c.vv + g_v * (c.vn - c.hv)
    vc, vd, vn = c.vc + g_v * (c.cn - c.hc), c.vd + g_v * (c.dn - c.hd), c.vn + g_v * (c.nn - c.hn)
    # (A P) A'
    return Covariance(
        hh + dt * hv + g_h * (hn - hh) + variance * dt**4 / 4,
        hv + g_v * (hn - hh) + variance * dt**3 / 2,
        hc * phi,
        hd,
        hn,
        vv + g_v * (vn - vh) + variance * dt**2,
        vc * phi,
        vd,
        vn,
        c.cc * phi**2 + correlated * (1 - phi**2),
        c.cd * phi,
        c.cn * phi,
        c.dd + drift * dt,
        c.dn,
        c.nn,
    )


@_inlined
def _take_sample(c: Covariance, white: float) -> Covariance:
    """Let n = c + d + white noise."""
    return Covariance(
        c.hh, c.hv, c.hc, c.hd, c.hc + c.hd,
        c.vv, c.vc, c.vd, c.vc + c.vd,
        c.cc, c.cd, c.cc + c.cd,
        c.dd, c.cd + c.dd,
        c.cc + 2 * c.cd + c.dd + white,
    )  # fmt: skip


@_inlined
def _rest(c: Covariance, variance: float) -> Covariance:
    """Let v be 0, give or take."""
    return Covariance(
        c.hh, 0.0, c.hc, c.hd, c.hn, variance, 0.0, 0.0, 0.0, c.cc, c.cd, c.cn, c.dd, c.dn, c.nn
    )  # fmt: skip


@_inlined
def _load(P: Signal) -> Covariance:
    return Covariance(
        P[0, 0], P[0, 1], P[0, 2], P[0, 3], P[0, 4],
        P[1, 1], P[1, 2], P[1, 3], P[1, 4],
        P[2, 2], P[2, 3], P[2, 4],
        P[3, 3], P[3, 4],
        P[4, 4],
    )  # fmt: skip


@_inlined
def _store(c: Covariance, P: Signal) -> None:
    k = 0
    for i in range(5):
        for j in range(i, 5):
            P[i, j] = P[j, i] = c[k]
            k += 1
