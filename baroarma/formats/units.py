"""Units that can't be: what a recording's values say about the labels of its columns.

Levels are judged by medians over some of the rows, so that neither a spike nor a long log matters.  What a
level can't tell, as deg/s under the label rad/s, the sensors tell of each other (`baroarma.tilt_evidence`,
`baroarma.climb_evidence`).
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.finding import Finding
from baroarma.glance import greatest, some_values, usual_interval
from baroarma.recording import Recording

PLAUSIBLE_PRESSURE: Final = (1.2e3, 200e3)
"""Median pressure in Pa that a barometer may report: 30 km high to twice the sea level's."""
LATEST_TIME: Final = 1e11
"""No time in seconds: the year 5138 when counted from 1970."""
SLOWEST_LOG: Final = 4.0
"""Median interval in s that makes one ask whether the times are in s: that of 250 Hz in ms."""
SLOWEST_IMU: Final = 0.9
"""The same with an IMU, which nobody logs once a second: that of 1 kHz in ms."""
FASTEST_GYRO: Final = 150.0
"""rad/s; twice the 4000 deg/s of the widest consumer gyros."""
PLAUSIBLE_FORCE: Final = (5.0, 20.0)
"""Median specific force in m/s² of anything that is not thrown or spun for most of the log."""
WEIGHTLESS: Final = 0.5
"""Median in m/s² below which gravity was taken out (or g were written under the label km/s²)."""
PLAUSIBLE_TEMPERATURE: Final = (-60.0, 150.0)
"""Median in °C of a sensor that still works."""
STEADY: Final = 0.2
"""Range of an absolute pressure over its median, at most; a gauge's zero knows no such bound."""


class _Unit(NamedTuple):
    """A range of medians, what they look like, and what to do."""

    low: float
    high: float
    looks_like: str
    cure: str


_PRESSURES: Final = (
    _Unit(300, 1200, "hPa (mbar)", "name the column pressure_hpa"),
    _Unit(31.5, 120, "kPa", "multiply them by 1000"),
    _Unit(25, 31.5, "inches of mercury", "multiply them by 3386.39"),
    _Unit(10, 16, "psi", "multiply them by 6894.76"),
    _Unit(0.3, 1.2, "bar or atm", "multiply them by 100000"),
    _Unit(30e5, 120e5, "Pa under the label hPa", "name the column pressure_pa"),
)
_FORCES: Final = (
    _Unit(0.9, 1.1, "g under the label m/s²", "name the columns acc_x_g, acc_y_g, acc_z_g"),
    _Unit(900, 1100, "mg under the label m/s²", "divide them by 1000 and name the columns acc_x_g …"),
    _Unit(
        0.9 * STANDARD_GRAVITY**2,
        1.1 * STANDARD_GRAVITY**2,
        "m/s² under the label g",
        "name them acc_x_m_s2 …",
    ),
    _Unit(30, 34, "ft/s²", "multiply them by 0.3048"),
)
_ABSOLUTE: Final = "check what the column holds and convert it to Pa"


def unit_findings(recording: Recording) -> tuple[Finding, ...]:
    """Name the units that can't be.

    A wrong unit of the pressure or of the time is an error (no noise model can come of it); one of the IMU a
    warning, because the barometer may still be all that is asked for.

    Examples
    --------
    >>> for finding in unit_findings(Recording(t=[0.0, 1.0], pressure=[1013.2, 1013.3])):
    ...     print(finding)
    error (units): The median pressure is 1013.25 Pa, no air pressure; the values look like hPa (mbar): name \
the column pressure_hpa.
    """
    found = (*_pressure(recording), *_time(recording), *imu_unit_findings(recording))
    return (*found, *_temperature(recording))


def imu_unit_findings(recording: Recording) -> tuple[Finding, ...]:
    """Name the units of accelerometer and gyro that can't be."""
    return (*_accel(recording), *_gyro(recording))


