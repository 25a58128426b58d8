"""ROS bags: ROS 2 folders, `.db3` and `.mcap`, and ROS 1 `.bag`; needs rosbags (Apache 2).

Messages and units are those of ROS's sensor_msgs [docs.ros.org]: `FluidPressure.fluid_pressure` in Pa,
`Imu.linear_acceleration` in m/s2 and `Imu.angular_velocity` in rad/s; a covariance that begins with -1 says
that there is no such measurement.  The acceleration is the specific force [REP 145]: at rest it points up.

Time is that of the message's header, s since 1970 or since the simulation began; where a driver left it at
zero, the time at which the bag received the message.  The first topic by name is taken; for the pressure the
first that carries an air pressure, because airspeed sensors publish their difference as `FluidPressure` too.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.formats.errors import UnreadableError
from baroarma.formats.logs import optional_module, parsing, several_note, stream
from baroarma.formats.table import Table
from baroarma.formats.units import PLAUSIBLE_PRESSURE

Signal = NDArray[np.float64]

PRESSURE: Final = "sensor_msgs/msg/FluidPressure"
IMU: Final = "sensor_msgs/msg/Imu"
SECOND: Final = 1_000_000_000
"""In ns."""
NOTHING: Final = (float("nan"),) * 3


@dataclass
class _Topic:
    """Collect the messages of one topic."""

    name: str
    kind: str
    t: list[float] = field(default_factory=list)
    rows: list[tuple[float, ...]] = field(default_factory=list)

    def add(self, message: Any, received: int) -> None:
        """Append one message; `received` is the bag's time in ns."""
        stamp = message.header.stamp
        ns = stamp.sec * SECOND + stamp.nanosec or received
        self.t.append(ns / SECOND)  # of two integers: rounded once
        self.rows.append((message.fluid_pressure,) if self.kind == PRESSURE else _six(message))

    def is_air_pressure(self) -> bool:
        """Return True if the median may be that of a barometer."""
        low, high = PLAUSIBLE_PRESSURE
        return low <= float(np.median([row[0] for row in self.rows])) <= high


def read_rosbag(path: str) -> tuple[Table, ...]:
    """Read one bag; parameters, result and errors as `baroarma.formats.ulog.read_ulog`."""
    topics = _topics(path)
    barometers = [topic for topic in topics if topic.kind == PRESSURE]
    imus = [topic for topic in topics if topic.kind == IMU]
    if not barometers:
        raise UnreadableError(f"{path}: the bag has no pressure (no topic of type {PRESSURE}); record one")
    baro = next((topic for topic in barometers if topic.is_air_pressure()), barometers[0])
    notes = several_note(path, "pressure topics", baro.name, [b.name for b in barometers if b is not baro])
    notes += several_note(path, "IMU topics", *_names(imus))
    pressure = stream(path, baro.name, np.array(baro.t), {"pressure_pa": np.array(baro.rows)[:, 0]})
    return (replace(pressure, notes=notes), *(_imu(path, topic) for topic in imus[:1]))


def _topics(path: str) -> list[_Topic]:
    """Return the topics that have messages of our two types, by name."""
    highlevel = optional_module("rosbags.highlevel", path, "ros")
    typesys = optional_module("rosbags.typesys", path, "ros")
    topics: dict[str, _Topic] = {}
    with parsing(path, "this is not a ROS bag, or it is damaged"):
        types = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)  # where the bag does not define its own
        with highlevel.AnyReader([Path(path)], default_typestore=types) as bag:
            ours = [c for c in bag.connections if c.msgtype in (PRESSURE, IMU)]
            for connection, received, data in bag.messages(ours) if ours else ():
                topic = topics.setdefault(connection.topic, _Topic(connection.topic, connection.msgtype))
                topic.add(bag.deserialize(data, connection.msgtype), received)
    return [topics[name] for name in sorted(topics)]


def _six(message: Any) -> tuple[float, ...]:
    """Return acceleration and angular rate; NaN for one that the message says it lacks."""
    pairs = (
        (message.linear_acceleration, message.linear_acceleration_covariance),
        (message.angular_velocity, message.angular_velocity_covariance),
    )
    lacks = [covariance[0] == -1 for _, covariance in pairs]
    vectors = [NOTHING if no else (v.x, v.y, v.z) for (v, _), no in zip(pairs, lacks, strict=True)]
    return (*vectors[0], *vectors[1])


def _imu(path: str, topic: _Topic) -> Table:
    rows = np.array(topic.rows)
    vectors = {"acc_{}_m_s2": rows[:, :3], "gyr_{}_rad_s": rows[:, 3:]}
    real = {name: value for name, value in vectors.items() if np.isfinite(value).any()}
    return stream(path, topic.name, np.array(topic.t), real)


def _names(topics: list[_Topic]) -> tuple[str, list[str]]:
    first, *others = [topic.name for topic in topics] or [""]
    return first, others
