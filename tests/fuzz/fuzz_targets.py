"""What is done with a broken input, and what must hold whatever it holds.

Every input goes through `baroarma.cli.main` as a user's file would.  Afterwards

* the exit code is 0, 1 or 2; unless it is 0, the last line on stderr is one sentence;
* nothing was raised, and there was no Python warning;
* there is no NaN or infinity in any file or on stdout;
* a failed run left no file, and no run a temporary one;
* it took less than `LONGEST` seconds, and less than `MOST_MEMORY` bytes more than any before.
"""

import io
import json
import os
import re
import resource
import shutil
import signal
import sys
import time
import traceback
import warnings
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from baroarma.cli import main

LONGEST = 5.0
"""Seconds of the processor; a healthy input takes 0.1 s at most."""
MOST_MEMORY = 200e6
"""Bytes; an input is no larger than 0.13 MB."""
MOST_SPACE = 2 << 30
"""Bytes of address space that the fuzzer may ask for once everything is imported."""
NOT_A_NUMBER = re.compile(rb"\b(nan|inf|infinity)\b", re.IGNORECASE)
PRESETS = "sg14-a,lee16,tanigawa08,baroarma"

COMMANDS = {
    "convert": ("convert", "{in}", "{out}/o.csv"),
    "identify": ("identify", "{in}", "--out", "{out}/noise.json", "--json"),
    "windows": ("identify", "{in}", "--method", "windows", "--json"),
    "track": ("track", "{in}", "--out", "{out}/t.csv"),
    "track --json": ("track", "{in}", "--preset", "sg14-b", "--json"),
    "compare": ("compare", "{in}", "--presets", PRESETS, "--json"),
    "calibrate": ("calibrate", "{in}", "--json"),
    "whiten": ("whiten", "{in}"),
    "whiten c": ("whiten", "{in}", "--rate", "50", "--format", "c", "--out", "{out}/w.h"),
    "track --noise": ("track", "{seed}", "--noise", "{in}", "--out", "{out}/t.csv"),
    "predict": ("predict", "--noise", "{in}", "--duration", "5", "--json"),
    "firmware": (
        "export",
        "firmware",
        "--noise",
        "{in}",
        "--preset",
        "baroarma",
        "--rate",
        "50",
        "--out",
        "{out}/fw",
    ),
    "compare --track": ("compare", "{seed}", "--presets", "sg14-a", "--track", "{in}", "--json"),
    "track -": ("track", "-"),
}
"""What is run, by the name it has in the counts."""

RECORDING = ("convert",) * 12 + ("identify", "windows", "track", "track --json", "compare", "calibrate")
SHARES = {
    "noise.json": ("whiten",) * 16 + ("whiten c", "whiten c", "track --noise", "predict", "firmware"),
    "rows": ("track -",),
    "track.csv": ("compare --track",),
}
"""Kind of input -> the commands it is given to, as often as they stand here; every other is a recording."""


class Broken(AssertionError):
    """An invariant does not hold."""


@dataclass(frozen=True)
class Outcome:
    """What a command did with an input."""

    command: str
    code: int
    out: str
    err: str
    seconds: float


def commands(kind):
    """Return the commands that a kind of input is given to."""
    return SHARES.get(kind, RECORDING)


def run(kind, command, data, folder, *, longest=LONGEST, most_memory=MOST_MEMORY):
    """Run a command on an input in an empty folder, which is empty afterwards, within time and memory.

    Raises
    ------
    Broken
        If an invariant does not hold; the message says which.
    """
    folder = Path(folder)
    (folder / "out").mkdir()
    try:
        (folder / f"in.{kind}").write_bytes(data)
        argv = [part.format_map(_Names(kind, folder)) for part in COMMANDS[command]]
        outcome = _guarded(command, argv, data, longest, most_memory)
        _check(outcome, folder)
    finally:
        for path in folder.iterdir():
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
    return outcome


