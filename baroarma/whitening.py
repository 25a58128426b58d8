"""The whitening filter: undo the shaping filter of coloured altimeter noise.

The shaping filter H(s) ~ (1 + s tau_o)/(1 + s tau_p) makes white noise coloured.  Its inverse

    W(s) ~ (1 + s tau_p)/(1 + s tau_o)

has its zero at 1/(2 pi tau_p) and its pole at 1/(2 pi tau_o).  `synthesise` discretises it by the bilinear
transform at the altimeter's rate and scales it to gain 1 at a chosen frequency [SG13, Secs. 2.4-2.5, 3.1].

The price is the gain at DC, tau-ratio times smaller than at high frequency: with unity gain anywhere above DC
a *steady height change is under-reported by the factor* `WhiteningFilter.dc_gain` [SG13, Table 5].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class WhiteningFilter:
    """Hold the coefficients of a first-order whitening filter and answer questions about it.

    Call it on an array to filter a signal; `stream` gives a filter for one sample at a time with identical
    numbers.  Both start in steady state: a constant input gives a constant output from the first sample on.

    Parameters
    ----------
    b, a : tuple of float
        Numerator and denominator as in SciPy's `lfilter`, a[0] = 1.
    rate_hz : float
        Sampling rate in Hz for which the coefficients hold.
    unity_gain_hz : float
        Frequency in Hz at which the gain is 1.
    note : str
        What a reader of the coefficients must know, such as why the filter does nothing.

    Examples
    --------
    >>> w = synthesise(tau_p=0.664286, tau_o=0.158333, rate_hz=50, unity_gain_hz=25)
    >>> w
    <WhiteningFilter at 50 Hz: DC gain 0.2384, zero 0.2396 Hz, pole 1.005 Hz, unity gain at 25 Hz>
    >>> [round(float(y), 3) for y in w([1.0, 1.0, 1.0])]
    [0.238, 0.238, 0.238]
    """

    b: tuple[float, ...]
    a: tuple[float, ...]
    rate_hz: float
    unity_gain_hz: float
    note: str = field(default="", compare=False)

    def __repr__(self) -> str:
        if self.zero_hz is None:
            return f"<WhiteningFilter at {self.rate_hz:g} Hz: 1 (nothing to whiten)>"
        return (
            f"<WhiteningFilter at {self.rate_hz:g} Hz: DC gain {self.dc_gain:.4g}, zero "
            f"{self.zero_hz:.4g} Hz, pole {self.pole_hz:.4g} Hz, unity gain at {self.unity_gain_hz:g} Hz>"
        )

    @property
    def dc_gain(self) -> float:
        """Gain at zero frequency: the factor by which a steady height change is reported."""
        return sum(self.b) / sum(self.a)

    @property
    def zero_hz(self) -> float | None:
        """Frequency of the analogue zero, 1/(2 pi tau_p), in Hz; None when the filter is 1.

        Examples
        --------
        >>> w = synthesise(tau_p=0.75, tau_o=0.15, rate_hz=50, unity_gain_hz=25)
        >>> round(w.zero_hz * 2 * np.pi * 0.75, 9), round(w.pole_hz * 2 * np.pi * 0.15, 9)
        (1.0, 1.0)
        """
        return _analogue_hz(self.b, self.rate_hz)

    @property
    def pole_hz(self) -> float | None:
        """Frequency of the analogue pole, 1/(2 pi tau_o), in Hz; None when the filter is 1."""
        return _analogue_hz(self.a, self.rate_hz)

    def response(self, frequency_hz: ArrayLike) -> NDArray[np.complex128]:
        """Return the complex frequency response.

        Parameters
        ----------
        frequency_hz : array_like
            Frequencies in Hz, 0 to `rate_hz` / 2.

        Returns
        -------
        ndarray
            Complex gain, same shape.

        Examples
        --------
        >>> w = synthesise(tau_p=0.664286, tau_o=0.158333, rate_hz=50, unity_gain_hz=25)
        >>> np.abs(w.response([0, 25])).round(4).tolist()  # DC gain, and 1 where that was asked for
        [0.2384, 1.0]
        """
        z = np.exp(-2j * np.pi * np.asarray(frequency_hz, float) / self.rate_hz)
        return np.polyval(self.b[::-1], z) / np.polyval(self.a[::-1], z)

    def __call__(self, x: ArrayLike) -> NDArray[np.float64]:
        """Filter a signal, starting in the steady state of its first sample.

        Parameters
        ----------
        x : array_like, shape (n,)
            Signal at `rate_hz`; NaN (no sample) gives NaN and leaves the filter as it was.

        Returns
        -------
        ndarray, shape (n,)
            The filtered signal.
        """
        from scipy.signal import lfilter

        x = np.asarray(x, float)
        if x.ndim != 1:
            raise ValueError(f"the signal has shape {x.shape}; a one-dimensional one is needed")
        out = np.full(x.shape, np.nan)
        new = np.isfinite(x)
        if len(self.b) == 1:
            return self.b[0] * x
        if new.any():
            stream = self.stream()
            stream.start(float(x[new][0]))
            out[new] = lfilter(self.b, self.a, x[new], zi=stream.delay)[0]
        return out

    def stream(self) -> WhiteningStream:
        """Return a new filter that takes one sample at a time."""
        return WhiteningStream(self.b, self.a)

    def to_dict(self) -> dict[str, object]:
        """Return the documented JSON object of `baroarma whiten`."""
        return {
            "b": list(self.b),
            "a": list(self.a),
            "rate_hz": self.rate_hz,
            "unity_gain_hz": self.unity_gain_hz,
            "dc_gain": self.dc_gain,
            "zero_hz": self.zero_hz,
            "pole_hz": self.pole_hz,
        }

    def summary(self) -> str:
        """Return coefficients and price as text."""
        return "\n".join([repr(self), *(f"  {name:16}{value}" for name, value in self._rows())])

    def _repr_html_(self) -> str:
        from baroarma.notebook import tables
        from baroarma.page import Table

        caption = f"Whitening filter at {self.rate_hz:g} Hz"
        return tables(Table(("what", "value"), tuple(self._rows()), caption))

    def _rows(self) -> list[tuple[str, str]]:
        rows = [(name, ", ".join(f"{c:.6g}" for c in getattr(self, name))) for name in ("b", "a")]
        price = f"{self.dc_gain:.4g}: of a climb by 10 m, {10 * self.dc_gain:.3g} m are left"
        rows += [("gain 1 at", f"{self.unity_gain_hz:g} Hz"), ("gain at DC", price)]
        corners = (("zero", self.zero_hz), ("pole", self.pole_hz))
        rows += [(name, f"{at:.4g} Hz") for name, at in corners if at is not None]
        return [*rows, *((("note", self.note),) if self.note else ())]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the gain and, without `ax`, the step response; see `baroarma.plotting.plot_whitening`."""
        from baroarma.plotting import plot_whitening

        return plot_whitening(self, ax)


