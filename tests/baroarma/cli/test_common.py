"""What the commands share."""

import numba
import pytest
from numba.core import event

from baroarma.cli.common import announce_compiling


def start_anew():
    event.unregister("numba:compile", announce_compiling())
    announce_compiling.cache_clear()


@pytest.fixture
def announced(capsys):
    """Start anew, as a new process does; give a function that returns what was said since."""
    start_anew()
    announce_compiling()
    announce_compiling()  # another command of the same process
    capsys.readouterr()
    return lambda: capsys.readouterr().err


def test_compiling_is_said_once_on_stderr(announced):
    numba.njit(lambda x: x + 1)(1.0)
    numba.njit(lambda x: x + 2)(1.0)
    said = announced()
    assert said.count("\n") == 1
    assert "compiling for this machine, once" in said


def test_what_is_compiled_already_is_not_worth_a_word(announced):
    add = numba.njit(lambda x: x + 3)
    add(1.0)
    announced()
    start_anew()
    announce_compiling()
    assert add(2.0) == 5.0
    assert announced() == ""
