"""PX4 logs: laid out as the ULog format is documented, written by pyulog's own writer."""

import io
import struct
import sys

import numpy as np
import pytest

from baroarma.formats import UnreadableError, read

pyulog = pytest.importorskip("pyulog", reason="the extra `ulog` is not installed")

MICROSECOND = 1e-6
BARO = "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float pressure;float temperature"
AIR = "uint64_t timestamp;uint64_t timestamp_sample;float baro_temp_celcius;float baro_pressure_pa"
COMBINED = (
    "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;"
    "int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2"
)
VEHICLE_IMU = (
    "uint64_t timestamp;uint64_t timestamp_sample;float[3] delta_angle;float[3] delta_velocity;"
    "uint16_t delta_angle_dt;uint16_t delta_velocity_dt"
)
RAW = "uint64_t timestamp;uint64_t timestamp_sample;float x;float y;float z"
TYPES = {"uint64_t": "<u8", "uint32_t": "<u4", "int32_t": "<i4", "uint16_t": "<u2", "float": "<f4"}


def message(kind, payload):
    return struct.pack("<HB", len(payload), ord(kind)) + payload


def layout(fields):
    parts = [part.split(" ") for part in fields.split(";")]
    return np.dtype(
        [(name, TYPES[kind.removesuffix("[3]")], 3 if "[" in kind else ()) for kind, name in parts]
    )


def ulog_bytes(*topics):
    """Return a log of (name, instance, fields, columns): header, flags, formats, subscriptions, data."""
    parts = [b"ULog\x01\x12\x35\x01", struct.pack("<Q", 0), message("B", bytes(40))]
    parts += [message("F", f"{name}:{fields};".encode()) for name, _, fields, _ in topics]
    parts += [
        message("A", struct.pack("<BH", instance, k) + name.encode())
        for k, (name, instance, _, _) in enumerate(topics)
    ]
    for k, (_, _, fields, columns) in enumerate(topics):
        rows = np.zeros(len(columns["timestamp"]), layout(fields))
        for name, value in columns.items():
            rows[name] = value
        parts += [message("D", struct.pack("<H", k) + row.tobytes()) for row in rows]
    return b"".join(parts)


def write(path, *topics):
    """Write by pyulog's own writer what it read from the documented layout."""
    pyulog.ULog(io.BytesIO(ulog_bytes(*topics))).write_ulog(str(path))
    return path


def us(t):
    return np.round(np.asarray(t) / MICROSECOND).astype(np.int64)


def baro_topic(t, pressure, name="sensor_baro", instance=0, **more):
    if name == "sensor_baro":
        columns = {"pressure": pressure, "temperature": 25.0}
    else:
        columns = {"baro_pressure_pa": pressure, "baro_temp_celcius": 25.0}
    fields = BARO if name == "sensor_baro" else AIR
    stamps = {"timestamp": us(t) + 500, "timestamp_sample": us(t)}
    return name, instance, fields, stamps | columns | more


def imu_topics(kind, streams):
    t = us(streams.imu_t)
    if kind == "sensor_combined":
        columns = {"timestamp": t - 300, "gyro_rad": streams.gyro, "accelerometer_timestamp_relative": 300}
        return [(kind, 0, COMBINED, columns | {"accelerometer_m_s2": streams.accel})]
    stamps = {"timestamp": t + 900, "timestamp_sample": t}
    if kind == "vehicle_imu":
        integrals = {"delta_angle": streams.gyro * 0.02, "delta_velocity": streams.accel * 0.02}
        steps = {"delta_angle_dt": 20_000, "delta_velocity_dt": 20_000}
        return [(kind, 0, VEHICLE_IMU, stamps | integrals | steps)]
    return [
        (name, 0, RAW, stamps | dict(zip("xyz", value.T, strict=True)))
        for name, value in (("sensor_accel", streams.accel), ("sensor_gyro", streams.gyro))
    ]


@pytest.mark.parametrize(
    ("baro", "imu"), [("sensor_baro", "sensor_accel"), ("vehicle_air_data", "vehicle_imu")]
)
def test_a_log_gives_the_noise_model_of_the_recording(streams, assert_same, tmp_path, baro, imu):
    topics = [baro_topic(streams.baro_t, streams.pressure, baro), *imu_topics(imu, streams)]
    found = read(write(tmp_path / "rest.ulg", *topics))
    assert_same(found, stamp=MICROSECOND)
    assert found.name == "rest"
    assert found.temperature[found.is_new] == pytest.approx(25.0)


def test_the_accelerometer_of_sensor_combined_has_a_clock_of_its_own(streams, expected, tmp_path):
    topics = [baro_topic(streams.baro_t, streams.pressure), *imu_topics("sensor_combined", streams)]
    found = read(write(tmp_path / "rest.ulg", *topics))
    np.testing.assert_allclose(found.t, expected.t, rtol=0, atol=MICROSECOND)
    np.testing.assert_allclose(found.accel, expected.accel, rtol=0, atol=1e-4)  # as in assert_same, and less


