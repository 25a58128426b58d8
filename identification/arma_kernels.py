"""Compiled exact Gaussian likelihood of ARMA(1,1), maximised for one window or a stack of them.

y_k + a y_{k-1} = e_k + b e_{k-1}.  With phi = -a the one-step predictions and their variances (in units of
the innovation variance) follow the innovations algorithm [Brockwell & Davis 1991, Sec. 5.2-5.3]

    yhat_0 = 0,                                    v_0 = (1 + 2 phi b + b^2) / (1 - phi^2)
    yhat_{k+1} = phi y_k + (b / v_k)(y_k - yhat_k),  v_{k+1} = 1 + b^2 - b^2 / v_k

and with r_k = y_k - yhat_k and the innovation variance concentrated out, s^2 = (1/N) sum r_k^2 / v_k,

    -(2/N) log L = log s^2 + (1/N) sum log v_k + 1 + log 2 pi.

It is minimised over |phi| < 1, |b| < 1 (phi = tanh x, b = tanh z) by BFGS with the exact gradient, from the
local minima of a coarse grid: where pole and zero nearly cancel there are several.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import njit

_ALONG = np.array([-4.0, -2.5, -1.6, -1.0, -0.5, 0.0, 0.5, 1.0, 1.6, 2.5, 4.0])  # x
_ACROSS = np.array([0.1, 0.4, 1.0, 2.0])  # |x + z|
_HOPELESS = 10.0  # a start so far below the best in log-likelihood is not followed
_SETTLED = 1.0 + 1e-13  # v has reached 1
_EDGE = 7.0  # tanh(7) = 1 - 1.7e-6: as near to the unit circle as 10^5 samples could tell


@njit(cache=True)
def maximise_windows(y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fit each row of `y` (m, N): returns (m, 4): a, b, innovation sd, log-likelihood; NaN for a dead row."""
    out = np.empty((y.shape[0], 4))
    for i in range(y.shape[0]):
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = maximise(y[i])
    return out


