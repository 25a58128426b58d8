"""Names: told, completed, and the nearest one to a wrong one."""

import pytest

from baroarma.cli import cli, main
from baroarma.cli.names import NAMES


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["trakc"], "Did you mean 'track'?"),
        (["track", "x.csv", "--preset", "sg14a"], "did you mean 'sg14-a'?"),
        (["compare", "x.csv", "--presets", "baroarma,lee-16"], "did you mean 'lee16'?"),
        (["predict", "--noise", "x.json", "--preset", "baroarm"], "did you mean 'baroarma'?"),
        (["export", "firmware", "--preset", "le16"], "did you mean 'lee16'?"),
        (["simulate", "squats", "--out", "x.csv"], "did you mean 'squat'?"),
        (["simulate", "lift", "--device", "GY-87", "--out", "x.csv"], "there are simple, wimu, gy-87"),
        (["experiment", "sg13-table1"], "did you mean 'sg13-table-1'?"),
        (["track", "x.csv", "--prest", "lee16"], "--preset"),
    ],
    ids=lambda value: "-".join(value) if isinstance(value, list) else None,
)
def test_a_misspelt_name_is_told_with_the_nearest_one(capsys, arguments, says):
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line


def test_no_near_name_is_no_guess(capsys):
    assert main(["track", "x.csv", "--preset", "quantum"]) == 2
    assert "did you mean" not in capsys.readouterr().err


@pytest.mark.parametrize("kind", sorted(NAMES))
def test_there_are_names_of_every_kind(kind):
    names = NAMES[kind]()
    assert len(set(names)) == len(names) > 1


def test_every_option_that_takes_a_value_says_what_it_takes():
    """No FLOAT or INTEGER RANGE: a letter of the unit, or what it is."""
    for name, command in cli.commands.items():
        for parameter in command.params:
            shown = parameter.make_metavar(command.make_context(name, [], resilient_parsing=True))
            assert not any(word in shown for word in ("FLOAT", "INTEGER", "TEXT", "PATH")), (name, shown)


@pytest.mark.parametrize("command", sorted(cli.commands))
def test_every_help_ends_with_an_example_that_can_be_parsed(command, capsys):
    import shlex

    example = shlex.split(cli.commands[command].epilog.partition("baroarma ")[2].rstrip(")"))
    assert example[0] == command
    context = cli.commands[command].make_context(command, example[1:])
    assert context.params
