"""Units that can't be: what a recording's values say about the labels of its columns."""

from __future__ import annotations

from typing import Final

import numpy as np

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.finding import Finding
from baroarma.recording import Recording

PLAUSIBLE_PRESSURE: Final = (1.2e3, 200e3)
"""Median pressure in Pa that a barometer may report: 30 km high to twice the sea level's."""
LATEST_TIME: Final = 1e11
"""No time in seconds: the year 5138 when counted from 1970."""
SLOWEST_LOG: Final = 4.0
"""Median interval in s that makes one ask whether the times are in s: that of 250 Hz in ms."""
FASTEST_GYRO: Final = 150.0
"""rad/s; twice the 4000 deg/s of the widest consumer gyros."""


def unit_findings(recording: Recording) -> tuple[Finding, ...]:
    """Name the units that can't be.

    A wrong unit of the pressure or of the time is an error (no noise model can come of it); one of the IMU a
    warning, because the barometer may still be all that is asked for.

    Examples
    --------
    >>> for finding in unit_findings(Recording(t=[0.0, 1.0], pressure=[1013.2, 1013.3])):
    ...     print(finding)
    error (units): The median pressure is 1013.25 Pa, no air pressure; the values look like hPa: name the \
column pressure_hpa.
    """
    return (*_pressure(recording), *_time(recording), *imu_unit_findings(recording))


def imu_unit_findings(recording: Recording) -> tuple[Finding, ...]:
    """Name the units of accelerometer and gyro that can't be."""
    return (*_accel(recording), *_gyro(recording))


def _pressure(recording: Recording) -> list[Finding]:
    median = float(np.nanmedian(recording.pressure))
    if PLAUSIBLE_PRESSURE[0] <= median <= PLAUSIBLE_PRESSURE[1]:
        return []
    advice = "check what the column holds and convert it to Pa"
    for low, high, unit, cure in (
        (300, 1200, "hPa", "name the column pressure_hpa"),
        (30, 120, "kPa", "multiply them by 1000"),
        (30e5, 120e5, "Pa under the label hPa", "name the column pressure_pa"),
    ):
        if low <= median <= high:
            advice = f"the values look like {unit}: {cure}"
    text = f"The median pressure is {median:.6g} Pa, no air pressure; {advice}."
    return [Finding("units", "error", text)]


def _time(recording: Recording) -> list[Finding]:
    last = float(np.abs(recording.t).max())
    if last < LATEST_TIME:
        return _interval(recording)
    return [
        Finding(
            "units", "error", f"A time of {last:.6g} s can't be; the values look like ms, us or ns: convert."
        )
    ]


def _interval(recording: Recording) -> list[Finding]:
    interval = float(np.median(np.diff(recording.t))) if len(recording) > 1 else 0.0
    if interval < SLOWEST_LOG:
        return []
    text = (
        f"The rows are {interval:.4g} s apart, slow for a barometer; if the times are in ms, us or ns, "
        "convert them to s: every rate and time constant depends on it."
    )
    return [Finding("units", "warning", text)]


def _accel(recording: Recording) -> list[Finding]:
    if recording.accel is None or not np.isfinite(recording.accel).any():
        return []
    median = float(np.nanmedian(np.linalg.norm(recording.accel, axis=1)))
    for low, high, unit, cure in (
        (0.9, 1.1, "g under the label m/s²", "name the columns acc_x_g, acc_y_g, acc_z_g"),
        (900.0, 1100.0, "mg under the label m/s²", "divide them by 1000 and name the columns acc_x_g …"),
        (
            0.9 * STANDARD_GRAVITY**2,
            1.1 * STANDARD_GRAVITY**2,
            "m/s² under the label g",
            "name them acc_x_m_s2 …",
        ),
    ):
        if low <= median <= high:
            text = f"The median specific force is {median:.4g} m/s², not 9.8; it looks like {unit}: {cure}."
            return [Finding("units", "warning", text)]
    return []


def _gyro(recording: Recording) -> list[Finding]:
    if recording.gyro is None or not np.isfinite(recording.gyro).any():
        return []
    fastest = float(np.nanmax(np.abs(recording.gyro)))
    if fastest < FASTEST_GYRO:
        return []
    text = (
        f"An angular rate of {fastest:.4g} rad/s is beyond every consumer gyro; the values look like deg/s: "
        "name the columns gyr_x_deg_s, gyr_y_deg_s, gyr_z_deg_s."
    )
    return [Finding("units", "warning", text)]
