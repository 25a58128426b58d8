"""Rows as they come: each one a sample at once, in SI units."""

import io
import os

import numpy as np
import pytest

from baroarma.formats import UnreadableError
from baroarma.formats.rows import LONGEST_LINE, sample_reader

HEAD = "time_s,pressure_hpa,acc_x_g,acc_y_g,acc_z_g,gyr_x_deg_s,gyr_y_deg_s,gyr_z_deg_s,note"


def test_a_row_becomes_a_sample_in_si_units():
    (sample,) = sample_reader([HEAD + "\n", "0.5,1013.25,0,0,1,180,0,0,hello\n"])
    assert (sample.t, sample.pressure) == (0.5, 101_325.0)
    assert sample.accel.tolist() == [0, 0, 9.80665]
    assert sample.gyro.tolist() == pytest.approx([np.pi, 0, 0])


def test_a_sample_is_there_before_the_next_line_is_asked_for():
    asked = []

    def lines():
        for line in (HEAD, "0,1000,0,0,1,0,0,0,", "1,1000,0,0,1,0,0,0,"):
            asked.append(line)
            yield line

    samples = sample_reader(lines())
    next(samples)
    assert len(asked) == 2


def test_empty_cells_and_lines_are_no_samples():
    lines = ["\ufeff" + HEAD, "", "0, ,0,0,1,nan,0,0,x", "   ", "1,1000,,,,0,0,0,"]
    first, second = sample_reader(lines)
    assert np.isnan(first.pressure)
    assert np.isnan(first.gyro[0])
    assert np.isnan(second.accel).all()


def test_a_stream_without_imu_says_so():
    (sample,) = sample_reader(["altitude_m,time_s", "0,3"])
    assert (sample.accel, sample.gyro) == (None, None)
    assert sample.pressure == pytest.approx(101_325.0)


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        ([""], "there is no column 'time_s'"),
        (["time_s,temperature_c"], "there is no pressure among the columns"),
        (["time_s,pressure_pa", "0,1e5", "1"], r"line 3: 1 cells, but the header has 2"),
        (["time_s,pressure_pa", "0,x"], r"line 2: 'x' in column pressure_pa is no number"),
        (["time_s,pressure_pa", "0,1_0"], r"line 2: '1_0' .* no number"),
        (["time_s,pressure_pa", "0,inf"], r"line 2: pressure_pa of inf can't be"),
        (["time_s,pressure_pa", "0,-5"], r"line 2: pressure_pa of -5 can't be"),
        (["time_s,pressure_pa", "0,1e5", "", "0,1e5"], r"line 4: time must increase, but 0 s follows 0 s"),
        (["time_s,pressure_pa", ",1e5"], r"line 2: the time is missing"),
        (["time_s,pressure_pa,acc_x_g", "0,1e5,1"], "of 3 accel columns there are only"),
    ],
)
def test_what_can_not_be_read_is_told_with_its_line(rows, says):
    with pytest.raises(UnreadableError, match=says):
        list(sample_reader(rows))


@pytest.mark.parametrize(
    "row",
    ["1", "1,1e5,7", "1;1e5", "1,x", "1,1\ufffd00000", "1,\0", "1,-5", "x,1e5", ",1e5", "time_s,pressure_pa"],
)
def test_a_row_that_can_not_be_read_is_as_if_it_had_never_been_sent(row):
    lines, told = ["time_s,pressure_pa", "0,1e5", "2,1e5", "3,100001"], []
    healthy = list(sample_reader(lines))
    assert list(sample_reader([*lines[:2], row, *lines[2:]], told.append)) == healthy
    (error,) = told
    assert str(error).startswith("standard input, line 3: ")


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (["time_s", "0"], "there is no pressure"),
        (["time_s,pressure_pa", "0", "1"], "not one row could be read; standard input, line 2: 1 cells"),
        (["time_s,pressure_pa", "1,1e5", "x", "1,1e5"], "line 4: time must increase"),
        (["time_s,pressure_pa", "1,1e5", "0" * LONGEST_LINE], "line 3: it is longer than 65536"),
    ],
)
def test_no_skipping_helps_a_wrong_header_a_clock_that_stands_or_a_stream_without_rows(lines, says):
    with pytest.raises(UnreadableError, match=says):
        list(sample_reader(lines, lambda error: None))


def test_binary_input_is_told_in_a_sentence():
    def lines():
        yield b"\xff\xfe\x00".decode("utf-8")

    with pytest.raises(UnreadableError, match="this is no text"):
        list(sample_reader(lines()))


def test_a_line_without_end_is_refused_before_it_fills_the_memory():
    class Endless(io.RawIOBase):
        asked = 0

        def readable(self):
            return True

        def readinto(self, buffer):
            Endless.asked += len(buffer)
            buffer[:] = b"0" * len(buffer)
            return len(buffer)

    with pytest.raises(UnreadableError, match="line 1: it is longer than 65536 characters"):
        next(sample_reader(io.TextIOWrapper(io.BufferedReader(Endless()))))
    assert Endless.asked < 3 * LONGEST_LINE


def test_a_stream_gives_each_sample_before_the_next_line_is_written():
    readable, writable = os.pipe()
    with open(readable) as lines, open(writable, "w", buffering=1) as logger:
        logger.write("time_s,pressure_pa\n")
        samples = sample_reader(lines)
        for k in range(5):
            logger.write(f"{k},{100_000 + k}\n")
            assert next(samples).pressure == 100_000 + k
