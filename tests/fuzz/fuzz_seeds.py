"""Small valid inputs of every kind, made by the tools' own writers: where the mutations start."""

import gzip
import io
import json
import struct
import sys
import tempfile
import zipfile
from functools import cache
from pathlib import Path

import numpy as np

AXES = "xyz"


@cache
def signals(n=60, rate_hz=20.0):
    """A device at rest, with times in s: few rows, so that a command takes milliseconds."""
    rng = np.random.default_rng(1)
    return {
        "t": np.arange(n) / rate_hz,
        "pressure": np.round(101_325 + rng.normal(0, 3, n), 2),
        "accel": np.round(rng.normal([0, 0, 9.81], 0.02, (n, 3)), 3),
        "gyro": np.round(rng.normal(0, 0.01, (n, 3)), 4),
    }


def _text(names, columns, separator=","):
    rows = np.column_stack(columns).tolist()
    return (
        "\n".join([separator.join(names), *(separator.join(map(repr, row)) for row in rows)]).encode() + b"\n"
    )


def _walk(**style):
    s = signals()
    names = ["time_s", "pressure_pa", *(f"acc_{x}_m_s2" for x in AXES), *(f"gyr_{x}_rad_s" for x in AXES)]
    return _text(names, (s["t"], s["pressure"], s["accel"], s["gyro"]), **style)


def _rest(n=320):
    s = signals(n, 10.0)
    return _text(["time_s", "pressure_hpa", "temperature_c"], (s["t"], s["pressure"] / 100, np.full(n, 21.5)))


def _csv():
    quoted = b'"time_s";"altitude_m";"note"\n' + b"".join(
        b'%d,5;%d,25;"a; b"\n' % (k, 100 + k % 3) for k in range(20)
    )
    return [
        _walk(),
        _walk(separator="\t"),
        _rest(),
        quoted,
        b"\xef\xbb\xbftime_s,pressure_pa\r\n0,1e5\r\n1,,\r\n",
    ]


def _gz():
    return [gzip.compress(text, mtime=0) for text in _csv()[:3]]


def _parquet():
    import pandas as pd

    frames = [pd.read_csv(io.BytesIO(text)) for text in (_walk(), _rest())]
    frames.append(frames[1].astype({"temperature_c": str}))
    return [frame.to_parquet(index=False) for frame in frames]


def _ulg():
    """Bytes as the ULog format is documented: header, flags, formats, subscriptions, data."""
    s = signals()
    us = np.round(s["t"] * 1e6).astype("<u8") + 1_000_000
    baro = np.zeros(len(us), [("t", "<u8"), ("ts", "<u8"), ("id", "<u4"), ("p", "<f4"), ("c", "<f4")])
    baro["t"], baro["ts"], baro["p"], baro["c"] = us + 500, us, s["pressure"], 25
    imu = np.zeros(len(us), [("t", "<u8"), ("g", "<f4", 3), ("dt", "<u4"), ("off", "<i4"), ("a", "<f4", 3)])
    imu["t"], imu["g"], imu["off"], imu["a"] = us, s["gyro"], 300, s["accel"]
    topics = [
        (
            "sensor_baro",
            "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;"
            "float pressure;float temperature;",
            baro,
        ),
        (
            "sensor_combined",
            "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;"
            "int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;",
            imu,
        ),
    ]
    parts = [b"ULog\x01\x12\x35\x01", bytes(8), _ulog_message("B", bytes(40))]
    parts += [_ulog_message("F", f"{name}:{fields}".encode()) for name, fields, _ in topics]
    parts += [
        _ulog_message("A", struct.pack("<BH", 0, k) + name.encode()) for k, (name, _, _) in enumerate(topics)
    ]
    parts += [
        _ulog_message("D", struct.pack("<H", k) + row.tobytes())
        for k, (_, _, rows) in enumerate(topics)
        for row in rows
    ]
    return [b"".join(parts)]


def _ulog_message(kind, payload):
    return struct.pack("<HB", len(payload), ord(kind)) + payload


def _bin():
    """An ArduPilot log: the format of formats, two formats, their messages."""
    s = signals()
    us = np.round(s["t"] * 1e6).astype(np.int64).tolist()
    kinds = {
        128: ("FMT", "BBnNZ", "Type,Length,Name,Format,Columns", "<BB4s16s64s"),
        100: ("BARO", "QBffc", "TimeUS,I,Alt,Press,Temp", "<QBffh"),
        101: ("IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ", "<QB6f"),
    }
    parts = [
        _flash(
            128,
            kinds[128][3],
            number,
            3 + struct.calcsize(layout),
            name.encode(),
            form.encode(),
            columns.encode(),
        )
        for number, (name, form, columns, layout) in kinds.items()
    ]
    for k, t in enumerate(us):
        parts.append(_flash(100, kinds[100][3], t, 0, 1.0, s["pressure"][k], 2150))
        parts.append(_flash(101, kinds[101][3], t, 0, *s["gyro"][k], *s["accel"][k]))
    return [b"".join(parts)]


def _flash(number, layout, *values):
    return struct.pack("<BBB", 0xA3, 0x95, number) + struct.pack(layout, *values)


