"""`baroarma demo`: the main job from end to end."""

import json

from baroarma import NoiseModel, read
from baroarma.cli import main
from baroarma.simulation import BMP085


def test_the_demo_leaves_logs_a_model_a_filter_a_track_and_a_page(tmp_path, capsys):
    folder = tmp_path / "new" / "demo"
    assert main(["demo", "--out", str(folder), "--json"]) == 0
    body = json.loads(capsys.readouterr().out)
    assert sorted(p.name for p in folder.iterdir()) == [
        "noise.json",
        "report.html",
        "rest.csv",
        "squat.csv",
        "track.csv",
        "whitening.json",
    ]
    noise = NoiseModel.load(folder / "noise.json")
    low, high = noise.ci95["correlation_time"]
    assert low < BMP085.noise.correlation_time < high
    assert read(folder / "rest.csv").duration > 1190
    assert json.loads((folder / "whitening.json").read_text()) == noise.whitening_filter().to_dict()
    assert body["whitening"] == noise.whitening_filter().to_dict()
    assert [row["preset"] for row in body["comparison"]["rows"]][:2] == ["baroarma", "sg14-a"]
    assert len((folder / "track.csv").read_text().splitlines()) == 3001
    assert (
        "<svg" in (folder / "report.html").read_text() or "data:image" in (folder / "report.html").read_text()
    )


def test_a_folder_that_cannot_be_made_is_exit_code_2(tmp_path, capsys):
    (tmp_path / "file").touch()
    for bad in (tmp_path / "file", tmp_path / "file" / "demo"):
        assert main(["demo", "--out", str(bad)]) == 2
        assert capsys.readouterr().err.count("\n") == 1
