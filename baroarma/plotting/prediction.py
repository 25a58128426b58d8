"""Plots of predictions: how the errors grow, and what tuning gains."""

from __future__ import annotations

from typing import TYPE_CHECKING

from baroarma.plotting.canvas import DATA, MODEL, axes_or_new, envelope, finish, logarithmic, printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from baroarma.predicted import Prediction
    from baroarma.tuning import Tuning


def plot_prediction(prediction: Prediction, ax: Axes | None = None) -> Axes:
    """Draw the predicted sds of height and velocity over time, with the steady ones dashed.

    Parameters
    ----------
    prediction : Prediction
        What `baroarma.predict_accuracy` returned.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Examples
    --------
    >>> from baroarma import NoiseModel, predict_accuracy
    >>> bmp085 = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)
    >>> plot_prediction(predict_accuracy(bmp085, "simple", "sg14-a", 20)).get_ylabel()
    'sd of the error (m, m/s)'
    """
    ax = axes_or_new(ax)
    _draw_sds(prediction, ax, "-", "")
    for steady, colour in ((prediction.steady_height_sd, DATA), (prediction.steady_velocity_sd, MODEL)):
        if steady is not None:
            ax.axhline(steady, color=colour, linestyle="--", linewidth=1.0, label="in the long run")
    return _finish(ax, f"{printable(prediction.preset)}: predicted accuracy", [prediction])


def plot_tuning(tuning: Tuning, ax: Axes | None = None) -> Axes:
    """Draw the predicted sds of height and velocity with tuned gains and, dotted, with the preset's own.

    Parameters
    ----------
    tuning : Tuning
        What `baroarma.tune` returned.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.

    Examples
    --------
    >>> from baroarma import NoiseModel, tune
    >>> ax = plot_tuning(tune("sg14-a", NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50), duration=20))
    >>> [line.get_label() for line in ax.get_lines()]
    ['height (m), tuned', 'velocity (m/s), tuned', 'height (m), before', 'velocity (m/s), before']
    """
    ax = axes_or_new(ax)
    _draw_sds(tuning.after, ax, "-", ", tuned")
    _draw_sds(tuning.before, ax, ":", ", before")
    return _finish(ax, f"{printable(tuning.preset)}: what tuning gains", [tuning.before, tuning.after])


def _draw_sds(prediction: Prediction, ax: Axes, dashes: str, which: str) -> None:
    begun = prediction.height_sd > 0
    for label, sd, colour in (
        ("height (m)", prediction.height_sd, DATA),
        ("velocity (m/s)", prediction.velocity_sd, MODEL),
    ):
        t, sd = envelope(prediction.t[begun], sd[begun])
        ax.plot(t, sd, color=colour, linestyle=dashes, linewidth=1.4, label=label + which)


def _finish(ax: Axes, title: str, drawn: list[Prediction]) -> Axes:
    ax.set_ylim(bottom=min(one.velocity_sd.max() for one in drawn) / 20)  # they begin at 0
    logarithmic(ax, "y")
    return finish(ax, title, "time (s)", "sd of the error (m, m/s)", columns=2)
