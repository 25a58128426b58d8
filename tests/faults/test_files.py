"""Files that are broken: what the user sees, by every command; `docs/faults.md` has the table."""

import gzip
import io
import os
import tracemalloc
import zipfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import baroarma as ba
from baroarma.cli import main
from baroarma.formats import UnreadableError, csv, errors

ROOT = Path(__file__).resolve().parents[2]
HEAD = "time_s,pressure_pa,temperature_c"
ROWS = [f"{k / 10},{101_320 + k % 7},21.5" for k in range(12)]
CLEAN = "\n".join([HEAD, *ROWS, ""])
COMMANDS = {
    "identify": ["identify", "{in}", "--out", "{out}"],
    "track": ["track", "{in}", "--out", "{out}"],
    "compare": ["compare", "{in}", "--report", "{out}"],
    "convert": ["convert", "{in}", "{out}"],
}


def edited(k, line):
    """Return the clean file with another line (the header is line 1)."""
    lines = [HEAD, *ROWS]
    lines[k - 1] = line
    return "\n".join([*lines, ""])


def zipped(**files):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name.replace("__", "/") + ".csv", text)
    return out.getvalue()


def parquet(rows):
    import pyarrow
    from pyarrow import parquet

    out, same = io.BytesIO(), pyarrow.array(np.ones(rows))
    parquet.write_table(pyarrow.table({"time_s": same, "pressure_pa": same}), out)
    return out.getvalue()


def lying_zip():
    """Claim that 100 kB are 100 bytes, in both of the places where a zip says so."""
    whole = zipped(Barometer="0" * 100_000)
    return whole.replace((100_000).to_bytes(4, "little"), (100).to_bytes(4, "little"))


PHONE = "seconds_elapsed,pressure\n0,1000\n"
PACKED = gzip.compress(CLEAN.encode() * 20, mtime=0)
CRC = PACKED[:-6] + bytes([PACKED[-6] ^ 1]) + PACKED[-5:]

