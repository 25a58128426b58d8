"""Plots: functions of (object, axes) that draw and return the axes.  Matplotlib is met only here.

`values` and `filters` draw what flows through the package, `tracks` what trackers make of it, `evidence` how
well a noise model describes its recording (the numbers behind that are in `estimates`), and `prediction`,
`windows`, `calibration` and `experiments` the results of their names.  A plot of several axes takes a figure
and returns it.  No plot changes the global style or calls ``show``; given no axes, it makes a new pyplot
figure, and some then draw what belongs beside or below.  In a notebook end the cell with ``;``, lest it show
the value, too.
"""

from baroarma.plotting.calibration import plot_calibration
from baroarma.plotting.climb import plot_climb
from baroarma.plotting.evidence import (
    plot_acf,
    plot_allan,
    plot_identification,
    plot_psd,
    plot_record,
    plot_residuals,
)
from baroarma.plotting.experiments import plot_result
from baroarma.plotting.filters import plot_arma, plot_step_response, plot_whitening
from baroarma.plotting.prediction import plot_prediction, plot_tuning
from baroarma.plotting.tracks import plot_comparison, plot_errors, plot_traces, plot_track
from baroarma.plotting.values import plot_model_allan, plot_noise_model, plot_recording
from baroarma.plotting.warm_up import plot_warm_up
from baroarma.plotting.windows import plot_averaging, plot_windows

__all__ = [
    "plot_acf",
    "plot_allan",
    "plot_arma",
    "plot_averaging",
    "plot_calibration",
    "plot_climb",
    "plot_comparison",
    "plot_errors",
    "plot_identification",
    "plot_model_allan",
    "plot_noise_model",
    "plot_prediction",
    "plot_psd",
    "plot_record",
    "plot_recording",
    "plot_residuals",
    "plot_result",
    "plot_step_response",
    "plot_traces",
    "plot_track",
    "plot_tuning",
    "plot_warm_up",
    "plot_whitening",
    "plot_windows",
]
