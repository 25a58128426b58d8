"""Loud, plain and quiet; and what comes next."""

import logging
import shlex

import pytest

from baroarma.cli import main
from baroarma.formats import write_csv
from baroarma.simulation import BMP085, simulate


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def squat(folder):
    write_csv(simulate("squat", duration=8, seed=1), "the squat.csv")
    BMP085.noise.save("noise.json")
    return "the squat.csv"


@pytest.mark.parametrize("where", ["before", "after"])
def test_quiet_leaves_the_result_alone(squat, capsys, where):
    arguments = ["track", squat, "--preset", "sg14-b"]
    assert main(arguments) == 0
    loud = capsys.readouterr()
    assert "warning (dc-gain)" in loud.err
    assert main(["--quiet", *arguments] if where == "before" else [*arguments, "--quiet"]) == 0
    assert capsys.readouterr() == (loud.out, "")


def test_quiet_still_tells_errors(capsys):
    assert main(["--quiet", "track", "none.csv"]) == 2
    assert "no such file" in capsys.readouterr().err


def test_verbose_says_what_is_read_and_decided_but_nothing_per_row(squat, capsys):
    assert main(["track", squat, "--verbose"]) == 0
    err = capsys.readouterr().err
    assert "baroarma.formats: read <Recording 'the squat': 400 rows" in err
    assert "aligned over the first 50 rows" in err
    assert "filterpy 2" in err
    assert err.count("\n") < 10


def test_verbose_is_over_when_the_command_is(squat, capsys):
    before = logging.getLogger("baroarma").level
    assert main(["--verbose", "track", squat, "--verbose"]) == 0
    assert capsys.readouterr().err.count("aligned over") == 1
    assert main(["track", squat]) == 0
    assert "aligned over" not in capsys.readouterr().err
    handlers = logging.getLogger("baroarma").handlers
    assert [type(handler) for handler in handlers] == [logging.NullHandler]
    assert logging.getLogger("baroarma").level == before


def test_a_program_hears_the_library_in_the_usual_way(squat, caplog):
    from baroarma import read

    with caplog.at_level(logging.INFO, logger="baroarma"):
        read(squat)
    assert [record.name for record in caplog.records] == ["baroarma.formats"]


def test_quiet_and_verbose_exclude_each_other(capsys):
    assert main(["--quiet", "demo", "--verbose"]) == 2
    assert "exclude each other" in capsys.readouterr().err.splitlines()[-1]


def next_of(capsys):
    """The words of the line that names the next command."""
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith("next: baroarma ")
    return shlex.split(line)[2:]


def test_each_command_names_the_next_one_until_the_height_is_known(capsys, folder):
    command = ["simulate", "rest", "--duration", "120", "--seed", "1", "--out", "my rest.csv"]
    walked = []
    while command[1] != "RECORDING.csv" and command[0] not in walked[:-1]:
        walked.append(command[0])
        assert main(command) == 0
        command = next_of(capsys)
    assert walked == ["simulate", "identify", "whiten"]
    assert command == ["track", "RECORDING.csv", "--noise", "noise.json", "--preset", "sg14-b"]
    assert (folder / "noise.json").exists()


def test_from_a_track_to_its_comparison_and_its_page(squat, capsys):
    assert main(["track", squat, "--noise", "noise.json", "--preset", "lee16"]) == 0
    command = next_of(capsys)
    assert command[:2] == ["compare", squat]
    assert main(command) == 0
    assert "lee16" in (out := capsys.readouterr()).out
    assert out.err.splitlines()[-1].endswith("--noise noise.json --report compare.html")


def test_the_next_command_reads_the_same_rows_by_the_same_names(squat, capsys):
    with open(squat, encoding="utf-8") as log, open("other.csv", "w", encoding="utf-8") as other:
        other.write(log.read().replace("pressure_pa", "Baro Press"))
    columns = ["--map", "pressure_pa=Baro Press", "--start", "0.5"]
    assert main(["track", "other.csv", *columns, "--noise", "noise.json"]) == 0
    command = next_of(capsys)
    assert command[:6] == ["compare", "other.csv", *columns]
    assert main(command) == 0


def test_a_programs_output_has_no_next_step(squat, capsys):
    assert main(["track", squat, "--json"]) == 0
    assert "next:" not in capsys.readouterr().err
