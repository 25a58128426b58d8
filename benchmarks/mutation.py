"""Change the core in one place at a time and count the changes that no test notices.

A *mutant* is a module with one small change: `+` for `-`, `<` for `<=`, 2 for 1, an argument left out,
None for a value.  Run a module's own tests on each of them: a mutant they fail on is *killed*; one they pass
on has *survived* and is either a missing test or a change that changes nothing (an *explained* one, listed
with its reason in `mutation_explained.toml`).  The score is killed / (mutants - explained).

The changes themselves are mutmut's.  What is ours is running them: its trampolines leave out every decorated
function (all properties, all compiled kernels) and take a file's path for its import name, which the folders
`identification/` and `estimators/` don't obey.  So here no file is touched.  One process imports everything
and collects the tests; for each mutant it forks, gives the one function its changed code and runs the tests
that call this function, fastest first.  What runs at import (constants, defaults, a dataclass's fields) is
imported afresh from the changed text instead.  Compiled kernels run as plain Python (NUMBA_DISABLE_JIT=1).

    python benchmarks/mutation.py                          # every module of the core
    python benchmarks/mutation.py baroarma/rotation.py     # one
    python benchmarks/mutation.py --again                  # those that survived, after a test was added
    python benchmarks/mutation.py --table                  # what has been measured, as in docs/mutation.md
"""

from __future__ import annotations

import argparse
import contextlib
import doctest
import functools
import gc
import importlib
import importlib.abc
import importlib.util
import itertools
import json
import os
import re
import resource
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "build" / "mutation"
EXPLAINED = Path(__file__).with_name("mutation_explained.toml")

# The module, and which tests beside its own (the mirrored file) are about what it does.
CORE: dict[str, tuple[str, ...]] = {
    "baroarma/arma.py": (),
    "baroarma/atmosphere.py": (),
    "baroarma/climbed.py": (),
    "baroarma/climbing.py": (),
    "baroarma/filter_rows.py": (),
    "baroarma/finding.py": (),
    "baroarma/local_gravity.py": (),
    "baroarma/metrics.py": (),
    "baroarma/noise_file.py": ("tests/baroarma/test_noise_model.py",),
    "baroarma/noise_model.py": ("tests/baroarma/test_whitening.py", "tests/baroarma/test_noise_file.py"),
    "baroarma/read_only.py": (),
    "baroarma/recording.py": (),
    "baroarma/rotation.py": (),
    "baroarma/sensor_table.py": (),
    "baroarma/track.py": (),
    "baroarma/turning_points.py": ("tests/baroarma/test_climbing.py",),
    "baroarma/whitening.py": (),
    "estimators/colouring.py": (),
    "estimators/conditioning.py": (),
    "estimators/stillness.py": (),
    "estimators/strapdown.py": (),
    "estimators/height/complementary_kernel.py": ("tests/estimators/height/test_complementary.py",),
    "estimators/height/drive.py": (),
    "estimators/height/kalman.py": (),
    "estimators/height/kernels.py": (
        "tests/estimators/height/test_coloured_kalman.py",
        "tests/estimators/height/test_kalman.py",
        "tests/estimators/height/test_linear.py",
    ),
    "estimators/height/linear.py": (
        "tests/estimators/height/test_coloured_kalman.py",
        "tests/estimators/height/test_kalman.py",
    ),
    "identification/arma_kernels.py": (),
    "identification/bound.py": (),
    "identification/kernels.py": (),
    "identification/structural.py": (),
    "identification/windows.py": (),
}

DONE_BY_KERNELS = ("estimators/height/linear.py",)

# What takes more than ten seconds without numba: an hour for every few mutants that live.
SLOW_AS_PYTHON = (
    "tests/estimators/height/test_coloured_kalman.py::test_in_pure_gauss_markov_noise_the_differenced_filter_knows_its_error_too",
    "tests/estimators/height/test_coloured_kalman.py::test_in_sg13_noise_only_the_augmented_filter_knows_its_error",
    "tests/estimators/height/test_coloured_kalman.py::test_what_it_reports_is_what_linear_trials_of_its_own_model_have",
    "tests/estimators/height/test_linear.py::test_a_run_of_many_rows_is_fast_and_quiet",
    "tests/estimators/height/test_linear.py::test_smoothed_errors_have_the_smoothed_sd",
    "tests/identification/test_arma_kernels.py::test_cancelling_pole_and_zero_do_not_hide_the_highest_maximum",
    "tests/identification/test_arma_kernels.py::test_the_maximum_is_that_of_statsmodels",
)

