"""Is it the same noise throughout?  Over windows by the spectral error, over recordings by ANOVA.

Both are SG13's, Secs. 2.5 and 3.1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.arma import ArmaModel
from baroarma.identification.whiteness import Outcome

Signal = NDArray[np.float64]


def spectral_error(model: ArmaModel, y: ArrayLike, lags: int = 20) -> float:
    """Return the spectral error measure between a model and a window of data.

    The window is filtered by the inverse of the model; if its spectrum is the model's, the errors e are white
    and as large as the innovations.  With their autocovariances c_k,

        SEM = (sd²/c_0 - 1)² + 2 sum_{k=1}^{lags} (c_k/c_0)²

    is the squared distance of their spectrum from a flat one [Bodenstein & Praetorius 1977, Proc.
    IEEE 65:642, with the AR inverse filter generalised to ARMA(1,1)].

    Parameters
    ----------
    model : ArmaModel
        An ARMA(1,1), identified on another window.
    y : array_like, shape (n,)
        The window, m, at the model's interval.
    lags : int
        Autocovariances to look at.

    Returns
    -------
    float
        0 for data whose spectrum is exactly the model's; (r² - 1)² where only the model's sd is r times too
        large.

    Examples
    --------
    >>> sg13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
    >>> from dataclasses import replace
    >>> y = sg13.simulate(20_000, rng=1)
    >>> round(spectral_error(sg13, y), 1), round(spectral_error(replace(sg13, sd=2 * sg13.sd), y))
    (0.0, 9)
    """
    from baroarma.identification.arma_kernels import prediction_errors

    (a,), (b,) = model.ar, model.ma
    e = prediction_errors(np.ascontiguousarray(y, dtype=float), a, b)
    c = np.array([e[k:] @ e[: len(e) - k] for k in range(lags + 1)]) / len(e)
    return float((model.sd**2 / c[0] - 1) ** 2 + 2 * np.sum((c[1:] / c[0]) ** 2))


def stationarity(
    windows: ArrayLike, dt: float, *, trials: int = 200, seed: int = 0, lags: int = 20
) -> Outcome:
    """Test short-term stationarity by letting one model whiten all windows.

    The statistic is the mean `spectral_error` of the windows under the ARMA(1,1) with their median
    coefficients.  Its distribution under stationarity has no closed form, because the windows are short and
    the model is estimated from them; it is simulated from that model (a parametric bootstrap).

    Parameters
    ----------
    windows : array_like, shape (m, N)
        Detrended windows, m; cut them in halves or quarters to look at shorter times.
    dt : float
        Sampling interval, s.
    trials : int
        Simulated recordings; p comes in steps of 1/(trials + 1), and each trial costs m fits.
    seed : int
        Seed of the simulation.
    lags : int
        See `spectral_error`.

    Returns
    -------
    Outcome
        The mean spectral error and its p.

    Raises
    ------
    ValueError
        If there is one window only, or one is constant.

    Examples
    --------
    >>> sg13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
    >>> windows = sg13.simulate(1200, rng=1).reshape(6, 200)
    >>> stationarity(windows, 0.1, trials=50).p > 0.05
    True
    >>> windows[4:] *= 2  # somebody opened a window
    >>> stationarity(windows, 0.1, trials=50).p < 0.05
    True
    """
    y = np.asarray(windows, float)
    if y.ndim != 2 or len(y) < 2:
        raise ValueError(f"windows of shape {y.shape} cannot be compared; at least 2 rows are needed")
    observed, model = _misfit(y, dt, lags)
    rng = np.random.default_rng(seed)
    null = [_misfit(model.simulate(y.size, rng).reshape(y.shape), dt, lags)[0] for _ in range(trials)]
    p = float((1 + np.sum(np.array(null) >= observed)) / (trials + 1))
    message = (
        "The windows are as alike as those of stationary noise."
        if p > 0.05
        else "The windows differ more than those of stationary noise: use shorter windows or a calmer place."
    )
    return Outcome(f"spectral error, {len(y)} windows", observed, p, message)


def _misfit(y: Signal, dt: float, lags: int) -> tuple[float, ArmaModel]:
    """Mean spectral error of the windows under the model with their median coefficients, and that model."""
    from baroarma.identification.arma_kernels import maximise_windows

    a, b, sd, _ = np.median(maximise_windows(np.ascontiguousarray(y)), axis=0).tolist()
    if not math.isfinite(sd):
        raise ValueError("a window is constant or not finite; leave it out")
    model = ArmaModel((a,), (b,), sd, dt)
    return float(np.mean([spectral_error(model, window, lags) for window in y])), model


def anova(groups: Sequence[ArrayLike], name: str = "coefficient") -> Outcome:
    """Test by one-way analysis of variance whether recordings share the mean of a quantity.

    SG13, Sec. 3.1, for a and b of the windows of six recordings: p > 0.4 and p > 0.26.

    Parameters
    ----------
    groups : sequence of array_like
        Values per recording, each (m_i,); NaN is left out.
    name : str
        What the values are, for the sentence.

    Raises
    ------
    ValueError
        If there are not two recordings of two values each.

    Examples
    --------
    >>> anova([[1.0, 1.1, 0.9], [2.0, 2.1, 1.9]], "a").p < 0.001
    True
    """
    from scipy.stats import f_oneway

    samples = [v[np.isfinite(v)] for v in (np.asarray(group, float) for group in groups)]
    if len(samples) < 2 or min(map(len, samples)) < 2:
        raise ValueError(f"{[len(v) for v in samples]} values per recording: 2 recordings with 2 are needed")
    result = f_oneway(*samples)
    verb = "share one" if result.pvalue > 0.05 else "do not share a"
    message = f"The {len(samples)} recordings {verb} mean of {name}."
    return Outcome(f"ANOVA of {name}", float(result.statistic), float(result.pvalue), message)