REFUSED = {
    # fault: (name, content, what is said after "baroarma: {path}")
    "UTF-16": ("a.csv", CLEAN.encode("utf-16"), ": this is no plain text but UTF-16 text; save it as UTF-8"),
    "zero bytes after a crash": (
        "a.csv",
        CLEAN + "\0" * 99,
        ", line 14: there are zero bytes, as after a crash or in a binary file; delete the lines that "
        "have them",
    ),
    "any binary file": (
        "a.csv",
        b"\x7fELF\x02\x01\x01\0",
        ": this is a binary file, not text; convert it to CSV first",
    ),
    "lines that end in CR": (
        "a.csv",
        CLEAN.replace("\n", "\r"),
        ": lines end in a carriage return alone; save the file with line feeds (\\n or \\r\\n)",
    ),
    "one CR within a line": (
        "a.csv",
        edited(4, "0.2,101322\r,21.5"),
        ", line 4: there is a carriage return within '0.2,101322\\r,21.5'; delete it",
    ),
    "cells separated by spaces": (
        "a.csv",
        CLEAN.replace(",", " "),
        ": the first line 'time_s pressure_pa temperature_c' has neither comma, semicolon nor tab; "
        "separate the "
        "cells of all lines by one of them",
    ),
    "too many cells in a row": (
        "a.csv",
        edited(4, "0.2,101322,21.5,7"),
        ", line 4: there are 4 fields where the header names 3: '0.2,101322,21.5,7'; complete or delete "
        "the line",
    ),
    "a half-written last line": (
        "a.csv",
        CLEAN + "1.2,1013",
        ", line 14: there are 2 fields where the header names 3: '1.2,1013'; complete or delete the line",
    ),
    "a quote that isn't closed": (
        "a.csv",
        edited(4, '0.2,"101322,21.5'),
        ", line 4: a quote isn't closed in '0.2,\"101322,21.5'; close or delete it",
    ),
    "comments before the header": (
        "a.csv",
        "# made by a logger\n" + CLEAN,
        ": the first line is a comment; delete what stands before the names of the columns",
    ),
    "a comment between rows": (
        "a.csv",
        edited(4, "# paused"),
        ", line 4: there are 1 fields where the header names 3: '# paused'; complete or delete the line",
    ),
    "a column twice": (
        "a.csv",
        "time_s,pressure_pa,pressure_pa\n0,1e5,1e5\n",
        ": the header names column 'pressure_pa' 2 times; keep one",
    ),
    "a quantity twice": (
        "a.csv",
        "time_s,pressure_pa,altitude_m\n0,1e5,100\n",
        ": the columns 'pressure_pa' and 'altitude_m' are the same quantity; rename one of them",
    ),
    "no time": (
        "a.csv",
        "stamp,pressure_pa\n0,1e5\n",
        ": there is no column 'time_s' among 'stamp', 'pressure_pa' in the first line; map it: time_s=NAME",
    ),
    "no pressure": (
        "a.csv",
        "time_s,baro\n0,1e5\n",
        ": there is no pressure (pressure_pa, pressure_hpa or altitude_m) among the columns 'time_s', "
        "'baro'; map "
        "one: pressure_pa=NAME",
    ),
    "an axis is missing": (
        "a.csv",
        "time_s,pressure_pa,acc_x_g,acc_y_g\n0,1e5,0,0\n",
        ": of 3 accel columns there are only 'acc_x_g', 'acc_y_g'; add the others",
    ),
    "an empty file": (
        "a.csv",
        "",
        ": the file is empty, or its first line is; line 1 must name the columns",
    ),
    "a header alone": (
        "a.csv",
        HEAD + "\n",
        ": there is a header but no row of data; record something first",
    ),
    "no header": (
        "a.csv",
        "0,101325\n1,101326\n",
        ": the first line holds numbers, '0', '101325'; put a line above it that names the columns",
    ),
    "text in a cell": (
        "a.csv",
        edited(4, "0.2,error,21.5"),
        ", line 4: pressure_pa is 'error', no number; correct it, or leave the cell empty where there is "
        "no sample",
    ),
    **{
        f"{cell} as a number": (
            "a.csv",
            edited(4, f"0.2,{cell},21.5"),
            f", line 4: pressure_pa is '{cell}', no number; correct it, or leave the cell empty where "
            f"there is no "
            "sample",
        )
        for cell in ("0x18BCD", "101_322", "1013.2.2", "１０１", "1e", "=101322", "101322 Pa")
    },
    **{
        f"{cell} as a number": (
            "a.csv",
            edited(4, f"0.2,{cell},21.5"),
            f", line 4: pressure_pa is {float(cell):g}, readable is above 0 to 1e+09; correct it, or "
            f"leave the cell "
            "empty where there is no sample",
        )
        for cell in ("1e400", "1e5000", "-1e400", "inf", "0", "1e300")
    },
    "a clock that was set": (
        "a.csv",
        edited(13, "1770000000,101325,21.5"),
        ", line 13: the time is 1770000000 s after 1 s: it jumps as if the clock was set; split the "
        "recording there",
    ),
    "a first line of 70 kB": (
        "a.csv",
        "time_s," + "a" * 70_000,
        ": the first line is longer than 65536 bytes; this is no table",
    ),
    "a line of 6 MB": (
        "a.csv",
        edited(4, "1," * 3_000_000),
        ", line 4: the line is longer than 1 MB; this is no table",
    ),
    "a .gz that is cut off": (
        "a.csv.gz",
        PACKED[:-30],
        ": the gzip data are cut off or damaged; copy the file again",
    ),
    "a .gz with a wrong check sum": (
        "a.csv.gz",
        CRC,
        ": the gzip data are cut off or damaged; copy the file again",
    ),
    "a .gz that is plain": (
        "a.csv.gz",
        CLEAN,
        ": this is not gzip; drop the .gz from its name if it is plain text",
    ),
    **{
        f"{what} named .csv": (
            "a.csv",
            content,
            f": this is no plain text but {what}; let its name end in {suffix}",
        )
        for what, content, suffix in (
            ("gzip", PACKED, ".csv.gz"),
            ("a zip archive", zipped(Barometer=PHONE), ".zip"),
            ("Parquet", b"PAR1\x15\4\x15", ".parquet"),
            ("a PX4 log", b"ULog\x01\x12\x35\x01", ".ulg"),
            ("an ArduPilot log", b"\xa3\x95\x80\x80", ".bin"),
            ("a ROS bag", b"\x89MCAP0\r\n", ".mcap"),
        )
    },
    "a zip in a .gz": (
        "a.csv.gz",
        gzip.compress(zipped(Barometer=PHONE)),
        ": what is packed in it is no plain text but a zip archive; let its name end in .zip",
    ),
    "CSV named .zip": (
        "a.zip",
        CLEAN,
        ": this is not a zip file, or it is damaged (File is not a zip file); copy the file again",
    ),
    "CSV named .parquet": (
        "a.parquet",
        CLEAN,
        ": this is not a Parquet file, or it is damaged; copy it again",
    ),
    "CSV named .ulg": (
        "a.ulg",
        CLEAN,
        ": this is not a ULog file, or it is damaged (Invalid file format (Failed to parse header)); "
        "copy the file "
        "again",
    ),
    "CSV named .bin": (
        "a.bin",
        CLEAN,
        ": this is not a dataflash log: it does not begin with A3 95; name another file",
    ),
    "a zip that is cut off": (
        "a.zip",
        zipped(Barometer=PHONE)[:-30],
        ": this is not a zip file, or it is damaged (File is not a zip file); copy the file again",
    ),
    "a zip that lies about sizes": (
        "a.zip",
        lying_zip(),
        ": this is not a zip file, or it is damaged (Bad CRC-32 for file 'Barometer.csv'); copy the file "
        "again",
    ),
    "a zip of something else": (
        "a.zip",
        zipped(Notes="a,b\n1,2\n"),
        ": this is a zip file without pressure from phyphox or Sensor Logger; export the barometer too, "
        "or name a CSV "
        "file in it and map its columns",
    ),
    "two exports in one zip": (
        "a.zip",
        zipped(one__Barometer=PHONE, two__Barometer=PHONE),
        ": there are two files 'Barometer.csv' in it; unpack it and name one export's folder",
    ),
    "a zip of 1001 files": (
        "a.zip",
        zipped(**{f"s{k}": "" for k in range(1001)}),
        ": 1001 CSV files are in it, more than a phone's export has",
    ),
    "a zip bomb": (
        "a.zip",
        zipped(Barometer="0" * 65_000_000),
        ": unpacked it would be more than 64 MB, more than an export's would; unpack the file and look at it",
    ),
    "a gzip bomb": (
        "a.csv.gz",
        gzip.compress(HEAD.encode() + b"\n" + (b"0,1," + b"0" * 9_995 + b"\n") * 6_500, 1),
        ": the gzip data grow to more than 64 MB, more than a log's would; unpack the file and look at it",
    ),
    "a Parquet bomb": (
        "a.parquet",
        parquet,
        ": 8100000 rows are more than a log of {size} bytes has; look at the file",
    ),
}
"""Fault -> name and content of the file, and the sentence after its path."""

