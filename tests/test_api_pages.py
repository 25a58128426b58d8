"""The pages of docs/api teach: who stands on them has an example, and says what it takes and what it raises.

That the examples run is `test_layout`'s.  What a class's example shows its methods need not show again.
"""

import ast
import importlib
import inspect
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
DIRECTIVE = re.compile(r"^\.\. auto(module|class|function):: (\S+)\n((?:   :.*\n)*)", re.MULTILINE)
WITHOUT_EXAMPLE = {"baroarma.experiments.experiment.no_tests": "does nothing, which no example shows"}


def public_names(name: str, options: dict[str, str]) -> list[str]:
    """Return which members of a module its directive lists."""
    if "members" not in options:
        return []
    module = importlib.import_module(name)
    own = [key for key, value in vars(module).items() if getattr(value, "__module__", None) == name]
    listed = re.findall(r"\w+", options["members"]) or getattr(module, "__all__", own)
    left_out = re.findall(r"\w+", options.get("exclude-members", ""))
    return [key for key in listed if not key.startswith("_") and key not in left_out]


def on_pages() -> dict[str, Any]:
    """Return all functions and classes that the pages document, by the names of their homes."""
    found = {}
    for page in sorted((ROOT / "docs" / "api").glob("*.md")):
        for kind, name, lines in DIRECTIVE.findall(page.read_text(encoding="utf-8")):
            options = dict(re.findall(r":([\w-]+): ?(.*)", lines))
            names = [f"{name}.{key}" for key in public_names(name, options)] if kind == "module" else [name]
            for path in names:
                home, _, key = path.rpartition(".")
                value = inspect.unwrap(getattr(importlib.import_module(home), key))
                if inspect.isclass(value) or inspect.isfunction(value):
                    found[f"{value.__module__}.{value.__qualname__}"] = value
    return dict(sorted(found.items()))


NAMES = on_pages()


def functions() -> Iterator[tuple[str, Any]]:
    """Yield all functions and all documented public methods."""
    for name, value in NAMES.items():
        if inspect.isfunction(value):
            yield name, value
        else:
            for key, member in vars(value).items():
                function = getattr(member, "fget", getattr(member, "__func__", member))
                if not key.startswith("_") and inspect.isfunction(function) and function.__doc__:
                    yield f"{name}.{key}", function


FUNCTIONS = dict(functions())


def section(value: Any, title: str) -> str:
    """Return a section of a docstring, empty if there is none."""
    text = inspect.cleandoc(value.__doc__ or "")  # an inherited docstring would be about another
    parts = re.split(r"^(\w[\w ]*)\n-{3,}$", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True)).get(title, "")


def raised_by(function: Any) -> set[str]:
    """Return the names of the exceptions that stand in a function's own body."""
    body = ast.walk(ast.parse(textwrap.dedent(inspect.getsource(function))))
    return {ast.unparse(n.exc.func) for n in body if isinstance(n, ast.Raise) and isinstance(n.exc, ast.Call)}


def test_the_pages_list_the_front_door_and_all_of_its_rooms():
    assert len(NAMES) > 150
    rooms = ("identification", "estimators", "formats", "simulation", "plotting", "export", "experiments")
    assert all(any(name.startswith(f"baroarma.{room}.") for name in NAMES) for room in rooms)


@pytest.mark.parametrize("name", sorted(set(NAMES) - set(WITHOUT_EXAMPLE)))
def test_who_stands_on_a_page_has_an_example(name):
    assert ">>>" in section(NAMES[name], "Examples"), f"{name} has no section Examples"


def test_who_goes_without_an_example_says_why_and_has_none():
    for name, why in WITHOUT_EXAMPLE.items():
        assert not section(NAMES[name], "Examples"), f"{name} has one by now; take it off the list"
        assert len(why) > 10
    assert len(WITHOUT_EXAMPLE) < len(NAMES) / 50


@pytest.mark.parametrize("name", [name for name, value in NAMES.items() if inspect.isfunction(value)])
def test_a_function_says_what_it_takes(name):
    text = inspect.getdoc(NAMES[name]) or ""
    untold = [p for p in inspect.signature(NAMES[name]).parameters if not re.search(rf"\b{p}\b", text)]
    assert not untold, f"{name} says nothing about {', '.join(untold)}"


@pytest.mark.parametrize("name", [name for name, function in FUNCTIONS.items() if raised_by(function)])
def test_what_a_function_raises_stands_in_its_docstring(name):
    untold = {e for e in raised_by(FUNCTIONS[name]) if e not in section(FUNCTIONS[name], "Raises")}
    assert not untold, f"{name} has no word about {', '.join(untold)}"
