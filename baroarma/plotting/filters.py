"""Plots of filters: the shaping filter of an ARMA model, the whitening filter, and its price."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from baroarma.plotting.canvas import (
    MARK,
    MODEL,
    axes_or_new,
    finish,
    ink,
    logarithmic,
    new_figure,
    truth,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from baroarma.arma import ArmaModel
    from baroarma.whitening import WhiteningFilter


def plot_arma(model: ArmaModel, ax: Axes | None = None) -> Axes:
    """Draw the one-sided power spectral density of an ARMA model, from far below Nyquist up to it.

    Parameters
    ----------
    model : ArmaModel
        Any orders.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> from baroarma import ArmaModel
    >>> plot_arma(ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)).get_xlabel()
    'frequency (Hz)'
    """
    ax = axes_or_new(ax)
    frequency = np.geomspace(1e-3, 0.5, 300) / model.dt
    ax.plot(frequency, model.psd(frequency), color=MODEL, linewidth=2)
    logarithmic(ax)
    title = f"ARMA({len(model.ar)}, {len(model.ma)}) of samples every {model.dt:g} s"
    return finish(ax, title, "frequency (Hz)", "power spectral density (m²/Hz)")


def plot_whitening(whitening: WhiteningFilter, ax: Axes | None = None) -> Axes:
    """Draw the gain over frequency with zero, pole, the frequency of unity gain and the gain at DC.

    Parameters
    ----------
    whitening : WhiteningFilter
        The filter.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure, in which the price stands beside it: the response to a step.

    Returns
    -------
    matplotlib.axes.Axes
        That of the gain.

    Examples
    --------
    >>> from baroarma import ArmaModel
    >>> arma = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
    >>> ax = plot_whitening(arma.whitening_filter(rate_hz=50, unity_gain_hz=25))
    >>> ax.get_legend_handles_labels()[1][:2]
    ['DC: steady height × 0.238', 'zero 0.24 Hz']
    """
    if ax is None:
        ax, beside = new_figure(10, 4.2).subplots(1, 2)
        plot_step_response(whitening, beside)
    nyquist = whitening.rate_hz / 2
    corners = [f for f in (whitening.zero_hz, whitening.pole_hz) if f] or [nyquist]
    frequency = np.geomspace(min(0.03 * min(corners), 1e-2 * nyquist), nyquist, 300)
    ax.plot(frequency, _decibel(whitening.response(frequency)), color=MODEL, linewidth=2)
    dc = whitening.dc_gain
    ax.axhline(_decibel(dc), color=MARK, linestyle="--", label=f"DC: steady height × {dc:.3g}")
    for name, at, dashes in (("zero", whitening.zero_hz, ":"), ("pole", whitening.pole_hz, "-.")):
        if at is not None:
            ax.axvline(at, color=ink(), alpha=0.7, linestyle=dashes, label=f"{name} {at:.3g} Hz")
    unity = max(whitening.unity_gain_hz, frequency[0])
    unity_label = f"unity gain at {whitening.unity_gain_hz:.3g} Hz"
    ax.plot(unity, 0.0, "o", color=MARK, label=unity_label, clip_on=False, zorder=3)
    logarithmic(ax, "x")
    ax.margins(y=0.08)
    title = "Whitening filter: what it keeps of each frequency"
    if whitening.zero_hz is None:
        ax.set_ylim(-6, 6)
        title = "Whitening filter: 1, there is nothing to whiten"
    return finish(ax, title, "frequency (Hz)", "gain (dB)", columns=2)


def plot_step_response(whitening: WhiteningFilter, ax: Axes | None = None) -> Axes:
    """Draw what the filter makes of a height that rises by one metre at t = 0: the price of whitening.

    Parameters
    ----------
    whitening : WhiteningFilter
        The filter.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    The whitened step ends at the DC gain:

    >>> import matplotlib.pyplot as plt
    >>> from baroarma.whitening import synthesise
    >>> w = synthesise(tau_p=0.664286, tau_o=0.158333, rate_hz=50, unity_gain_hz=25)
    >>> _, whitened, left = plot_step_response(w).get_lines()
    >>> left.get_label(), round(float(whitened.get_ydata()[-1]), 2)
    ('left in the end: 0.238 m', 0.24)
    >>> plt.close("all")
    """
    ax = axes_or_new(ax)
    settles = 5 / (2 * np.pi * whitening.pole_hz) if whitening.pole_hz else 10 / whitening.rate_hz
    after = min(max(int(settles * whitening.rate_hz), 10), 100_000)
    k = np.arange(-after // 4, after)
    step = (k >= 0).astype(float)
    t = k / whitening.rate_hz
    ax.step(t, step, where="post", **{**truth(), "label": "height"})
    ax.step(t, whitening(step), where="post", color=MODEL, linewidth=1.5, label="whitened")
    ax.axhline(
        whitening.dc_gain, color=MARK, linestyle="--", label=f"left in the end: {whitening.dc_gain:.3g} m"
    )
    title = "Its price: what is left of a climb by 1 m"
    if whitening.zero_hz is None:
        title = "No price: a climb by 1 m stays one"
    return finish(ax, title, "time (s)", "height (m)", columns=3)


def _decibel(gain: Any) -> Any:
    return 20 * np.log10(np.abs(gain))