def _zip():
    s = signals()
    phyphox = {
        "Barometer.csv": _text(['"Time (s)"', '"Pressure (hPa)"'], (s["t"], s["pressure"] / 100)),
        "Accelerometer.csv": _text(
            ['"Time (s)"', *(f'"Acceleration {x} (m/s^2)"' for x in AXES)], (s["t"], s["accel"])
        ),
        "meta/device.csv": b'"property","value"\n"model","phone"\n',
    }
    logger = {
        "Barometer.csv": _text(
            ["time", "seconds_elapsed", "pressure"], (s["t"] * 1e9, s["t"], s["pressure"] / 100)
        ),
        "TotalAcceleration.csv": _text(
            ["time", "seconds_elapsed", *AXES], (s["t"] * 1e9, s["t"], s["accel"])
        ),
        "Gyroscope.csv": _text(["time", "seconds_elapsed", *AXES], (s["t"] * 1e9, s["t"], s["gyro"])),
        "Metadata.csv": b"version,platform\n3,ios\n",
    }
    return [packed(files) for files in (phyphox, logger)]


def packed(files):
    """Return a zip of {name: bytes}."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(zipfile.ZipInfo(name), text)
    return out.getvalue()


def _bags(storage):
    """One bag with pressure and IMU, by rosbags' writers: ``bag`` (ROS 1), ``mcap`` or ``db3`` (ROS 2)."""
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_typestore

    ros1, s = storage == "bag", signals()
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    serialize = store.serialize_ros1 if ros1 else store.serialize_cdr
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / ("a.bag" if ros1 else "a")
        if ros1:
            writer = rosbag1.Writer(path)
        else:
            plugin = rosbag2.StoragePlugin.MCAP if storage == "mcap" else rosbag2.StoragePlugin.SQLITE3
            writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
        with writer:
            topics = {
                name: writer.add_connection(f"/{name}", f"sensor_msgs/msg/{kind}", typestore=store)
                for name, kind in (("baro", "FluidPressure"), ("imu", "Imu"))
            }
            for k, t in enumerate(s["t"]):
                ns = round(1e9 * (1_770_000_000 + t))
                for connection, message in zip(
                    topics.values(), _messages(store.types, ns, s, k), strict=True
                ):
                    writer.write(connection, ns, serialize(message, connection.msgtype))
        return [path.read_bytes() if ros1 else next(path.glob(f"*.{storage}")).read_bytes()]


def _messages(types, ns, s, k):
    header_type = types["std_msgs/msg/Header"]
    extra = {"seq": 0} if "seq" in header_type.__dataclass_fields__ else {}
    stamp = types["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
    header, vector = header_type(stamp=stamp, frame_id="b", **extra), types["geometry_msgs/msg/Vector3"]
    yield types["sensor_msgs/msg/FluidPressure"](
        header=header, fluid_pressure=float(s["pressure"][k]), variance=0.0
    )
    yield types["sensor_msgs/msg/Imu"](
        header=header,
        orientation=types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
        orientation_covariance=np.zeros(9),
        angular_velocity=vector(*map(float, s["gyro"][k])),
        angular_velocity_covariance=np.zeros(9),
        linear_acceleration=vector(*map(float, s["accel"][k])),
        linear_acceleration_covariance=np.zeros(9),
    )


def _noise():
    from baroarma.finding import Finding
    from baroarma.noise_model import PARAMETERS, NoiseModel

    white = NoiseModel(0, 0, 0.3, rate_hz=20)
    full = NoiseModel(
        0.2,
        0.7,
        0.4,
        0.01,
        rate_hz=20,
        ci95=dict.fromkeys(PARAMETERS, (0.0, 1.0)),
        method="structural",
        sensor="BMP280",
        verdict=(Finding("gaps", "warning", "3 gaps."),),
        whiteness_p={"ljung_box_10": 0.5},
        source={"name": "a.csv", "sha256": None, "duration_s": 600.0},
    )
    return [json.dumps(model.to_dict()).encode() for model in (white, full)]


def _track():
    s = signals()
    names = ("time_s", "height_m", "velocity_m_s", "height_sd_m", "velocity_sd_m_s")
    rest = np.zeros(len(s["t"]))
    return [_text(names, (s["t"], rest, rest, rest + 0.3, rest + 0.1))]


MAKERS = {
    "csv": _csv,
    "csv.gz": _gz,
    "parquet": _parquet,
    "ulg": _ulg,
    "bin": _bin,
    "zip": _zip,
    "bag": lambda: _bags("bag"),
    "mcap": lambda: _bags("mcap"),
    "db3": lambda: _bags("db3"),
    "noise.json": _noise,
    "rows": lambda: [_walk(), _rest(40)],
    "track.csv": _track,
}
"""Kind of input -> function that makes its seeds; a kind is also the ending of the file's name."""


@cache
def seeds(kind):
    """Return valid inputs of a kind."""
    return tuple(MAKERS[kind]())


def available():
    """Return the kinds whose libraries are installed."""
    needs = {"parquet": "pyarrow", "ulg": "pyulog", "bin": "pymavlink"}
    needs |= dict.fromkeys(("bag", "mcap", "db3"), "rosbags")
    return tuple(kind for kind in MAKERS if kind not in needs or _there(needs[kind]))


def _there(module):
    try:
        __import__(module)
    except ImportError:
        print(f"{module} is not installed: its inputs are left out", file=sys.stderr)
        return False
    return True
