"""CSV: dialects, units, and a plain sentence for every way to be wrong."""

import gzip
import random

import numpy as np
import pytest

import baroarma as ba
from baroarma.formats import UnreadableError, csv, read
from baroarma.formats.csv import _exact_floats

HEAD = "time_s,pressure_pa,temperature_c\n"


@pytest.fixture
def file(tmp_path):
    def write(content, name="log.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def refusal(*paths, **options):
    with pytest.raises(UnreadableError) as caught:
        read(*paths, **options)
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 400
    return message


@pytest.mark.parametrize(
    ("header", "value", "field", "expected"),
    [
        ("pressure_hpa", 1013.25, "pressure", 101_325.0),
        ("altitude_m", 110.884, "pressure", 100_000.0),
        ("temperature_c", -5.5, "temperature", -5.5),
        ("ref_height_m", 2.0, "reference", 2.0),
        ("ref_velocity_m_s", -1.5, "reference_velocity", -1.5),
    ],
)
def test_scalar_units_become_si(file, header, value, field, expected):
    pressure = "" if field == "pressure" else ",pressure_pa"
    found = read(file(f"time_s,{header}{pressure}\n0,{value}{',1e5' if pressure else ''}\n"))
    # The altitude is published to a millimetre, 0.012 Pa; all else is exact but for rounding.
    assert getattr(found, field)[0] == pytest.approx(expected, abs=0.012 if header == "altitude_m" else 1e-9)


@pytest.mark.parametrize(
    ("prefix", "unit", "field", "one"),
    [
        ("acc", "m_s2", "accel", 1.0),
        ("acc", "g", "accel", 9.80665),
        ("gyr", "rad_s", "gyro", 1.0),
        ("gyr", "deg_s", "gyro", np.pi / 180),
    ],
)
def test_vector_units_become_si_whatever_the_order_of_the_columns(file, prefix, unit, field, one):
    names = ",".join(f"{prefix}_{axis}_{unit}" for axis in "zxy")
    found = read(file(f"{names},pressure_pa,time_s\n3,1,2,1e5,0\n"))
    np.testing.assert_allclose(getattr(found, field), [[1 * one, 2 * one, 3 * one]], rtol=1e-15)


def test_unknown_columns_are_ignored_even_with_separators_in_quotes(file):
    found = read(file('time_s,note,pressure_pa\n0,"a, b",1e5\n1,"°",1e5\n2,c,1e5\n'))
    assert len(found) == 3


def test_an_empty_cell_is_no_sample(file):
    found = read(file(HEAD + "0,,20\n1,1e5,\n2,nan,21\n"))
    np.testing.assert_array_equal(found.pressure, [np.nan, 1e5, np.nan])
    np.testing.assert_array_equal(found.temperature, [20, np.nan, 21])


@pytest.mark.parametrize(
    "content",
    [
        "\ufefftime_s,pressure_pa\n0.5,100000.25\n",
        "time_s;pressure_pa\n0,5;100000,25\n",
        "time_s;pressure_pa\n0.5;100000.25\n",
        "time_s\tpressure_pa\n0.5\t100000.25\n",
        "time_s,pressure_pa\r\n0.5,100000.25\r\n",
        ' time_s , "pressure_pa" \n 0.5 , 100000.25 \n\n',
        "time_s,pressure_pa\r\r\n0.5,100000.25\r\r\n",
        '"time_s","pressure_pa"\n"0.5","100000.25"',
    ],
    ids=["bom", "decimal comma", "semicolon", "tab", "windows", "windows twice", "spaces", "quotes"],
)
def test_other_peoples_csv_reads_the_same(file, content):
    found = read(file(content))
    assert (found.t[0], found.pressure[0]) == (0.5, 100_000.25)


def test_mapping_names_columns_and_wins_over_our_own_names(file):
    path = file("stamp,BaroPress,altitude_m\n0,1013,7\n")
    found = read(path, mapping={"time_s": "stamp", "pressure_hpa": "BaroPress"})
    assert found.pressure[0] == pytest.approx(101_300.0)
    with pytest.raises(ValueError, match="'pressure' is no column of ours"):
        read(path, mapping={"pressure": "BaroPress"})
    assert "no column is called 'BaroPres'" in refusal(
        path, mapping={"time_s": "stamp", "pressure_pa": "BaroPres"}
    )


def test_floats_read_back_exactly_whichever_pandas(file):
    x = np.random.default_rng(1).normal(1e5, 300, 5000)
    found = read(file("time_s,pressure_pa\n" + "".join(f"{k},{v!r}\n" for k, v in enumerate(x.tolist()))))
    np.testing.assert_array_equal(found.pressure, x)
    assert _exact_floats("2.2.3") == {
        "float_precision": "round_trip"
    }  # before 3.1 the default was an ulp off
    assert _exact_floats("3.1.1") == {}


@pytest.mark.parametrize("block", [1, 17, 64, 1000])
def test_the_size_of_the_blocks_changes_nothing(file, monkeypatch, block):
    rows = "".join(f"{k / 10},{100_000 + k % 5},\n" + ("\n" if k % 7 == 0 else "") for k in range(50))
    path = file(HEAD + rows)
    whole = read(path)
    monkeypatch.setattr(csv, "BLOCK", block)
    np.testing.assert_array_equal(read(path).pressure, whole.pressure)
    # Line 1 names the columns; then come 50 rows, 8 empty lines among them, and one more before the bad row.
    assert "line 61: pressure_pa is 'x'" in refusal(file(HEAD + rows + "\n5.0,x,\n"))


def test_the_line_of_a_bad_value_counts_empty_lines(file):
    assert "line 6: pressure_pa is -3" in refusal(file(HEAD + "\n0,1e5,\n\n1,1e5,\n2,-3,\n"))


GOOD = HEAD + "".join(f"{k},{100_000 + k},20\n" for k in range(5))

BAD = {
    "empty": ("", "the file is empty"),
    "blank": ("\n\n", "first line is; line 1 must name the columns"),
    "header only": (HEAD, "a header but no row of data"),
    "binary": (bytes(range(256)) * 20, "binary file"),
    "utf-16": (GOOD.encode("utf-16"), "UTF-16 text; save it as UTF-8"),
    "zeros after a crash": (GOOD.encode() + b"\0" * 50, "line 7: there are zero bytes"),
    "no header": ("0,100000\n1,100001\n", "the first line holds numbers, '0', '100000'"),
    "no time": ("pressure_pa\n100000\n", "no column 'time_s'"),
    "no pressure": ("time_s,temperature_c\n0,20\n", "there is no pressure"),
    "no pressure sample": (HEAD + "0,,20\n1,,20\n", "every cell of the pressure column is empty"),
    "pressure twice": ("time_s,pressure_pa,altitude_m\n0,1e5,100\n", "are the same quantity"),
    "same name twice": ("time_s,pressure_pa,pressure_pa\n0,1e5,1e5\n", "column 'pressure_pa' 2 times"),
    "g and m/s2": ("time_s,pressure_pa,acc_x_g,acc_x_m_s2\n0,1e5,0,0\n", "are the same quantity"),
    "one axis": ("time_s,pressure_pa,acc_x_g\n0,1e5,0\n", "of 3 accel columns there are only 'acc_x_g'"),
    "too many fields": (
        GOOD + "5,1e5,20,7\n6,1e5,20\n",
        "line 7: there are 4 fields where the header names 3",
    ),
    "too few fields": (
        GOOD + "5,1e5\n6,1e5,20\n",
        "line 7: there are 2 fields where the header names 3: '5,1e5'",
    ),
    "half a last line": (GOOD + "5,10", "line 7: there are 2 fields"),
    "text": (GOOD + "5,n/a,20\n", "line 7: pressure_pa is 'n/a', no number"),
    "two points": (GOOD + "5,100.000.25,20\n", "line 7: pressure_pa is '100.000.25', no number"),
    "open quote": ('time_s,note,pressure_pa\n0,a,1e5\n1,"a,1e5\n2,a,1e5\n', "line 3: a quote isn't closed"),
    "quoted separator": (
        'time_s,note,pressure_pa\n0,a,1e5\n1,"a,1e5"\n2,a,1e5\n',
        "line 3: there are 2 fields",
    ),
    "quote that swallows a line": (
        'time_s,pressure_pa,note\n0,1e5,a\n1,1e5,"a\n2,1e5,a"\n3,1e5,a\n',
        "line 3: a quote isn't closed",
    ),
    "carriage return": (GOOD + "5,1e5,20\r6,1e5,20\n", "line 7: there is a carriage return within"),
    "inf": (GOOD + "5,inf,20\n", "line 7: pressure_pa is inf"),
    "1e300": (GOOD + "5,1e300,20\n", "line 7: pressure_pa is 1e+300, readable is above 0 to 1e+09"),
    "1e400": (GOOD + "5,1e400,20\n", "line 7: pressure_pa is inf"),
    "negative": (GOOD + "5,-100000,20\n", "line 7: pressure_pa is -100000"),
    "zero": (GOOD + "5,0,20\n", "line 7: pressure_pa is 0"),
    "above vacuum": ("time_s,altitude_m\n0,50000\n", "altitude_m is 50000, readable is from -10000 to 44000"),
    "backwards": (GOOD + "3,1e5,20\n", "line 7: the time is 3 s after 4 s: it runs backwards"),
    "same time": (GOOD + "4,1e5,20\n", "line 7: the time is 4 s after 4 s: it stands still"),
    "time missing": (GOOD + ",1e5,20\n", "line 7: the time is missing"),
    "time infinite": (GOOD + "inf,1e5,20\n", "line 7: time_s is inf"),
}


@pytest.mark.parametrize("case", BAD)
@pytest.mark.parametrize("suffix", ["", ".gz"])
def test_a_bad_file_is_refused_in_one_sentence(file, case, suffix):
    content, expected = BAD[case]
    content = content if isinstance(content, bytes) else content.encode()
    message = refusal(file(gzip.compress(content) if suffix else content, "log.csv" + suffix))
    assert "log.csv" in message
    assert expected in message


def test_files_that_are_not_there_or_not_files_are_refused(tmp_path, file):
    assert "there is no such file" in refusal(tmp_path / "none.csv")
    assert "there is no such file" in refusal(tmp_path / "none.csv.gz")
    assert "this is a folder" in refusal(tmp_path)
    assert "this is not gzip" in refusal(file(GOOD, "log.csv.gz"))
    whole = gzip.compress(random.Random(1).randbytes(5000).hex().encode())
    assert "cut off or damaged" in refusal(file(whole[:-20], "cut.csv.gz"))
    with pytest.raises(ValueError, match="at least one file"):
        read()


def test_random_damage_never_escapes_as_another_error(file):
    rng = random.Random(7)
    refused = 0
    for _ in range(300):
        content = bytearray(GOOD.encode())
        for _ in range(rng.randint(1, 4)):
            content[rng.randrange(len(content))] = rng.randrange(256)
        try:
            read(file(bytes(content)))
        except UnreadableError:
            refused += 1
    assert 100 < refused < 300  # some damage only changes a digit


def test_a_coarse_clock_may_repeat_a_time_now_and_then(file, shared_data):
    t = np.arange(1000) / 100
    t[500] = t[499]
    found = read(file("time_s,pressure_pa\n" + "".join(f"{a},{100_000 + k % 9}\n" for k, a in enumerate(t))))
    assert len(found) == 999
    assert found.pressure[500] == 100_000 + 501 % 9
    assert [note.code for note in found.notes] == ["repeated-times"]
    real = read(shared_data / "stampfly_tof_handheld" / "rest_400hz_g.csv.gz")
    assert len(real) == 11_227 - 5  # its README: 5 repeated time stamps


def test_every_real_recording_reads(shared_data):
    for path in sorted(shared_data.glob("*/*.csv.gz")):
        if not path.name.endswith(("_acc.csv.gz", "_gyr.csv.gz")):
            assert isinstance(read(path), ba.Recording)
