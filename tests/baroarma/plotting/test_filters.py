"""Plots of filters: what they keep of each frequency, and of a height."""

import matplotlib as mpl
import numpy as np
import pytest

import baroarma as ba
from baroarma import plotting

mpl.use("Agg")
import matplotlib.pyplot as plt

NOISE = ba.NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


def test_the_step_response_is_the_filters_own_and_ends_at_the_gain_at_dc():
    whitening = NOISE.whitening_filter(unity_gain_hz=25)
    gain, price = whitening.plot().figure.axes
    height, left, end = price.get_lines()
    assert left.get_ydata() == pytest.approx(whitening(height.get_ydata()), abs=1e-12)
    # drawn for five time constants of the pole, of which e^-5 = 0.7 % is left
    assert left.get_ydata()[-1] == pytest.approx(whitening.dc_gain, abs=0.01)
    assert end.get_ydata()[0] == whitening.dc_gain
    assert gain.get_ylabel() == "gain (dB)"
    assert price.get_ylabel() == "height (m)"


def test_a_filter_that_is_1_has_no_price():
    one = ba.NoiseModel(0, 0, 0.4, rate_hz=50).whitening_filter()
    price = plotting.plot_step_response(one)
    assert price.get_title(loc="left").startswith("No price")
    height, left, _ = price.get_lines()
    assert np.array_equal(height.get_ydata(), left.get_ydata())


def test_the_spectrum_of_an_arma_model_holds_its_variance():
    model = ba.ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
    f, density = model.plot().get_lines()[0].get_data()
    variance = np.trapezoid(density, f) + density[0] * f[0]
    # flat below the first frequency; 300 points trapeze the rest to a few parts in a thousand
    assert variance == pytest.approx(model.autocovariance(0)[0], rel=0.005)


def test_an_arma_model_without_noise_is_drawn_at_zero():
    assert np.all(ba.ArmaModel((), (), 0.0, 1.0).plot().get_lines()[0].get_ydata() == 0)