STRICT = re.compile(r",\s*(strict=\w+)?(?=\))")
"""The end of a call of `zip` that asserts equal lengths."""
Row = dict[str, Any]
KILLED, SURVIVED, SLOW = "killed", "survived", "slow"


@dataclass(frozen=True)
class Mutant:
    """One change: the outermost function it is in ("" at the module's own level), the changed line, and the
    whole changed text."""

    function: str
    line: int
    was: str
    became: str
    text: str

    def row(self) -> Row:
        """Return what is kept of it."""
        return {"line": self.line, "function": self.function, "was": self.was, "became": self.became}

    @property
    def key(self) -> tuple[str, str, str]:
        """What tells it from others."""
        return key_of(self.row())


# -- which mutants there are ------------------------------------------


def mutants(path: Path) -> list[Mutant]:
    """Make every mutant of a file."""
    import libcst as cst

    source = path.read_text(encoding="utf-8")
    module = cst.parse_module(source)
    found = [_mutant(module, source, *change) for change in _changes(module, _Place())]
    return [mutant for mutant in found if STRICT.sub("", mutant.was) != STRICT.sub("", mutant.became)]


@dataclass(frozen=True)
class _Place:
    """Where in the file we are: the qualified name so far, the function, and whether text here is wording."""

    names: tuple[str, ...] = ()
    function: str = ""
    wording: bool = False


def _changes(node, place: _Place):
    """Yield places, nodes and what they become; no types, docstrings, assertions, words of messages."""
    import libcst as cst
    from mutmut.mutation.mutators import mutation_operators, operator_string

    skipped = cst.Annotation | cst.Import | cst.ImportFrom | cst.Decorator | cst.Assert
    if isinstance(node, skipped) or _is_a_type(node) or _is_a_decorator(node):
        return
    if isinstance(node, cst.FormattedString | cst.Raise | cst.ConcatenatedString) or _warns(node):
        place = replace(place, wording=True)
    for kind, operator in mutation_operators:
        if isinstance(node, kind) and not (operator is operator_string and place.wording):
            changed = list(operator(node))
            for new in changed[:1] if operator is operator_string else changed:
                yield place, node, new
    for child in node.children:
        yield from _changes(child, _within(place, node, child))


def _within(place: _Place, node, child) -> _Place:
    """Return the place of a node's child: a function is named with its body, and it is the outermost one."""
    import libcst as cst

    if not isinstance(node, cst.FunctionDef | cst.ClassDef) or place.function:
        return place
    names = (*place.names, node.name.value)
    body = isinstance(node, cst.FunctionDef) and child is node.body
    return replace(place, names=names, function=".".join(names) if body else "")


def _is_a_type(node) -> bool:
    """Say whether this is another name of a type, `Signal = NDArray[...]`: only the type checker reads it."""
    import libcst.matchers as m

    generic = m.OneOf(*map(m.Name, ("Callable", "Literal", "NDArray", "dict", "tuple")))
    return m.matches(node, m.Assign(value=m.Subscript(value=generic)))


def _is_a_decorator(node) -> bool:
    """Say whether this is a decorator with a name, `_inlined = njit(...)`: the options of a compiler."""
    import libcst.matchers as m

    return m.matches(node, m.Assign(value=m.Call(func=m.Name("njit"))))


def _warns(node) -> bool:
    import libcst.matchers as m

    return m.matches(node, m.Call(func=m.Attribute(attr=m.Name("warn"))))


def _mutant(module, source: str, place: _Place, node, new) -> Mutant:
    text = module.deep_replace(node, new).code
    was, became = source.splitlines(), text.splitlines()
    first = _alike(was, became)
    last = min(_alike(was[::-1], became[::-1]), len(was) - first - 1, len(became) - first - 1)

    def changed(lines: list[str]) -> str:
        return " ".join(line.strip() for line in lines[first : len(lines) - last])

    return Mutant(place.function, first + 1, changed(was), changed(became), text)


