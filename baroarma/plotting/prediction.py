"""Plots of predictions: how the errors grow."""

from __future__ import annotations

from typing import TYPE_CHECKING

from baroarma.plotting.canvas import DATA, MODEL, axes_or_new, envelope, finish, printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from baroarma.predicted import Prediction


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
    'sd of the error'
    """
    ax = axes_or_new(ax)
    begun = prediction.height_sd > 0
    for label, sd, steady, colour in (
        ("height (m)", prediction.height_sd, prediction.steady_height_sd, DATA),
        ("velocity (m/s)", prediction.velocity_sd, prediction.steady_velocity_sd, MODEL),
    ):
        ax.plot(*envelope(prediction.t[begun], sd[begun]), color=colour, linewidth=1.4, label=label)
        if steady is not None:
            ax.axhline(steady, color=colour, linestyle="--", linewidth=1.0)
    ax.set_yscale("log")
    ax.set_ylim(bottom=prediction.velocity_sd.max() / 100)  # both begin at 0
    title = f"{printable(prediction.preset)}: predicted accuracy"
    return finish(ax, title, "time (s)", "sd of the error", columns=2)
