"""Recordings hold signals on one clock."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from baroarma import Recording
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