def _alike(one: list[str], other: list[str]) -> int:
    """Return how many lines are alike from the start."""
    return sum(1 for _ in itertools.takewhile(lambda pair: pair[0] == pair[1], zip(one, other, strict=False)))


# -- running the tests on one -----------------------------------------


def in_a_fork(action: Callable[[], object], cpu_seconds: float) -> tuple[str, object]:
    """Run `action` in a copy of this process and say how it ended, and what it returned as JSON."""
    read, write = os.pipe()
    pid = os.fork()
    if pid == 0:
        code = 1
        with contextlib.suppress(BaseException):
            os.close(read)
            _be_quiet(cpu_seconds)
            answer = json.dumps(action())
            with os.fdopen(write, "w") as pipe:
                pipe.write(answer)
            code = 0
        os._exit(code)
    os.close(write)
    with os.fdopen(read) as pipe:
        answer = pipe.read()
    status = os.waitpid(pid, 0)[1]
    if os.WIFSIGNALED(status):
        slow = os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL, signal.SIGALRM)
        return (SLOW if slow else KILLED), None
    return (SURVIVED, json.loads(answer)) if answer else (KILLED, None)


def _be_quiet(cpu_seconds: float) -> None:
    """Say nothing, and end when the processor's or the clock's time is over (the machine may be busy)."""
    gc.disable()  # so that a fork copies little
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    limit = int(cpu_seconds) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))
    signal.alarm(20 * limit)


class Killed(Exception):
    """A test failed."""


class Session:
    """Where pytest would run the collected tests, run them on each mutant instead."""

    def __init__(self, path: Path, name: str, todo: list[Mutant], tell: Callable[[Mutant, str], None]):
        self.path, self.name, self.todo, self.tell = path, name, todo, tell

    def pytest_runtestloop(self, session) -> bool:
        """Find out which test calls which function, then fork once per mutant."""
        importlib.import_module(self.name)  # a lazy front door may not have done so
        forget_caches()
        ended, calls = in_a_fork(lambda: self._calls(session.items), 3600)
        if ended is not SURVIVED:
            raise SystemExit(f"the tests of {self.path} fail without any change, or take too long")
        living = functions_of(self.path)
        source = self.path.read_text(encoding="utf-8")
        if in_a_fork(lambda: self._try(source, living, session.items), 3600)[0] is not SURVIVED:
            raise SystemExit(f"the tests of {self.path} fail on its own functions, exchanged for themselves")
        gc.freeze()  # what a fork never writes to need not be copied
        while self.todo:
            mutant = self.todo.pop(0)
            items = [item for item in session.items if mutant.function in calls[item.nodeid][1]]
            items.sort(key=lambda item: calls[item.nodeid][0])
            budget = 5.0 + 4.0 * sum(calls[item.nodeid][0] for item in items)
            changed = {mutant.function: living[mutant.function]}
            ended, _ = in_a_fork(functools.partial(self._try, mutant.text, changed, items), budget)
            self.tell(mutant, ended)
        return True

    def _calls(self, items) -> dict[str, tuple[float, list[str]]]:
        """Time each test and note the outermost functions of the module that it calls."""
        found = {}
        for item in items:
            called: set[str] = set()
            start = time.process_time()
            with _noting(str(self.path), called):
                run_test(item)
            found[item.nodeid] = time.process_time() - start, sorted(called)
        run_doctests(self.name)
        return found

    def _try(self, text: str, living: dict[str, list[FunctionType]], items) -> bool:
        program = compile(text, str(self.path), "exec")
        for functions in living.values():
            for function in functions:
                function.__code__ = code_of(program, function.__code__.co_qualname)
        for item in items:
            run_test(item)
        run_doctests(self.name)
        return True


@contextlib.contextmanager
def _noting(filename: str, called: set[str]) -> Iterator[None]:
    def note(frame, event, _argument) -> None:
        if event == "call" and frame.f_code.co_filename == filename:
            called.add(frame.f_code.co_qualname.split(".<locals>")[0])

    sys.setprofile(note)
    try:
        yield
    finally:
        sys.setprofile(None)


def run_test(item) -> None:
    """Run one collected test, setup to teardown."""
    from _pytest.runner import runtestprotocol

    if any(report.failed for report in runtestprotocol(item, nextitem=None, log=False)):
        raise Killed(item.nodeid)


