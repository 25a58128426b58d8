"""Completion by Tab, as click's scripts ask for it."""

import json
import os
import shutil
import subprocess

import click
import pytest
from click.shell_completion import get_completion_class

from baroarma.cli import cli, main
from baroarma.presets import PRESETS


def completed(*words):
    """What Tab offers for the last word: values, and "file" where the shell is to list files."""
    kind = get_completion_class("bash")(cli, {}, "baroarma", "_BAROARMA_COMPLETE")
    items = kind.get_completions(list(words[:-1]), words[-1])
    return [item.value if item.type == "plain" else item.type for item in items]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["wh"], ["whiten"]),
        (["track", "--preset", "sg"], ["sg14-a", "sg14-b"]),
        (["track", "--height", "k"], ["kalman"]),
        (["compare", "x.csv", "--presets", "baroarma,lee16-"], ["baroarma,lee16-kf"]),
        (["simulate", "st"], ["stairs"]),
        (["simulate", "lift", "--device", "g"], ["gy-87"]),
        (["experiment", "lee"], ["lee16-table-2"]),
        (["whiten", "n.json", "--format", "c"], ["csv", "c", "cmsis"]),
        (["export", "f"], ["firmware"]),
        (["predict", "--imu", "wi"], ["wimu"]),
        (["predict", "--imu", "my"], ["file"]),
        (["track", "my"], ["file"]),
        (["track", "x.csv", "--noise", "n"], ["file"]),
        (["track", "x.csv", "--out", "t"], ["file"]),
        (["whiten", "n"], ["file"]),
        (["completion", ""], ["bash", "zsh", "fish"]),
    ],
    ids=lambda value: "-".join(value),
)
def test_tab_offers_what_fits(words, expected):
    assert completed(*words) == expected


def test_all_presets_are_offered():
    assert completed("track", "--preset", "") == list(PRESETS)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_is_printed_and_where_it_belongs_is_told(shell, capsys):
    if shell == "bash" and not shutil.which("bash"):
        pytest.skip("click asks bash for its version")
    assert main(["completion", shell]) == 0
    captured = capsys.readouterr()
    assert f"_BAROARMA_COMPLETE={shell}_complete" in captured.out
    assert captured.err.startswith(f"next: baroarma completion {shell} > ")
    assert main(["completion", shell, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["script"] + "\n" == captured.out


@pytest.mark.skipif(not shutil.which("bash"), reason="needs bash")
def test_bash_completes_a_preset(capsys, tmp_path):
    import sys

    program = tmp_path / "baroarma"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m baroarma "$@"\n')
    program.chmod(0o755)
    assert main(["completion", "bash"]) == 0
    asks = "COMP_WORDS=(baroarma track --preset le); COMP_CWORD=3; _baroarma_completion baroarma\n"
    script = capsys.readouterr().out + asks + 'echo "${COMPREPLY[@]}"\n'
    path = {"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(
        ["bash", "--norc", "-c", script], env=os.environ | path, capture_output=True, text=True, timeout=30
    )
    assert done.stdout.split() == ["lee16", "lee16-kf"]


def test_an_unknown_shell_is_refused(capsys):
    assert main(["completion", "tcsh"]) == 2
    assert "'tcsh' is not one of" in capsys.readouterr().err


def test_files_are_completed_wherever_they_are_asked_for():
    for name, command in cli.commands.items():
        for parameter in command.params:
            if parameter.name in ("noise_file", "files", "report"):
                assert isinstance(parameter.type, click.Path), (name, parameter.name)
