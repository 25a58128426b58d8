"""Plots of an identification: the record, and how well the noise model describes it.

Each function takes what `baroarma.identify` returns.  Without a model there is nothing to compare with, and
all but `plot_record` refuse.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.noise_model import PARAMETERS, NoiseModel
from baroarma.plotting.canvas import (
    BAND,
    DATA,
    DRIFT,
    MODEL,
    axes_or_new,
    envelope,
    finish,
    ink,
    new_figure,
    printable,
)
from baroarma.plotting.estimates import (
    autocovariance,
    cumulative_periodogram,
    spectrum,
    without_levels,
)
from baroarma.plotting.filters import plot_whitening
from baroarma.plotting.values import draw_allan, draw_density

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from baroarma.identification import Identification

Signal = NDArray[np.float64]

SIMULATIONS: Final = 80
"""Simulated records behind a band; their 95 % quantiles are then known to about 2 %."""
SIMULATED_SAMPLES: Final = 100_000
"""Longest record that is simulated so often; of a longer one the middle is taken."""
DRAWN_RESIDUALS: Final = 2**20
"""Most prediction errors that are drawn: enough to see a deviation of 0.1 %."""


def plot_record(found: Identification, ax: Axes | None = None) -> Axes:
    """Draw the heights about their median with ten-second means, which show drift and motion.

    Parameters
    ----------
    found : Identification
        With or without a model.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> from baroarma.identification import identify
    >>> from baroarma.simulation import simulate_rest
    >>> ax = plot_record(identify(simulate_rest(60, seed=1)))
    >>> means = ax.get_lines()[1]
    >>> means.get_label(), len(means.get_ydata())
    ('10 s means', 6)
    >>> plt.close("all")
    """
    ax = axes_or_new(ax)
    height = found.recording.height(found.temperature)
    there = np.isfinite(height)
    t, height = found.recording.t[there], height[there]
    if not len(t):
        return finish(ax, "Record: not one pressure sample", "time (s)", "height (m)")
    height = height - np.median(height)
    ax.plot(*envelope(t, height), color=DATA, linewidth=0.6, alpha=0.75, label="samples")
    ax.plot(*envelope(*_ten_second_means(t, height)), color=DRIFT, linewidth=1.8, label="10 s means")
    title = "Record: at rest, the means wander slowly"
    if found.model is None:
        title = "Record: no noise model, see the verdict"
    return finish(ax, title, "time (s)", "height about its median (m)", columns=2)


def plot_acf(found: Identification, ax: Axes | None = None) -> Axes:
    """Draw the autocovariance of the heights on the band that simulations of the model fill.

    Drift makes any sample autocovariance depend on the length of the record.  Levels of long blocks are
    therefore removed, and as this lowers the autocovariance, the model's is not computed by its formula but
    estimated in the same way from `SIMULATIONS` records simulated at the same times.

    Parameters
    ----------
    found : Identification
        With a model.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ValueError
        Without a model.

    Examples
    --------
    Noise of 0.27 m and 0.46 m has the variance 0.285 m²:

    >>> import matplotlib.pyplot as plt
    >>> from baroarma.identification import identify
    >>> from baroarma.simulation import simulate_rest
    >>> [line.get_label() for line in plot_acf(identify(simulate_rest(60, seed=1))).get_lines()]
    ['data (0.283 at lag 0)', 'model, simulated the same way', 'correlation time 0.7 s']
    >>> plt.close("all")
    """
    model = _model(found)
    lag, data, simulated = acf_of_data_and_model(found)
    low, middle, high = np.quantile(simulated, (0.025, 0.5, 0.975), axis=0)
    ax = axes_or_new(ax)
    points = f"data ({data[0]:.3g} at lag 0)"
    band = f"95 % ({low[0]:.3g}–{high[0]:.3g} at lag 0)"
    ax.plot(lag[1:], data[1:], ".-", color=DATA, linewidth=0.8, markersize=4, label=points)
    ax.plot(lag[1:], middle[1:], color=MODEL, linewidth=1.5, label="model, simulated the same way")
    ax.fill_between(lag[1:], low[1:], high[1:], color=MODEL, label=band, **BAND)
    if model.has_gauss_markov:
        tau = f"correlation time {model.correlation_time:.2g} s"
        ax.axvline(model.correlation_time, color=ink(), linewidth=0.8, linestyle=":", label=tau)
    title = "Autocovariance: the data should stay in the band"
    return finish(ax, title, "lag (s)", "autocovariance (m²)", columns=2)


def acf_of_data_and_model(found: Identification, seed: int = 0) -> tuple[Signal, Signal, Signal]:
    """Return lags (s), the data's autocovariance (m²) and the simulations', shape (`SIMULATIONS`, lags)."""
    model = _model(found)
    t, height = (_middle(v, SIMULATED_SAMPLES) for v in found.samples())
    dt = 1 / model.rate_hz
    longest = min(max(6 * model.correlation_time, 60 * dt), (t[-1] - t[0]) / 4)
    lags = max(int(longest / dt), 1)
    block_s = max(60.0, 10 * longest)
    drawn = np.unique(np.linspace(0, lags, 120).astype(int))

    def estimate(x: Signal) -> Signal:
        return np.asarray(autocovariance(t, without_levels(t, x, block_s), dt, lags)[drawn])

    rng = np.random.default_rng(seed)
    simulated = np.array([estimate(model.simulate(t, rng)) for _ in range(SIMULATIONS)])
    return drawn * dt, estimate(height), simulated


def plot_psd(found: Identification, ax: Axes | None = None) -> Axes:
    """Draw the spectrum of the raw samples with its 95 % band on the model's and that of its terms.

    The legend says whether it comes from the longest gap-free stretch or, where the times are too irregular
    for one, from all samples at their times (see `estimates.spectrum`).

    Parameters
    ----------
    found : Identification
        With a model.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> from baroarma.identification import identify
    >>> from baroarma.simulation import simulate_rest
    >>> plot_psd(identify(simulate_rest(60, seed=1))).get_xlabel()
    'frequency (Hz)'
    >>> plt.close("all")
    """
    model = _model(found)
    data = spectrum(*found.samples())
    ax = axes_or_new(ax)
    what = f"data, {data.duration:.4g} s without gaps" if data.regular else "data, all uneven samples"
    ax.fill_between(data.frequency, data.low, data.high, color=DATA, **BAND)
    ax.plot(data.frequency, data.density, ".-", color=DATA, linewidth=0.8, markersize=4, label=what)
    # the samples used have white_sd each, at whatever mean rate they came
    draw_density(replace(model, rate_hz=data.rate_hz), data.frequency, ax)
    title = "Spectrum: the model should stay in the band"
    return finish(ax, title, "frequency (Hz)", "power spectral density (m²/Hz)", columns=3)


def plot_allan(found: Identification, ax: Axes | None = None) -> Axes:
    """Draw the Allan deviation of height with its 95 % band on the model's.

    The model's own band comes from its `ci95`, the parameters drawn independently and log-normally.

    Parameters
    ----------
    found : Identification
        With a model.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ValueError
        Without a model.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> from baroarma.identification import identify
    >>> from baroarma.simulation import simulate_rest
    >>> ax = plot_allan(identify(simulate_rest(60, seed=1)))
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['model, 95 %', 'model', 'white', 'Gauss-Markov', 'data, 95 %']
    >>> plt.close("all")
    """
    model = _model(found)
    ax = axes_or_new(ax)
    title = "Allan deviation: where averaging longer stops helping"
    try:
        data = found.allan()
    except ValueError:  # too irregular a log: the model is still worth seeing
        title = "Allan deviation of the model: no gap-free data for it"
        tau = np.geomspace(1 / model.rate_hz, found.recording.duration / 8, 100)
    else:
        tau = np.geomspace(data.tau[0], data.tau[-1], 100)
        bars = np.array([data.deviation - data.low, data.high - data.deviation])
        dots: dict[str, Any] = {"fmt": "o", "color": DATA, "markersize": 4, "capsize": 2}
        ax.errorbar(data.tau, data.deviation, bars, label="data, 95 %", **dots)
    low, high = allan_band(model, tau)
    ax.fill_between(tau, low, high, color=MODEL, label="model, 95 %", **BAND)
    draw_allan(model, tau, ax)
    return finish(ax, title, "averaging time (s)", "Allan deviation of height (m)", columns=3)


def allan_band(model: NoiseModel, tau: Signal, draws: int = 300) -> tuple[Signal, Signal]:
    """Return the 95 % band of the model's Allan deviation; the line itself if it has no intervals."""
    if model.ci95 is None:
        line = model.allan_deviation(tau)
        return line, line
    rng = np.random.default_rng(0)
    values = {name: np.zeros(draws) for name in PARAMETERS}
    for name in PARAMETERS:
        value, (low, high) = getattr(model, name), model.ci95[name]
        if value > 0:
            sd = math.log(high / low) / 3.92 if low > 0 else math.log(high / value) / 1.96
            values[name] = value * np.exp(sd * rng.normal(size=draws))
    drawn = [
        NoiseModel(**{name: values[name][i] for name in PARAMETERS}, rate_hz=model.rate_hz)
        for i in range(draws)
    ]
    low, high = np.quantile([one.allan_deviation(tau) for one in drawn], (0.025, 0.975), axis=0)
    return low, high