class _Names(dict):
    def __init__(self, kind, folder):
        super().__init__({"in": folder / f"in.{kind}", "out": folder / "out"})
        self.folder = folder

    def __missing__(self, key):
        """Write a healthy recording when a command asks for it."""
        import fuzz_seeds

        path = self.folder / "seed.csv"
        path.write_bytes(fuzz_seeds.seeds("csv")[0])
        return path


def _guarded(command, argv, data, longest, most_memory):
    memory, start = _peak_memory(), time.process_time()
    out, err = io.StringIO(), io.StringIO()
    stdin = io.TextIOWrapper(io.BytesIO(data if argv[-1] == "-" else b""), encoding="utf-8")
    with warnings.catch_warnings(record=True) as warned, mock.patch.object(sys, "stdin", stdin):
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", ResourceWarning)  # Python doesn't show it: a library's forgotten file
        try:
            with redirect_stdout(out), redirect_stderr(err), _alarm(2 * longest):
                code = main(argv)
        except BaseException as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            raise Broken(f"raised {error!r:.200} at {where.filename}:{where.lineno}") from error
    seconds = time.process_time() - start
    if seconds > longest:
        raise Broken(f"took {seconds:.1f} s")
    if _peak_memory() - memory > most_memory:
        raise Broken(f"took {(_peak_memory() - memory) / 1e6:.0f} MB")
    for warning in warned:
        raise Broken(f"warned {warning.message!s:.200} at {warning.filename}:{warning.lineno}")
    return Outcome(command, code, out.getvalue(), err.getvalue(), seconds)


class TooLong(BaseException):
    """The time is up; no reader catches this."""


@contextmanager
def _alarm(seconds):
    """Interrupt what takes longer, of the processor's time: others may be busy, too."""

    def ring(number, frame):
        raise TooLong

    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def limit_memory():
    """Let the process have no more than `MOST_SPACE` bytes beyond what it has: a bomb must not hit others."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * os.sysconf("SC_PAGE_SIZE") + MOST_SPACE
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


def _check(outcome, folder):
    if outcome.code not in (0, 1, 2):
        raise Broken(f"exit code {outcome.code}")
    if "Traceback" in outcome.err or "Warning" in outcome.err:
        raise Broken(f"stderr says {outcome.err:.300}")
    if outcome.code and not re.search(r"(?:^|\n)baroarma: [^\n]{10,}\n$", outcome.err):
        raise Broken(f"exit code {outcome.code} without a sentence: {outcome.err[-300:]!r}")
    files = [path for path in (folder / "out").rglob("*") if path.is_file()]
    if outcome.code and files:
        raise Broken(f"exit code {outcome.code} and {files[0].name}")
    if any(path.name.startswith(".baroarma-") for path in folder.rglob("*")):
        raise Broken("a temporary file was left")
    for path in files:
        _check_numbers(path.name, path.read_bytes())
    _check_numbers("stdout of " + outcome.command, outcome.out.encode("utf-8", "replace"))


def _check_numbers(name, content):
    """Refuse what isn't a finite number: in JSON wherever a number stands, elsewhere anywhere."""
    if name.endswith((".c", ".h")):
        content = re.sub(rb"/\*.*?\*/|\"[^\"\n]*\"|\b(NAN|INFINITY)\b", b"", content, flags=re.DOTALL)
    if content.lstrip()[:1] in (b"{", b"["):
        json.loads(content, parse_constant=_refuse_constant)
    elif found := NOT_A_NUMBER.search(content):
        raise Broken(f"{name} has {content[max(0, found.start() - 60) : found.end() + 20]!r}")


def _refuse_constant(name):
    raise Broken(f"a JSON document has {name}")


def _peak_memory():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def quick_folder():
    """Return where small files are quick, or None for the usual place."""
    return "/dev/shm" if os.path.isdir("/dev/shm") and os.access("/dev/shm", os.W_OK) else None
