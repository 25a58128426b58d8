"""`baroarma compare`: the bake-off as a table or as JSON."""

import json

import pytest

from baroarma.cli import main
from baroarma.formats import write_csv
from baroarma.simulation import BMP085, simulate

PRESETS = ("--presets", "sg14-a, baroarma")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    write_csv(simulate("squat", duration=8, seed=1), folder / "squat.csv")
    write_csv(simulate("rest", duration=8, seed=1, imu=None), folder / "rest.csv")
    BMP085.noise.save(folder / "noise.json")
    return folder


def test_one_recording_is_one_table_or_the_documented_json(files, capsys):
    arguments = [str(files / "squat.csv"), "--noise", str(files / "noise.json"), *PRESETS]
    assert main(["compare", *arguments]) == 0
    text = capsys.readouterr().out
    assert text.startswith("squat: 400 rows over 7.98 s\npreset")
    assert main(["compare", *arguments, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["recording"] == "squat"
    assert [row["preset"] for row in document["rows"]] == ["sg14-a", "baroarma"]
    assert f"{document['rows'][0]['height_rmse_m']:.3f}" in text


def test_several_recordings_are_several_tables_without_a_bar_off_a_terminal(files, capsys):
    both = [str(files / "squat.csv"), str(files / "rest.csv")]
    assert main(["compare", *both, "--presets", "baroarma", "--json"]) == 0
    captured = capsys.readouterr()
    assert [d["recording"] for d in json.loads(captured.out)["recordings"]] == ["squat", "rest"]
    assert captured.err == ""


def test_a_terminal_sees_a_bar(files, capsys, monkeypatch):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    both = [str(files / "squat.csv"), str(files / "squat.csv")]
    assert main(["compare", *both, "--presets", "sg14-a"]) == 0
    captured = capsys.readouterr()
    assert "comparing" in captured.err
    assert captured.out.count("squat: 400 rows") == 2


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (
            ["rest.csv", "--presets", "sg14-a,lee16"],
            1,
            "no preset could track rest: rest has no accelerometer",
        ),
        (["squat.csv", "--presets", "sg14"], 2, "there is no preset 'sg14'"),
        (["squat.csv", "--presets", " ,"], 2, "nothing to compare"),
        (["none.csv"], 2, "no such file"),
    ],
)
def test_refusals_are_one_sentence(files, capsys, monkeypatch, arguments, code, says):
    monkeypatch.chdir(files)
    assert main(["compare", *arguments]) == code
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line
