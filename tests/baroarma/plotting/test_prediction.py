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
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time (s)", "sd of the error (m, m/s)")
    given = plt.figure().subplots()
    assert found.plot(given) is given
    plt.close("all")


def test_tuning_is_drawn_before_and_after():
    import matplotlib.pyplot as plt

    noise = ba.NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)
    found = ba.tune("sg14-a", noise, duration=20)
    ax = found.plot()
    lines = {line.get_label(): line for line in ax.get_lines()}
    assert lines["velocity (m/s), tuned"].get_ydata().max() == found.after.velocity_sd.max()
    assert lines["velocity (m/s), before"].get_ydata().max() == found.before.velocity_sd.max()
    for quantity in ("height (m)", "velocity (m/s)"):
        tuned, before = lines[f"{quantity}, tuned"], lines[f"{quantity}, before"]
        assert tuned.get_color() == before.get_color()
        assert tuned.get_linestyle() != before.get_linestyle()
    plt.close("all")
