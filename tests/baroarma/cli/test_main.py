"""The program: it answers at once, and every failure is one sentence and a documented exit code."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import click
import numpy as np
import pytest

from baroarma import __version__
from baroarma.cli import cli, main
from baroarma.cli.common import OutputFile, write_text

HEAVY = ("numpy", "scipy", "pandas", "statsmodels", "matplotlib", "numba", "filterpy", "rich")
PROGRAM = (sys.executable, "-c", "from baroarma.cli import entry_point; entry_point()")


def run(*arguments):
    return subprocess.run(arguments, capture_output=True, text=True, timeout=60)


def loaded_by(*arguments):
    """Which of the heavy modules are there after a command; their imports are what start-up costs."""
    code = f"""
import sys
from baroarma.cli import main
assert main({list(arguments)}) == 0
print(*[name for name in {HEAVY} if name in sys.modules], file=sys.stderr)"""
    return run(sys.executable, "-c", code).stderr.splitlines()[-1].split()


@pytest.mark.parametrize("arguments", [("--help",), ("whiten", "--help"), ("--version",)], ids="-".join)
def test_help_and_version_load_nothing_heavy(arguments):
    assert loaded_by(*arguments) == []


def test_a_track_loads_no_tables_no_pictures_and_no_colours(tmp_path):
    log, track = str(tmp_path / "squat.csv"), str(tmp_path / "track.csv")
    assert main(["simulate", "squat", "--duration", "20", "--seed", "1", "--out", log, "--quiet"]) == 0
    assert loaded_by("track", log, "--out", track, "--quiet") == ["numpy", "scipy", "numba", "filterpy"]


@pytest.mark.parametrize("command", [(), *((name,) for name in sorted(cli.commands))])
@pytest.mark.parametrize("flag", ["-h", "--help"])
def test_every_command_explains_itself(capsys, command, flag):
    assert main([*command, flag]) == 0
    out = capsys.readouterr().out
    assert out.startswith(f"Usage: baroarma{' ' if command else ''}{' '.join(command)} ")


@pytest.mark.parametrize("command", sorted(cli.commands))
def test_every_option_has_a_sentence_and_every_command_json(command):
    options = [p for p in cli.commands[command].params if isinstance(p, click.Option)]
    assert all(option.help for option in options)
    assert "--json" in {name for option in options for name in option.opts}


PAGE = Path(__file__).resolve().parents[3] / "docs" / "command-line.md"


@pytest.mark.parametrize("command", sorted(cli.commands))
def test_the_page_has_every_option_of_every_command(command):
    page = PAGE.read_text(encoding="utf-8")
    shared, _, commands = page.partition("## Commands")
    section = re.search(rf"^### {command}$(.*?)(?=^### |\Z)", commands, re.MULTILINE | re.DOTALL).group(1)
    for parameter in cli.commands[command].params:
        for option in parameter.opts if isinstance(parameter, click.Option) else ():
            assert re.search(rf"`[^`]*{option}\b", section + shared), option


def test_the_version_is_told_with_those_it_rests_on(capsys):
    assert main(["--version"]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    assert line.startswith(
        f"baroarma {__version__} (Python {sys.version.split()[0]}, numpy {np.__version__}, "
    )
    assert re.search(r"scipy [\d.]+.*, numba [\d.]+.*, filterpy [\d.]+.*, statsmodels [\d.]+", line)


def test_commands_are_listed_as_one_needs_them(capsys):
    assert main(["--help"]) == 0
    out = capsys.readouterr().out
    assert out.index("  identify") < out.index("  whiten") < out.index("  track") < out.index("  demo")


@pytest.mark.parametrize(
    ("argv", "sentence"),
    [
        ([], "give a command"),
        (["guess"], "No such command 'guess'"),
        (["identify"], "Missing argument"),
        (["identify", "--guess", "x.csv"], "No such option"),
        (["identify", "x.csv", "--start", "soon"], "'soon'"),
        (["identify", "x.csv", "--map", "pressure_pa"], "COLUMN=NAME"),
    ],
)
def test_wrong_usage_is_one_sentence_and_exit_code_2(capsys, argv, sentence):
    if len(argv) > 1 and argv[0] == "identify" and "--map" in argv:
        argv = ["identify", "no-such-file.csv", *argv[2:]]
    assert main(argv) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("baroarma: ")
    assert captured.err.count("\n") == 1
    assert sentence in captured.err


def test_ctrl_c_is_exit_code_130_and_leaves_no_file(capsys, monkeypatch, tmp_path):
    def interrupt(*args, **options):
        raise KeyboardInterrupt

    assert main(["simulate", "rest", "--duration", "20", "--out", str(tmp_path / "rest.csv")]) == 0
    monkeypatch.setattr("baroarma.identification.identify", interrupt)
    out = tmp_path / "noise.json"
    assert main(["identify", str(tmp_path / "rest.csv"), "--out", str(out)]) == 130
    assert "interrupted" in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["rest.csv"]


ARMA = ("whiten", "--arma", "-0.86", "-0.52", "--interval", "0.1", "--rate", "50", "--quiet")


@pytest.mark.parametrize("arguments", [("whiten", "--help"), ("--version",), ARMA], ids="-".join)
def test_a_reader_that_goes_away_is_no_error(arguments):
    pipe = subprocess.Popen([*PROGRAM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    pipe.stdout.close()
    assert pipe.stderr.read() == b""
    pipe.stderr.close()
    assert pipe.wait() == 0


def test_a_track_that_is_read_by_half_is_no_error(tmp_path):
    log = tmp_path / "squat.csv"
    assert main(["simulate", "squat", "--duration", "60", "--seed", "1", "--out", str(log), "--quiet"]) == 0
    pipe = subprocess.Popen(
        [*PROGRAM, "track", str(log), "--quiet"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert pipe.stdout.readline().startswith(b"time_s")
    pipe.stdout.close()
    assert pipe.stderr.read() == b""
    pipe.stderr.close()
    assert pipe.wait() == 0


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="Linux has a disk that is always full")
@pytest.mark.parametrize("arguments", [("--version",), ARMA], ids="-".join)
def test_a_full_disk_behind_stdout_is_one_sentence_and_exit_code_2(arguments):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [*PROGRAM, *arguments], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60
        )
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith("baroarma: ")
    assert "No space left" in line


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
@pytest.mark.parametrize(
    ("number", "code", "says"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")],
    ids=["Ctrl-C", "kill"],
)
def test_a_command_that_is_stopped_says_so_and_leaves_no_file(tmp_path, number, code, says):
    out = tmp_path / "walk.csv"
    process = subprocess.Popen(
        [*PROGRAM, "simulate", "walk", "--duration", "3e4", "--verbose", "--out", str(out)],
        stderr=subprocess.PIPE,
        text=True,
    )
    first = process.stderr.readline()  # --verbose tells that it has begun
    assert "baroarma" in first
    while process.poll() is None:  # a library that is just being imported may swallow the first
        time.sleep(1)
        process.send_signal(number)
    rest = process.stderr.read()
    process.stderr.close()
    assert process.wait(60) == code
    assert f"baroarma: {says}; no file is half-written" in rest
    assert "Traceback" not in rest
    assert list(tmp_path.iterdir()) == []


def test_too_little_memory_is_one_sentence_and_exit_code_2(capsys, monkeypatch):
    def exhaust(*args, **options):
        raise MemoryError("Unable to allocate 9 TiB")

    monkeypatch.setattr("baroarma.simulation.simulate", exhaust)
    assert main(["simulate", "walk", "--out", "x.csv"]) == 2
    assert capsys.readouterr().err.startswith("baroarma: there is not enough memory; try less")


def test_a_file_is_written_complete_or_not_at_all(tmp_path):
    target = tmp_path / "whole.txt"
    target.write_text("old")
    with pytest.raises(UnicodeEncodeError):
        write_text(target, "half \ud800")
    assert target.read_text() == "old"
    write_text(target, "new")
    assert target.read_text() == "new"
    assert list(tmp_path.iterdir()) == [target]


def test_an_output_that_cannot_be_is_refused_before_the_work(tmp_path):
    (tmp_path / "file").touch()
    for bad, reason in [
        (tmp_path, "is a directory"),
        (tmp_path / "none" / "x.json", "there is no folder"),
        (tmp_path / "file" / "x.json", "there is no folder"),
    ]:
        with pytest.raises(click.BadParameter, match=reason):
            OutputFile().convert(str(bad), None, None)
    assert OutputFile().convert(str(tmp_path / "file"), None, None) == str(tmp_path / "file")
