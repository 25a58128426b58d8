"""Units that can't be are named; units that may be are left alone."""

from dataclasses import replace

import numpy as np
import pytest

from baroarma import Recording
from baroarma.formats import read
from baroarma.formats.units import unit_findings


def recording(pressure=101_325.0, accel=(0.0, 0.0, 9.8), gyro=(0.0, 0.0, 1.0), start=0.0):
    n = 5
    return Recording(
        t=start + np.arange(n) / 50,
        pressure=np.full(n, pressure),
        accel=np.tile(accel, (n, 1)),
        gyro=np.tile(gyro, (n, 1)),
    )


@pytest.mark.parametrize("pressure", [26_500.0, 101_325.0, 110_000.0, 3_000.0])
def test_pressures_from_thirty_kilometres_to_a_mine_are_plausible(pressure):
    assert unit_findings(recording(pressure)) == ()


@pytest.mark.parametrize(
    ("pressure", "cure"),
    [
        (1013.25, "look like hPa (mbar): name the column pressure_hpa"),
        (305.0, "look like hPa"),
        (101.3, "look like kPa: multiply them by 1000"),
        (101_325e2, "Pa under the label hPa: name the column pressure_pa"),
        (7e5, "check what the column holds"),
        (29.92, "look like inches of mercury: multiply them by 3386.39"),
        (14.7, "look like psi"),
        (1.013, "look like bar or atm"),
        (5.0, "may be a gauge"),
    ],
)
def test_a_pressure_that_cannot_be_is_an_error_with_a_cure(pressure, cure):
    (found,) = unit_findings(recording(pressure))
    assert (found.code, found.severity) == ("units", "error")
    assert cure in found.message


def test_hpa_labelled_pa_reads_and_carries_the_finding(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time_s,pressure_pa\n" + "".join(f"{k},{1013 + k % 3}\n" for k in range(50)))
    assert [(note.code, note.severity) for note in read(path).notes] == [("units", "error")]
    assert read(path, mapping={"pressure_hpa": "pressure_pa"}).notes == ()


@pytest.mark.parametrize(
    ("accel", "unit"),
    [
        ((0.0, 0.0, 1.0), "g under"),
        ((600.0, 0.0, -800.0), "mg under"),
        ((0.0, 96.0, 0.0), "m/s² under the label g"),
    ],
)
def test_an_accelerometer_in_the_wrong_unit_is_a_warning(accel, unit):
    (found,) = unit_findings(recording(accel=accel))
    assert (found.code, found.severity) == ("units", "warning")
    assert unit in found.message


def test_a_gyro_beyond_all_gyros_is_a_warning():
    (found,) = unit_findings(recording(gyro=(250.0, 0.0, 0.0)))
    assert (found.code, found.severity) == ("units", "warning")
    assert "gyr_x_deg_s" in found.message
    assert unit_findings(recording(gyro=(69.0, 0.0, 0.0))) == ()  # 4000 deg/s


def test_nanoseconds_are_not_seconds_but_unix_time_is_time():
    (found,) = unit_findings(replace(recording(), t=1.7e15 + 20.0 * np.arange(5)))
    assert (found.code, found.severity) == ("units", "error")
    assert unit_findings(recording(start=1.7e9)) == ()


def test_milliseconds_since_the_start_are_asked_about():
    log = recording()
    alone = replace(log, accel=None, gyro=None)
    for one in (log, alone):
        (found,) = unit_findings(replace(one, t=one.t * 1000.0))
        assert (found.code, found.severity) == ("units", "warning")
        assert "20 s apart" in found.message
    assert unit_findings(replace(alone, t=log.t * 100.0)) == ()  # a barometer may be read every 2 s
    assert "2 s apart, slow for an IMU" in unit_findings(replace(log, t=log.t * 100.0))[0].message