def plot_residuals(found: Identification, ax: Axes | None = None) -> Axes:
    """Draw how far the cumulative periodogram of the prediction errors is off white noise's.

    The band is Kolmogorov's at 95 %: of white noise, one curve in twenty leaves it anywhere.  A bulge
    upwards says that the model leaves power below that frequency.  Of more than `DRAWN_RESIDUALS` prediction
    errors the middle is drawn.

    Parameters
    ----------
    found : Identification
        With a model.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ValueError
        Without a model.

    Examples
    --------
    The model's own noise leaves a curve that stays in the band:

    >>> import matplotlib.pyplot as plt
    >>> from baroarma.identification import identify
    >>> from baroarma.simulation import simulate_rest
    >>> ax = plot_residuals(identify(simulate_rest(60, seed=1)))
    >>> curve, band = ax.get_lines()[-1].get_ydata(), ax.patches[0].get_height() / 2
    >>> bool((abs(curve) < band).all())
    True
    >>> plt.close("all")
    """
    from scipy.stats import kstwo

    model = _model(found)
    assert found.residuals is not None
    frequency, off = cumulative_periodogram(_middle(found.residuals, DRAWN_RESIDUALS))
    limit = 100 * float(kstwo.ppf(0.95, len(frequency) - 1))
    ax = axes_or_new(ax)
    ax.axhspan(-limit, limit, color=MODEL, label="95 % of white noise", **BAND)
    ax.axhline(0, color=ink(), linewidth=0.8, alpha=0.6)
    ax.plot(*envelope(frequency * model.rate_hz, 100 * off), color=DATA, label="prediction errors")
    title = "Prediction errors: white if the curve stays in the band"
    y = "cumulative periodogram − diagonal (%)"
    return finish(ax, title, "frequency (Hz)", y, columns=2)


