"""The house: folders, names, doctests and imports are where setup.cfg says."""

import configparser
import doctest
import importlib
import re
from pathlib import Path

import pytest

import baroarma

ROOT = Path(__file__).resolve().parents[1]
CONFIG = configparser.ConfigParser()
CONFIG.read(ROOT / "setup.cfg")
PACKAGES = CONFIG["options"]["packages"].split()
FOLDERS = dict(line.split(" = ") for line in CONFIG["options"]["package_dir"].strip().splitlines())


def folder_of(package: str) -> Path:
    """Return the folder that setup.cfg maps a package to."""
    root = max((p for p in FOLDERS if package == p or package.startswith(p + ".")), key=len)
    return ROOT.joinpath(FOLDERS[root], *package[len(root) :].strip(".").split("."))


def modules() -> list[str]:
    names = []
    for package in PACKAGES:
        stems = sorted(path.stem for path in folder_of(package).glob("*.py"))
        names += [package if stem == "__init__" else f"{package}.{stem}" for stem in stems]
    return names


def test_packages_in_setup_cfg_are_the_folders_on_disk():
    on_disk = {path.parent for name in set(FOLDERS.values()) for path in (ROOT / name).rglob("__init__.py")}
    assert {folder_of(package) for package in PACKAGES} == on_disk


@pytest.mark.parametrize("name", modules())
def test_every_example_in_a_docstring_runs(name):
    result = doctest.testmod(importlib.import_module(name), optionflags=doctest.ELLIPSIS)
    assert result.failed == 0


def test_no_module_is_imported_by_its_bare_folder_name():
    for path in [*ROOT.glob("*/**/*.py")]:
        if not {".venv", "build"} & set(path.relative_to(ROOT).parts):
            bare = re.search(
                r"^\s*(from|import) (identification|estimators)\b", path.read_text(), re.MULTILINE
            )
            assert bare is None, f"{path}: {bare and bare.group()}"


def test_the_rooms_do_not_know_each_other():
    for room, other in (("identification", "estimators"), ("estimators", "identification")):
        for path in (ROOT / room).rglob("*.py"):
            assert f"baroarma.{other}" not in path.read_text(), path


def test_every_promised_name_is_there_and_typed():
    source = Path(baroarma.__file__).read_text()
    for name in baroarma.__all__:
        assert getattr(baroarma, name).__name__ == name
        assert f"import {name} as {name}" in source