class WhiteningStream:
    """Filter one sample at a time (direct form II transposed, as `lfilter` does).

    Examples
    --------
    >>> w = synthesise(tau_p=0.75, tau_o=0.145, rate_hz=50, unity_gain_hz=25)
    >>> stream = w.stream()
    >>> [round(stream.step(x), 6) for x in (1.0, 2.0)] == [round(float(y), 6) for y in w([1.0, 2.0])]
    True
    """

    def __init__(self, b: tuple[float, ...], a: tuple[float, ...]) -> None:
        order = max(len(a), len(b)) - 1
        self.b = (*b, *(0.0,) * (order + 1 - len(b)))
        self.a = (*a, *(0.0,) * (order + 1 - len(a)))
        self.delay: list[float] | None = None

    def start(self, x: float) -> None:
        """Put the filter into the steady state of the constant input `x`.

        Parameters
        ----------
        x : float
            In the signal's unit.  Without this the first sample is taken for it.

        Examples
        --------
        >>> w = synthesise(tau_p=0.75, tau_o=0.145, rate_hz=50, unity_gain_hz=25)
        >>> stream = w.stream()
        >>> stream.start(100.0)
        >>> round(stream.step(100.0), 9) == round(100 * w.dc_gain, 9)
        True
        """
        y = x * sum(self.b) / sum(self.a)
        delay, tail = [], 0.0
        for b, a in zip(self.b[:0:-1], self.a[:0:-1], strict=True):
            tail += b * x - a * y
            delay.append(tail)
        self.delay = delay[::-1]

    def step(self, x: float) -> float:
        """Return the filtered value of one sample; NaN (no sample) gives NaN and changes nothing.

        Parameters
        ----------
        x : float
            In the signal's unit.
        """
        if math.isnan(x):
            return x
        if self.delay is None:
            self.start(x)
        assert self.delay is not None
        y = self.b[0] * x + (self.delay[0] if self.delay else 0.0)
        shifted = [*self.delay, 0.0][1:]
        self.delay = [s + b * x - a * y for s, b, a in zip(shifted, self.b[1:], self.a[1:], strict=True)]
        return y