PANELS: Final[tuple[Callable[[Identification, Axes], Axes], ...]] = (
    plot_record,
    plot_acf,
    plot_psd,
    plot_allan,
    plot_residuals,
)


def plot_identification(found: Identification, figure: Figure | None = None) -> Figure:
    """Draw record, autocovariance, spectrum, Allan deviation, prediction errors and whitening filter.

    Parameters
    ----------
    found : Identification
        Without a model, the record alone is drawn, under the reason.
    figure : matplotlib.figure.Figure, optional
        Where to draw; default: a new pyplot figure.

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> from baroarma import identify
    >>> from baroarma.simulation import simulate_rest
    >>> len(plot_identification(identify(simulate_rest(60, seed=1))).axes)
    6
    """
    if figure is None:
        figure = new_figure(8, 4) if found.model is None else new_figure(15, 8)
    name = printable(found.recording.name)
    if found.model is None:
        plot_record(found, figure.subplots())
        reasons = " ".join(f.message for f in found.verdict if f.severity == "error")
        name = textwrap.fill(f"{name}: {printable(reasons, 400)}", 100)
    else:
        axes = figure.subplots(2, 3).ravel()
        for panel, ax in zip(PANELS, axes, strict=False):
            panel(found, ax)
        plot_whitening(found.model.whitening_filter(), axes[-1])
    figure.suptitle(name, parse_math=False, fontsize="large" if found.model else "medium")
    return figure


def _model(found: Identification) -> NoiseModel:
    if found.model is None:
        reasons = " ".join(f.message for f in found.verdict if f.severity == "error")
        raise ValueError(f"there is no noise model to draw, only the record (plot_record): {reasons}")
    return found.model


def _middle(x: Signal, most: int) -> Signal:
    start = max(0, (len(x) - most) // 2)
    return x[start : start + most]


def _ten_second_means(t: Signal, height: Signal) -> tuple[Signal, Signal]:
    _, block = np.unique(np.floor((t - t[0]) / 10), return_inverse=True)
    count = np.bincount(block)
    return np.bincount(block, t) / count, np.bincount(block, height) / count
