"""PX4's flight logs, `.ulg`; needs pyulog (BSD).

Topics, fields and units are those of PX4's uORB message reference [docs.px4.io, msg_docs]:

    sensor_baro       pressure, temperature (C)         Pa; mbar in old logs, told by the value
    vehicle_air_data  baro_pressure_pa, baro_temp_celcius
    sensor_combined   gyro_rad, accelerometer_m_s2 at accelerometer_timestamp_relative (us) later
    vehicle_imu       delta_angle (rad) over delta_angle_dt (us), delta_velocity (m/s) over delta_velocity_dt
    sensor_accel, sensor_gyro   x, y, z               m/s2, rad/s

Which of these a log has, and how often, depends on its logging profile: of each kind the topic with the most
samples is taken, the earlier in the list if equal.  Of several instances the first is taken.  Time is that of
`timestamp_sample`, us since boot, or of `timestamp` where there is none.  Axes are forward, right, down, and
the acceleration is the specific force: a level vehicle at rest reads -9.8 along z, which points up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.formats.errors import UnreadableError
from baroarma.formats.logs import damaged_note, optional_module, parsing, several_note, stream
from baroarma.formats.table import Table

Signal = NDArray[np.float64]
Topic = Mapping[str, NDArray[Any]]

BAROMETERS: Final = {
    "sensor_baro": ("pressure", "temperature"),
    "vehicle_air_data": ("baro_pressure_pa", "baro_temp_celcius"),
}
IMUS: Final = ("sensor_combined", "vehicle_imu", "sensor_accel")
HIGHEST_IN_MBAR: Final = 2000.0
"""No air has a pressure between 2000 Pa (27 km high) and 2000 mbar, so that a median below is in mbar."""
INVALID_OFFSET: Final = 0x7FFFFFFF
"""Offset in us of a sample that sensor_combined does not have."""


def read_ulog(path: str) -> tuple[Table, ...]:
    """Read one PX4 log.

    Parameters
    ----------
    path : str
        The file.

    Returns
    -------
    tuple of Table
        The barometer, then accelerometer and gyro if logged; not yet checked.

    Raises
    ------
    UnreadableError
        If it is no such log, or one without pressure.
    """
    topics, damaged = _topics(path)
    taken = _busiest(topics, tuple(BAROMETERS))
    if taken is None:
        raise UnreadableError(
            f"{path}: the log has no pressure (neither {' nor '.join(BAROMETERS)}); log one of them"
        )
    name, instance = taken
    others = [f"{other} {k}" for other in BAROMETERS for k in topics.get(other, ()) if (other, k) != taken]
    notes = several_note(path, "records of pressure", f"{name} {instance}", others)
    notes += damaged_note(path) if damaged else ()
    with parsing(path, "a topic of the log is not as PX4 writes it"):
        baro = _barometer(path, name, topics[name][instance])
        return (replace(baro, notes=notes), *_imu(path, topics))


def _topics(path: str) -> tuple[dict[str, dict[int, Topic]], bool]:
    """Return topic -> instance -> fields, and whether the log is damaged."""
    pyulog = optional_module("pyulog", path, "ulog")
    with open(path, "rb") as file, parsing(path, "this is not a ULog file, or it is damaged"):
        log = pyulog.ULog(file, [*BAROMETERS, *IMUS, "sensor_gyro"])
    topics: dict[str, dict[int, Topic]] = {}
    for data in log.data_list:
        if "timestamp" in data.data:
            topics.setdefault(data.name, {})[data.multi_id] = data.data
    return topics, bool(log.file_corruption)


def _busiest(topics: Mapping[str, Mapping[int, Topic]], names: Sequence[str]) -> tuple[str, int] | None:
    """Return name and instance of the topic with the most samples among the first instances."""
    first = [(name, min(topics[name])) for name in names if name in topics]
    return max(first, key=lambda key: len(topics[key[0]][key[1]]["timestamp"]), default=None)


def _barometer(path: str, name: str, topic: Topic) -> Table:
    pressure, temperature = (np.asarray(topic[field], float) for field in BAROMETERS[name])
    real = pressure[np.isfinite(pressure)]
    in_mbar = len(real) > 0 and 0 < np.median(real) < HIGHEST_IN_MBAR
    column = "pressure_hpa" if in_mbar else "pressure_pa"
    return stream(path, name, _time(topic), {column: pressure, "temperature_c": temperature})


def _imu(path: str, topics: Mapping[str, Mapping[int, Topic]]) -> tuple[Table, ...]:
    taken = _busiest(topics, IMUS)
    if taken is None:
        return ()
    name, instance = taken
    others = [f"{name} {k}" for k in topics[name] if k != instance]
    notes = several_note(path, "IMUs", f"{name} {instance}", others)
    samples = _samples(topics, name, instance)
    return tuple(
        replace(stream(path, name, t, {column: value}), notes=notes if column.startswith("acc") else ())
        for column, (t, value) in samples.items()
        if len(t)
    )


def _samples(
    topics: Mapping[str, Mapping[int, Topic]], name: str, instance: int
) -> dict[str, tuple[Signal, Signal]]:
    """Return our column names -> time stamps and samples, (n,) and (n, 3)."""
    topic = topics[name][instance]
    if name == "sensor_combined":
        accel, gyro = _combined_accel(topic), (_time(topic), _axes(topic, "gyro_rad[{}]"))
    elif name == "vehicle_imu":
        accel, gyro = _mean_rate(topic, "delta_velocity"), _mean_rate(topic, "delta_angle")
    else:
        accel, gyro = _raw(topics, "sensor_accel"), _raw(topics, "sensor_gyro")
    return {"acc_{}_m_s2": accel, "gyr_{}_rad_s": gyro}


def _raw(topics: Mapping[str, Mapping[int, Topic]], name: str) -> tuple[Signal, Signal]:
    """Return the samples of a sensor's first instance; none if it was not logged."""
    if name not in topics:
        return np.empty(0), np.empty((0, 3))
    topic = topics[name][min(topics[name])]
    return _time(topic), _axes(topic, "{}", "xyz")


def _combined_accel(topic: Topic) -> tuple[Signal, Signal]:
    offset = np.asarray(topic["accelerometer_timestamp_relative"], np.int64)
    valid = offset != INVALID_OFFSET
    t = (np.asarray(topic["timestamp"], np.int64) + offset)[valid] / 1e6
    return t, _axes(topic, "accelerometer_m_s2[{}]")[valid]


def _mean_rate(topic: Topic, name: str) -> tuple[Signal, Signal]:
    """Return what was integrated divided by the time it was integrated over."""
    dt = np.asarray(topic[f"{name}_dt"], float) / 1e6
    real = dt > 0
    return _time(topic)[real], _axes(topic, f"{name}[{{}}]")[real] / dt[real, None]


def _axes(topic: Topic, field: str, axes: Sequence[object] = (0, 1, 2)) -> Signal:
    return np.column_stack([np.asarray(topic[field.format(axis)], float) for axis in axes])


def _time(topic: Topic) -> Signal:
    """Return the time stamps in s."""
    sample = topic.get("timestamp_sample")
    stamps = topic["timestamp"] if sample is None or not np.all(sample) else sample
    return np.asarray(stamps / 1e6)