def run_doctests(name: str) -> None:
    """Run the examples in the module's docstrings."""
    if doctest.testmod(importlib.import_module(name), optionflags=doctest.ELLIPSIS).failed:
        raise Killed(name)


def forget_caches() -> None:
    """Forget what cached functions returned while the tests were imported."""
    for thing in gc.get_objects():
        if isinstance(thing, functools._lru_cache_wrapper) and thing.__module__.startswith("baroarma"):
            thing.cache_clear()


def functions_of(path: Path) -> dict[str, list[FunctionType]]:
    """Return a file's functions by the outermost one's name, wherever they are kept (class, property, cache).

    What a function returned while all was imported, as the likelihoods of `identification.kernels`, is among
    them: it would not follow its maker's changed code.
    """
    found: dict[str, list[FunctionType]] = {}
    for thing in gc.get_objects():
        if isinstance(thing, FunctionType) and thing.__code__.co_filename == str(path):
            name = thing.__code__.co_qualname
            if "<lambda>" not in name:
                found.setdefault(name.split(".<locals>")[0], []).append(thing)
    return found


def code_of(program: CodeType, qualified_name: str) -> CodeType:
    inner = [constant for constant in program.co_consts if isinstance(constant, CodeType)]
    for code in inner:
        if code.co_qualname == qualified_name:
            return code
        if qualified_name.startswith(f"{code.co_qualname}."):
            return code_of(code, qualified_name)
    raise LookupError(qualified_name)


