"""Plots of the windows method: each window once, its means and SDs, and what averages do."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest

import baroarma as ba
from baroarma.identification.averaging import averaging_study
from baroarma.identification.windows import identify_windows
from baroarma.plotting import plot_windows

mpl.use("Agg")
import matplotlib.pyplot as plt

NOISE = ba.NoiseModel(0.27, 0.75, 0.46, rate_hz=50)
T = np.arange(15_000) / 50
HEIGHT = NOISE.simulate(T, 1)


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def found():
    return identify_windows(T, HEIGHT)


def test_every_window_is_a_point_about_the_trimmed_mean(found):
    white, correlated, time = found.plot().axes
    for ax, name in ((white, "white_sd"), (correlated, "correlated_sd"), (time, "correlation_time")):
        points, mean = ax.get_lines()[:2]
        inside = found.fits.inside
        assert np.array_equal(points.get_xdata(), found.start[inside])
        assert np.array_equal(points.get_ydata(), getattr(found.fits, name)[inside])
        assert mean.get_ydata()[0] == found.table[name].mean
    assert [ax.get_ylabel() for ax in (white, correlated, time)] == ["sd (m)", "sd (m)", "time (s)"]
    assert time.get_xlabel() == "start of the window (s)"


def test_windows_without_the_component_are_crosses_and_counted(found):
    outside = np.arange(len(found)) < 2
    blank = {name: np.where(outside, np.nan, getattr(found.fits, name)) for name in
             ("correlated_sd", "correlation_time", "white_sd")}  # fmt: skip
    ax = plot_windows(replace(found, fits=replace(found.fits, **blank))).axes[0]
    crosses = ax.get_lines()[-1]
    assert np.array_equal(crosses.get_xdata(), found.start[:2])
    assert crosses.get_label() == "2 outside"


def test_a_given_figure_is_drawn_into(found):
    figure = plt.figure()
    assert plot_windows(found, figure) is figure


def test_the_study_of_averages_draws_its_rows():
    study = averaging_study(T, HEIGHT, (1, 2, 4))
    ax = study.plot()
    total, correlated, white, theory = ax.get_lines()
    assert total.get_xdata() == pytest.approx([1, 2, 4])
    for drawn, name in ((total, "total_sd"), (correlated, "correlated_sd"), (white, "white_sd")):
        assert list(drawn.get_ydata()) == [getattr(row, name).mean for row in study.rows]
    assert theory.get_ydata()[2] == pytest.approx(white.get_ydata()[0] / 2)  # 1/√4
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("length of the average M (samples)", "sd (m)")
