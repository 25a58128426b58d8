"""What the README shows works as it stands there."""

import re
import shlex
from pathlib import Path

import pytest

from baroarma.cli import main
from baroarma.formats import write_csv
from baroarma.simulation import simulate, simulate_rest

README = (Path(__file__).resolve().parents[1] / "README.md").read_text(encoding="utf-8")


@pytest.fixture
def logs(tmp_path, monkeypatch):
    """A folder with the logs that the README speaks of, as the working folder."""
    write_csv(simulate_rest(300, seed=1), tmp_path / "rest.csv")
    write_csv(simulate("squat", duration=30, seed=1), tmp_path / "walk.csv")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_python_block_runs(logs, capsys):
    blocks = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert len(blocks) >= 2
    for block in blocks:
        names: dict[str, object] = {}
        exec(block, names)
        if "track" in names:  # the user's whole path, in batch and on-line
            on_line = [state.height for state in names["states"] if state is not None]
            assert on_line == pytest.approx(names["track"].height[-len(on_line) :], abs=1e-9)
            assert "sg14-b" in capsys.readouterr().out


def test_every_baroarma_command_of_the_first_steps_runs(logs):
    block = next(b for b in re.findall(r"```sh\n(.*?)```", README, re.DOTALL) if "baroarma identify" in b)
    lines = [line for line in block.splitlines() if line.startswith("baroarma ")]
    assert len(lines) >= 2
    for line in lines:
        assert main(shlex.split(line)[1:]) == 0, line
    assert {"noise.json", "page.html"} <= {path.name for path in logs.iterdir()}
