"""The noise of a barometric altimeter: Gauss-Markov + white + random-walk drift.

    n(t) = c(t) + u(t) + b(t)                                                        [SG13, Eq. 5]

c is a first-order Gauss-Markov process (sd sigma_c, time constant tau), u is white with sd sigma_u *per raw
sample*, b is a random walk that grows by `drift_rate` metres per square-root second.

What survives a change of sampling rate is the spectral density of the white noise, sigma_u^2 / rate, not its
sd.  `at_rate`, `arma` and `whitening_filter` therefore work from the density.
"""

from __future__ import annotations

import json
import math
import os
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.arma import ArmaModel, gauss_markov_arma
from baroarma.atomic import replacing
from baroarma.finding import Finding
from baroarma.noise_file import FORMAT, VERSION, model_fields, read_object
from baroarma.whitening import WhiteningFilter, no_whitening, synthesise

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PARAMETERS: Final = ("correlated_sd", "correlation_time", "white_sd", "drift_rate")
JSON_KEYS: Final = (
    "correlated_sd_m",
    "correlation_time_s",
    "white_sd_m",
    "drift_rate_m_per_sqrt_s",
)
TERM_NAMES: Final = {"white": "white", "drift": "drift", "gm": "Gauss-Markov", "gm2": "second Gauss-Markov"}
"""What people call the terms of a model."""
TEST_NAMES: Final = {
    "ljung_box_10": "Ljung-Box over 10 lags",
    "ljung_box_40": "Ljung-Box over 40 lags",
    "bartlett": "Bartlett's cumulative periodogram",
}
"""What people call the whiteness tests, by their keys in `NoiseModel.whiteness_p`."""
Interval = tuple[float, float]
SMALLEST: Final = 1e-30
LARGEST: Final = 1e9
"""What a parameter that isn't 0 can be, in its own unit: far beyond any sensor, and products stay finite."""

HALF_NORMAL_95: Final = 1.959964
"""The 95 % quantile of a half-normal distribution, in units of its root mean square."""


