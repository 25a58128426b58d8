"""Is a series white?  Bartlett's cumulative periodogram and Ljung-Box.

Bartlett's is not the equal-variance test of that name.  On the residuals of a fitted ARMA it is very
conservative (it rejects 0.2 % where 5 % is meant); Ljung-Box corrects its degrees of freedom and stands
beside it [SG13, Sec. 2.5].
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.identification.arma_fit import WindowFits

Signal = NDArray[np.float64]
LONG: Final = 1 << 17
"""Samples from which the length of a Fourier transform matters."""


@dataclass(frozen=True)
class Outcome:
    """Hold the outcome of a test: a number, how unusual it is, and a sentence.

    Parameters
    ----------
    name : str
        What was tested.
    statistic : float
        The test statistic.
    p : float
        Probability of a statistic at least as large if the null hypothesis holds.
    message : str
        What it means.

    Examples
    --------
    Means 2 and 5 of three values each, with the variance 1: F = 13.5/1.

    >>> from baroarma.identification.homogeneity import anova
    >>> print(anova([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "a"))
    ANOVA of a: 13.5, p = 0.0213.  The 2 recordings do not share a mean of a.
    """

    name: str
    statistic: float
    p: float
    message: str

    def __str__(self) -> str:
        return f"{self.name}: {self.statistic:.4g}, p = {self.p:.3g}.  {self.message}"


def cumulative_periodogram_test(residuals: ArrayLike) -> Outcome:
    """Test whiteness by Bartlett's cumulative periodogram.

    The normalised cumulative sums of the periodogram of Gaussian white noise at its q = (n - 1)//2 inner
    frequencies are distributed as q - 1 ordered uniform numbers; their largest distance from the diagonal is
    Kolmogorov's statistic, and p is exact for series that were not fitted.

    Parameters
    ----------
    residuals : array_like, shape (n,)
        Prediction errors, any unit.

    Raises
    ------
    ValueError
        If there are fewer than 5 residuals, some are not finite, or all are the same.

    Examples
    --------
    >>> cumulative_periodogram_test(np.random.default_rng(0).normal(size=300)).p > 0.05
    True
    """
    x = _finite(residuals, 5)
    x = x[len(x) - _easy_length(len(x)) :]
    q = (len(x) - 1) // 2
    periodogram = np.abs(np.fft.rfft(x - x.mean())[1 : q + 1]) ** 2
    cumulated = np.cumsum(periodogram)
    u = cumulated[:-1] / cumulated[-1]
    steps = np.arange(q) / (q - 1)
    distance = float(max(np.max(steps[1:] - u), np.max(u - steps[:-1])))
    from scipy.stats import kstwo

    return _whiteness("cumulative periodogram", distance, float(kstwo.sf(distance, q - 1)))


def _easy_length(n: int) -> int:
    """Return how many samples to transform: of a long series a few less, a number of small prime factors.

    An FFT of a large prime length takes ten times the memory; a fifth of a percent at most is left off.

    Examples
    --------
    >>> _easy_length(211), _easy_length(4_319_999)
    (211, 4312440)
    """
    if n < LONG:
        return n
    while _without_small_primes(n) > 1:
        n -= 1
    return n


def _without_small_primes(n: int) -> int:
    for prime in (2, 3, 5, 7, 11):
        while n % prime == 0:
            n //= prime
    return n


def ljung_box(residuals: ArrayLike, lags: int, fitted_parameters: int = 0) -> Outcome:
    """Test whiteness by the first autocorrelations: Q = n (n + 2) sum r_k² / (n - k).

    Q is chi-square for long series; of white windows of 300 samples, 20 lags reject 6 % instead of 5 %.

    Parameters
    ----------
    residuals : array_like, shape (n,)
        Prediction errors, any unit.
    lags : int
        Number of autocorrelations.  More see longer structure and have less power against short one.
    fitted_parameters : int
        p + q of the ARMA whose residuals these are; chi-square has `lags` minus that many degrees of freedom.

    Raises
    ------
    ValueError
        If the lags don't exceed the fitted parameters, the residuals are too few or all the same, or some are
        not finite.

    Examples
    --------
    >>> ljung_box(np.sin(np.arange(300)), 10).p < 0.001
    True
    """
    if lags <= fitted_parameters:
        raise ValueError(
            f"{lags} lags leave nothing after {fitted_parameters} fitted parameters; use more lags"
        )
    x = _finite(residuals, lags + 1)
    from scipy.special import chdtrc

    x, n = x - x.mean(), len(x)
    # einsum instead of @: BLAS would spin up threads for dot products that take microseconds
    r = np.array([np.einsum("i,i", x[k:], x[: n - k]) for k in range(lags + 1)])
    r = r[1:] / r[0]
    statistic = float(n * (n + 2) * np.sum(r**2 / (n - np.arange(1, lags + 1))))
    return _whiteness(
        f"Ljung-Box, {lags} lags", statistic, float(chdtrc(lags - fitted_parameters, statistic))
    )


def _finite(x: ArrayLike, needed: int) -> Signal:
    x = np.asarray(x, float).ravel()
    if len(x) < needed:
        raise ValueError(f"{len(x)} residuals are too few for this test; at least {needed} are needed")
    if not np.isfinite(x).all():
        raise ValueError("the residuals are not all finite; leave out the rows without a sample")
    if not np.ptp(x) > 0:
        raise ValueError(f"the residuals are all {x[0]:g}; there is no noise to test")
    return x


def _whiteness(name: str, statistic: float, p: float) -> Outcome:
    message = (
        "The residuals look white."
        if p > 0.05
        else "The residuals are not white: the model misses structure."
    )
    return Outcome(name, statistic, p, message)


def whiteness_of_windows(fits: WindowFits, lags: int = 20) -> tuple[Signal, Signal]:
    """Return the p-values (m,) of Bartlett's test and of Ljung-Box over windows; NaN for a dead window.

    Parameters
    ----------
    fits : WindowFits
        What `fit_windows` returned, m windows.
    lags : int
        Autocorrelations for Ljung-Box, of which the two fitted parameters take two degrees of freedom.

    Examples
    --------
    Windows of an ARMA(1, 1) leave white residuals; dead ones leave none:

    >>> from baroarma import ArmaModel
    >>> from baroarma.identification.arma_fit import fit_windows
    >>> sg13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
    >>> windows = sg13.simulate(1200, rng=1).reshape(4, 300)
    >>> windows[3] = 0.0
    >>> bartlett, ljung = whiteness_of_windows(fit_windows(windows, 0.1))
    >>> (bartlett > 0.05).tolist(), np.isnan(ljung).tolist()
    ([True, True, True, False], [False, False, False, True])
    """
    alive = np.isfinite(fits.innovation_sd) & (np.ptp(fits.residuals, axis=1) > 0)
    bartlett, ljung = np.full((2, len(alive)), np.nan)
    for i in np.flatnonzero(alive):
        bartlett[i] = cumulative_periodogram_test(fits.residuals[i]).p
        ljung[i] = ljung_box(fits.residuals[i], lags, fitted_parameters=2).p
    return bartlett, ljung
