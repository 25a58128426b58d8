"""Plots of a recording and of a noise model with its terms."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from baroarma.plotting.canvas import (
    COLOURS,
    DATA,
    DRIFT,
    GAUSS_MARKOV,
    MODEL,
    STYLES,
    WHITE,
    axes_or_new,
    envelope,
    finish,
    logarithmic,
    new_figure,
    printable,
    truth,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from baroarma.noise_model import NoiseModel
    from baroarma.recording import Recording


def plot_recording(recording: Recording, ax: Axes | None = None) -> Axes:
    """Draw the height over time, zeroed over its first second, and the reference if there is one.

    Parameters
    ----------
    recording : Recording
        Long ones are drawn by their envelope.
    ax : matplotlib.axes.Axes, optional
        Where to draw the height; default: a new figure, in which the other sensors stand below it.

    Returns
    -------
    matplotlib.axes.Axes
        That of the height.

    Examples
    --------
    >>> from baroarma.simulation import simulate_rest
    >>> plot_recording(simulate_rest(10, seed=1)).get_ylabel()
    'height (m)'
    """
    others = [] if ax else [s for s in SENSORS if getattr(recording, s) is not None]
    if ax is None:
        rows = 1 + len(others)
        figure = new_figure(8, 1.8 + 1.8 * rows)
        ax, *below = figure.subplots(
            rows, 1, sharex=True, squeeze=False, height_ratios=[2] + [1] * len(others)
        )[:, 0]
        for name, panel in zip(others, below, strict=True):
            _draw_sensor(recording, name, panel)
        if below:
            below[-1].set_xlabel("time (s)")
    thin: dict[str, Any] = {"color": DATA, "linewidth": 0.8}
    drawn = [("barometer", recording.height(), thin)]
    if recording.reference is not None:
        in_front = {"alpha": 0.9, "linewidth": 1.5, "zorder": 2.5}  # the barometer's noise would hide it
        drawn.append(("reference", recording.reference, {**truth(), **in_front}))
    for label, height, style in drawn:
        there = np.isfinite(height)
        t, height = recording.t[there], height[there]
        if len(t):
            ax.plot(*envelope(t, height - height[t < t[0] + 1].mean()), **{"label": label, **style})
    title = f"{printable(recording.name)}: height above the first second".removeprefix(": ")
    return finish(ax, title, "" if others else "time (s)", "height (m)", columns=2 if len(drawn) > 1 else 0)


SENSORS: Final = {
    "accel": ("Accelerometer", "force (m/s²)", "xyz"),
    "gyro": ("Gyro", "rate (rad/s)", "xyz"),
    "temperature": ("Temperature of the sensor", "(°C)", ""),
}
"""What stands below the height: title, label of the axis, components."""


def _draw_sensor(recording: Recording, name: str, ax: Axes) -> None:
    title, y, axes = SENSORS[name]
    columns = getattr(recording, name).reshape(len(recording), -1)
    for i in range(columns.shape[1]):
        there = np.isfinite(columns[:, i])
        t, values = envelope(recording.t[there], columns[there, i])
        ax.plot(t, values, linewidth=0.8, color=COLOURS[i], linestyle=STYLES[i], label=axes[i : i + 1])
    finish(ax, title, "", y, columns=len(axes))


def plot_noise_model(model: NoiseModel, ax: Axes | None = None) -> Axes:
    """Draw the one-sided power spectral density of the raw samples and of each term.

    Parameters
    ----------
    model : NoiseModel
        The frequencies reach from far below its corner to Nyquist.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure, in which the Allan deviation stands beside it.

    Returns
    -------
    matplotlib.axes.Axes
        That of the density.

    Examples
    --------
    >>> from baroarma import NoiseModel
    >>> ax = plot_noise_model(NoiseModel(0.27, 0.75, 0.46, rate_hz=50))
    >>> [line.get_label() for line in ax.get_lines()]
    ['model', 'white', 'Gauss-Markov']
    """
    if ax is None:
        ax, beside = new_figure(10, 4.2).subplots(1, 2)
        plot_model_allan(model, beside)
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


def plot_model_allan(model: NoiseModel, ax: Axes | None = None) -> Axes:
    """Draw the Allan deviation of height that the model and each of its terms have.

    Parameters
    ----------
    model : NoiseModel
        Averaging times reach from a sample to well beyond the correlation time.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> from baroarma import NoiseModel
    >>> ax = plot_model_allan(NoiseModel(0.27, 0.75, 0.46, rate_hz=50))
    >>> [line.get_label() for line in ax.get_lines()]
    ['model', 'white', 'Gauss-Markov']
    >>> tau, white = ax.get_lines()[1].get_data()
    >>> round(float(white[0] * tau[0] ** 0.5 / (white[-1] * tau[-1] ** 0.5)), 9)  # it falls as tau^-1/2
    1.0
    >>> plt.close("all")
    """
    ax = axes_or_new(ax)
    tau = np.geomspace(1 / model.rate_hz, max(1e4 / model.rate_hz, 100 * model.correlation_time), 200)
    draw_allan(model, tau, ax)
    title = "Allan deviation: what is left after averaging"
    return finish(ax, title, "averaging time (s)", "Allan deviation of height (m)", columns=4)


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


def draw_allan(model: NoiseModel, tau: Any, ax: Axes) -> None:
    """Draw the model's Allan deviation and that of its terms at given averaging times, likewise."""
    total = model.allan_deviation(tau)
    ax.plot(tau, total, color=MODEL, linewidth=2, label="model", zorder=2.5)
    for label, one, style in terms(model):
        ax.plot(tau, one.allan_deviation(tau), linewidth=1.3, label=label, **style)
    if total.min() > 0:
        ax.set_ylim(bottom=0.5 * total.min())
    logarithmic(ax)
