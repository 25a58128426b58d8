"""Is the noise what the model says?  Tests and studies behind SG13's Secs. 2.5 and 3.1.

Whiteness of prediction errors: Bartlett's cumulative periodogram (not the equal-variance test of that name)
and Ljung-Box.  On the residuals of a fitted ARMA the cumulative periodogram is very conservative (it rejects
0.2 % where 5 % is meant); Ljung-Box corrects its degrees of freedom and stands beside it.  Then: which order
(FPE, AIC, BIC), stationary over windows (spectral error), equal over recordings (ANOVA), and what averaging
does (SG13, Fig. 5).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.arma import ArmaModel, Split
from baroarma.identification.arma_fit import ArmaFit, WindowFits, fit_arma, fit_windows
from baroarma.identification.preprocessing import (
    Trimmed,
    WindowSettings,
    condition,
    new_samples,
    trimmed_mean,
)

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

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


@dataclass(frozen=True, eq=False, repr=False)
class OrderTable:
    """Hold the fits of all orders up to (max_p, max_q), by order.

    Parameters
    ----------
    fits : dict of (int, int) to ArmaFit
        The fits by (p, q).

    Examples
    --------
    >>> sg13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
    >>> table = order_table(sg13.simulate(600, rng=1), 0.1, max_p=1, max_q=1)
    >>> table
    <OrderTable of 4 ARMA orders, best by FPE (1, 1), AIC (1, 1), BIC (1, 1)>
    >>> table.fits[1, 1].fpe < table.fits[1, 0].fpe < table.fits[0, 0].fpe
    True
    """

    fits: dict[tuple[int, int], ArmaFit]

    def __repr__(self) -> str:
        best = ", ".join(f"{name.upper()} {self.best(name)}" for name in ("fpe", "aic", "bic"))
        return f"<OrderTable of {len(self.fits)} ARMA orders, best by {best}>"

    def best(self, criterion: str = "fpe") -> tuple[int, int]:
        """Return the order with the smallest ``"fpe"``, ``"aic"`` or ``"bic"``.

        Raises
        ------
        ValueError
            For another criterion.
        """
        if criterion not in ("fpe", "aic", "bic"):
            raise ValueError(f"criterion {criterion!r} is unknown; choose 'fpe', 'aic' or 'bic'")
        return min(self.fits, key=lambda order: float(getattr(self.fits[order], criterion)))

    def summary(self) -> str:
        """Return a table with one row per order; a star marks the smallest of each column."""
        lines = [f"{'order':8}{'FPE, m²':>13}{'AIC':>12}{'BIC':>12}"]
        for order, fit in self.fits.items():
            cells = [
                f"{getattr(fit, name):.{digits}f}{'*' if self.best(name) == order else ' '}"
                for name, digits in (("fpe", 6), ("aic", 2), ("bic", 2))
            ]
            end = "" if fit.converged else "   did not converge"
            lines.append(f"{order!s:8}{cells[0]:>13}{cells[1]:>12}{cells[2]:>12}{end}")
        return "\n".join(lines)

    def to_frame(self) -> pd.DataFrame:
        """Return the table as a pandas DataFrame, a row per order."""
        import pandas as pd

        return pd.DataFrame(
            [
                {"p": p, "q": q, "fpe_m2": f.fpe, "aic": f.aic, "bic": f.bic, "converged": f.converged}
                for (p, q), f in self.fits.items()
            ]
        )

    def _repr_html_(self) -> str:
        from baroarma.notebook import tables
        from baroarma.page import Table

        rows = []
        for order, fit in self.fits.items():
            cells = (("fpe", 6), ("aic", 2), ("bic", 2))
            texts = [f"{getattr(fit, c):.{d}f}{' *' * (self.best(c) == order)}" for c, d in cells]
            rows.append((str(order), *texts, "" if fit.converged else "did not converge"))
        head = ("order (p, q)", "FPE (m²)", "AIC", "BIC", "")
        return tables(Table(head, tuple(rows), "ARMA orders; * smallest of its column"))


def order_table(y: ArrayLike, dt: float, max_p: int = 3, max_q: int = 3) -> OrderTable:
    """Fit every ARMA(p, q) up to (max_p, max_q) to one series and compare them.

    SG13 defends ARMA(1,1) by Akaike's final prediction error.  Slow: one statsmodels fit per order.

    Parameters
    ----------
    y : array_like, shape (n,)
        Detrended heights in m, one every `dt` seconds.
    dt : float
        Sampling interval, s.
    max_p, max_q : int
        Largest orders.

    Returns
    -------
    OrderTable
        (max_p + 1)(max_q + 1) fits.

    Examples
    --------
    >>> wander = ArmaModel(ar=(-0.9,), ma=(), sd=0.1, dt=0.1).simulate(600, rng=1)
    >>> order_table(wander, 0.1, max_p=1, max_q=1).best("bic")
    (1, 0)
    """
    orders = [(p, q) for p in range(max_p + 1) for q in range(max_q + 1)]
    return OrderTable({order: fit_arma(y, dt, order) for order in orders})


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


@dataclass(frozen=True)
class AveragingRow:
    """One length of the moving average in the study of SG13, Fig. 5; sds in m.

    Parameters
    ----------
    average : int
        M, samples.
    total_sd, correlated_sd, white_sd : Trimmed
        Trimmed mean and SD over windows, m.
    theory_white_sd : float
        What 1/sqrt(M) makes of the white sd of the first row, m.
    bartlett_failures, ljung_box_failures : float
        Share of the windows that the test rejects at 5 %.
    outside : float
        Share of the windows whose coefficients are no Gauss-Markov plus white noise.

    Examples
    --------
    >>> from baroarma import NoiseModel
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> row = averaging_study(np.arange(15000) / 50, noise.simulate(15000, 1), averages=(4,)).rows[0]
    >>> round(row.white_sd.mean, 2), row.outside  # 0.46 m/sqrt(4) = 0.23 m, in windows of 300 samples 4 % low
    (0.22, 0.0)
    """

    average: int
    total_sd: Trimmed
    correlated_sd: Trimmed
    white_sd: Trimmed
    theory_white_sd: float
    """What 1/sqrt(M) makes of the white sd of the first row."""
    bartlett_failures: float
    """Fraction of windows that Bartlett's test rejects at 5 %."""
    ljung_box_failures: float
    outside: float
    """Fraction of windows whose coefficients are no Gauss-Markov plus white noise."""