def synthesise(
    *, tau_p: float, tau_o: float, rate_hz: float, unity_gain_hz: float, note: str = ""
) -> WhiteningFilter:
    """Synthesise the whitening filter of a first-order shaping filter [SG13, Secs. 2.4-2.5].

    Parameters
    ----------
    tau_p, tau_o : float
        Time constants of the shaping filter's pole and zero in s, tau_p > tau_o >= 0.
    rate_hz : float
        Rate in Hz at which the filter is to run: the altimeter's own.
    unity_gain_hz : float
        Frequency in Hz with gain 1, from 0 to `rate_hz` / 2.  Lower: less distortion of slow motion, more
        amplified white noise.
    note : str
        Passed on to the filter.

    Raises
    ------
    ValueError
        If the rate is not positive or the frequency lies outside 0 ... Nyquist.

    Examples
    --------
    SG13's filter, from the time constants that follow from a = -0.86, b = -0.52 at 0.1 s:

    >>> w = synthesise(tau_p=0.664286, tau_o=0.158333, rate_hz=50, unity_gain_hz=25)
    >>> [round(c, 3) for c in (*w.b, *w.a)]
    [0.955, -0.926, 1.0, -0.881]
    """
    if not (math.isfinite(rate_hz) and rate_hz > 0):
        raise ValueError(f"the rate must be a positive number of Hz, but it is {rate_hz:g}")
    if not 0 <= unity_gain_hz <= rate_hz / 2:
        raise ValueError(
            f"unity gain at {unity_gain_hz:g} Hz is impossible at a rate of {rate_hz:g} Hz; "
            f"choose a frequency from 0 to {rate_hz / 2:g} Hz"
        )
    zero, pole = 2 * rate_hz * tau_p, 2 * rate_hz * tau_o
    b = np.array([1 + zero, 1 - zero]) / (1 + pole)
    a = np.array([1.0, (1 - pole) / (1 + pole)])
    z = np.exp(-2j * np.pi * unity_gain_hz / rate_hz)
    b /= abs((b[0] + b[1] * z) / (a[0] + a[1] * z))
    return WhiteningFilter(
        (float(b[0]), float(b[1])), (1.0, float(a[1])), float(rate_hz), float(unity_gain_hz), note
    )


def no_whitening(*, rate_hz: float, unity_gain_hz: float, note: str) -> WhiteningFilter:
    """Return the filter that is 1: for noise without a correlated component, saying so in `note`.

    Parameters
    ----------
    rate_hz, unity_gain_hz : float
        As in `synthesise`; they are kept and checked, and change nothing.
    note : str
        Why there is nothing to whiten.

    Returns
    -------
    WhiteningFilter
        With b = a = (1,).

    Raises
    ------
    ValueError
        As `synthesise`.

    Examples
    --------
    >>> w = no_whitening(rate_hz=50, unity_gain_hz=25, note="white noise is white already")
    >>> w
    <WhiteningFilter at 50 Hz: 1 (nothing to whiten)>
    >>> w([0.5, -0.2]).tolist(), w.dc_gain, w.pole_hz
    ([0.5, -0.2], 1.0, None)
    """
    synthesise(tau_p=1.0, tau_o=1.0, rate_hz=rate_hz, unity_gain_hz=unity_gain_hz)  # same checks
    return WhiteningFilter((1.0,), (1.0,), float(rate_hz), float(unity_gain_hz), note)


def _analogue_hz(polynomial: tuple[float, ...], rate_hz: float) -> float | None:
    """Frequency of the analogue root that the bilinear transform sends to the polynomial's root."""
    if len(polynomial) < 2:
        return None
    root = -polynomial[1] / polynomial[0]
    return rate_hz / math.pi * (1 - root) / (1 + root)