@njit(cache=True)
def maximise(y: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Fit one window `y` (N,); returns a, b, innovation sd, log-likelihood."""
    power = np.sum(y**2)
    if not (power > 0.0 and power < np.inf):
        return np.nan, np.nan, np.nan, np.nan
    best, x, z = np.inf, 0.0, 0.0
    for start in _starts(y):
        f, xi, zi = _descend(y, start[0], start[1])
        if f < best:
            best, x, z = f, xi, zi
    phi, b = math.tanh(x), math.tanh(z)
    n = len(y)
    variance = _criterion(y, phi, b)[1]
    return -phi, b, math.sqrt(variance), -0.5 * n * (best + 1.0 + math.log(2.0 * math.pi))


@njit(cache=True)
def log_likelihood(y: NDArray[np.float64], a: float, b: float) -> float:
    """Exact log-likelihood of `y` (N,) at (a, b), the innovation variance concentrated out."""
    return -0.5 * len(y) * (_criterion(y, -a, b)[0] + 1.0 + math.log(2.0 * math.pi))


@njit(cache=True)
def prediction_errors(y: NDArray[np.float64], a: float, b: float) -> NDArray[np.float64]:
    """One-step prediction errors r_k / sqrt(v_k) of `y` (N,): all with the innovations' variance."""
    out = np.empty_like(y)
    phi, v, predicted = -a, _first_variance(-a, b), 0.0
    for k in range(len(y)):
        r = y[k] - predicted
        out[k] = r / math.sqrt(v)
        predicted = phi * y[k] + b / v * r
        v = 1.0 + b * b - b * b / v
    return out


@njit(cache=True, inline="always")
def _first_variance(phi: float, b: float) -> float:
    return (1.0 + 2.0 * phi * b + b * b) / (1.0 - phi * phi)


@njit(cache=True)
def _criterion(y: NDArray[np.float64], phi: float, b: float) -> tuple[float, float]:
    """Return log s^2 + mean log v, and s^2."""
    v, predicted, total, logs, product = _first_variance(phi, b), 0.0, 0.0, 0.0, 1.0
    k, n = 0, len(y)
    while k < n and v > _SETTLED:
        w = 1.0 / v
        r = y[k] - predicted
        total += r * r * w
        product *= v
        if product > 1e200:
            logs, product = logs + math.log(product), 1.0
        predicted = phi * y[k] + b * w * r
        v = 1.0 + b * b - b * b * w
        k += 1
    for i in range(k, n):
        r = y[i] - predicted
        total += r * r
        predicted = phi * y[i] + b * r
    logs += math.log(product)
    s2 = total / len(y)
    return math.log(s2) + logs / len(y), s2


@njit(cache=True)
def _gradient(y: NDArray[np.float64], x: float, z: float) -> tuple[float, float, float]:
    """Return the criterion at phi = tanh x, b = tanh z, and its derivatives by x and z.

    Inside, the suffix p is a derivative by phi, q one by b.
    """
    phi, b = math.tanh(x), math.tanh(z)
    v = _first_variance(phi, b)
    vp = (2.0 * b + 2.0 * phi * v) / (1.0 - phi * phi)
    vq = (2.0 * phi + 2.0 * b) / (1.0 - phi * phi)
    predicted, predicted_p, predicted_q = 0.0, 0.0, 0.0
    total, total_p, total_q, logs, logs_p, logs_q = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(len(y)):
        r, w = y[k] - predicted, 1.0 / v
        u = r * w
        up, uq = (-predicted_p - u * vp) * w, (-predicted_q - u * vq) * w
        total += r * u
        total_p += r * up - predicted_p * u
        total_q += r * uq - predicted_q * u
        if v > _SETTLED:
            logs += math.log(v)
        logs_p += vp * w
        logs_q += vq * w
        predicted = phi * y[k] + b * u
        predicted_p = y[k] + b * up
        predicted_q = u + b * uq
        v, vp, vq = (
            1.0 + b * b - b * b * w,
            b * b * w * w * vp,
            2.0 * b * (1.0 - w) + b * b * w * w * vq,
        )
    n = len(y)
    f = math.log(total / n) + logs / n
    return (
        f,
        (total_p / total + logs_p / n) * (1.0 - phi * phi),
        (total_q / total + logs_q / n) * (1.0 - b * b),
    )


@njit(cache=True)
def _starts(y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return starts (k, 2) in (x, z): on either side of cancellation, the lowest valleys along it.

    Where pole and zero cancel (z = -x) the criterion is that of white noise for every x: a flat ridge between
    two sides.  On each side the best distance from it is found per x, and every local minimum along x starts
    a descent.
    """
    m = len(_ALONG)
    found, depths, k = np.empty((2 * m, 2)), np.empty(2 * m), 0
    for side in (-1.0, 1.0):
        depth, where = np.full(m + 2, np.inf), np.empty(m)
        for i in range(m):
            for across in _ACROSS:
                z = side * across - _ALONG[i]
                f = _criterion(y, math.tanh(_ALONG[i]), math.tanh(z))[0]
                if f < depth[i + 1]:
                    depth[i + 1], where[i] = f, z
        for i in range(m):
            if depth[i + 1] <= min(depth[i], depth[i + 2]):
                found[k, 0], found[k, 1], depths[k] = _ALONG[i], where[i], depth[i + 1]
                k += 1
    worth = depths[:k] <= depths[:k].min() + 2.0 * _HOPELESS / len(y)
    chosen: NDArray[np.float64] = found[:k][worth]
    return chosen


@njit(cache=True)
def _descend(y: NDArray[np.float64], x: float, z: float) -> tuple[float, float, float]:
    """Minimise the criterion from (x, z) by BFGS; h.. is the inverse Hessian."""
    f, gx, gz = _gradient(y, x, z)
    hxx, hxz, hzz = 1.0, 0.0, 1.0
    for _ in range(100):
        if gx * gx + gz * gz < 1e-18:
            break
        dx, dz = -(hxx * gx + hxz * gz), -(hxz * gx + hzz * gz)
        if dx * gx + dz * gz >= 0.0:
            hxx, hxz, hzz, dx, dz = 1.0, 0.0, 1.0, -gx, -gz
        longest = max(abs(dx), abs(dz))
        step = min(1.0, 1.0 / longest)
        slope = dx * gx + dz * gz
        for _ in range(40):
            xn = min(max(x + step * dx, -_EDGE), _EDGE)
            zn = min(max(z + step * dz, -_EDGE), _EDGE)
            fn, gxn, gzn = _gradient(y, xn, zn)
            if fn <= f + 1e-4 * step * slope:
                break
            step *= 0.4
        if not fn < f:
            break
        sx, sz, tx, tz = xn - x, zn - z, gxn - gx, gzn - gz
        x, z, f, gx, gz = xn, zn, fn, gxn, gzn
        curvature = sx * tx + sz * tz
        if curvature > 1e-14:
            hx, hz = hxx * tx + hxz * tz, hxz * tx + hzz * tz
            scale = (1.0 + (tx * hx + tz * hz) / curvature) / curvature
            hxx += scale * sx * sx - 2.0 * sx * hx / curvature
            hxz += scale * sx * sz - (sx * hz + hx * sz) / curvature
            hzz += scale * sz * sz - 2.0 * sz * hz / curvature
    return f, x, z
