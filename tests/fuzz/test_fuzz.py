"""Some hundred broken inputs, always the same: the promises of `fuzz_targets` hold for each.

``make fuzz`` runs a hundred thousand, led by coverage; what it finds becomes a test where the fault was.
"""

import contextlib
import os
import subprocess
import sys
import warnings
from pathlib import Path

import fuzz_mutations
import fuzz_seeds
import fuzz_targets
import pytest

INPUTS = 40
"""Per kind; bags, which take 20 ms each to open, a quarter of it."""
PATIENT = {"longest": 300, "most_memory": 1e9}
"""What may be compiled on the way counts, too."""
SCRIPT = Path(__file__).with_name("fuzz.py")


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """A healthy track in every preset that is used, so that no compilation is timed."""
    folder = tmp_path_factory.mktemp("compiled")
    for command in ("compare", "track", "track --json"):
        fuzz_targets.run("csv", command, fuzz_seeds.seeds("csv")[0], folder, **PATIENT)


@pytest.mark.parametrize("kind", fuzz_seeds.MAKERS)
def test_no_input_breaks_a_promise(kind, tmp_path, compiled):
    if kind not in fuzz_seeds.available():
        pytest.skip(f"the library that reads {kind} is not installed")
    rng = fuzz_mutations.generator(f"gate {kind}")
    inputs = INPUTS // 4 if kind in ("bag", "mcap", "db3") else INPUTS
    codes = set()
    for data in fuzz_seeds.seeds(kind):
        codes.add(fuzz_targets.run(kind, fuzz_targets.commands(kind)[0], data, tmp_path, **PATIENT).code)
    assert 0 in codes  # what is broken was healthy
    for _ in range(inputs):
        command = rng.choice(fuzz_targets.commands(kind))
        codes.add(
            fuzz_targets.run(kind, command, fuzz_mutations.random_input(kind, rng), tmp_path, **PATIENT).code
        )
    assert {0, 2} <= codes <= {0, 1, 2}  # some survive and some are refused, or nothing was tried
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("out", "files", "code", "promise"),
    [
        ("time_s\nnan\n", {}, 0, "has b'time_s"),
        ('{"a": NaN}', {}, 0, "a JSON document has NaN"),
        ("", {"t.csv": "1,inf\n"}, 0, "t.csv has"),
        ("", {"t.csv": "1,2\n"}, 2, "exit code 2 and t.csv"),
        ("", {".baroarma-1-2.tmp": ""}, 0, "a temporary file was left"),
        ("", {}, 3, "exit code 3"),
    ],
)
def test_a_broken_promise_is_noticed(tmp_path, monkeypatch, out, files, code, promise):
    def broken(argv):
        sys.stdout.write(out)
        sys.stderr.write("baroarma: a sentence.\n")
        for name, text in files.items():
            (tmp_path / "out" / name).write_text(text)
        return code

    monkeypatch.setattr(fuzz_targets, "main", broken)
    with pytest.raises(fuzz_targets.Broken, match=promise):
        fuzz_targets.run("csv", "convert", b"", tmp_path)


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is known on Linux only")
@pytest.mark.parametrize(
    ("fault", "promise"),
    [
        ("raise KeyError('x')", "raised KeyError"),
        ("warnings.warn('odd')", "warned odd"),
        ("bytearray(b'1') * (300_000_000 + PEAK - CURRENT)", "took [23].. MB"),
        ("while True: pass", "raised TooLong"),
    ],
)
def test_an_exception_a_warning_memory_and_time_are_noticed(tmp_path, monkeypatch, fault, promise):
    def broken(argv):
        current = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        exec(fault, {"warnings": warnings, "PEAK": fuzz_targets._peak_memory(), "CURRENT": current})
        return 0

    monkeypatch.setattr(fuzz_targets, "main", broken)
    with pytest.raises(fuzz_targets.Broken, match=promise):
        fuzz_targets.run("csv", "convert", b"", tmp_path, longest=0.5 if "while" in fault else 30.0)


def test_the_same_seed_breaks_the_same(tmp_path):
    def first(seed):
        rng = fuzz_mutations.generator(seed)
        return [fuzz_mutations.random_input(kind, rng) for kind in ("csv", "csv.gz", "zip", "noise.json")]

    assert first(5) == first(5) != first(6)


def test_the_command_counts_what_it_ran_and_shows_an_input_again(tmp_path):
    options = [
        "--no-coverage",
        "--runs",
        "12",
        "--seed",
        "4",
        "--kinds",
        "csv,noise.json",
        "--out",
        str(tmp_path),
    ]
    done = subprocess.run([sys.executable, SCRIPT, *options], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    counts = (tmp_path / "counts.json").read_text()
    assert '"inputs": 12' in counts
    with contextlib.suppress(FileNotFoundError):
        assert (tmp_path / "failures.txt").read_text() == ""
    (tmp_path / "kept").write_bytes(b"\0\0time_s\n")
    again = [sys.executable, SCRIPT, "--again", str(tmp_path / "kept"), "--out", str(tmp_path)]
    done = subprocess.run(again, capture_output=True, text=True, timeout=120)
    assert "csv convert Outcome(command='convert', code=2" in done.stdout
