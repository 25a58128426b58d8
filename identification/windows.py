"""The windows method: SG13's identification, window by window.

Preprocess (`preprocessing`), fit an ARMA(1,1) to every window (`arma_fit`), split it into Gauss-Markov and
white noise (`baroarma.arma`), average over windows with trimming.  The result stands at the windows' interval
(SG13: T = 0.1 s, "conditioned"); `WindowsResult.to_noise_model` goes back to raw samples, where averaging M
of them lowered the white sd by sqrt(M).

The method cannot see drift, because detrending removes it, and short windows and the average bias it a
little: with SG13's noise and settings the exact split finds sigma_u 3 % and sigma_c 1 % low, the bilinear one
sigma_u 2 % high and sigma_c 5 % low.  Windows whose coefficients no Gauss-Markov plus white noise can have
are counted, not clipped.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.arma import Split
from baroarma.finding import Finding
from baroarma.identification.arma_fit import WindowFits, coefficient_covariance, fit_windows
from baroarma.identification.preprocessing import (
    Conditioned,
    Trimmed,
    WindowSettings,
    condition,
    new_samples,
    trimmed_mean,
)
from baroarma.identification.whiteness import whiteness_of_windows
from baroarma.noise_model import Interval, NoiseModel

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

_QUANTITIES = {
    "correlation_time": "s",
    "correlated_sd": "m",
    "white_sd": "m",
    "total_sd": "m",
    "a": "",
    "b": "",
    "innovation_sd": "m",
}


@dataclass(frozen=True, eq=False, repr=False)
class WindowsResult:
    """Hold what the windows method found; all sds are those of the conditioned samples.

    Parameters
    ----------
    fits : WindowFits
        a, b, innovation sd, components (NaN outside the region) and total sd per window.
    start : ndarray, shape (m,)
        Time of each window's first sample, s.
    bartlett_p, ljung_box_p : ndarray, shape (m,)
        Whiteness of each window's prediction errors: cumulative periodogram, Ljung-Box (20 lags, 2 fitted).
    table : dict of str to Trimmed
        Trimmed mean, SD and 95 % interval over windows of ``correlation_time``, ``correlated_sd``,
        ``white_sd``, ``total_sd``, ``a``, ``b``, ``innovation_sd`` [SG13, Tables 1-2].
    dt : float
        Interval of the conditioned samples, s.
    rate_hz : float
        Rate of the raw samples, Hz.
    settings : WindowSettings
        What was done.
    split : {"exact", "bilinear"}
        How coefficients became components.
    drift_upper : float
        Largest drift rate, m/sqrt(s), that the levels which detrending removed allow.
    findings : tuple of Finding
        What to know before trusting it.

    Examples
    --------
    The windows' white sd is that of averages of four; the noise model's is that of raw samples:

    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> found = identify_windows(np.arange(15000) / 50, noise.simulate(15000, 1))
    >>> len(found), found.settings.average
    (10, 4)
    >>> round(found.to_noise_model().white_sd / found.table["white_sd"].mean, 9)
    2.0
    >>> low, high = found.table["correlation_time"].ci95
    >>> low < 0.75 < high
    True
    """

    fits: WindowFits
    start: NDArray[np.float64]
    bartlett_p: NDArray[np.float64]
    ljung_box_p: NDArray[np.float64]
    table: dict[str, Trimmed]
    dt: float
    rate_hz: float
    settings: WindowSettings
    split: Split
    drift_upper: float
    findings: tuple[Finding, ...]

    def __len__(self) -> int:
        return len(self.start)

    def __repr__(self) -> str:
        tau, correlated, white = (self.table[name].mean for name in list(_QUANTITIES)[:3])
        return (
            f"<WindowsResult of {len(self)} windows at {self.dt:.4g} s ({self.split}): "
            f"white {white:.4g} m, Gauss-Markov {correlated:.4g} m / {tau:.4g} s>"
        )

    def eq16_ci95(self) -> dict[str, Interval]:
        """Return 95 % intervals of the mean a and b by theory: 1.96 sd/sqrt(m), sd of SG13, Eq. 16.

        They don't look at the scatter over windows, which `table` does; if that is larger, the noise is
        less stationary than the model (or the windows short: at 300 samples Eq. 16 is 8 to 14 % optimistic).
        """
        half = 1.96 * np.array(self.eq16_sd()) / math.sqrt(max(self.table["a"].n, 1))
        means = np.array([self.table["a"].mean, self.table["b"].mean])
        low, high = (means - half).tolist(), (means + half).tolist()
        return {"a": (low[0], high[0]), "b": (low[1], high[1])}

    def eq16_sd(self) -> tuple[float, float]:
        """Return the sds of one window's a and b by SG13, Eq. 16, at the mean coefficients.

        Returns
        -------
        tuple of float
            Of a and of b; infinite where a = b.

        Examples
        --------
        They are as the roots of 1 - a² and 1 - b²:

        >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
        >>> found = identify_windows(np.arange(15000) / 50, noise.simulate(15000, 1))
        >>> (sd_a, sd_b), a, b = found.eq16_sd(), found.table["a"].mean, found.table["b"].mean
        >>> round((sd_a / sd_b) ** 2 * (1 - b**2) / (1 - a**2), 9)
        1.0
        """
        a, b = self.table["a"].mean, self.table["b"].mean
        if a == b:  # they cancel: (a, b) is not determined
            return math.inf, math.inf
        sd_a, sd_b = np.sqrt(np.diag(coefficient_covariance(a, b, self.settings.window))).tolist()
        return sd_a, sd_b

    def to_noise_model(self) -> NoiseModel:
        """Return the noise of the *raw* samples: the white sd times sqrt(M), the rest as it is.

        The 95 % intervals come from the scatter over windows (`trimmed_mean`), which needs no assumption
        about one window's estimate; they don't contain the method's bias.  With fewer than 3 windows they
        span [0, inf) as far as JSON can say it: 0 to ten times the value.  The drift is 0.0, because
        detrending removes it; its interval reaches up to the drift that would explain *all* wander of the
        removed levels.

        When no window supports a Gauss-Markov component, the model is white noise of the total sd, and the
        intervals of the missing component reach up to the total sd and to the length of a window.

        """
        values, ci95 = self._components() if self.fits.inside.any() else self._only_white()
        root = math.sqrt(self.settings.average)
        low, high = ci95["white_sd"]
        return NoiseModel(
            values["correlated_sd"],
            values["correlation_time"],
            values["white_sd"] * root,
            rate_hz=self.rate_hz,
            ci95={**ci95, "white_sd": (low * root, high * root), "drift_rate": (0.0, self.drift_upper)},
            method="windows",
            verdict=self.findings,
        )

    def _components(self) -> tuple[dict[str, float], dict[str, Interval]]:
        names = ("correlated_sd", "correlation_time", "white_sd")
        return (
            {name: self.table[name].mean for name in names},
            {name: _interval(self.table[name]) for name in names},
        )

    def _only_white(self) -> tuple[dict[str, float], dict[str, Interval]]:
        total = _interval(self.table["total_sd"])
        return (
            {"correlated_sd": 0.0, "correlation_time": 0.0, "white_sd": self.table["total_sd"].mean},
            {
                "correlated_sd": (0.0, total[1]),
                "correlation_time": (0.0, self.settings.window * self.dt),
                "white_sd": (0.0, total[1]),
            },
        )

    def summary(self) -> str:
        """Return a table in the style of SG13, Table 1, with what Eq. 16 says and what was noticed."""
        s = self.settings
        lines = [
            f"{len(self)} windows of {s.window} samples at {self.dt:.4g} s ({self.split} split; "
            f"detrend {s.detrend_s:g} s, average {s.average}, every {s.decimate}. sample)",
            f"  {'':17}{'mean':>9}   {'SD':>8}   {s.trim:.0%} trimmed",
        ]
        for name, unit in _QUANTITIES.items():
            value = self.table[name]
            sd = "–" if value.sd is None else f"{value.sd:.4f}"
            lines.append(f"  {name.replace('_', ' '):17}{value.mean:9.4f} ± {sd:>8} {unit}")
        lines.append("  SD of one window by Eq. 16: a {:.4f}, b {:.4f}".format(*self.eq16_sd()))
        lines.append(
            f"  outside the region: {np.sum(~self.fits.inside)}; not white (5 %): "
            f"Bartlett {np.sum(self.bartlett_p < 0.05)}, Ljung-Box {np.sum(self.ljung_box_p < 0.05)}"
        )
        return "\n".join(lines + [f"  {finding}" for finding in self.findings])

    def _repr_html_(self) -> str:
        from baroarma.notebook import about, number, tables
        from baroarma.page import Table

        rows = [
            (name.replace("_", " "), f"{number(v.mean)} {unit}", f"{number(v.sd, 2)} {unit}", str(v.n))
            for name, unit in _QUANTITIES.items()
            for v in (self.table[name],)
        ]
        caption = (
            f"{len(self)} windows of {self.settings.window} samples at {self.dt:.4g} s ({self.split} split)"
        )
        head = ("quantity", "trimmed mean", "SD", "windows")
        return tables(Table(head, tuple(rows), caption), *about(self.findings))

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas DataFrame with a row per window; a component it doesn't have is NaN."""
        import pandas as pd

        columns = {f"{name}_{unit}" if unit else name: name for name, unit in _QUANTITIES.items()}
        return pd.DataFrame(
            {
                "start_s": self.start,
                **{column: getattr(self.fits, name) for column, name in columns.items()},
                "bartlett_p": self.bartlett_p,
                "ljung_box_p": self.ljung_box_p,
            }
        )

    def plot(self) -> Figure:
        """Draw the components over the windows; see `baroarma.plotting.plot_windows`."""
        from baroarma.plotting import plot_windows

        return plot_windows(self)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain JSON values, null where there is none."""
        per_window = {name: _plain(getattr(self.fits, name)) for name in _QUANTITIES}
        return {
            "split": self.split,
            "dt_s": self.dt,
            "rate_hz": self.rate_hz,
            "settings": {k: v if math.isfinite(v) else None for k, v in vars(self.settings).items()},
            "table": {
                name: {
                    "mean": _plain([v.mean])[0],
                    "sd": v.sd,
                    "ci95": v.ci95 and list(v.ci95),
                    "count": v.n,
                }
                for name, v in self.table.items()
            },
            "eq16_ci95": {name: _plain(interval) for name, interval in self.eq16_ci95().items()},
            "outside": int(np.sum(~self.fits.inside)),
            "drift_upper_m_per_sqrt_s": self.drift_upper,
            "windows": {
                "start_s": _plain(self.start),
                **per_window,
                "bartlett_p": _plain(self.bartlett_p),
                "ljung_box_p": _plain(self.ljung_box_p),
            },
            "verdict": [finding.to_dict() for finding in self.findings],
        }


def identify_windows(
    t: ArrayLike,
    height: ArrayLike,
    settings: WindowSettings | None = None,
    *,
    split: Split = "exact",
) -> WindowsResult:
    """Identify the noise of a barometer at rest by SG13's windows method.

    Parameters
    ----------
    t, height : array_like, shape (n,)
        Times in s and heights in m of new samples; rows whose height is NaN are left out.
    settings : WindowSettings, optional
        Default: SG13's at 50 Hz, adapted to the rate by `WindowSettings.for_rate`.
    split : {"exact", "bilinear"}
        How coefficients become components: by matched autocovariances, or as SG13 does.

    Raises
    ------
    ValueError
        If there is not one gap-free window; the message says how long a recording is needed.

    Examples
    --------
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> found = identify_windows(np.arange(30000) / 50, noise.simulate(30000, 1))
    >>> found
    <WindowsResult of 20 windows at 0.1 s (exact): white 0.2201 m, Gauss-Markov 0.2536 m / 0.7211 s>
    >>> found.to_noise_model().rate_hz
    50.0
    """
    t, height = new_samples(t, height)
    settings = settings or WindowSettings.for_rate(1 / float(np.median(np.diff(t))))
    cut = condition(t, height, settings)
    if not len(cut.windows):
        raise ValueError(_too_short(t, cut, settings))
    fits = fit_windows(cut.windows, cut.dt, split)
    bartlett, ljung = whiteness_of_windows(fits)
    return WindowsResult(
        fits=fits,
        start=cut.start,
        bartlett_p=bartlett,
        ljung_box_p=ljung,
        table={name: trimmed_mean(getattr(fits, name), settings.trim) for name in _QUANTITIES},
        dt=cut.dt,
        rate_hz=cut.rate_hz,
        settings=settings,
        split=split,
        drift_upper=_drift_upper(t, height, settings.detrend_s),
        findings=(*_cut_findings(cut), *_fit_findings(fits, cut.dt, ljung)),
    )


def _too_short(t: NDArray[np.float64], cut: Conditioned, settings: WindowSettings) -> str:
    need = settings.window * cut.dt
    found = f"a recording of {t[-1] - t[0]:.4g} s with {cut.gaps} gaps has no gap-free window"
    return (
        f"{found} of {settings.window} samples at {cut.dt:.4g} s; record at least {need:.4g} s without gaps"
    )


def _cut_findings(cut: Conditioned) -> list[Finding]:
    findings = []
    if cut.gaps:
        message = (
            f"{cut.gaps} gaps or surplus samples cost {cut.skipped} windows; {len(cut.windows)} are left."
        )
        findings.append(Finding("gaps", "warning", message))
    if cut.jitter > 0.05:
        message = (
            f"The sampling interval jitters by {cut.jitter:.0%} (RMS); the windows method "
            "takes it for regular, the structural method uses the times as they are."
        )
        findings.append(Finding("gaps", "info", message))
    return findings


def _fit_findings(fits: WindowFits, dt: float, ljung_box_p: NDArray[np.float64]) -> list[Finding]:
    findings, m = [], len(fits.a)
    inside, rejected = int(fits.inside.sum()), int(np.sum(ljung_box_p < 0.05))
    if inside <= m / 2:
        message = (
            f"Only {inside} of {m} windows support Gauss-Markov plus white noise; don't trust the component."
        )
        findings.append(Finding("no-gm", "warning", message))
    elif inside < m:
        message = (
            f"{m - inside} of {m} windows don't support Gauss-Markov plus white noise; they are left out."
        )
        findings.append(Finding("no-gm", "info", message))
    tau, length = trimmed_mean(fits.correlation_time).mean, fits.residuals.shape[1] * dt
    if tau > length / 6:
        message = (
            f"The correlation time of {tau:.3g} s is not short against the windows of {length:.3g} s: "
            "it may be drift that detrending left; use longer windows or the structural method."
        )
        findings.append(Finding("too-short", "warning", message))
    from scipy.special import bdtrc

    if bdtrc(rejected - 1, m, 0.05) < 0.01:  # that many rejections at 5 % are no chance
        message = f"At 5 % Ljung-Box rejects {rejected} of {m} windows: an ARMA(1, 1) misses structure."
        findings.append(Finding("not-white", "warning", message))
    return findings


def _drift_upper(t: NDArray[np.float64], height: NDArray[np.float64], length_s: float) -> float:
    """Drift rate that explains all wander of the removed levels, at the upper end of its 95 % interval.

    Means of a random walk over adjacent blocks of length L differ with the variance (2/3) L d²; adjacent
    differences correlate by 1/4, which costs a ninth of the degrees of freedom.  At least four blocks.
    """
    from scipy.special import chdtri

    blocks = max(round((t[-1] - t[0]) / length_s), 4)
    length = (t[-1] - t[0]) / blocks
    block = np.minimum((t - t[0]) // length, blocks - 1).astype(int)
    filled, block = np.unique(block, return_inverse=True)
    level = np.bincount(block, weights=height - height[0]) / np.bincount(block)
    squares = np.diff(level) ** 2 / ((np.diff(filled) - 1 / 3) * length)
    freedom = 8 / 9 * len(squares)
    return float(math.sqrt(squares.mean() * freedom / chdtri(freedom, 0.975)))


def _interval(value: Trimmed) -> Interval:
    if value.ci95 is None:
        return 0.0, 10 * value.mean
    return max(value.ci95[0], 0.0), value.ci95[1]


def _plain(values: ArrayLike) -> list[float | None]:
    return [v if math.isfinite(v) else None for v in np.asarray(values, float).tolist()]