def _pressure(recording: Recording) -> list[Finding]:
    pressure = some_values(recording.pressure)
    if not len(pressure):
        return []
    median = float(np.median(pressure))
    if PLAUSIBLE_PRESSURE[0] <= median <= PLAUSIBLE_PRESSURE[1]:
        return []
    steady = float(np.ptp(pressure)) < STEADY * abs(median)
    advice = _advice(median, _PRESSURES) if steady else None
    if advice is None and median < PLAUSIBLE_PRESSURE[0]:
        advice = f"the sensor may be a gauge, which measures against the outside; {_ABSOLUTE}"
    text = f"The median pressure is {median:.6g} Pa, no air pressure; {advice or _ABSOLUTE}."
    return [Finding("units", "error", text)]


def _advice(median: float, units: tuple[_Unit, ...]) -> str | None:
    for unit in units:
        if unit.low <= median <= unit.high:
            return f"the values look like {unit.looks_like}: {unit.cure}"
    return None


def _time(recording: Recording) -> list[Finding]:
    last = float(np.abs(recording.t[[0, -1]]).max())
    if last < LATEST_TIME:
        return _interval(recording)
    text = (
        f"A time of {last:.6g} s can't be; the values look like ms, us or ns: convert them, or name the "
        "column time_ms, time_us or time_ns."
    )
    return [Finding("units", "error", text)]


def _interval(recording: Recording) -> list[Finding]:
    interval = usual_interval(recording.t)
    has_imu = recording.accel is not None or recording.gyro is not None
    if interval < (SLOWEST_IMU if has_imu else SLOWEST_LOG):
        return []
    text = (
        f"The rows are {interval:.4g} s apart, slow for {'an IMU' if has_imu else 'a barometer'}; if the "
        "times are in ms, us or ns, convert them to s: every rate and time constant depends on it."
    )
    return [Finding("units", "warning", text)]


def _accel(recording: Recording) -> list[Finding]:
    force = np.empty((0, 3)) if recording.accel is None else some_values(recording.accel)
    if not len(force):
        return []
    median = float(np.median(np.linalg.norm(force, axis=1)))
    if PLAUSIBLE_FORCE[0] <= median <= PLAUSIBLE_FORCE[1]:
        return []
    text = f"The median specific force is {median:.4g} m/s², not 9.8; "
    unit = next((unit for unit in _FORCES if unit.low <= median <= unit.high), None)
    if unit is not None:
        text += f"it looks like {unit.looks_like}: {unit.cure}."
    elif median < WEIGHTLESS:
        text += "gravity seems to have been taken out; log the accelerometer itself, which shows it at rest."
    else:
        text += "check the columns' unit and scale."
    return [Finding("units", "warning", text)]


def _gyro(recording: Recording) -> list[Finding]:
    if recording.gyro is None or greatest(recording.gyro) < FASTEST_GYRO:
        return []
    rate = np.nan_to_num(np.abs(recording.gyro)).max(axis=1)
    lasting = np.minimum(rate[:-1], rate[1:])  # a lone row may be a spike
    fastest = float(lasting.max(initial=0.0))
    if fastest < FASTEST_GYRO:
        return []
    text = (
        f"An angular rate of {fastest:.4g} rad/s is beyond every consumer gyro; the values look like deg/s: "
        "name the columns gyr_x_deg_s, gyr_y_deg_s, gyr_z_deg_s."
    )
    return [Finding("units", "warning", text)]


def _temperature(recording: Recording) -> list[Finding]:
    values = np.empty(0) if recording.temperature is None else some_values(recording.temperature)
    median = float(np.median(values)) if len(values) else 20.0
    if PLAUSIBLE_TEMPERATURE[0] <= median <= PLAUSIBLE_TEMPERATURE[1]:
        return []
    hint = "; it looks like kelvin: subtract 273.15" if 220 < median < 360 else "; check the unit"
    text = f"The median temperature is {median:.4g} °C, too much for a sensor{hint}; no result depends on it."
    return [Finding("units", "info", text)]
