"""Fit ARMA models: a series in any order by statsmodels, many windows of ARMA(1,1) by compiled code.

Convention of `baroarma.arma`: y_k + a_1 y_{k-1} + ... = e_k + b_1 e_{k-1} + ...  statsmodels' AR
coefficients are -a; this is the only file that meets it.  No constant is
fitted: the series were detrended, and demeaning the windows once more would shorten the correlation time.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.arma import ArmaModel, Split

Signal = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ArmaFit:
    """Hold an ARMA(p, q) model fitted to one series.

    Parameters
    ----------
    model : ArmaModel
        The model, with the innovation sd in m.
    covariance : ndarray, shape (p + q, p + q)
        Covariance of (a_1 ... a_p, b_1 ... b_q) from the outer products of the scores.
    loglik, aic, bic : float
        Log-likelihood and the criteria of Akaike and Schwarz, p + q + 1 parameters counted.
    fpe : float
        Akaike's final prediction error, m²: sd² (1 + d/n)/(1 - d/n) with d = p + q.
    residuals : ndarray, shape (n,)
        One-step prediction errors, m, all scaled to the innovations' variance.
    converged : bool
        Whether the optimiser says that it arrived.
    """

    model: ArmaModel
    covariance: Signal
    loglik: float
    aic: float
    bic: float
    fpe: float
    residuals: Signal
    converged: bool

    @property
    def coefficient_sd(self) -> tuple[float, ...]:
        """Standard deviations of a_1 ... a_p, b_1 ... b_q."""
        return tuple(np.sqrt(np.diag(self.covariance)).tolist())

    def __repr__(self) -> str:
        end = "" if self.converged else ", not converged"
        return f"<ArmaFit of {len(self.residuals)} samples: {self.model!r}{end}>"


def fit_arma(y: ArrayLike, dt: float, order: tuple[int, int] = (1, 1)) -> ArmaFit:
    """Fit an ARMA(p, q) by exact maximum likelihood with statsmodels.

    Parameters
    ----------
    y : array_like, shape (n,)
        Detrended heights in m, one every `dt` seconds.
    dt : float
        Sampling interval, s.
    order : tuple of int
        (p, q).  Higher orders fit more structure and need more samples.

    Raises
    ------
    ValueError
        If the series is too short for the order, constant or not finite.

    Examples
    --------
    >>> y = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.27, dt=0.1).simulate(3000, 1)
    >>> fit = fit_arma(y, 0.1)
    >>> [round(v, 2) for v in (fit.model.ar[0], fit.model.ma[0], fit.model.sd)]
    [-0.85, -0.5, 0.27]
    """
    y = np.asarray(y, float)
    p, q = order
    _check(y, order)
    from statsmodels.tsa.arima.model import ARIMA

    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore"
        )  # statsmodels warns of bad starts and no convergence: `converged` says it
        arima = ARIMA(y, order=(p, 0, q), trend="n", concentrate_scale=True)
        result = arima.fit(method_kwargs={"maxiter": 200}) if p + q else arima.filter([])
    n, d = len(y), p + q
    variance = float(result.scale)
    sign = np.repeat([-1.0, 1.0], order)
    return ArmaFit(
        model=ArmaModel(tuple(-result.params[:p]), tuple(result.params[p : p + q]), math.sqrt(variance), dt),
        covariance=np.asarray(result.cov_params())[:d, :d] * np.outer(sign, sign),
        loglik=float(result.llf),
        aic=2 * (d + 1) - 2 * float(result.llf),
        bic=(d + 1) * math.log(n) - 2 * float(result.llf),
        fpe=variance * (1 + d / n) / (1 - d / n),
        residuals=np.ravel(result.standardized_forecasts_error) * math.sqrt(variance),
        converged=bool(result.mle_retvals["converged"]) if d else True,
    )


def _check(y: Signal, order: tuple[int, int]) -> None:
    name = f"ARMA{order}"
    if min(order) < 0:
        raise ValueError(f"{name} has a negative order; both must be 0 or more")
    if y.ndim != 1:
        raise ValueError(f"the series has shape {y.shape}; (n,) is needed")
    needed = 20 * (sum(order) + 1)
    if len(y) < needed:
        raise ValueError(f"a series of {len(y)} samples is too short for {name}; use at least {needed}")
    if not np.isfinite(y).all():
        raise ValueError("the series has samples that are not finite; an ARMA fit needs a gap-free series")
    if not np.ptp(y) > 0:
        raise ValueError(f"the series is constant ({y[0]:g} m); there is no noise to fit")


def coefficient_covariance(a: float, b: float, n: int) -> Signal:
    """Return the asymptotic covariance of estimates of (a, b) from `n` samples [SG13, Eq. 16].

    (1 - ab)/(n (a - b)²) [[(1 - a²)(1 - ab), (1 - a²)(1 - b²)], [(1 - a²)(1 - b²), (1 - b²)(1 - ab)]].
    It holds to 4 % at n >= 1000 and is 8 to 14 % optimistic (in sd) at 300.

    Examples
    --------
    >>> [round(float(v), 3) for v in np.sqrt(np.diag(coefficient_covariance(-0.86, -0.52, 300)))]
    [0.048, 0.08]
    """
    factor = (1 - a * b) / (n * (a - b) ** 2)
    cross = (1 - a**2) * (1 - b**2)
    return factor * np.array([[(1 - a**2) * (1 - a * b), cross], [cross, (1 - b**2) * (1 - a * b)]])


@dataclass(frozen=True, eq=False)
class WindowFits:
    """Hold the ARMA(1,1) of every window; arrays of shape (m,).

    Parameters
    ----------
    a, b, innovation_sd, loglik : ndarray
        The fit; NaN where a window is constant.
    correlated_sd, correlation_time, white_sd : ndarray
        Its Gauss-Markov and white components at the windows' interval, m, s, m; NaN where the coefficients
        lie outside the region that such noise can have.
    total_sd : ndarray
        RMS of the window about its detrended level (0), m.
    residuals : ndarray, shape (m, N)
        Prediction errors, m.
    """

    a: Signal
    b: Signal
    innovation_sd: Signal
    loglik: Signal
    correlated_sd: Signal
    correlation_time: Signal
    white_sd: Signal
    total_sd: Signal
    residuals: Signal

    @property
    def inside(self) -> NDArray[np.bool_]:
        """True where the window supports Gauss-Markov plus white noise."""
        return np.isfinite(self.correlation_time)


def fit_windows(windows: ArrayLike, dt: float, split: Split = "exact") -> WindowFits:
    """Fit an ARMA(1,1) to every window by exact maximum likelihood and split it into components.

    Parameters
    ----------
    windows : array_like, shape (m, N)
        Detrended heights in m, one every `dt` seconds.
    dt : float
        Sampling interval, s.
    split : {"exact", "bilinear"}
        How (a, b, innovation sd) becomes components; see `baroarma.arma`.

    Examples
    --------
    >>> y = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.27, dt=0.1).simulate(3000, 1)
    >>> fits = fit_windows(y.reshape(10, 300), 0.1)
    >>> round(float(np.median(fits.a)), 2), int(fits.inside.sum())
    (-0.86, 10)
    """
    from baroarma.identification.arma_kernels import maximise_windows, prediction_errors

    y = np.ascontiguousarray(windows, dtype=float)
    a, b, sd, loglik = maximise_windows(y).T
    parts = np.array([_components(*row, dt, split) for row in zip(a, b, sd, strict=True)]).reshape(-1, 3)
    return WindowFits(
        a=a,
        b=b,
        innovation_sd=sd,
        loglik=loglik,
        correlated_sd=parts[:, 0],
        correlation_time=parts[:, 1],
        white_sd=parts[:, 2],
        total_sd=np.sqrt(np.mean(y**2, axis=1)),
        residuals=np.array([prediction_errors(*row) for row in zip(y, a, b, strict=True)]).reshape(y.shape),
    )


def _components(a: float, b: float, sd: float, dt: float, split: Split) -> tuple[float, float, float]:
    """Components in m, s, m, or NaN outside the region."""
    if not math.isfinite(sd):
        return math.nan, math.nan, math.nan
    try:
        return ArmaModel((a,), (b,), sd, dt).split(split)
    except ValueError:
        if split not in ("exact", "bilinear"):
            raise
        return math.nan, math.nan, math.nan
