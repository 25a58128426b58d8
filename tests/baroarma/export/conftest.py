"""A C compiler for the tests, and what its programs make of a recording."""

import io
import shutil
import subprocess

import pandas as pd
import pytest

STRICT = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wdouble-promotion"]


@pytest.fixture(scope="session")
def gcc():
    """Compile files of a folder into a program; where there is no compiler the test is skipped."""
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc")

    def compile_to(folder, name, *options, sources=("*.c",)):
        files = [path for pattern in sources for path in sorted(folder.glob(pattern))]
        command = ["gcc", *STRICT, *options, *files, "-lm", "-o", folder / name]
        done = subprocess.run([*map(str, command)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return folder / name

    return compile_to


@pytest.fixture(scope="session")
def replay():
    """Feed a recording's CSV, a text, to a replay program and return the track's columns."""

    def track_of(program, csv):
        done = subprocess.run([program], input=csv, capture_output=True, text=True, check=True)
        return pd.read_csv(io.StringIO(done.stdout))

    return track_of