class FromText(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Import one module from a changed text; everything else as always."""

    def __init__(self, name: str, path: Path, text: str):
        self.name, self.path, self.text = name, path, text

    def find_spec(self, fullname, path=None, target=None):
        """Answer for the one module only."""
        if fullname != self.name:
            return None
        return importlib.util.spec_from_file_location(fullname, self.path, loader=self)

    def exec_module(self, module: ModuleType) -> None:
        """Run the changed text as the module's."""
        exec(compile(self.text, str(self.path), "exec"), module.__dict__)


def run_afresh(name: str, path: Path, text: str, options: list[str]) -> bool:
    """Import the changed module, then collect and run its tests."""
    import pytest

    sys.meta_path.insert(0, FromText(name, path, text))
    if pytest.main(["-x", *options]):
        raise Killed(name)
    run_doctests(name)
    return True


# -- a module, and all of them ----------------------------------------


def import_name(module: str) -> str:
    """Return the import name of a file: the rooms are inside the package."""
    dotted = module.removesuffix(".py").replace("/", ".")
    return dotted if dotted.startswith("baroarma.") else f"baroarma.{dotted}"


def tests_of(module: str) -> list[str]:
    """Return the mirrored test file, if there is one, and the others named in CORE."""
    folder, _, file = module.rpartition("/")
    own = f"tests/{folder}/test_{file}"
    return [own] * (ROOT / own).exists() + list(CORE.get(module, ()))


def measure(module: str, again: bool) -> None:
    """Try every mutant of one module, or those that lived the last time, and write what became of each."""
    import pytest

    path, name = ROOT / module, import_name(module)
    options = ["-q", "-s", "-p", "no:cacheprovider", "--rootdir", str(ROOT), "-m", "not slow"]
    options += tests_of(module)
    options += [f"--deselect={test}" for test in SLOW_AS_PYTHON] * compiled(module)
    rows: list[Row] = []

    def tell(mutant: Mutant, ended: str) -> None:
        rows.append(mutant.row() | {"ended": ended})
        if ended == SURVIVED:
            where = f"  {module}:{mutant.line} {mutant.function}"
            print(f"{where}\n    - {mutant.was}\n    + {mutant.became}", flush=True)

    killed = killed_before(module) if again else {}
    todo = []
    for mutant in mutants(path):
        if mutant.key in killed:
            tell(mutant, killed[mutant.key])
        else:
            todo.append(mutant)
    _import_the_heavy_guests()
    unchanged = functools.partial(run_afresh, name, path, path.read_text(encoding="utf-8"), options)
    if in_a_fork(unchanged, 3600)[0] is not SURVIVED:
        raise SystemExit(f"the tests of {module} fail without any change")
    budget = 30.0 + 4.0 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    for mutant in (m for m in todo if not m.function):
        tell(mutant, in_a_fork(functools.partial(run_afresh, name, path, mutant.text, options), budget)[0])
    session = Session(path, name, [m for m in todo if m.function], tell)
    if pytest.main(options, plugins=[session]) or session.todo:
        raise SystemExit(f"{len(session.todo)} mutants of {module} were not tried")
    results_of(module).parent.mkdir(parents=True, exist_ok=True)
    unfinished = results_of(module).with_suffix(".part")
    unfinished.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    unfinished.replace(results_of(module))


def results_of(module: str) -> Path:
    """Return the file that keeps what became of a module's mutants."""
    return RESULTS / f"{import_name(module)}.json"


def killed_before(module: str) -> dict[tuple[str, str, str], str]:
    """Return the changes that were noticed the last time, wherever in the function they were made."""
    rows = json.loads(results_of(module).read_text(encoding="utf-8"))
    lived = {key_of(row) for row in rows if row["ended"] == SURVIVED}
    return {key_of(row): row["ended"] for row in rows if key_of(row) not in lived}


def key_of(row: Row) -> tuple[str, str, str]:
    """Return what tells a mutant from others, though its line may move."""
    return row["function"], row["was"], row["became"]


def _import_the_heavy_guests() -> None:
    """Import once what every fork needs, with the same examples from hypothesis each time."""
    for guest in (
        "numba",
        "pandas",
        "scipy.signal",
        "scipy.stats",
        "scipy.optimize",
        "statsmodels.tsa.api",
        "filterpy.kalman",
        "matplotlib",
    ):
        importlib.import_module(guest)
    from hypothesis import settings

    settings.register_profile("mutation", derandomize=True, database=None, deadline=None)
    settings.load_profile("mutation")


def compiled(module: str) -> bool:
    """Say whether the module has functions for numba, or its job is done by them."""
    return "njit" in (ROOT / module).read_text(encoding="utf-8") or module in DONE_BY_KERNELS


def table() -> str:
    """Return what has been measured as a table in Markdown."""
    explained = tomllib.loads(EXPLAINED.read_text(encoding="utf-8"))
    lines = ["| module | mutants | killed | survived | explained | score |", "|---|---:|---:|---:|---:|---:|"]
    total = [0, 0, 0, 0]
    for module in CORE:
        if results_of(module).exists():
            rows = json.loads(results_of(module).read_text(encoding="utf-8"))
            counts = _counts(rows, explained.get(module, []))
            total = [a + b for a, b in zip(total, counts, strict=True)]
            lines.append(_row(f"`{module}`", counts))
    return "\n".join([*lines, _row("**all**", total)])


def _counts(rows: list[Row], explained: list[dict[str, str]]) -> list[int]:
    """Return mutants, killed, survived, explained: a survivor is one of the last two."""
    reasons = {(each["was"], each["became"]) for each in explained}
    lived = [row for row in rows if row["ended"] == SURVIVED]
    known = sum((row["was"], row["became"]) in reasons for row in lived)
    return [len(rows), len(rows) - len(lived), len(lived) - known, known]


def _row(name: str, counts: list[int]) -> str:
    mutants, killed, survived, explained = counts
    score = 100.0 * killed / max(mutants - explained, 1)
    return f"| {name} | {mutants} | {killed} | {survived} | {explained} | {score:.0f} % |"


def main() -> int:
    """Measure the modules asked for, one process each, and print the table; one that fails stops no other."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("modules", nargs="*", help="files of the core; all of them without")
    parser.add_argument("--table", action="store_true", help="print the table of what has been measured")
    parser.add_argument("--again", action="store_true", help="only those that survived the last time")
    parser.add_argument("--here", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.here:
        measure(asked.modules[0], asked.again)
        return 0
    failed = []
    for module in () if asked.table else asked.modules or CORE:
        print(module, flush=True)
        jit = {"NUMBA_DISABLE_JIT": "1"} if compiled(module) else {}
        quiet = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "agg"}
        command = [sys.executable, __file__, "--here", module, *["--again"] * asked.again]
        if subprocess.run(command, env=os.environ | jit | quiet, cwd=ROOT).returncode:
            failed.append(module)
    print(table())
    if failed:
        print("not measured:", *failed, file=sys.stderr)
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
