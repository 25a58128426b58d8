"""Streams of different rates on one clock."""

import numpy as np
import pytest

from baroarma.formats import UnreadableError, read, streams
from baroarma.formats.streams import onto, union


def write(path, **columns):
    names = list(columns)
    rows = np.column_stack([columns[name] for name in names])
    cells = [",".join("" if np.isnan(v) else repr(float(v)) for v in row) for row in rows]
    path.write_text(",".join(names) + "\n" + "\n".join(cells) + "\n")
    return path


def accel_columns(t, slope=1.0):
    return {"time_s": t, "acc_x_m_s2": slope * t, "acc_y_m_s2": 0 * t, "acc_z_m_s2": 9.8 + 0 * t}


@pytest.fixture
def three(tmp_path):
    rng = np.random.default_rng(4)
    t_baro = np.arange(100) / 10 + rng.uniform(0, 0.02, 100)
    t_acc = 0.5 + np.arange(800) / 100
    t_gyr = 0.3 + np.arange(400) / 50
    rate = {f"gyr_{axis}_rad_s": 0.1 * k + t_gyr for k, axis in enumerate("xyz")}
    return (
        write(tmp_path / "x_baro.csv", time_s=t_baro, pressure_pa=101_325 + rng.normal(0, 3, 100)),
        write(tmp_path / "x_acc.csv", **accel_columns(t_acc)),
        write(tmp_path / "x_gyr.csv", time_s=t_gyr, **rate),
    )


def test_the_clock_is_that_of_barometer_and_accelerometer_together(three):
    baro, accel = read(three[0]), read(three[0], three[1])
    np.testing.assert_array_equal(read(*three).t, accel.t)
    assert set(baro.t) <= set(accel.t)
    assert len(accel) == 900  # 100 + 800, no two within a microsecond


def test_pressure_stands_at_the_barometers_own_rows_only(three):
    baro, merged = read(three[0]), read(*three)
    np.testing.assert_array_equal(merged.t[merged.is_new], baro.t)
    np.testing.assert_array_equal(merged.pressure[merged.is_new], baro.pressure)


def test_a_linear_signal_is_on_every_row_within_its_span_and_nan_outside(three):
    merged = read(*three)
    for value, offset, first, last in (
        (merged.accel[:, 0], 0, 0.5, 8.49),
        (merged.gyro[:, 2], 0.2, 0.3, 8.28),
    ):
        inside = (merged.t >= first - 1e-9) & (merged.t <= last + 1e-9)
        # Linear interpolation is exact on a line, up to rounding.
        np.testing.assert_allclose(value[inside], merged.t[inside] + offset, atol=1e-12)
        assert np.isnan(value[~inside]).all()
        assert np.count_nonzero(~inside) > 0


def test_the_order_of_the_other_files_does_not_matter(three):
    a, b = read(*three), read(three[0], three[2], three[1])
    np.testing.assert_array_equal(a.accel, b.accel)
    np.testing.assert_array_equal(a.gyro, b.gyro)


def test_a_gap_is_not_bridged_but_jitter_is():
    own = np.concatenate((np.arange(0, 1, 0.01), np.arange(1.2, 2, 0.01)))  # 0.21 s without samples
    t = np.array([0.5, 0.99, 1.05, 1.15, 1.2, 1.5])
    np.testing.assert_allclose(onto(t, own, own), [0.5, 0.99, np.nan, np.nan, 1.2, 1.5], atol=1e-12)
    slow = np.arange(0, 60, 1.0)  # 1 s apart is no gap for a thermometer
    assert np.isfinite(onto(t, slow, slow)).all()
    fast = np.concatenate((np.arange(0, 1, 0.01), np.arange(1.08, 2, 0.01)))  # 9 intervals, but only 0.09 s
    assert np.isfinite(onto(t, fast, fast)).all()


def test_stamps_within_a_microsecond_are_one_row():
    first = np.array([0.0, 0.1, 0.2])
    np.testing.assert_array_equal(union(first, first + 4e-7), first)
    assert len(union(first, first + 4e-6)) == 6
    np.testing.assert_array_equal(onto(first, first + 4e-7, first), np.maximum(first - 4e-7, 0.0))


def test_missing_cells_of_a_stream_are_interpolated_like_missing_rows():
    t = np.arange(0, 1, 0.1)
    value = np.where(np.arange(10) == 5, np.nan, 2 * t)
    np.testing.assert_allclose(onto(t, t, value), 2 * t, atol=1e-12)


def test_rows_of_a_single_file_stay_as_they_are(tmp_path):
    t = np.arange(5) / 10
    accel = accel_columns(t)
    accel["acc_x_m_s2"][2] = np.nan
    found = read(write(tmp_path / "a.csv", **accel, pressure_pa=np.where(t > 0.2, 1e5 + t, np.nan)))
    np.testing.assert_array_equal(found.t, t)
    np.testing.assert_array_equal(found.is_new, t > 0.2)
    assert np.isnan(found.accel[2, 0])


def test_a_reference_attitude_survives_a_change_of_sign(tmp_path):
    t = np.arange(0, 2, 0.1)
    q = (
        np.column_stack([np.sin(t), 0 * t, 0 * t, np.cos(t)])
        * np.where(np.arange(20) % 2, -1.0, 1.0)[:, None]
    )
    truth = {f"ref_q{axis}": q[:, k] for k, axis in enumerate("xyzw")}
    times = np.arange(0.05, 1.9, 0.1)
    baro = write(tmp_path / "baro.csv", time_s=times, pressure_pa=1e5 + times)
    found = read(baro, write(tmp_path / "ref.csv", time_s=t, **truth)).reference_attitude
    exact = np.column_stack([np.sin(times), 0 * times, 0 * times, np.cos(times)])
    # Halfway on the chord and normalised is halfway on the arc: exact but for rounding.
    np.testing.assert_allclose(np.abs(np.sum(found * exact, axis=1)), 1.0, atol=1e-12)


def test_streams_that_do_not_fit_together_are_refused(tmp_path, three):
    late = write(tmp_path / "late.csv", **accel_columns(1.6e9 + np.arange(5.0), slope=0.0))
    with pytest.raises(UnreadableError, match="outside the barometer's 0"):
        read(three[0], late)
    with pytest.raises(UnreadableError, match=r"accel is already in .*x_acc\.csv"):
        read(three[0], three[1], write(tmp_path / "again.csv", **accel_columns(np.arange(5.0))))
    with pytest.raises(UnreadableError, match="2 of the files have pressure"):
        read(three[0], three[0])
    with pytest.raises(UnreadableError, match="there is no pressure"):
        read(three[1], three[2])


def test_the_elevator_ride_has_its_imu_on_every_row(shared_data):
    folder = shared_data / "srp_altimu10_elevator_rocket"
    ride = read(*(folder / f"elevator_{stream}.csv.gz" for stream in ("baro", "acc", "gyr")))
    assert ride.is_new.sum() == 1064
    assert len(ride) == 1064 + 10_639
    # Accelerometer and gyro start 4 and 9 ms after the barometer: no more rows than these lack them.
    assert np.isnan(ride.accel[:, 0]).sum() <= 1
    assert np.isnan(ride.gyro[:, 0]).sum() <= 2
    assert np.linalg.norm(ride.accel[1000:1800], axis=1).mean() == pytest.approx(
        9.906, abs=0.05
    )  # its README
    assert np.diff(ride.t).min() > streams.SAME_TIME