READ = {
    "a UTF-8 byte order mark": ("a.csv", "\ufeff" + CLEAN),
    "lines that end in CR LF": ("a.csv", CLEAN.replace("\n", "\r\n")),
    "lines that end in CR CR LF": ("a.csv", CLEAN.replace("\n", "\r\r\n")),
    "semicolons": ("a.csv", CLEAN.replace(",", ";")),
    "tabs": ("a.csv", CLEAN.replace(",", "\t")),
    "semicolons and decimal commas": ("a.csv", CLEAN.replace(",", ";").replace(".", ",")),
    "tabs and decimal commas": ("a.csv", CLEAN.replace(",", "\t").replace(".", ",")),
    "quoted cells": ("a.csv", '"' + CLEAN[:-1].replace(",", '","').replace("\n", '"\n"') + '"\n'),
    "spaces around cells": ("a.csv", CLEAN.replace(",", " , ")),
    "empty lines": ("a.csv", CLEAN.replace("\n", "\n\n") + " \n\n"),
    "shuffled columns": (
        "a.csv",
        "\n".join(",".join(line.split(",")[::-1]) for line in [HEAD, *ROWS]) + "\n",
    ),
    "other columns, in Latin-1": (
        "a.csv",
        "".join(f"{line},{'Höhe' if k == 0 else '=1+1'}\n" for k, line in enumerate([HEAD, *ROWS])).encode(
            "latin-1"
        ),
    ),
    "capitals in the suffix": ("A.CSV.GZ", gzip.compress(CLEAN.encode())),
    "gzip in several pieces": (
        "a.csv.gz",
        gzip.compress(CLEAN[:50].encode()) + gzip.compress(CLEAN[50:].encode()),
    ),
}
"""What other programs write -> name and content; all of them read as the clean file does."""


@pytest.fixture
def put(tmp_path):
    """Write a file of the catalogue, and return its path."""

    def write(name, content):
        if callable(content):
            pytest.importorskip("pyarrow")
            content = content(8_100_000)
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


@pytest.fixture
def command(tmp_path, capfd):
    """Run a command on a file, and return code, stdout, stderr and the files that are there afterwards."""

    def run(name, path, out="out"):
        words = {"in": os.fspath(path), "out": os.fspath(tmp_path / out)}
        capfd.readouterr()
        code = main([part.format_map(words) for part in COMMANDS[name]])
        said = capfd.readouterr()
        return SimpleNamespace(code=code, out=said.out, err=said.err, files=sorted(os.listdir(tmp_path)))

    return run