@dataclass(frozen=True, repr=False)
class AveragingStudy:
    """Hold what averages of growing length do to the noise [SG13, Fig. 5].

    Parameters
    ----------
    rows : tuple of AveragingRow
        One per length.

    Examples
    --------
    >>> from baroarma import NoiseModel
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> study = averaging_study(np.arange(15000) / 50, noise.simulate(15000, 1), averages=(1, 4, 16))
    >>> study
    <AveragingStudy of M = 1, 4, 16 samples>
    >>> first, second, _ = study.to_frame()["theory_white_sd_m"]
    >>> round(first / second, 9)  # sqrt(4/1)
    2.0
    """

    rows: tuple[AveragingRow, ...]

    def __repr__(self) -> str:
        return f"<AveragingStudy of M = {', '.join(str(row.average) for row in self.rows)} samples>"

    def summary(self) -> str:
        """Return a table with one row per length M."""
        lines = [
            "  M   sigma_s   sigma_c   sigma_u   1/sqrt(M)   Bartlett   Ljung-Box   outside",
            "           m         m         m           m   rejects     rejects",
        ]
        lines += [
            f"{r.average:3d}{r.total_sd.mean:10.3f}{_cell(r.correlated_sd)}{_cell(r.white_sd)}"
            f"{r.theory_white_sd:12.3f}{r.bartlett_failures:10.0%}{r.ljung_box_failures:12.0%}{r.outside:10.0%}"
            for r in self.rows
        ]
        return "\n".join(lines)

    def to_frame(self) -> pd.DataFrame:
        """Return the table as a pandas DataFrame, a row per length."""
        import pandas as pd

        return pd.DataFrame(
            [
                {
                    "average": r.average,
                    "total_sd_m": r.total_sd.mean,
                    "correlated_sd_m": r.correlated_sd.mean,
                    "white_sd_m": r.white_sd.mean,
                    "theory_white_sd_m": r.theory_white_sd,
                    "bartlett_failures": r.bartlett_failures,
                    "ljung_box_failures": r.ljung_box_failures,
                    "outside": r.outside,
                }
                for r in self.rows
            ]
        )

    def _repr_html_(self) -> str:
        from baroarma.notebook import tables
        from baroarma.page import Table

        rows = []
        for r in self.rows:
            sds = (r.total_sd.mean, r.correlated_sd.mean, r.white_sd.mean, r.theory_white_sd)
            shares = (r.bartlett_failures, r.ljung_box_failures, r.outside)
            cells = ("–" if sd != sd else f"{sd:.3f}" for sd in sds)
            rows.append((str(r.average), *cells, *(f"{share:.0%}" for share in shares)))
        head = (
            "M",
            "total sd (m)",
            "Gauss-Markov sd (m)",
            "white sd (m)",
            "white by 1/√M (m)",
            "Bartlett rejects",
            "Ljung-Box rejects",
            "outside",
        )
        return tables(Table(head, tuple(rows), "Averages of M samples; shares of windows"))

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the sds over the length; see `baroarma.plotting.plot_averaging`."""
        from baroarma.plotting import plot_averaging

        return plot_averaging(self, ax)


def _cell(found: Trimmed) -> str:
    """Return a mean for the table; a dash where no window had the component."""
    return "-".rjust(10) if math.isnan(found.mean) else f"{found.mean:10.3f}"


def averaging_study(
    t: ArrayLike,
    height: ArrayLike,
    averages: Sequence[int] = (1, 2, 4, 8, 16, 32, 64, 128, 256),
    settings: WindowSettings | None = None,
    *,
    split: Split = "exact",
) -> AveragingStudy:
    """Repeat the identification with moving averages of growing length [SG13, Sec. 3.1, Fig. 5].

    Averages longer than the decimation put their own shape into the data, which an ARMA(1,1) cannot follow:
    the whiteness tests reject and the coefficients leave the region of Gauss-Markov plus white noise.

    Parameters
    ----------
    t, height : array_like, shape (n,)
        Times in s and heights in m of new samples at rest.
    averages : sequence of int
        Lengths M of the moving average in raw samples.
    settings : WindowSettings, optional
        The other settings; default: those for the rate.
    split : {"exact", "bilinear"}
        How coefficients become components.

    Returns
    -------
    AveragingStudy
        A row per length.

    Raises
    ------
    ValueError
        If no gap-free window is left.

    Examples
    --------
    After averages of 16 samples no window is one of Gauss-Markov plus white noise any more; after those of 4,
    as SG13 has it, each is:

    >>> from baroarma import NoiseModel
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> study = averaging_study(np.arange(15000) / 50, noise.simulate(15000, 1), averages=(4, 16))
    >>> [row.outside for row in study.rows], [row.ljung_box_failures for row in study.rows]
    ([0.0, 1.0], [0.0, 1.0])
    """
    t, height = new_samples(t, height)
    settings = settings or WindowSettings.for_rate(1 / float(np.median(np.diff(t))))
    rows: list[AveragingRow] = []
    for m in averages:
        cut = condition(t, height, replace(settings, average=m))
        if not len(cut.windows):
            raise ValueError(f"the recording has no gap-free window left after an average of {m} samples")
        fits = fit_windows(cut.windows, cut.dt, split)
        white = trimmed_mean(fits.white_sd, settings.trim)
        first = (rows[0].theory_white_sd * math.sqrt(rows[0].average)) if rows else white.mean * math.sqrt(m)
        bartlett, ljung = whiteness_of_windows(fits)
        rows.append(
            AveragingRow(
                average=m,
                total_sd=trimmed_mean(fits.total_sd, settings.trim),
                correlated_sd=trimmed_mean(fits.correlated_sd, settings.trim),
                white_sd=white,
                theory_white_sd=first / math.sqrt(m),
                bartlett_failures=float(np.mean(bartlett < 0.05)),
                ljung_box_failures=float(np.mean(ljung < 0.05)),
                outside=float(np.mean(~fits.inside)),
            )
        )
    return AveragingStudy(tuple(rows))