@dataclass(frozen=True)
class NoiseModel:
    """Describe the noise of raw altimeter samples; a term that isn't there is 0.

    Parameters
    ----------
    correlated_sd : float
        Standard deviation of the Gauss-Markov component, m.  0 together with `correlation_time`: none.
    correlation_time : float
        Its time constant, s.
    white_sd : float
        Standard deviation of the white component of one raw sample, m.
    drift_rate : float
        Growth of the random-walk drift, m/sqrt(s).
    rate_hz : float
        Rate of the raw samples, Hz.
    ci95 : dict, optional
        95 % intervals by field name, ``{"white_sd": (low, high), ...}``; None when built by hand.
    method : str
        ``"structural"``, ``"windows"`` or ``"by hand"``.
    sensor : str
        What it is the noise of.
    verdict : tuple of Finding
        What to know before trusting it.
    whiteness_p : dict, optional
        p-values of the whiteness tests of the prediction errors.
    source : dict, optional
        The recording: ``{"name", "sha256", "duration_s"}``.

    Raises
    ------
    ValueError
        If a value is negative, not finite or beyond all sensors, or only one of the Gauss-Markov pair is 0.

    Examples
    --------
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> noise
    <NoiseModel at 50 Hz: white 0.46 m, Gauss-Markov 0.27 m / 0.75 s, no drift>
    >>> noise.at_rate(25).white_sd < noise.white_sd
    True
    >>> noise.whitening_filter(unity_gain_hz=25)
    <WhiteningFilter at 50 Hz: DC gain 0.193, zero 0.2122 Hz, pole 1.099 Hz, unity gain at 25 Hz>
    """

    correlated_sd: float
    correlation_time: float
    white_sd: float
    drift_rate: float = 0.0
    rate_hz: float = field(kw_only=True)
    ci95: dict[str, Interval] | None = field(default=None, kw_only=True, hash=False)
    method: str = field(default="by hand", kw_only=True)
    sensor: str = field(default="", kw_only=True)
    verdict: tuple[Finding, ...] = field(default=(), kw_only=True)
    whiteness_p: dict[str, float] | None = field(default=None, kw_only=True, hash=False)
    source: dict[str, Any] | None = field(default=None, kw_only=True, hash=False)

    def __post_init__(self) -> None:
        for name in (*PARAMETERS, "rate_hz"):
            value = float(getattr(self, name))
            if not (math.isfinite(value) and value >= 0):
                raise ValueError(f"{name} must be a number >= 0, but it is {value}")
            if value and not SMALLEST <= value <= LARGEST:
                raise ValueError(
                    f"{name} is {value:g}, which no altimeter has; it must be 0 or from {SMALLEST:g} to "
                    f"{LARGEST:g}"
                )
            object.__setattr__(self, name, value)
        if self.rate_hz == 0:
            raise ValueError("rate_hz must be positive: it says at which rate white_sd holds")
        if (self.correlated_sd == 0) != (self.correlation_time == 0):
            raise ValueError(
                f"correlated_sd = {self.correlated_sd} and correlation_time = {self.correlation_time}: "
                "both describe the Gauss-Markov component, so either both are 0 or neither is"
            )
        if self.ci95 is not None:
            ci95 = {name: tuple(float(v) for v in self.ci95[name]) for name in PARAMETERS}
            object.__setattr__(self, "ci95", ci95)

    def __repr__(self) -> str:
        gm = f"Gauss-Markov {self.correlated_sd:.4g} m / {self.correlation_time:.4g} s"
        drift = f"drift {self.drift_rate:.4g} m/sqrt(s)" if self.drift_rate else "no drift"
        return (
            f"<NoiseModel at {self.rate_hz:.4g} Hz: white {self.white_sd:.4g} m, "
            f"{gm if self.has_gauss_markov else 'no Gauss-Markov'}, {drift}>"
        )

    @property
    def has_gauss_markov(self) -> bool:
        """Whether there is a Gauss-Markov component."""
        return self.correlated_sd > 0

    @property
    def white_density(self) -> float:
        """Two-sided spectral density of the white component, m²/Hz: sigma_u²/rate, the same at any rate.

        Examples
        --------
        >>> noise = NoiseModel(0, 0, white_sd=0.5, rate_hz=50)
        >>> noise.white_density, round(noise.at_rate(12.5).white_density, 9)
        (0.005, 0.005)
        """
        return self.white_sd**2 / self.rate_hz

    def at_rate(self, rate_hz: float) -> NoiseModel:
        """Return the model of the same noise sampled at another rate, the white density kept.

        This is the noise of a sensor that integrates over its sampling interval (or is averaged down to
        it).  Picking every n-th raw sample without averaging keeps `white_sd` instead; then use
        `dataclasses.replace(noise, rate_hz=...)`.

        Parameters
        ----------
        rate_hz : float
            The other rate, Hz.

        Raises
        ------
        ValueError
            If the rate is no positive number.

        Examples
        --------
        Averages of four samples have half the white noise; the rest is as slow as it was:

        >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
        >>> noise.at_rate(12.5)
        <NoiseModel at 12.5 Hz: white 0.23 m, Gauss-Markov 0.27 m / 0.75 s, no drift>
        """
        if not (math.isfinite(rate_hz) and rate_hz > 0):
            raise ValueError(f"the rate must be a positive number of Hz, but it is {rate_hz:g}")
        factor = math.sqrt(rate_hz / self.rate_hz)
        ci95 = self.ci95 and {
            **self.ci95,
            "white_sd": (self.ci95["white_sd"][0] * factor, self.ci95["white_sd"][1] * factor),
        }
        return replace(self, white_sd=self.white_sd * factor, rate_hz=rate_hz, ci95=ci95)

    def with_possible_drift(self) -> NoiseModel:
        """Return the model with the drift that its rest was too short to exclude, if it has none.

        A filter that believes in no drift trusts the barometer for ever.  If the drift's interval is [0, u],
        its root mean square under a half-normal of that 95 % quantile is u/1.96; a long rest leaves little.

        Examples
        --------
        >>> sure = {"correlated_sd": (0, 0), "correlation_time": (0, 0), "white_sd": (0.4, 0.5)}
        >>> rest = NoiseModel(0, 0, 0.46, rate_hz=50, ci95={**sure, "drift_rate": (0.0, 0.0196)})
        >>> round(rest.with_possible_drift().drift_rate, 6)
        0.01
        """
        if self.drift_rate or self.ci95 is None:
            return self
        return replace(self, drift_rate=self.ci95["drift_rate"][1] / HALF_NORMAL_95)

    def arma(self, dt: float) -> ArmaModel:
        """Return the ARMA(1,1) of the stationary part (Gauss-Markov + white) sampled every `dt` s.

        The drift is not stationary and not in it.  White density is kept, as in `at_rate`.

        Raises
        ------
        ValueError
            If `dt` is no positive number.

        Examples
        --------
        >>> NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50).arma(0.02)
        <ArmaModel(1, 1): a = [-0.9737], b = [-0.8711], sd 0.4863, 0.02 s>
        """
        if not (math.isfinite(dt) and dt > 0):
            raise ValueError(f"the sampling interval must be positive, but it is {dt:g} s")
        return gauss_markov_arma(
            correlated_sd=self.correlated_sd,
            correlation_time=self.correlation_time,
            white_sd=math.sqrt(self.white_density / dt),
            dt=dt,
        )

    def autocovariance(self, lag: ArrayLike) -> NDArray[np.float64]:
        """Return the autocovariance of the stationary part at lags in s, m²; white noise is at lag 0.

        Parameters
        ----------
        lag : array_like
            Lags in s, of either sign.

        Examples
        --------
        0.5² + 0.3² at lag 0, then 0.3² exp(-lag/2 s):

        >>> noise = NoiseModel(correlated_sd=0.3, correlation_time=2.0, white_sd=0.5, rate_hz=50)
        >>> noise.autocovariance([0.0, 2 * math.log(2)]).round(6).tolist()
        [0.34, 0.045]
        """
        distance = np.abs(np.asarray(lag, float))
        correlated = np.zeros(distance.shape)
        if self.has_gauss_markov:
            correlated = self.correlated_sd**2 * np.exp(-distance / self.correlation_time)
        return correlated + np.where(distance == 0, self.white_sd**2, 0.0)

    def psd(self, frequency_hz: ArrayLike) -> NDArray[np.float64]:
        """Return the one-sided power spectral density of the raw samples, m²/Hz.

        Parameters
        ----------
        frequency_hz : array_like
            Frequencies in Hz, 0 to `rate_hz` / 2.  With drift the density is infinite at 0.

        Returns
        -------
        ndarray
            Density of the sampled process (aliasing included); its integral from 0 to Nyquist is the
            variance when there is no drift.

        Examples
        --------
        >>> noise = NoiseModel(correlated_sd=0.3, correlation_time=2.0, white_sd=0.5, rate_hz=10)
        >>> frequency = np.linspace(0, 5, 2001)
        >>> round(float(np.trapezoid(noise.psd(frequency), frequency)), 4)  # 0.3² + 0.5²
        0.34
        """
        dt = 1 / self.rate_hz
        x = 2 * np.pi * np.asarray(frequency_hz, float) * dt
        density = np.full(x.shape, 2 * dt * self.white_sd**2)
        if self.has_gauss_markov:
            phi = math.exp(-dt / self.correlation_time)
            shape = -math.expm1(-2 * dt / self.correlation_time) / (1 - 2 * phi * np.cos(x) + phi**2)
            density += 2 * dt * self.correlated_sd**2 * shape
        if self.drift_rate:
            with np.errstate(divide="ignore"):
                density += 2 * dt * self.drift_rate**2 * dt / (4 * np.sin(x / 2) ** 2)
        return density

    def allan_deviation(self, tau: ArrayLike) -> NDArray[np.float64]:
        """Return the Allan deviation of *height* averaged over `tau` seconds, m.

        White noise falls as tau^-1/2, drift grows as tau^1/2, Gauss-Markov noise has its hump near
        1.9 correlation times.  The continuous-time formulas hold for tau of several sampling intervals.

        Parameters
        ----------
        tau : array_like
            Averaging times, s.

        Examples
        --------
        White noise of 0.5 m at 50 Hz, averaged over 50 samples and over 200; drift over 3 s and over 12 s:

        >>> NoiseModel(0, 0, white_sd=0.5, rate_hz=50).allan_deviation([1.0, 4.0]).round(4).tolist()
        [0.0707, 0.0354]
        >>> NoiseModel(0, 0, 0, drift_rate=0.01, rate_hz=50).allan_deviation([3.0, 12.0]).round(9).tolist()
        [0.01, 0.02]
        """
        tau = np.asarray(tau, float)
        variance = self.white_density / tau + self.drift_rate**2 * tau / 3
        if self.has_gauss_markov:
            r = tau / self.correlation_time
            large = np.maximum(r, 1e-2)  # below, 3 - 4 e^-r + e^-2r loses its digits and the series serves
            full = (1 - (3 - 4 * np.exp(-large) + np.exp(-2 * large)) / (2 * large)) / large
            variance += 2 * self.correlated_sd**2 * np.where(r < 1e-2, r / 3 - r**2 / 4, full)
        return np.sqrt(variance)

    def simulate(self, t: ArrayLike, rng: np.random.Generator | int | None = None) -> NDArray[np.float64]:
        """Simulate the noise of raw samples taken at given times.

        Parameters
        ----------
        t : array_like, shape (n,), or int
            Increasing times in s, regular or not; an integer n means n samples at `rate_hz`.
        rng : numpy.random.Generator or int, optional
            Generator or seed.

        Returns
        -------
        ndarray, shape (n,)
            Noise in m; the drift starts at 0.

        Examples
        --------
        >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
        >>> round(float(np.std(noise.simulate(100_000, rng=1))), 2)  # sqrt(0.27² + 0.46²)
        0.53
        """
        rng = np.random.default_rng(rng)
        times = np.arange(int(t)) / self.rate_hz if np.ndim(t) == 0 else np.asarray(t, float)  # type: ignore[arg-type]
        dt = np.diff(times, prepend=times[:1])
        noise = self.white_sd * rng.normal(size=len(times))
        correlated, drift = rng.normal(size=(2, len(times)))
        if self.has_gauss_markov:
            noise += self.correlated_sd * _gauss_markov(correlated, dt / self.correlation_time)
        return noise + self.drift_rate * np.cumsum(np.sqrt(dt) * drift)

    def whitening_filter(
        self, *, rate_hz: float | None = None, unity_gain_hz: float | None = None
    ) -> WhiteningFilter:
        """Synthesise the whitening filter of this noise.

        tau_p = tau and tau_o = tau sqrt(S_u / (S_u + 2 sigma_c² tau)) with the white noise's two-sided
        density S_u = sigma_u²/rate: what whitens raw samples at their own rate (SG13's zero time constant
        tau alpha/sqrt(alpha²+beta²), Eq. 11, with the tau that its print lacks).  That is an approximation
        for tau_o of several sampling intervals: the whitened density ripples by 0.5 % for SG13's noise at
        50 Hz, by 9 % at 10 Hz, by a third where tau_o is half an interval.  Below that (little white noise,
        or none) the bilinear transform would put the pole near Nyquist and make the filter ring; there the
        sampled process itself is undone, which whitens exactly.

        Parameters
        ----------
        rate_hz : float, optional
            Rate in Hz at which the filter is to run; default: the model's.
        unity_gain_hz : float, optional
            Frequency in Hz with gain 1, from 0 to Nyquist; default: Nyquist, as SG13.

        Returns
        -------
        WhiteningFilter
            1 when there is no Gauss-Markov component, with a `note` that says so.

        Raises
        ------
        ValueError
            If the frequency lies beyond Nyquist.
        """
        rate_hz = self.rate_hz if rate_hz is None else rate_hz
        unity_gain_hz = rate_hz / 2 if unity_gain_hz is None else unity_gain_hz
        if not self.has_gauss_markov:
            note = "The model has no Gauss-Markov component: there is nothing to whiten, the filter is 1."
            return no_whitening(rate_hz=rate_hz, unity_gain_hz=unity_gain_hz, note=note)
        tau_p = self.correlation_time
        correlated_density = 2 * self.correlated_sd**2 * tau_p
        tau_o = tau_p * math.sqrt(self.white_density / (self.white_density + correlated_density))
        if 2 * rate_hz * tau_o < 1:  # no analogue pole, or none that the bilinear transform can carry
            sampled = self.arma(1 / rate_hz)
            ma = sampled.ma or (0.0,)
            tau_p, tau_o = replace(sampled, ma=ma).time_constants()
        return synthesise(tau_p=tau_p, tau_o=tau_o, rate_hz=rate_hz, unity_gain_hz=unity_gain_hz)

    def to_dict(self) -> dict[str, Any]:
        """Return the documented JSON object, format ``baroarma.noise-model`` version 1."""
        keys = dict(zip(JSON_KEYS, PARAMETERS, strict=True))
        return {
            "format": FORMAT,
            "version": VERSION,
            **{key: getattr(self, name) for key, name in keys.items()},
            "rate_hz": self.rate_hz,
            "ci95": None if self.ci95 is None else {k: list(self.ci95[name]) for k, name in keys.items()},
            "method": self.method,
            "sensor": self.sensor,
            "whiteness_p": self.whiteness_p,
            "verdict": [finding.to_dict() for finding in self.verdict],
            "source": self.source,
        }

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> NoiseModel:
        """Build a model from the documented JSON object.

        Parameters
        ----------
        data : dict
            What `to_dict` gives, or ``json.load`` of a noise file.

        Raises
        ------
        ValueError
            If the format, the version or a key is not as documented; the message names it.

        Examples
        --------
        >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
        >>> NoiseModel.from_dict(json.loads(json.dumps(noise.to_dict()))) == noise
        True
        >>> NoiseModel.from_dict({**noise.to_dict(), "version": 2})
        Traceback (most recent call last):
            ...
        ValueError: version 2 was written by a newer baroarma; ...
        """
        return cls(**model_fields(data, dict(zip(JSON_KEYS, PARAMETERS, strict=True))))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model as JSON, complete or not at all; floats read back exactly.

        Parameters
        ----------
        path : str or path
            Where to; a file that is there is replaced.

        Examples
        --------
        >>> import tempfile
        >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=1 / 3, rate_hz=50)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     noise.save(os.path.join(folder, "noise.json"))
        ...     NoiseModel.load(os.path.join(folder, "noise.json")) == noise
        True
        """
        text = json.dumps(self.to_dict(), indent=2, allow_nan=False) + "\n"
        with replacing(path) as temporary:
            temporary.write_text(text, encoding="utf-8")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> NoiseModel:
        """Read a model that `save` wrote.

        Parameters
        ----------
        path : str or path
            The file.

        Raises
        ------
        ValueError
            If the file holds no noise model; the message names the file.
        """
        data = read_object(path)
        try:
            return cls.from_dict(data)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error

    def summary(self) -> str:
        """Return a small table of the terms with their 95 % intervals."""
        units = ("m", "s", "m", "m/sqrt(s)")
        lines = [
            f"Noise of {self.sensor or 'a barometric altimeter'} at {self.rate_hz:.4g} Hz ({self.method})"
        ]
        for name, unit in zip(PARAMETERS, units, strict=True):
            value = getattr(self, name)
            interval = "" if self.ci95 is None else "  [{:.4g}, {:.4g}]".format(*self.ci95[name])
            lines.append(f"  {name.replace('_', ' '):17}{value:10.4g} {unit:10}{interval}")
        lines += [f"  {finding}" for finding in self.verdict]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from baroarma.notebook import about, styled, tables
        from baroarma.report import model_table

        findings = about(self.verdict)
        return styled(model_table(self)) + (tables(*findings) if findings else "")

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw spectrum and, without `ax`, Allan deviation; see `baroarma.plotting.plot_noise_model`."""
        from baroarma.plotting import plot_noise_model

        return plot_noise_model(self, ax)


def _gauss_markov(w: NDArray[np.float64], steps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit-variance Gauss-Markov noise from unit white noise, `steps` being dt/tau."""
    from baroarma.kernels import gauss_markov

    return np.asarray(gauss_markov(w, steps))
