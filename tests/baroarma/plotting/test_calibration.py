"""The plot of a calibration: each axis with the interval that its sd says."""

import matplotlib as mpl
import numpy as np
import pytest

from baroarma.estimators.calibration import Calibration

mpl.use("Agg")
import matplotlib.pyplot as plt


def test_scale_offset_and_bias_are_drawn_in_their_units_with_95_percent_intervals():
    found = Calibration(
        (1.01, 0.98, 1.0), (0.1, -0.2, 0.3), (0.001, 0.002, 0.003), (0.01, 0.02, 0.03),
        (0.01, 0.0, -0.01), (1e-4, 2e-4, 3e-4), 8, 0.02,
    )  # fmt: skip
    figure = found.plot()
    expected = (
        ("scale − 1 (%)", [1.0, -2.0, 0.0], [0.1, 0.2, 0.3]),
        ("offset (m/s²)", [0.1, -0.2, 0.3], [0.01, 0.02, 0.03]),
        ("bias (°/s)", np.rad2deg([0.01, 0, -0.01]), np.rad2deg([1e-4, 2e-4, 3e-4])),
    )
    for ax, (label, values, sds) in zip(figure.axes, expected, strict=True):
        points = ax.containers[0].lines[0].get_xdata()
        bars = ax.containers[0].lines[2][0].get_segments()
        assert ax.get_xlabel() == label
        assert points == pytest.approx(values)
        assert [bar[1, 0] - bar[0, 0] for bar in bars] == pytest.approx(2 * 1.96 * np.array(sds))
        assert [text.get_text() for text in ax.get_yticklabels()] == list("xyz")
    plt.close("all")
