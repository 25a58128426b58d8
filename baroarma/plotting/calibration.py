"""Plot of a calibration: scale, offset and gyro bias of each axis with their intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from baroarma.plotting.canvas import DATA, finish, ink, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from baroarma.estimators.calibration import Calibration

Signal = NDArray[np.float64]


def plot_calibration(calibration: Calibration, figure: Figure | None = None) -> Figure:
    """Draw what each axis is off by, with 95 % intervals (1.96 sd).

    Parameters
    ----------
    calibration : Calibration
        What `baroarma.estimators.calibrate` found.
    figure : matplotlib.figure.Figure, optional
        Where to draw; default: a new pyplot figure.

    Returns
    -------
    matplotlib.figure.Figure
        Three axes: scale, offset, gyro bias.

    Examples
    --------
    >>> from baroarma.estimators.calibration import Calibration
    >>> three = (0.01, 0.02, -0.01)
    >>> found = Calibration((1.01, 0.99, 1.0), three, (0.001,) * 3, (0.01,) * 3, three, (1e-4,) * 3, 6, 0.01)
    >>> [ax.get_xlabel() for ax in plot_calibration(found).axes]
    ['scale − 1 (%)', 'offset (m/s²)', 'bias (°/s)']
    """
    figure = figure or new_figure(9, 2.8)
    scale, offset, gyro = figure.subplots(1, 3)
    _draw(scale, 100 * (np.array(calibration.accel_scale) - 1), 100 * np.array(calibration.accel_scale_sd))
    finish(scale, "Accelerometer: scale", "scale − 1 (%)", "axis")
    _draw(offset, np.array(calibration.accel_offset), np.array(calibration.accel_offset_sd))
    finish(offset, "Accelerometer: offset", "offset (m/s²)", "")
    _draw(gyro, np.rad2deg(calibration.gyro_bias), np.rad2deg(calibration.gyro_bias_sd))
    finish(gyro, f"Gyro: bias over {calibration.rests} rests", "bias (°/s)", "")
    return figure


def _draw(ax: Axes, value: Signal, sd: Signal) -> None:
    ax.axvline(0, color=ink(), linewidth=0.8, alpha=0.6)
    ax.errorbar(value, range(3), xerr=1.96 * sd, fmt="o", color=DATA, capsize=3)
    ax.set_yticks(range(3), "xyz")
    ax.set_ylim(2.5, -0.5)
