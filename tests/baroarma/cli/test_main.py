"""The program: it answers at once, and every failure is one sentence and a documented exit code."""

import subprocess
import sys
import time

import click
import pytest

from baroarma import __version__
from baroarma.cli import cli, main
from baroarma.cli.common import OutputFile, write_text

HEAVY = ("scipy", "pandas", "statsmodels", "matplotlib", "numba", "filterpy", "rich")
PROGRAM = (sys.executable, "-c", "from baroarma.cli import entry_point; entry_point()")


def run(*arguments):
    return subprocess.run(arguments, capture_output=True, text=True, timeout=60)


def test_help_answers_in_less_than_a_third_of_a_second():
    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        done = run(*PROGRAM, "--help")
        seconds.append(time.perf_counter() - start)
        assert done.returncode == 0
        assert "identify" in done.stdout
    assert min(seconds) < 0.3


def loaded(names):
    """Which of the modules are there after importing the command line."""
    code = f"import sys, baroarma.cli; print(*[name for name in {names} if name in sys.modules])"
    return run(sys.executable, "-c", code).stdout.split()


def test_the_front_door_loads_nothing_heavy():
    assert loaded(HEAVY) == []


def test_the_front_door_does_not_even_load_numpy():
    assert loaded(("numpy",)) == []


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


def test_the_version_is_told(capsys):
    assert main(["--version"]) == 0
    assert __version__ in capsys.readouterr().out


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


def test_a_reader_that_goes_away_is_no_error():
    pipe = subprocess.Popen([*PROGRAM, "whiten", "--help"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    pipe.stdout.close()
    assert b"Traceback" not in pipe.stderr.read()
    pipe.stderr.close()
    assert pipe.wait() == 0


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