def needs(name):
    modules = {".parquet": "pyarrow", ".ulg": "pyulog", ".bin": "pymavlink"}
    if module := modules.get(Path(name).suffix):
        pytest.importorskip(module)


@pytest.mark.parametrize("fault", REFUSED)
def test_a_broken_file_is_refused_in_one_sentence_and_nothing_is_written(put, command, fault):
    name, content, sentence = REFUSED[fault]
    needs(name)
    path = put(name, content)
    sentence = f"{path}{sentence}".replace("{size}", str(path.stat().st_size))
    for what in COMMANDS:
        done = command(what, path)
        assert (done.code, done.out, done.err, done.files) == (2, "", f"baroarma: {sentence}\n", [name]), what
    with pytest.raises(UnreadableError) as caught:
        ba.read(path)
    assert str(caught.value) == sentence


@pytest.mark.parametrize("style", READ)
def test_what_other_programs_write_reads_as_the_clean_file(put, command, style):
    path = put(*READ[style])
    clean, found = ba.read(put("clean.csv", CLEAN)), ba.read(path)
    for field in ("t", "pressure", "temperature"):
        np.testing.assert_array_equal(getattr(found, field), getattr(clean, field))
    assert found.notes == clean.notes
    assert command("convert", path, "o.csv").code == 0


def test_a_last_line_without_end_is_named(put, command):
    path = put("a.csv", CLEAN[:-1])
    said = "a.csv: the last line has no end; if the file was cut off, '1.1,101324,21.5' is cut off too."
    assert f"info (unended-line): {said}\n" in command("convert", path, "o.csv").err
    assert [note.message for note in ba.read(path).notes if note.code == "unended-line"] == [said]


# What is no file


def test_a_path_that_is_not_there_says_so(tmp_path, command):
    for name in ("none.csv", "none.csv.gz", "none.ulg", "none.zip", "none.parquet"):
        done = command("track", tmp_path / name)
        sentence = f"baroarma: {tmp_path / name}: there is no such file; check the name\n"
        assert (done.code, done.err) == (2, sentence)


def test_a_folder_that_is_no_export_says_so(tmp_path, command):
    (tmp_path / "logs").mkdir()
    done = command("identify", tmp_path / "logs")
    assert done.code == 2
    assert f"{tmp_path / 'logs'}: this is a folder without pressure from phyphox or Sensor Logger" in done.err


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="nothing is unreadable to root")
def test_a_file_without_permission_says_so(put, command):
    path = put("a.csv", CLEAN)
    path.chmod(0)
    done = command("track", path)
    sentence = f"baroarma: {path}: the file can't be opened (Permission denied); check its permissions\n"
    assert (done.code, done.err) == (2, sentence)


def test_a_file_that_cannot_be_opened_says_so(put, command, monkeypatch):
    path = put("a.csv", CLEAN)

    def denied(*args, **options):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(csv, "open", denied, raising=False)
    done = command("track", path)
    sentence = f"baroarma: {path}: the file can't be opened (Permission denied); check its permissions\n"
    assert (done.code, done.err) == (2, sentence)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="there are no such devices")
def test_devices_and_pipes_are_refused_before_they_are_opened(tmp_path, command):
    os.mkfifo(tmp_path / "pipe.csv")
    for path in ("/dev/null", "/dev/zero", tmp_path / "pipe.csv"):
        done = command("identify", path)
        said = f"{path}: this is a pipe or a device, not a file; write what it gives into a file first"
        assert (done.code, done.err) == (2, f"baroarma: {said}\n")


# Names


@pytest.mark.parametrize(
    "name", ["a\nb", "tür \U0001f6a9", "-x", "%s%n", "a b;c", "$(id)", "*.csv", b"\xff\xfe", "x" * 240]
)
def test_any_name_will_do(tmp_path, command, name):
    path = tmp_path / (os.fsdecode(name) + ".csv")
    path.write_text(CLEAN)
    done = command("convert", path, os.fsdecode(name) + ".out")
    assert done.code == 0
    assert len(done.files) == 2
    found = ba.read(path)
    found.name.encode()  # can be written anywhere
    (tmp_path / path.name).write_text("nonsense")
    done = command("identify", path)
    assert done.code == 2
    assert done.err.count("\n") == 1


