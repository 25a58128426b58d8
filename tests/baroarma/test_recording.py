"""Recordings hold signals on one clock."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from baroarma import Recording
from baroarma.atmosphere import temperature_factor
from baroarma.finding import Finding


def make(n=10, **signals):
    return Recording(t=np.arange(n) / 50, pressure=np.full(n, 101_325.0), **signals)


def test_time_must_increase_and_the_message_names_the_row():
    with pytest.raises(ValueError, match=r"row 2 says 0\.5 s after 1 s"):
        Recording(t=[0, 1, 0.5], pressure=[1e5] * 3)
    with pytest.raises(ValueError, match="row 1 is nan"):
        Recording(t=[0, np.nan, 2], pressure=[1e5] * 3)


def test_every_signal_has_one_row_per_time():
    with pytest.raises(ValueError, match=r"accel has shape \(9, 3\); \(10, 3\) is needed"):
        make(accel=np.zeros((9, 3)))


def test_nothing_can_be_changed_but_by_replace():
    recording = make()
    with pytest.raises(FrozenInstanceError):
        recording.name = "other"
    with pytest.raises(ValueError, match="read-only"):
        recording.pressure[0] = 1.0
    pressure = np.where(np.arange(10) % 2, np.nan, 1e5)
    assert np.array_equal(replace(recording, pressure=pressure).pressure, pressure, equal_nan=True)


def test_the_rate_is_that_of_new_samples():
    pressure = np.where(np.arange(100) % 5 == 0, 1e5, np.nan)
    assert Recording(t=np.arange(100) / 50, pressure=pressure).rate_hz == pytest.approx(10)


def test_the_duration_is_from_first_to_last_wherever_the_clock_starts():
    assert Recording(t=[100, 101, 107.5], pressure=[1e5] * 3).duration == 7.5
    assert make(1).duration == 0.0
    assert make().source is None


def test_a_part_keeps_all_signals_in_step():
    recording = make(accel=np.arange(30.0).reshape(10, 3), reference=np.arange(10.0))
    part = recording.between(0.04, 0.1)
    assert part.reference.tolist() == [2, 3, 4]
    assert part.accel[0].tolist() == [6, 7, 8]


def test_temperature_stretches_differences_not_the_level():
    recording = Recording(t=[0, 1, 2], pressure=[100_000, 100_100, 100_050])
    isa, warm = recording.height(), recording.height(temperature=44.0)
    assert np.ptp(warm) / np.ptp(isa) == pytest.approx(
        (44 + 273.15) / 287.46, rel=1e-4
    )  # T_ISA at 1000.5 hPa
    assert warm[2] == pytest.approx(isa[2])


def test_a_slice_shares_memory_and_stays_read_only_and_backwards_is_refused():
    whole = Recording(t=np.arange(6.0), pressure=np.arange(6.0) + 1e5, accel=np.ones((6, 3)), name="bench")
    part = whole.rows(slice(1, 5, 2))
    assert np.array_equal(part.t, [1, 3])
    assert part.accel.shape == (2, 3)
    assert part.gyro is None
    assert part.name == "bench"
    assert np.shares_memory(part.accel, whole.accel)
    with pytest.raises(ValueError, match="read-only"):
        part.pressure[0] = 0.0
    with pytest.raises(ValueError, match="time must increase"):
        whole.rows(slice(None, None, -1))


def test_noting_adds_findings_and_shares_the_signals():
    log = Recording(t=[0.0, 1.0], pressure=[1e5, 1e5], notes=(Finding("a", "info", "One."),))
    noted = log.noting(Finding("b", "warning", "Two."))
    assert [note.code for note in noted.notes] == ["a", "b"]
    assert noted.pressure is log.pressure
    assert len(log.notes) == 1


def test_the_rate_of_too_few_samples_is_refused_with_their_number():
    for pressure, n in (([np.nan, np.nan], 0), ([1e5, np.nan], 1)):
        with pytest.raises(ValueError, match=f"{n} pressure samples have no rate; at least 2 are needed"):
            _ = Recording(t=[0, 1], pressure=pressure).rate_hz
    assert Recording(t=[0, 4], pressure=[1e5, 1e5]).rate_hz == 0.25


def test_two_samples_have_a_rate_and_one_has_none_in_its_line():
    named = {"name": "bench", "accel": np.zeros((2, 3)), "gyro": np.zeros((2, 3)), "temperature": [20, 21]}
    both = Recording(t=[0, 4], pressure=[1e5, 1e5], reference=[0, 1], **named)
    assert repr(both) == (
        "<Recording 'bench': 2 rows, 4 s, pressure 2 samples at 0.25 Hz, accel, gyro, temperature, reference>"
    )
    one = Recording(t=[0, 4], pressure=[1e5, np.nan])
    assert repr(one) == "<Recording '': 2 rows, 4 s, pressure 1 samples>"
    none = Recording(t=[], pressure=[])
    assert repr(none) == "<Recording '': 0 rows, 0 s, pressure 0 samples>"


@pytest.mark.parametrize(("field", "columns"), [("accel", 3), ("gyro", 3), ("reference_attitude", 4)])
def test_a_vector_has_its_columns(field, columns):
    assert getattr(make(**{field: np.ones((10, columns))}), field).shape == (10, columns)
    with pytest.raises(ValueError, match=rf"{field} has shape \(10, 2\); \(10, {columns}\) is needed"):
        make(**{field: np.ones((10, 2))})


def test_time_and_pressure_are_never_left_out():
    with pytest.raises(ValueError, match=r"pressure has shape \(\); \(2,\) is needed"):
        Recording(t=[0, 1], pressure=None)
    with pytest.raises(ValueError, match=r"t has shape \(\); \(1,\) is needed"):
        Recording(t=None, pressure=[1e5])


def test_equal_times_are_refused_as_well():
    with pytest.raises(ValueError, match=r"row 1 says 5 s after 5 s; sort the rows or drop the repeated"):
        Recording(t=[5, 5, 6], pressure=[1e5] * 3)


def test_warm_air_stretches_about_the_median_pressure():
    recording = Recording(t=[0, 1, 2, 3], pressure=[100_000, 100_100, np.nan, 100_050])
    isa, warm = recording.height(), recording.height(temperature=44.0)
    assert np.isnan(warm).tolist() == [False, False, True, False]
    assert warm[3] == isa[3]
    factor = temperature_factor(100_050.0, 44.0)
    assert warm[[0, 1]] - warm[3] == pytest.approx(factor * (isa[[0, 1]] - isa[3]))
    blank = Recording(t=[0], pressure=[np.nan])
    assert np.isnan(blank.height(temperature=44.0)).all()


def test_rows_are_chosen_by_mask_indices_or_slice_with_the_same_result():
    recording = make(gyro=np.arange(30.0).reshape(10, 3), temperature=np.arange(10.0), source={"name": "a"})
    by_slice = recording.rows(slice(2, 8, 3))
    for which in (np.array([2, 5]), np.isin(np.arange(10), [2, 5])):
        part = recording.rows(which)
        for field in ("t", "pressure", "gyro", "temperature"):
            assert np.array_equal(getattr(part, field), getattr(by_slice, field))
        assert (part.name, part.source, part.accel) == (by_slice.name, by_slice.source, None)
    assert by_slice.temperature.tolist() == [2, 5]
    assert len(recording.rows(slice(3))) == 3
    assert np.shares_memory(recording.rows(slice(3)).t, recording.t)
    assert len(recording) == 10


def test_the_weather_of_a_second_barometer_is_taken_off():
    t = np.arange(200) / 2
    weather = 30 * np.sin(t / 20)
    here, there = Recording(t, 1e5 + weather - 120 * (t > 60)), Recording(t, 1.001e5 + weather)
    flat = here.relative_to(there, lag=0.0).pressure
    assert np.ptp(flat[t <= 60]) < 0.5  # what the height of 10 m between the two makes of 60 Pa
    assert np.mean(flat[t <= 60]) - np.mean(flat[t > 60]) == pytest.approx(120, abs=1)
    moved = here.relative_to(Recording(t + 7.0, 1.001e5 + weather), lag=7.0)
    assert np.ptp(moved.pressure[t <= 60]) < 0.5


def test_the_summary_has_a_line_per_signal_under_its_columns_and_the_notes():
    note = Finding("gaps", "info", "One.")
    recording = make(accel=np.tile([0.0, 3.0, 4.0], (10, 1)), notes=(note,), name="bench")
    first, head, *rows, last = recording.summary().splitlines()
    assert first == repr(recording)
    assert head == "  signal                      samples  rate        range"
    assert rows == [
        "  pressure                         10  50 Hz       1013.25 to 1013.25 hPa",
        "  specific force (modulus)         10  50 Hz       5.00 to 5.00 m/s²",
    ]
    assert last == "  info (gaps): One."
    html = recording._repr_html_()
    for cell in (
        "bench: 10 rows over 0.18 s", ">signal<", ">samples<", ">rate<", ">range<", ">50 Hz<", ">One.<"
    ):  # fmt: skip
        assert cell in html
    assert "Recording: 10 rows" in make()._repr_html_()


def test_a_frame_has_a_column_per_signal_and_axis():
    recording = make(gyro=np.arange(30.0).reshape(10, 3))
    frame = recording.to_frame()
    assert list(frame) == ["time_s", "pressure_pa", "gyr_x_rad_s", "gyr_y_rad_s", "gyr_z_rad_s"]
    assert frame.gyr_y_rad_s.tolist() == recording.gyro[:, 1].tolist()


def test_a_dataset_has_the_signals_and_the_notes():
    pytest.importorskip("xarray")
    found = make(notes=(Finding("gaps", "info", "One."),)).to_xarray()
    assert found.pressure.values.tolist() == [101_325.0] * 10
    assert found.attrs["findings"] == ["info (gaps): One."]


def test_it_is_drawn_where_it_is_told():
    ax = Figure().subplots()
    assert make().plot(ax) is ax
    assert ax.lines
