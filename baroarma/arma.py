"""ARMA models of sampled noise, and how an ARMA(1,1) splits into Gauss-Markov and white noise.

Convention, as in SciPy's `lfilter` and MATLAB:  y_k + a y_{k-1} = e_k + b e_{k-1}.  statsmodels' AR
coefficient is -a, its MA coefficient is b.

A first-order Gauss-Markov component (sd sigma_c, time constant tau) plus white noise (sd sigma_u), sampled
every T seconds, is an ARMA(1,1).  Two ways lead back from (a, b, innovation sd H_o) to the components:

``exact``
    Match autocovariances: phi = -a, tau = -T/ln phi, sigma_c^2 = gamma_1/phi, sigma_u^2 = gamma_0 - sigma_c^2
    = (b/a) H_o^2.  Needs a < b < 0.
``bilinear``
    Read the ARMA as the bilinear transform of the shaping filter [SG13, Eqs. 7-15]: sigma_u = alpha =
    H_o (1-b)/(1-a), sqrt(alpha^2+beta^2) = H_o (1+b)/(1+a), tau = (T/2)(1-a)/(1+a).  The printed
    sigma_c = beta/sqrt(2 tau) (Eq. 7) lacks the interval; sigma_c^2 = beta^2 T/(2 tau + T) makes the two
    variances add up to the ARMA's exactly.  Needs b > a.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.whitening import WhiteningFilter, synthesise

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Split = Literal["exact", "bilinear"]


class Components(NamedTuple):
    """What an ARMA(1,1) says about Gauss-Markov plus white noise, at the ARMA's own interval.

    Parameters
    ----------
    correlated_sd : float
        Sd of the Gauss-Markov component, m.
    correlation_time : float
        Its time constant, s.
    white_sd : float
        Sd of the white component of one sample, m.

    Examples
    --------
    The exact split gives back what was put in; the bilinear one takes a little of the component for white:

    >>> arma = gauss_markov_arma(correlated_sd=0.27, correlation_time=0.75, white_sd=0.23, dt=0.1)
    >>> [round(value, 3) for value in arma.split("exact")]
    [0.27, 0.75, 0.23]
    >>> [round(value, 3) for value in arma.split("bilinear")]
    [0.261, 0.751, 0.24]
    """

    correlated_sd: float
    correlation_time: float
    white_sd: float


@dataclass(frozen=True)
class ArmaModel:
    """Hold an ARMA(p, q) model of noise sampled every `dt` seconds.

    Parameters
    ----------
    ar : tuple of float
        a_1 ... a_p of y_k + a_1 y_{k-1} + ... = e_k + b_1 e_{k-1} + ...
    ma : tuple of float
        b_1 ... b_q.
    sd : float
        Standard deviation of the innovations e, in the unit of y (m).
    dt : float
        Sampling interval, s.

    Raises
    ------
    ValueError
        If `sd` is negative, `dt` not positive, or the model not stationary.

    Examples
    --------
    SG13's own design, Sec. 3.1:

    >>> sg13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
    >>> w = sg13.whitening_filter(rate_hz=50, unity_gain_hz=25)
    >>> [round(v, 4) for v in (w.dc_gain, w.zero_hz, w.pole_hz)]
    [0.2384, 0.2396, 1.0052]
    """

    ar: tuple[float, ...]
    ma: tuple[float, ...]
    sd: float
    dt: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "ar", tuple(float(c) for c in self.ar))
        object.__setattr__(self, "ma", tuple(float(c) for c in self.ma))
        if not (math.isfinite(self.sd) and self.sd >= 0):
            raise ValueError(f"the innovation sd must be a number >= 0, but it is {self.sd}")
        if not (math.isfinite(self.dt) and self.dt > 0):
            raise ValueError(f"the sampling interval must be positive, but it is {self.dt} s")
        if not all(math.isfinite(c) for c in (*self.ar, *self.ma)):
            raise ValueError(f"the coefficients must be finite, but they are {self.ar} and {self.ma}")
        radius = _radius(self.ar)
        if radius >= 1:
            raise ValueError(
                f"the AR part {self.ar} is not stationary (root of modulus {radius:.4g}); "
                "with one coefficient, -1 < a < 1 is needed"
            )

    def __repr__(self) -> str:
        ar = ", ".join(f"{c:.4g}" for c in self.ar)
        ma = ", ".join(f"{c:.4g}" for c in self.ma)
        orders = f"{len(self.ar)}, {len(self.ma)}"
        return f"<ArmaModel({orders}): a = [{ar}], b = [{ma}], sd {self.sd:.4g}, {self.dt:g} s>"

    def autocovariance(self, lags: int) -> NDArray[np.float64]:
        """Return the autocovariance at lags 0 ... `lags` samples, in squared units of y.

        Parameters
        ----------
        lags : int
            Largest lag, samples.

        Returns
        -------
        ndarray, shape (lags + 1,)
            The variance first.

        Examples
        --------
        An AR(1) with phi = 1/2 has gamma_k = phi^k / (1 - phi²):

        >>> ArmaModel(ar=(-0.5,), ma=(), sd=1.0, dt=0.1).autocovariance(3) * 3
        array([4. , 2. , 1. , 0.5])
        """
        p, q = len(self.ar), len(self.ma)
        m = max(p, q) + 1
        a = np.zeros(m)
        a[: p + 1] = 1.0, *self.ar
        b = np.zeros(m)
        b[: q + 1] = 1.0, *self.ma
        psi = _impulse_response(a, b, m)
        # sum_j a_j gamma(k - j) = sd^2 sum_{j>=k} b_j psi_{j-k}, solved for gamma(0 ... m-1)
        matrix = np.zeros((m, m))
        for k in range(m):
            for j in range(m):
                matrix[k, abs(k - j)] += a[j]
        right = np.array([b[k:] @ psi[: m - k] for k in range(m)])
        gamma = list(self.sd**2 * np.linalg.solve(matrix, right))
        for k in range(m, lags + 1):
            gamma.append(-sum(c * gamma[k - 1 - j] for j, c in enumerate(self.ar)))
        return np.array(gamma[: lags + 1])

    def psd(self, frequency_hz: ArrayLike) -> NDArray[np.float64]:
        """Return the one-sided power spectral density in squared units of y per Hz, up to Nyquist.

        Parameters
        ----------
        frequency_hz : array_like
            Frequencies in Hz, 0 to 1/(2 `dt`).

        Examples
        --------
        Its integral is the variance:

        >>> sg13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
        >>> frequency = np.linspace(0, 5, 1001)
        >>> variance = np.trapezoid(sg13.psd(frequency), frequency)
        >>> round(float(variance / sg13.autocovariance(0)[0]), 4)
        1.0
        """
        z = np.exp(-2j * np.pi * np.asarray(frequency_hz, float) * self.dt)
        gain = np.polyval((*self.ma[::-1], 1.0), z) / np.polyval((*self.ar[::-1], 1.0), z)
        return 2 * self.dt * self.sd**2 * np.abs(gain) ** 2

    def simulate(self, n: int, rng: np.random.Generator | int | None = None) -> NDArray[np.float64]:
        """Simulate `n` samples of the stationary process; `rng` is a generator or a seed.

        Parameters
        ----------
        n : int
            How many.
        rng : numpy.random.Generator or int, optional
            Generator or seed; default: other noise each time.

        Returns
        -------
        ndarray, shape (n,)
            In the unit of `sd`; the start is as stationary as the rest.

        Examples
        --------
        >>> sg13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
        >>> y = sg13.simulate(100_000, rng=1)
        >>> round(float(np.std(y)), 2), round(float(np.sqrt(sg13.autocovariance(0)[0])), 2)
        (0.33, 0.33)
        """
        from scipy.signal import lfilter

        burn_in = 20 + _memory(self.ar)
        e = np.random.default_rng(rng).normal(scale=self.sd, size=n + burn_in)
        return np.asarray(lfilter((1.0, *self.ma), (1.0, *self.ar), e)[burn_in:])

    def split(self, how: Split = "exact") -> Components:
        """Split an ARMA(1,1) into Gauss-Markov and white noise at this interval (module docstring).

        Parameters
        ----------
        how : {"exact", "bilinear"}
            By matched autocovariances, or as SG13 does.

        Returns
        -------
        Components
            sds in the unit of y, the correlation time in s.

        Raises
        ------
        ValueError
            If the coefficients lie outside the region that such noise can have.

        Examples
        --------
        Either way the two variances add up to the ARMA's:

        >>> sg13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
        >>> variance = float(sg13.autocovariance(0)[0])
        >>> for found in (sg13.split("exact"), sg13.split("bilinear")):
        ...     round((found.correlated_sd**2 + found.white_sd**2) / variance, 9)
        1.0
        1.0
        """
        a, b, T, h = *self._first_order(), self.dt, self.sd
        if how == "bilinear":
            alpha, total = h * (1 - b) / (1 - a), h * (1 + b) / (1 + a)
            if b <= a:
                raise ValueError(
                    f"a = {a:.4g}, b = {b:.4g} is no Gauss-Markov plus white noise: b > a is needed"
                )
            tau = T / 2 * (1 - a) / (1 + a)
            return Components(math.sqrt((total**2 - alpha**2) * T / (2 * tau + T)), tau, alpha)
        if how != "exact":
            raise ValueError(f"split {how!r} is unknown; choose 'exact' or 'bilinear'")
        if not a < b < 0:
            raise ValueError(
                f"a = {a:.4g}, b = {b:.4g} is no Gauss-Markov plus white noise: a < b < 0 is needed"
            )
        gamma1 = self.autocovariance(1)[1]
        return Components(math.sqrt(gamma1 / -a), -T / math.log(-a), h * math.sqrt(b / a))

    def time_constants(self) -> tuple[float, float]:
        """Return (tau_p, tau_o) in s of the analogue shaping filter of an ARMA(1,1) [SG13, Eq. 15].

        Raises
        ------
        ValueError
            If it is no ARMA(1, 1), or its MA part can't be inverted.

        Examples
        --------
        >>> tau_p, tau_o = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1).time_constants()
        >>> round(tau_p, 3), round(tau_o, 3)  # 0.05 s times 1.86/0.14 and 1.52/0.48
        (0.664, 0.158)
        """
        a, b = self._first_order()
        return self.dt / 2 * (1 - a) / (1 + a), self.dt / 2 * (1 - b) / (1 + b)

    def whitening_filter(self, *, rate_hz: float, unity_gain_hz: float) -> WhiteningFilter:
        """Synthesise the filter that undoes this ARMA(1,1)'s shaping filter at another sampling rate.

        SG13's own recipe [Secs. 2.4-2.5].  Time constants identified at one rate whiten only roughly at
        another, because averaging and decimation change the density of white noise;
        `NoiseModel.whitening_filter` starts from the density.

        Parameters
        ----------
        rate_hz : float
            Rate in Hz at which the filter is to run.
        unity_gain_hz : float
            Frequency in Hz with gain 1, from 0 to Nyquist.
        """
        tau_p, tau_o = self.time_constants()
        return synthesise(tau_p=tau_p, tau_o=tau_o, rate_hz=rate_hz, unity_gain_hz=unity_gain_hz)

    def summary(self) -> str:
        """Return the coefficients as text, and the components they stand for where they stand for some."""
        return "\n".join([repr(self), *(f"  {name:20}{value}" for name, value in self._rows())])

    def _repr_html_(self) -> str:
        from baroarma.notebook import tables
        from baroarma.page import Table

        caption = f"ARMA({len(self.ar)}, {len(self.ma)}) of samples every {self.dt:g} s"
        return tables(Table(("parameter", "value"), tuple(self._rows()), caption))

    def _rows(self) -> list[tuple[str, str]]:
        rows = [(f"a{i}", f"{value:.6g}") for i, value in enumerate(self.ar, 1)]
        rows += [(f"b{i}", f"{value:.6g}") for i, value in enumerate(self.ma, 1)]
        rows.append(("innovation sd", f"{self.sd:.4g} m"))
        try:
            found = self.split()
        except ValueError:  # no Gauss-Markov plus white noise
            return rows
        return [
            *rows,
            ("Gauss-Markov sd", f"{found.correlated_sd:.4g} m"),
            ("correlation time", f"{found.correlation_time:.4g} s"),
            ("white sd", f"{found.white_sd:.4g} m"),
        ]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the power spectral density; see `baroarma.plotting.plot_arma`."""
        from baroarma.plotting import plot_arma

        return plot_arma(self, ax)

    def _first_order(self) -> tuple[float, float]:
        if (len(self.ar), len(self.ma)) != (1, 1):
            raise ValueError(f"an ARMA(1, 1) is needed, but this is an ARMA({len(self.ar)}, {len(self.ma)})")
        if not -1 < self.ma[0] < 1:
            raise ValueError(f"the MA part b = {self.ma[0]:.4g} cannot be inverted; -1 < b < 1 is needed")
        return self.ar[0], self.ma[0]


