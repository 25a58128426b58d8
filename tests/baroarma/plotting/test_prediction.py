"""The plot of a prediction."""

import matplotlib as mpl
import numpy as np

import baroarma as ba

mpl.use("Agg")


def test_both_sds_are_drawn_from_the_end_of_the_alignment_with_the_steady_ones_dashed():
    import matplotlib.pyplot as plt

    noise = ba.NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)
    found = ba.predict_accuracy(noise, "simple", "sg14-a", 20.0)
    ax = found.plot()
    height, velocity, steady = ax.get_lines()
    assert height.get_xdata()[0] >= 1.0
    assert np.max(height.get_ydata()) == found.height_sd.max()
    assert np.max(velocity.get_ydata()) == found.velocity_sd.max()
    assert steady.get_linestyle() == "--"
    assert steady.get_ydata()[0] == found.steady_velocity_sd
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time (s)", "sd of the error")
    given = plt.figure().subplots()
    assert found.plot(given) is given
    plt.close("all")
