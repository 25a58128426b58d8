"""Disks that are full, Ctrl-C, a kill, two processes at once: a file is complete or not there."""

import errno
import json
import os
import re
import resource
import signal
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from baroarma.cli import main
from baroarma.simulation import simulate

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals and limits are POSIX's")

SLOW = """
import pathlib, sys, time

def stop(self, target):
    print("at work", file=sys.stderr, flush=True)
    time.sleep(60)

pathlib.Path.replace = stop  # the last step of every output: all is written, nothing is in its place
from baroarma.cli import main
sys.exit(main(sys.argv[1:]))
"""
PROGRAM = [sys.executable, "-c", "\n".join(["import sys", *SLOW.splitlines()[-2:]])]
WRITERS = {
    "identify": ["identify", "rest.csv", "--out", "out"],
    "track": ["track", "rest.csv", "--out", "out"],
    "convert": ["convert", "rest.csv", "out"],
    "experiment": ["experiment", "sg13-figure-5", "--trials", "1", "--jobs", "1", "--report", "out"],
}


@pytest.fixture(scope="module")
def rest():
    return simulate("rest", duration=30, seed=1)


@pytest.fixture
def folder(tmp_path, rest, monkeypatch):
    """Work in a folder with a recording and an older result."""
    from baroarma.formats import write_csv

    monkeypatch.chdir(tmp_path)
    write_csv(rest, "rest.csv")
    Path("out").write_text("precious")
    return tmp_path


def stopped_at_work(name, number):
    """Start a command, and send it a signal just before its output would be in place."""
    program = [sys.executable, "-c", SLOW, *WRITERS[name]]
    process = subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    said = ""
    for line in process.stderr:
        said += line
        if "at work" in line:
            process.send_signal(number)
            break
    said += process.communicate(timeout=180)[1]
    return process.returncode, said


@pytest.mark.parametrize("name", WRITERS)
def test_ctrl_c_leaves_the_older_file_and_nothing_else(folder, name):
    code, said = stopped_at_work(name, signal.SIGINT)
    assert code == 130
    assert re.fullmatch(r"\n?baroarma: interrupted; [^\n]+\n", said.rpartition("at work\n")[2])
    assert "Traceback" not in said
    assert sorted(os.listdir()) == ["out", "rest.csv"]
    assert Path("out").read_text() == "precious"


def test_a_killed_process_leaves_the_older_file_and_a_temporary_one_with_our_name(folder):
    code, _ = stopped_at_work("convert", signal.SIGKILL)
    assert code == -signal.SIGKILL
    left = set(os.listdir()) - {"out", "rest.csv"}
    assert [bool(re.fullmatch(r"\.baroarma-\d+-\d+\.tmp", name)) for name in left] == [True]
    assert Path("out").read_text() == "precious"
    assert main(["convert", "rest.csv", "out"]) == 0  # what was left is in nobody's way
    assert Path("out").read_text().startswith("time_s,")


@pytest.mark.parametrize(
    ("name", "reason"),
    [*((name, errno.ENOSPC) for name in WRITERS), ("convert", errno.EDQUOT), ("convert", errno.EIO)],
)
def test_a_full_disk_is_told_in_a_sentence_and_leaves_the_older_file(
    folder, name, reason, monkeypatch, capsys
):
    def full(self, target):
        raise OSError(reason, os.strerror(reason), os.fspath(self))

    monkeypatch.setattr(Path, "replace", full)
    assert main(WRITERS[name]) == 2
    said = f"out: the file can't be written ({os.strerror(reason)}); make room, or write elsewhere"
    assert capsys.readouterr().err.splitlines()[-1] == f"baroarma: {said}"
    assert sorted(os.listdir()) == ["out", "rest.csv"]
    assert Path("out").read_text() == "precious"


@pytest.mark.parametrize("suffix", ["", ".csv.gz", ".parquet"])
def test_a_file_that_grows_too_large_leaves_nothing(folder, suffix):
    if suffix == ".parquet":
        pytest.importorskip("pyarrow")

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))

    done = subprocess.run(
        [*PROGRAM, "convert", "rest.csv", f"new{suffix}"],
        preexec_fn=limit,
        capture_output=True,
        text=True,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},  # whose cache the limit would break, too
    )
    assert done.returncode == 2
    assert f"baroarma: new{suffix}: the file can't be written (File too large); make room" in done.stderr
    assert done.stderr.count("\n") == 1
    assert sorted(os.listdir()) == ["out", "rest.csv"]


def test_a_device_gets_what_is_written_and_stays_a_device(folder, capsys):
    try:
        os.mknod("full", stat.S_IFCHR | 0o666, os.makedev(1, 7))
    except PermissionError:
        pytest.skip("only root can make a device")
    assert main(["convert", "rest.csv", "full"]) == 2
    said = "full: the file can't be written (No space left on device); make room, or write elsewhere"
    assert capsys.readouterr().err.endswith(f"baroarma: {said}\n")
    assert stat.S_ISCHR(os.stat("full").st_mode)


def test_a_pipe_gets_what_is_written(folder):
    os.mkfifo("pipe")
    got = []
    reader = threading.Thread(target=lambda: got.append(Path("pipe").read_text()))
    reader.start()
    assert main(["convert", "rest.csv", "pipe"]) == 0
    reader.join(timeout=10)
    assert main(["convert", "rest.csv", "out"]) == 0
    assert got == [Path("out").read_text()]
    assert stat.S_ISFIFO(os.stat("pipe").st_mode)


def test_two_processes_with_one_output_leave_one_whole_file(folder):
    starts = [["convert", "rest.csv", "out"], ["identify", "rest.csv", "--out", "out"]]
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    running = [subprocess.Popen([*PROGRAM, *start], **silent) for start in starts]
    assert [process.wait(timeout=180) for process in running] == [0, 0]
    text = Path("out").read_text()
    if text.startswith("{"):
        assert json.loads(text)["format"] == "baroarma.noise-model"
    else:
        assert text.count("\n") == Path("rest.csv").read_text().count("\n")
    assert sorted(os.listdir()) == ["out", "rest.csv"]


def test_two_processes_on_a_new_cache_of_compiled_code_agree(tmp_path):
    code = (
        "import numpy as np\nfrom baroarma.kernels import gauss_markov as f\n"
        "print(f(np.ones(9), np.full(9, 0.1)).sum(), sum(f.stats.cache_hits.values()))"
    )
    program, surroundings = [sys.executable, "-c", code], {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    running = [
        subprocess.Popen(program, env=surroundings, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    said = [process.communicate(timeout=180) for process in running]
    assert [err for _, err in said] == ["", ""]
    values = {out.split()[0] for out, _ in said}
    assert len(values) == 1
    again = subprocess.run(program, env=surroundings, capture_output=True, text=True, timeout=180)
    assert again.stdout.split() == [*values, "1"]  # and the third takes it from the cache
