"""Plots: functions of (object, axes) that draw and return the axes.  Matplotlib is met only here.

`values` draws what flows through the package, `tracks` what trackers make of it, `evidence` how well a noise
model describes its recording; the numbers behind the evidence are in `estimates`.  No plot changes the global
style or calls ``show``; given no axes, it makes a new pyplot figure.
"""

from baroarma.plotting.evidence import (
    plot_acf,
    plot_allan,
    plot_identification,
    plot_psd,
    plot_record,
    plot_residuals,
)
from baroarma.plotting.prediction import plot_prediction
from baroarma.plotting.tracks import plot_comparison, plot_errors, plot_traces, plot_track
from baroarma.plotting.values import plot_noise_model, plot_recording, plot_whitening

__all__ = [
    "plot_acf",
    "plot_allan",
    "plot_comparison",
    "plot_errors",
    "plot_identification",
    "plot_noise_model",
    "plot_prediction",
    "plot_psd",
    "plot_record",
    "plot_recording",
    "plot_residuals",
    "plot_traces",
    "plot_track",
    "plot_whitening",
]
