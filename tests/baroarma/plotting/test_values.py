"""Plots of recordings and noise models: all that there is to see, each thing once."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest

import baroarma as ba
from baroarma import plotting
from baroarma.simulation import simulate

mpl.use("Agg")
import matplotlib.pyplot as plt

NOISE = ba.NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def squats():
    return simulate("squat", duration=20, seed=1)


def test_every_sensor_has_its_axes_and_what_was_logged_in_it(squats):
    warm = replace(squats, temperature=np.linspace(20, 21, len(squats)))
    height, accel, gyro, temperature = warm.plot().figure.axes
    for ax, values in ((accel, squats.accel), (gyro, squats.gyro), (temperature, warm.temperature[:, None])):
        assert [line.get_ydata().tolist() for line in ax.get_lines()] == values.T.tolist()
    labels = [ax.get_ylabel() for ax in (height, accel, gyro, temperature)]
    assert labels == ["height (m)", "force (m/s²)", "rate (rad/s)", "(°C)"]
    assert temperature.get_xlabel() == "time (s)"


def test_given_axes_take_the_height_alone(squats):
    ax = plt.figure().subplots()
    assert squats.plot(ax) is ax
    assert ax.figure.axes == [ax]
    assert ax.get_xlabel() == "time (s)"


def test_a_missing_component_leaves_a_gap_and_no_warning(squats):
    accel = squats.accel.copy()
    accel[100:300] = np.nan
    line = replace(squats, accel=accel).plot().figure.axes[1].get_lines()[0]
    assert np.isnan(line.get_ydata()).sum() == 1


def test_spectrum_and_allan_deviation_of_a_model_stand_side_by_side():
    spectrum, allan = NOISE.plot().figure.axes
    tau, deviation = allan.get_lines()[0].get_data()
    assert deviation == pytest.approx(NOISE.allan_deviation(tau), rel=1e-12)
    names = [line.get_label() for line in allan.get_lines()]
    assert names == [line.get_label() for line in spectrum.get_lines()]
    assert allan.get_ylabel().endswith("(m)")


def test_the_squares_of_the_terms_allan_deviations_add_up():
    model, *terms = plotting.plot_model_allan(NOISE).get_lines()
    total = sum(line.get_ydata() ** 2 for line in terms)
    assert model.get_ydata() ** 2 == pytest.approx(total, rel=1e-12)


def test_a_term_has_one_colour_in_spectrum_and_allan_deviation():
    spectrum, allan = NOISE.plot().figure.axes
    for one, other in zip(spectrum.get_lines(), allan.get_lines(), strict=True):
        assert (one.get_color(), one.get_linestyle()) == (other.get_color(), other.get_linestyle())


def test_noise_that_is_not_there_is_drawn_at_zero():
    for ax in ba.NoiseModel(0, 0, 0, rate_hz=50).plot().figure.axes:
        assert np.all(ax.get_lines()[0].get_ydata() == 0)


@pytest.mark.parametrize("n", [0, 1])
def test_a_recording_of_no_or_one_row_has_its_axes(n):
    recording = ba.Recording(t=np.arange(n), pressure=np.full(n, 1e5))
    assert recording.plot().get_ylabel() == "height (m)"
