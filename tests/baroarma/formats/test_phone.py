"""Exports of phyphox and Sensor Logger, laid out as the apps document and write them."""

import io
import zipfile

import numpy as np
import pytest

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.formats import read

XYZ = "xyz"


def packed(path, files):
    """Write a zip of {name: text}."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return path


def unpacked(path, files):
    path.mkdir()
    for name, text in files.items():
        (path / name).parent.mkdir(exist_ok=True)
        (path / name).write_text(text, encoding="utf-8")
    return path


def table(names, *columns, fmt="%.9E", separator=",", decimal="."):
    out = io.StringIO()
    np.savetxt(out, np.column_stack(columns), fmt, separator)
    text = out.getvalue() if decimal == "." else out.getvalue().replace(".", decimal)
    return separator.join(names) + "\n" + text.replace("nan", "NaN")


# phyphox: ten digits; the names in quotes

PHYPHOX_STAMP = 1e-7
"""The tenth digit of 299.98 s, in s."""


def phyphox(streams, names="android", **style):
    acceleration, rate = ("Acceleration {} (m/s^2)", "Gyroscope {} (rad/s)")
    baro, axes = "Pressure (hPa)", XYZ
    if names == "ios":
        acceleration, rate, baro, axes = "{} (m/s^2)", "{} (rad/s)", "X (hPa)", "XYZ"

    def head(*columns):
        return [f'"{column}"' for column in ("Time (s)", *columns)]

    imu_head = [acceleration.format(axis) for axis in axes]
    return {
        "Accelerometer.csv": table(head(*imu_head), streams.imu_t, streams.accel, **style),
        "Linear Accelerometer.csv": table(head(*imu_head), streams.imu_t, streams.accel * 0, **style),
        "Gyroscope.csv": table(head(*(rate.format(a) for a in axes)), streams.imu_t, streams.gyro, **style),
        "Barometer.csv": table(head(baro), streams.baro_t, streams.pressure / 100, **style),
        "meta/device.csv": '"property","value"\n"deviceModel","phone"\n',
        "meta/time.csv": '"event","experiment time","system time"\n"START",0.0,1.7e9\n',
    }


@pytest.mark.parametrize("write", [packed, unpacked])
@pytest.mark.parametrize(
    "style",
    [{}, {"names": "ios", "separator": "\t"}, {"separator": ";", "decimal": ","}],
    ids=["comma", "tab-ios", "semicolon"],
)
def test_phyphox_gives_the_noise_model_of_the_recording(streams, assert_same, tmp_path, write, style):
    path = tmp_path / ("rest.zip" if write is packed else "rest 2026-02-02 12.30")
    found = read(write(path, phyphox(streams, **style)))
    assert_same(found, stamp=PHYPHOX_STAMP)  # ten digits are finer than a float32's seven
    assert found.name == path.name.removesuffix(".zip")


def test_phyphox_fills_a_shorter_column_up_and_that_is_no_sample(tmp_path):
    text = '"Time (s)","Pressure (hPa)","Height (m)"\n0.0,1000.0,0.0\n0.1,1000.1,0.1\nNaN,NaN,0.2\n'
    found = read(packed(tmp_path / "a.zip", {"Raw Data.csv": text}))
    assert found.t.tolist() == [0.0, 0.1]


def test_a_sensor_that_the_phone_lacks_is_left_out(tmp_path):
    texts = {
        "Pressure.csv": "Time (s),Pressure (hPa)\n0.0,1000.0\n0.1,1000.1\n",
        "Gyroscope.csv": "Time (s),Gyroscope x (rad/s),Gyroscope y (rad/s),Gyroscope z (rad/s)\n",
    }
    found = read(packed(tmp_path / "a.zip", texts))
    assert (len(found), found.gyro) == (2, None)


# Sensor Logger: nanoseconds since 1970, seconds since the start

LEVEL = (0.1, -0.2, 9.8)
ANDROID = "version,platform,standardisation\n3,android,false\n"
IOS = "version,platform,standardisation\n3,ios,false\n"
STANDARDISED = "version,platform,standardisation\n3,ios,true\n"


def sensor(t, columns, values):
    head = ("time", "seconds_elapsed", *columns)
    ns = [f"{1_770_000_000_000_000_000 + round(x * 1e9)}" for x in t]
    rows = np.broadcast_to(np.asarray(values, float).reshape(-1, len(columns)), (len(t), len(columns)))
    lines = (
        ",".join([s, repr(float(x)), *map(repr, row)]) for s, x, row in zip(ns, t, rows.tolist(), strict=True)
    )
    return ",".join(head) + "\n" + "\n".join(lines) + "\n"


def vector(t, values):
    """Sensor Logger writes z, y, x."""
    return sensor(t, "zyx", np.atleast_2d(values)[:, ::-1])


def test_sensor_logger_gives_the_noise_model_of_the_recording(streams, assert_same, tmp_path):
    hpa = np.column_stack([0 * streams.pressure, streams.pressure / 100])
    files = {
        "Barometer.csv": sensor(streams.baro_t, ("relativeAltitude", "pressure"), hpa),
        "TotalAcceleration.csv": vector(streams.imu_t, streams.accel),
        "Accelerometer.csv": vector(streams.imu_t, (0, 0, 0)),
        "Gyroscope.csv": vector(streams.imu_t, streams.gyro),
        "Metadata.csv": ANDROID,
    }
    found = read(packed(tmp_path / "rest.zip", files))
    assert_same(found, stamp=1e-9, float32=False)


def phone(tmp_path, name, files):
    t = np.arange(40) / 10
    logged = {"Barometer.csv": sensor(t, ("relativeAltitude", "pressure"), (0.0, 1013.25))}
    logged |= {stem: text if isinstance(text, str) else vector(t, text) for stem, text in files.items()}
    return read(packed(tmp_path / name, logged))


@pytest.mark.parametrize(
    ("name", "files"),
    [
        ("total", {"TotalAcceleration.csv": LEVEL, "Metadata.csv": ANDROID}),
        ("no-metadata", {"TotalAcceleration.csv": LEVEL, "Accelerometer.csv": (0, 0, 0)}),
        ("raw", {"AccelerometerUncalibrated.csv": LEVEL, "Metadata.csv": ANDROID}),
        (
            "raw-ios",
            {"AccelerometerUncalibrated.csv": -np.array(LEVEL) / STANDARD_GRAVITY, "Metadata.csv": IOS},
        ),
        ("raw-standardised", {"AccelerometerUncalibrated.csv": LEVEL, "Metadata.csv": STANDARDISED}),
        (
            "sum-ios",
            {"Accelerometer.csv": (-0.1, 0.2, 0.0), "Gravity.csv": (0, 0, -9.8), "Metadata.csv": IOS},
        ),
    ],
)
def test_the_acceleration_with_gravity_points_up_whatever_the_phone(tmp_path, name, files):
    found = phone(tmp_path, f"{name}.zip", files)
    # Nothing is rounded but the conversion from g.
    np.testing.assert_allclose(found.accel, np.tile(LEVEL, (40, 1)), rtol=1e-12)
    assert found.pressure == pytest.approx(101_325)


def test_an_acceleration_without_gravity_is_left_out_and_said_so(tmp_path):
    found = phone(tmp_path, "a.zip", {"Accelerometer.csv": (0, 0, 0), "Gyroscope.csv": (0, 0, 0.1)})
    assert found.accel is None
    assert found.gyro[0].tolist() == [0, 0, 0.1]
    assert [(note.code, note.severity) for note in found.notes] == [("no-gravity", "warning")]


# what can't be read


def test_an_export_without_pressure_is_refused(tmp_path, refusal):
    assert "no such file" in refusal(tmp_path / "none.zip")
    assert "this is a zip file without pressure" in refusal(packed(tmp_path / "a.zip", {"a.txt": "x"}))
    files = {"Accelerometer.csv": vector([0.0], LEVEL)}
    assert "this is a folder without pressure" in refusal(unpacked(tmp_path / "a", files))


def test_a_damaged_zip_is_refused_in_a_sentence(streams, tmp_path, refusal):
    whole = packed(tmp_path / "whole.zip", phyphox(streams)).read_bytes()
    path = tmp_path / "a.zip"
    broken = bytearray(whole)
    broken[len(whole) // 2] ^= 0xFF
    for content in (b"", b"time_s,pressure_pa\n", whole[:1000], whole[:-30], bytes(broken)):
        path.write_bytes(content)
        assert "a.zip: this is not a zip file, or it is damaged" in refusal(path)


def test_a_bad_value_is_named_by_file_and_line_in_the_export(tmp_path, refusal):
    text = '"Time (s)","Pressure (hPa)"\n0.0,1000.0\n0.1,{}\n'
    for value, said in (("high", "pressure_hpa is 'high'"), ("-1", "pressure_hpa is -1")):
        path = packed(tmp_path / "a.zip", {"Raw Data.csv": text.format(value)})
        assert f"{path}/Raw Data.csv, line 3: {said}" in refusal(path)