def test_a_name_that_begins_with_a_dash_is_a_file_after_two_dashes(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("-x.csv").write_text(CLEAN)
    assert main(["convert", "--", "-x.csv", "-y.csv"]) == 0
    assert main(["convert", "-x.csv", "y.csv"]) == 2
    assert "No such option" in capsys.readouterr().err
    assert sorted(os.listdir()) == ["-x.csv", "-y.csv"]


def test_the_files_of_a_zip_cannot_leave_their_folder(tmp_path, command):
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("../" * 9 + f"{tmp_path}/Barometer.csv".lstrip("/"), PHONE + "1,1000.1\n2,1000.2\n")
        archive.writestr(f"{tmp_path}/Gyroscope.csv", "seconds_elapsed,x,y,z\n0,0,0,0\n2,0,0,0\n")
    found = ba.read(tmp_path / "a.zip")
    assert (len(found), found.gyro.shape) == (3, (3, 3))
    assert command("convert", tmp_path / "a.zip", "o.csv").files == ["a.zip", "o.csv"]


def test_cells_that_a_spreadsheet_would_compute_are_never_written(put, command, tmp_path):
    rows = "".join(f'{row},"=HYPERLINK(1)",@SUM(1)\n' for row in ROWS)
    path = put("a.csv", f"{HEAD},=cmd(),note\n{rows}")
    assert command("convert", path, "o.csv").code == 0
    text = (tmp_path / "o.csv").read_text()
    assert not set("=@|") & set(text)  # nothing but our own names and numbers


# How much is too much


def test_a_line_of_100_mb_takes_no_more_memory_than_a_block(put, monkeypatch):
    path = put("a.csv", b"time_s,pressure_pa\n0,1" + b"0" * 100_000_000)
    tracemalloc.start()
    with pytest.raises(UnreadableError, match="longer than 1 MB"):
        ba.read(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    path.unlink()
    assert peak < 4 * csv.BLOCK  # the block, the rest of the line, and their sum


def test_line_ends_alone_take_bounded_memory(put):
    path = put("a.csv", HEAD + "\n" * 20_000_000)
    tracemalloc.start()
    with pytest.raises(UnreadableError, match="a header but no row of data"):
        ba.read(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # A byte becomes seven integers of eight bytes (place, length, fields, returns, quotes ...) of one block;
    # of every block it stays where its empty lines are.
    assert peak < 60 * csv.BLOCK + 8 * 20_000_000 * 2


def test_a_log_may_grow_as_logs_do(put, monkeypatch):
    monkeypatch.setattr(errors, "FREE", 1000)
    constant = "".join(f"{k / 100},{101_325 + k % 3},21.5,0,0,0,0,0,0,ok\n" for k in range(20_000))
    packed = gzip.compress(f"{HEAD},a,b,c,d,e,f,note\n{constant}".encode(), 9)
    assert len(constant) > 10 * len(packed)
    assert len(ba.read(put("a.csv.gz", packed))) == 20_000


# The logs of others, cut off


@pytest.fixture
def seeds(monkeypatch):
    """Small healthy files of every kind."""
    monkeypatch.syspath_prepend(ROOT / "tests" / "fuzz")
    import fuzz_seeds

    return fuzz_seeds


@pytest.mark.parametrize("kind", ["ulg", "bin", "bag", "mcap", "db3", "zip", "parquet", "csv.gz"])
@pytest.mark.parametrize("share", [0.02, 0.5, 0.98])
def test_a_log_cut_off_is_read_as_far_as_it_goes_or_refused(seeds, put, command, kind, share):
    if kind not in seeds.available():
        pytest.skip(f"the library that reads {kind} is not installed")
    whole = seeds.seeds(kind)[0]
    path = put(f"a.{kind}", whole[: int(share * len(whole))])
    done = command("convert", path, "o.csv")
    assert done.code in (0, 2)
    assert done.files == ([path.name] if done.code else [path.name, "o.csv"])
    if done.code:
        assert done.err.startswith(f"baroarma: {path}: ")
        assert done.err.count("\n") == 1
    if kind in ("ulg", "bin") and share == 0.98:  # as when the battery is pulled
        assert done.code == 0


# The table in the docs


def rows_of_the_docs():
    for fault, (name, _, sentence) in REFUSED.items():
        shown = f"{name}{sentence}".replace("{size}", "1234")
        yield f"| {fault} | `{shown}` | `tests/faults/test_files.py` |".replace(
            "１０１", "fullwidth digits", 1
        )
    for style in READ:
        yield f"| {style} | nothing: read as if it were our own | `tests/faults/test_files.py` |"


def test_the_catalogue_in_the_docs_is_this_one():
    text = (ROOT / "docs" / "faults.md").read_text(encoding="utf-8")
    missing = [row for row in rows_of_the_docs() if row not in text]
    assert not missing, "docs/faults.md lacks:\n" + "\n".join(missing)
