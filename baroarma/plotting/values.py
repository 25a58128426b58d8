"""Plots of the values that flow: a recording, a noise model, a whitening filter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from baroarma.plotting.canvas import (
    DATA,
    DRIFT,
    GAUSS_MARKOV,
    MARK,
    MODEL,
    WHITE,
    axes_or_new,
    envelope,
    finish,
    logarithmic,
    printable,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from baroarma.noise_model import NoiseModel
    from baroarma.recording import Recording
    from baroarma.whitening import WhiteningFilter


def plot_recording(recording: Recording, ax: Axes | None = None) -> Axes:
    """Draw the height over time, zeroed over its first second, and the reference if there is one.

    Parameters
    ----------
    recording : Recording
        Long ones are drawn by their envelope.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> from baroarma.simulation import simulate_rest
    >>> plot_recording(simulate_rest(10, seed=1)).get_ylabel()
    'height (m)'
    """
    ax = axes_or_new(ax)
    thin: dict[str, Any] = {"color": DATA, "linewidth": 0.8}
    drawn = [("barometer", recording.height(), thin)]
    if recording.reference is not None:
        drawn.append(("reference", recording.reference, {"color": MODEL, "linewidth": 1.5}))
    for label, height, style in drawn:
        there = np.isfinite(height)
        t, height = recording.t[there], height[there]
        if len(t):
            ax.plot(*envelope(t, height - height[t < t[0] + 1].mean()), label=label, **style)
    title = f"{printable(recording.name)}: height above the first second".removeprefix(": ")
    return finish(ax, title, "time (s)", "height (m)", columns=2 if len(drawn) > 1 else 0)


def plot_noise_model(model: NoiseModel, ax: Axes | None = None) -> Axes:
    """Draw the one-sided power spectral density of the raw samples and of each term.

    Parameters
    ----------
    model : NoiseModel
        The frequencies reach from far below its corner to Nyquist.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> from baroarma import NoiseModel
    >>> ax = plot_noise_model(NoiseModel(0.27, 0.75, 0.46, rate_hz=50))
    >>> [line.get_label() for line in ax.get_lines()]
    ['model', 'white', 'Gauss-Markov']
    """
    ax = axes_or_new(ax)
    corner = 1 / (2 * np.pi * model.correlation_time) if model.has_gauss_markov else model.rate_hz / 2
    frequency = np.geomspace(min(1e-2 * corner, 1e-3 * model.rate_hz), model.rate_hz / 2, 300)
    draw_density(model, frequency, ax)
    return finish(
        ax,
        "Noise of the raw samples: which term rules where",
        "frequency (Hz)",
        "power spectral density (m²/Hz)",
        columns=4,
    )


def plot_whitening(whitening: WhiteningFilter, ax: Axes | None = None) -> Axes:
    """Draw the gain over frequency with zero, pole, the frequency of unity gain and the gain at DC.

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
    >>> from baroarma import ArmaModel
    >>> arma = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
    >>> ax = plot_whitening(arma.whitening_filter(rate_hz=50, unity_gain_hz=25))
    >>> ax.get_legend_handles_labels()[1][:2]
    ['DC: steady height × 0.238', 'zero 0.24 Hz']
    """
    ax = axes_or_new(ax)
    nyquist = whitening.rate_hz / 2
    corners = [f for f in (whitening.zero_hz, whitening.pole_hz) if f] or [nyquist]
    frequency = np.geomspace(min(0.03 * min(corners), 1e-2 * nyquist), nyquist, 300)
    ax.plot(frequency, _decibel(whitening.response(frequency)), color=MODEL, linewidth=2)
    dc = whitening.dc_gain
    ax.axhline(_decibel(dc), color=DRIFT, linestyle="--", label=f"DC: steady height × {dc:.3g}")
    for name, at, dashes in (("zero", whitening.zero_hz, ":"), ("pole", whitening.pole_hz, "-.")):
        if at is not None:
            ax.axvline(at, color=GAUSS_MARKOV, linestyle=dashes, label=f"{name} {at:.3g} Hz")
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


def terms(model: NoiseModel) -> Iterator[tuple[str, NoiseModel, dict[str, Any]]]:
    """Yield each term that the model has: its label, a model of it alone, how to draw it."""
    off: dict[str, Any] = {"white_sd": 0.0, "correlated_sd": 0.0, "correlation_time": 0.0, "drift_rate": 0.0}
    gauss_markov = {"correlated_sd": model.correlated_sd, "correlation_time": model.correlation_time}
    if model.white_sd:
        one = replace(model, **{**off, "white_sd": model.white_sd})
        yield "white", one, {"color": WHITE, "linestyle": "--"}
    if model.has_gauss_markov:
        one = replace(model, **{**off, **gauss_markov})
        yield "Gauss-Markov", one, {"color": GAUSS_MARKOV, "linestyle": "-."}
    if model.drift_rate:
        one = replace(model, **{**off, "drift_rate": model.drift_rate})
        yield "drift", one, {"color": DRIFT, "linestyle": ":"}


def draw_density(model: NoiseModel, frequency: Any, ax: Axes) -> None:
    """Draw the model's spectral density and that of its terms at given frequencies, on logarithmic axes."""
    total = model.psd(frequency)
    ax.plot(frequency, total, color=MODEL, linewidth=2, label="model", zorder=2.5)
    for label, one, style in terms(model):
        ax.plot(frequency, one.psd(frequency), linewidth=1.3, label=label, **style)
    if total.min() > 0:
        ax.set_ylim(bottom=0.2 * total.min())
    logarithmic(ax)


def _decibel(gain: Any) -> Any:
    return 20 * np.log10(np.abs(gain))