def level(n=50):
    """A vehicle at rest and level: forward, right, down."""
    t = 1 + np.arange(n) / 10
    columns = {"timestamp": us(t), "accelerometer_m_s2": (0, 0, -9.8), "gyro_rad": (0, 0, 0.1)}
    return t, ("sensor_combined", 0, COMBINED, columns)


def test_a_level_vehicle_reads_up_along_minus_z(tmp_path):
    t, imu = level()
    found = read(write(tmp_path / "a.ulg", baro_topic(t, 1e5), imu))
    assert found.accel[25] == pytest.approx([0, 0, -9.8])
    assert found.gyro[25] == pytest.approx([0, 0, 0.1])


def test_an_invalid_accelerometer_sample_is_none(tmp_path):
    t, imu = level()
    imu[3]["accelerometer_timestamp_relative"] = np.where(np.arange(50) < 20, 0x7FFFFFFF, 0)
    found = read(write(tmp_path / "a.ulg", baro_topic(t, 1e5), imu))
    assert np.isnan(found.accel[:20]).all()
    assert np.isfinite(found.accel[20:]).all()


def test_millibar_of_old_logs_become_pascal(tmp_path):
    t, imu = level()
    found = read(write(tmp_path / "a.ulg", baro_topic(t, np.float32(1013.25)), imu))
    assert found.pressure[found.is_new] == pytest.approx(101_325)
    assert not found.notes


def test_publication_time_stands_in_for_a_missing_sample_time(tmp_path):
    t, _ = level()
    found = read(write(tmp_path / "a.ulg", baro_topic(t, 1e5, timestamp_sample=0)))
    np.testing.assert_allclose(found.t, t + 500e-6, rtol=0, atol=MICROSECOND)


def test_the_busiest_topic_and_its_first_instance_are_taken_and_the_others_named(tmp_path):
    t, _ = level()
    topics = [
        baro_topic(t[::10], 1e5),
        baro_topic(t, 9e4, "vehicle_air_data", 0),
        baro_topic(t, 8e4, "vehicle_air_data", 1),
    ]
    found = read(write(tmp_path / "a.ulg", *topics))
    assert set(found.pressure) == {9e4}
    assert [note.code for note in found.notes] == ["several-sensors"]
    assert (
        "vehicle_air_data 0 was taken and sensor_baro 0, vehicle_air_data 1 left out"
        in found.notes[0].message
    )


def test_the_first_imu_is_taken_and_one_without_samples_is_none(tmp_path):
    t, imu = level()
    second = (*imu[:1], 1, imu[2], imu[3] | {"accelerometer_m_s2": (0, 0, 1.0)})
    found = read(write(tmp_path / "a.ulg", baro_topic(t, 1e5), imu, second))
    assert found.accel[25] == pytest.approx([0, 0, -9.8])
    assert "sensor_combined 0 was taken and sensor_combined 1 left out" in found.notes[0].message
    imu[3]["accelerometer_timestamp_relative"] = 0x7FFFFFFF
    found = read(write(tmp_path / "b.ulg", baro_topic(t, 1e5), imu))
    assert found.accel is None
    assert found.gyro[25] == pytest.approx([0, 0, 0.1])


def test_what_is_no_log_with_pressure_is_refused_in_a_sentence(tmp_path, monkeypatch, refusal):
    path = tmp_path / "a.ulg"
    assert "no such file" in refusal(path)
    for content in (b"", b"time_s,pressure_pa\n", bytes(1000)):
        path.write_bytes(content)
        assert "a.ulg: this is not a ULog file, or it is damaged" in refusal(path)
    path.write_bytes(ulog_bytes(level()[1]))
    assert "neither sensor_baro nor vehicle_air_data" in refusal(path)
    monkeypatch.setitem(sys.modules, "pyulog", None)
    assert "pip install 'baroarma[ulog]'" in refusal(path)


def test_a_log_cut_off_anywhere_gives_what_was_there_or_a_sentence(tmp_path, capfd):
    t, imu = level()
    content = ulog_bytes(baro_topic(t, 1e5), imu)
    path = tmp_path / "a.ulg"
    lengths = []
    for end in range(0, len(content), 97):
        path.write_bytes(content[:end])
        try:
            lengths.append(len(read(path)))
        except UnreadableError:
            lengths.append(0)
    assert lengths == sorted(lengths)
    assert lengths[-1] == 50
    assert capfd.readouterr() == ("", "")


def test_damage_is_noted_or_refused_but_never_a_traceback(tmp_path, capfd):
    t, imu = level(200)
    content = ulog_bytes(baro_topic(t, 1e5), imu)
    path, rng, outcomes = tmp_path / "a.ulg", np.random.default_rng(0), set()
    for _ in range(60):
        damaged = bytearray(content)
        for position in rng.integers(0, len(content), 20):
            damaged[position] = rng.integers(256)
        path.write_bytes(damaged)
        try:
            outcomes |= {note.code for note in read(path).notes}
        except UnreadableError:
            outcomes.add("refused")
    assert {"damaged", "refused"} <= outcomes
    assert capfd.readouterr() == ("", "")
