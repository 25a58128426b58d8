"""Every notebook in examples runs from top to bottom, draws, and is committed without its outputs.

A kernel runs in another folder than the notebook's, so that nothing is found by accident.
"""

import json
import os
import re
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
NOTEBOOKS = sorted(EXAMPLES.glob("*.ipynb"))
REAL = EXAMPLES / "05_real_recordings.ipynb"
SECONDS = 120
"""For one cell, on a busy machine; a notebook takes 5 to 30 s on an idle one."""
MODULES = ("matplotlib._fontconfig_pattern", "matplotlib._mathtext", "pyparsing.util")
OLDER = [f"ignore::DeprecationWarning:{name}" for name in MODULES]
"""What an older matplotlib complains about when it meets a newer pyparsing."""
every_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def execute(path: Path, folder: Path, **environment: str):
    """Run a notebook in a folder by a kernel with these variables; the notebook with its outputs."""
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook, timeout=SECONDS, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    )
    inherited = {name: value for name, value in os.environ.items() if name != "MPLBACKEND"}
    client.execute(env={**inherited, "PYTHONWARNINGS": ",".join(["default", *OLDER]), **environment})
    return notebook


def outputs_of(notebook):
    return [one for cell in notebook.cells if cell.cell_type == "code" for one in cell.outputs]


def pictures_of(notebook):
    return [one for one in outputs_of(notebook) if "image/png" in one.get("data", {})]


def complaints_of(notebook):
    return [one.text for one in outputs_of(notebook) if one.get("name") == "stderr"]


@pytest.mark.parametrize("path", [path for path in NOTEBOOKS if path != REAL], ids=lambda path: path.stem)
def test_a_notebook_runs_without_complaint_and_draws(path, tmp_path):
    done = execute(path, tmp_path)
    assert complaints_of(done) == []
    assert len(pictures_of(done)) >= 2


def test_the_real_recordings_are_found_from_the_repository(shared_data, tmp_path):
    done = execute(REAL, tmp_path)
    assert complaints_of(done) == []
    assert len(pictures_of(done)) >= 2


def test_without_the_real_recordings_their_notebook_says_so_and_ends(tmp_path):
    done = execute(REAL, tmp_path, BAROARMA_DATA=str(tmp_path / "nowhere"))
    said = outputs_of(done)
    assert [one.get("name") for one in said] == ["stdout"]
    assert "not on this machine" in said[0].text


@every_notebook
def test_a_notebook_is_committed_without_outputs(path):
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        assert cell["metadata"] == {}
        if cell["cell_type"] == "code":
            assert (cell["outputs"], cell["execution_count"]) == ([], None), cell["id"]


@every_notebook
def test_a_notebook_is_valid_and_knows_only_its_kernel(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert (notebook.nbformat, notebook.nbformat_minor) == (4, 5)
    assert list(notebook.metadata) == ["kernelspec"]
    assert notebook.metadata.kernelspec.name == "python3"
    ids = [cell.id for cell in notebook.cells]
    assert len(set(ids)) == len(ids)


@every_notebook
def test_a_notebook_asks_one_question_and_ends_by_leading_on(path):
    first, *_, last = nbformat.read(path, as_version=4).cells
    number = int(path.stem[:2])
    assert re.fullmatch(rf"# {number} · .+\?", first.source.splitlines()[0])
    following = NOTEBOOKS[number % len(NOTEBOOKS)].name
    assert last.source.startswith("**Next:**")
    assert f"({following})" in last.source


def test_the_reading_order_lists_every_notebook():
    for page in (EXAMPLES / "README.md", EXAMPLES.parent / "docs" / "notebooks.md"):
        listed = re.findall(r"(0\d_\w+\.ipynb)", page.read_text(encoding="utf-8"))
        assert list(dict.fromkeys(listed)) == [path.name for path in NOTEBOOKS], page.name