def gauss_markov_arma(
    *, correlated_sd: float, correlation_time: float, white_sd: float, dt: float
) -> ArmaModel:
    """Return the ARMA(1,1) of Gauss-Markov plus white noise sampled every `dt` s: `split`'s exact inverse.

    Parameters
    ----------
    correlated_sd, correlation_time, white_sd : float
        The components, m, s and m per sample at this interval.  Without a Gauss-Markov component the
        model is an ARMA(0,0).
    dt : float
        Sampling interval, s.

    Examples
    --------
    >>> raw = gauss_markov_arma(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, dt=0.02)
    >>> raw
    <ArmaModel(1, 1): a = [-0.9737], b = [-0.8711], sd 0.4863, 0.02 s>
    >>> round(raw.split().correlated_sd, 6)
    0.27
    """
    if correlated_sd == 0:
        return ArmaModel((), (), white_sd, dt)
    phi = math.exp(-dt / correlation_time)
    if white_sd == 0:
        return ArmaModel((-phi,), (), correlated_sd * math.sqrt(-math.expm1(-2 * dt / correlation_time)), dt)
    g1 = -phi * white_sd**2
    g0 = -(correlated_sd**2) * math.expm1(-2 * dt / correlation_time) + white_sd**2 * (1 + phi**2)
    # g0 = (1 + b²) sd² and g1 = b sd², with |b| < 1: sd² is the larger root; g1 may vanish, where dt >> tau
    variance = (g0 + math.sqrt((g0 - 2 * g1) * (g0 + 2 * g1))) / 2
    return ArmaModel((-phi,), (g1 / variance,), math.sqrt(variance), dt)


def _radius(ar: tuple[float, ...]) -> float:
    return float(max(np.abs(np.roots((1.0, *ar))), default=0.0))


def _memory(ar: tuple[float, ...]) -> int:
    """Samples after which the AR part has forgotten its start to double precision."""
    radius = _radius(ar)
    return min(math.ceil(-37 / math.log(radius)), 1_000_000) if radius > 0 else 0


def _impulse_response(a: NDArray[np.float64], b: NDArray[np.float64], n: int) -> NDArray[np.float64]:
    psi = np.zeros(n)
    for k in range(n):
        psi[k] = b[k] - a[1 : k + 1] @ psi[:k][::-1]
    return psi
