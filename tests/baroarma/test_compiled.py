"""Compiled code and its cache: what was compiled in from another file counts as the function's own."""

import os
import subprocess
import sys

import numpy as np
import pytest

from baroarma.compiled import as_array, as_rows

INNER = """
from typing import NamedTuple
from baroarma.compiled import njit

LIMIT = 1.0

class Settings(NamedTuple):
    first: float
    second: float

@njit(cache=True)
def inner(x):
    return x + 1.0

@njit(cache=True, inline="always")
def inlined(x):
    return x + 0.1
"""
MIDDLE = """
from inner import inlined, inner
from baroarma.compiled import njit

@njit(cache=True)
def middle(x):
    return inner(inlined(x))
"""
OUTER = """
from inner import LIMIT, Settings
from middle import middle
from baroarma.compiled import njit

@njit(cache=True)
def outer(x):
    return LIMIT * middle(x) + 10.0 * Settings(2.0, 3.0).first

print(outer(1.0), sum(outer.stats.cache_hits.values()))
"""


@pytest.fixture
def said(tmp_path):
    """Run the outermost of three modules in a new process; return its value and the cache's hits."""

    def run():
        surroundings = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        surroundings.pop("NUMBA_DISABLE_JIT", None)
        given = {"env": surroundings, "cwd": tmp_path, "capture_output": True, "text": True, "timeout": 180}
        found = subprocess.run([sys.executable, "outer.py"], **given)
        assert found.stderr == ""
        value, hits = found.stdout.split()
        return float(value), int(hits)

    return run


def test_a_change_of_what_is_called_or_read_in_another_file_compiles_anew(tmp_path, said):
    inner = INNER
    for name, text in (("inner", INNER), ("middle", MIDDLE), ("outer", OUTER)):
        (tmp_path / f"{name}.py").write_text(text)
    assert said() == (22.1, 0)
    assert said() == (22.1, 1)  # nothing has changed
    changes = (
        ("x + 1.0", "x + 1.5", 22.6),
        ("x + 0.1", "x + 0.5", 23.0),
        ("LIMIT = 1.0", "LIMIT = 2.0", 26.0),
        ("first: float\n    second: float", "second: float\n    first: float", 36.0),
    )
    for before, after, value in changes:
        inner = inner.replace(before, after)
        (tmp_path / "inner.py").write_text(inner)
        assert said() == (value, 0)


def test_a_copy_to_compile_for_is_writeable_and_row_after_row():
    given = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    given.flags.writeable = False
    copy = as_array(given)
    assert copy.flags.c_contiguous
    assert copy.flags.writeable
    assert not np.shares_memory(copy, given)
    np.testing.assert_array_equal(copy, given)


def test_rows_to_compile_for_are_read_only_and_the_same_memory_where_that_can_be():
    given = np.arange(6.0)
    rows = as_rows(given, 3)
    assert rows.shape == (2, 3)
    assert np.shares_memory(rows, given)
    assert not rows.flags.writeable
    assert given.flags.writeable
    assert not np.shares_memory(as_rows(given[::2]), given)  # not row after row: a copy
