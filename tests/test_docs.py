"""Every block of code in the documents runs, page by page, and prints what the page says it prints.

A page is run from top to bottom in a folder of its own that holds the files of `LOGS`; its Python blocks
share one namespace.  A block of ``text`` right behind a block of code is what that prints, ``...`` standing
for anything.  What can't run here says why in a comment before it: ``<!-- not run: takes minutes -->``.
"""

import contextlib
import doctest
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import types
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from markdown_it import MarkdownIt

import baroarma
from baroarma.cli import main
from baroarma.formats import write_csv
from baroarma.simulation import BMP085, simulate

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
NOT_RUN = re.compile(r"<!-- not run: (.*?) -->", re.DOTALL)
INSTALLS = re.compile(r"make |pip install|python3 -m venv|\.venv/", re.MULTILINE)
"""What changes the machine is not run, wherever it stands."""
BY_BASH = re.compile(r"[|<>;&()$]|^(?!baroarma )")
"""Lines for a shell; all others are commands of ours, which need no process of their own."""
LOGS = {
    "rest.csv": lambda: simulate("rest", duration=300, seed=1),
    "walk.csv": lambda: simulate("squat", duration=30, seed=1),
    "ride.csv": lambda: simulate("stairs", duration=40, seed=1),
    "day.parquet": lambda: simulate("rest", duration=60, seed=2),
    "noise.json": lambda: BMP085.noise,
}
"""The files that pages speak of."""
ALIKE = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


class Block(NamedTuple):
    """A block of code on a page, what it prints as far as the page says it, and why it is not run."""

    line: int
    language: str
    text: str
    expected: str | None
    not_run: str | None


def blocks_of(page: Path) -> list[Block]:
    """Return the blocks of code of a page."""
    tokens = MarkdownIt().parse(page.read_text(encoding="utf-8"))
    found = []
    for before, token, after in zip([None, *tokens], tokens, [*tokens[1:], None], strict=False):
        if token.type == "fence" and token.info in RUN:
            said = NOT_RUN.search(before.content) if before and before.type == "html_block" else None
            reason = said.group(1) if said else why_not(token)
            expected = after.content if after and after.type == "fence" and after.info == "text" else None
            found.append(Block(token.map[0] + 1, token.info, token.content, expected, reason))
    return found


def why_not(token) -> str | None:
    if token.info in ("sh", "console") and INSTALLS.search(token.content):
        return "installs"
    if "gcc " in token.content and shutil.which("gcc") is None:
        return "there is no gcc here"
    return None


@pytest.fixture(scope="session")
def logs(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("logs")
    for name, make in LOGS.items():
        value = make()
        if name.endswith(".json"):
            value.save(folder / name)
        else:
            write_csv(value, folder / name)
    return folder


def run_python(block: Block, module: types.ModuleType) -> None:
    exec(compile("\n" * block.line + block.text, module.__name__, "exec"), vars(module))


def run_commands(block: Block, module: types.ModuleType) -> None:
    for line in block.text.replace("\\\n", " ").splitlines():
        command = line.removeprefix("$ ").partition(" #")[0].strip()
        if command and BY_BASH.search(command):
            # a plain `python` and `baroarma` are those that run the tests
            path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
            environment = {**os.environ, "PATH": path}
            print(subprocess.check_output(["bash", "-ec", command], env=environment, text=True), end="")
        elif command:
            assert main(shlex.split(command)[1:]) == 0, f"{command} failed"


RUN: dict[str, Callable[[Block, types.ModuleType], None]] = {
    "python": run_python,
    "sh": run_commands,
    "console": run_commands,
}
"""How a block of a language is run."""


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("page", [p for p in PAGES if blocks_of(p)], ids=name_of)
def test_every_block_of_a_page_runs_and_prints_what_the_page_says(page, logs, tmp_path, monkeypatch):
    shutil.copytree(logs, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    module = types.ModuleType("page_of_the_documents")
    monkeypatch.setitem(sys.modules, module.__name__, module)  # so that classes of a page can be pickled
    for block in blocks_of(page):
        if block.not_run is None:
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                RUN[block.language](block, module)
            if block.expected is not None:
                check_output(f"{name_of(page)}:{block.line}", block.expected, printed.getvalue())
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


def check_output(where: str, expected: str, printed: str) -> None:
    same = doctest.OutputChecker().check_output(expected, printed, ALIKE)
    assert same, f"{where} says that this prints\n{expected}\nbut it prints\n{printed}"


def test_most_blocks_run_and_the_others_say_why():
    every = [(name_of(page), block) for page in PAGES for block in blocks_of(page)]
    left_out = [f"{name}:{block.line}: {block.not_run}" for name, block in every if block.not_run is not None]
    print(f"{len(left_out)} of {len(every)} blocks are not run:", *left_out, sep="\n")
    assert len(left_out) < len(every) / 3
    assert all(block.not_run is None or len(block.not_run) > 5 for _, block in every)


def test_no_block_of_code_hides_from_these_tests():
    for page in PAGES:
        opened = re.findall(
            r"^[ >]*`{3,}\{?(?:code-block\} )?(python|pycon|sh|console|bash|shell)\b",
            page.read_text(encoding="utf-8"),
            re.MULTILINE,
        )
        assert len(opened) == len(blocks_of(page)), name_of(page)


def test_a_wrong_output_is_noticed():
    with pytest.raises(AssertionError, match="prints"):
        check_output("page:1", "1 m\n", "2 m\n")


@pytest.mark.parametrize(
    "package",
    ["", ".estimators", ".experiments", ".export", ".formats", ".identification", ".plotting", ".simulation"],
)
def test_the_names_that_a_package_promises_stand_in_the_reference(package):
    pages = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs" / "api").glob("*.md"))
    listed = re.search(rf"automodule:: baroarma{re.escape(package)}\n   :members:\n((?:   .*\n)*)", pages)
    assert listed, f"no page of docs/api lists baroarma{package}"
    left_out = re.findall(r"\w+", listed.group(1).partition("exclude-members:")[2])
    assert set(left_out) <= set(baroarma.__all__)  # the front door's have their own page


def links_of(page: Path) -> list[str]:
    inline = [t for t in MarkdownIt().parse(page.read_text(encoding="utf-8")) if t.type == "inline"]
    return [
        str(child.attrGet("href") or child.attrGet("src"))
        for token in inline
        for child in token.children or []
        if child.type in ("link_open", "image")
    ]


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_link_to_a_file_leads_somewhere(page):
    for link in links_of(page):
        target = link.partition("#")[0]
        if target and ":" not in target:
            assert (page.parent / target).exists(), f"{name_of(page)} links to {link}"
