"""`baroarma export`: firmware in a folder, hints as text or JSON; and the firmware's track comes back."""

import json
import shutil
import subprocess

import pytest

from baroarma.cli import main
from baroarma.formats import write_csv
from baroarma.simulation import BMP085, simulate

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")
FIRMWARE = ("export", "firmware", "--preset", "sg14-b", "--rate", "50")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("export")
    BMP085.noise.save(folder / "noise.json")
    write_csv(simulate("squat", duration=12, seed=1), folder / "squat.csv")
    return folder


def built(folder, *options):
    subprocess.run(["gcc", *options, *folder.glob("*.c"), "-lm", "-o", folder / "program"], check=True)
    return folder / "program"


@needs_gcc
@pytest.mark.parametrize("real", ["--float", "--double"])
@pytest.mark.parametrize("preset", ["sg14-b", "baroarma"])
def test_the_folder_builds_and_its_self_test_passes(files, tmp_path, capsys, preset, real):
    out = tmp_path / "firmware"
    noise = ("--noise", str(files / "noise.json"))
    assert main([*FIRMWARE, "--preset", preset, *noise, real, "--out", str(out)]) == 0
    said = capsys.readouterr()
    assert said.out == ""
    assert ("times its size (DC gain)" in said.err) == (preset == "sg14-b")
    assert subprocess.run([built(out)], cwd=out, capture_output=True).returncode == 0


def test_json_says_what_was_written(files, tmp_path, capsys):
    assert main([*FIRMWARE, "--double", "--out", str(tmp_path / "here"), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["preset"], document["rate_hz"], document["real"]) == ("sg14-b", 50.0, "double")
    assert sorted(document["files"]) == sorted(path.name for path in (tmp_path / "here").iterdir())


@needs_gcc
def test_the_firmwares_track_is_compared_with_pythons(files, tmp_path, capsys):
    out = tmp_path / "firmware"
    noise = ("--noise", str(files / "noise.json"))
    assert main([*FIRMWARE, *noise, "--out", str(out)]) == 0
    rows = (files / "squat.csv").read_text()
    done = subprocess.run(
        [built(out, "-DBAROARMA_REPLAY")], input=rows, capture_output=True, text=True, check=True
    )
    (out / "mcu.csv").write_text(done.stdout)
    capsys.readouterr()
    compared = ("compare", str(files / "squat.csv"), *noise, "--presets", "sg14-a,sg14-b")
    assert main([*compared, "--track", str(out / "mcu.csv"), "--json"]) == 0
    *_, python, firmware = json.loads(capsys.readouterr().out)["rows"]
    assert (python["preset"], firmware["preset"]) == ("sg14-b", "mcu.csv")
    assert firmware["height_rmse_m"] == pytest.approx(python["height_rmse_m"], abs=2e-3)  # floats: 2 mm
    assert firmware["us_per_sample"] is None
    (finding,) = firmware["findings"]
    assert finding["message"].startswith("It is nearest to sg14-b: at most ")


@needs_gcc
def test_the_replay_says_which_column_is_missing(files, tmp_path):
    assert main([*FIRMWARE, "--out", str(tmp_path / "fw")]) == 0
    program = built(tmp_path / "fw", "-DBAROARMA_REPLAY")
    done = subprocess.run([program], input="time_s,pressure_pa\n0,1e5\n", capture_output=True, text=True)
    assert done.returncode == 2
    assert "the recording has no column acc_x_m_s2" in done.stderr


def test_hints_are_text_or_json(files, capsys):
    arguments = ["export", "hints", "--noise", str(files / "noise.json")]
    assert main(arguments) == 0
    text = capsys.readouterr().out
    assert main([*arguments, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["hints"]
    assert [hint["tool"] for hint in found] == ["PX4", "ArduPilot", "Gazebo", "MATLAB"]
    for hint in found:
        assert all(f"{setting['name']} = {setting['value']:.6g}" in text for setting in hint["settings"])
        assert all(limit in text for limit in hint["limits"])
    assert main([*arguments, "--pressure", "70000"]) == 0
    assert capsys.readouterr().out != text


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["firmware", "--preset", "sg14-a", "--rate", "50"], "needs --preset, --rate and --out"),
        (["firmware", "--pressure", "9e4"], "--pressure has no meaning for export firmware"),
        (["hints"], "export hints needs --noise N.json"),
        (["hints", "--float"], "--float and --double has no meaning for export hints"),
        (["bundle"], "'bundle' is not one of 'firmware', 'hints'"),
        (["firmware", "--preset", "bourke08", "--rate", "50", "--out", "x"], "it works off-line"),
        (["firmware", "--preset", "lee16", "--rate", "0", "--out", "x"], "must be 4 to 2000 Hz"),
        (["firmware", "--preset", "lee16", "--rate", "50", "--out", "no/x"], "there is no folder no"),
    ],
)
def test_wrong_usage_is_one_sentence_and_writes_nothing(tmp_path, monkeypatch, capsys, arguments, says):
    monkeypatch.chdir(tmp_path)
    assert main(["export", *arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("time_s,height_m\n0,1\n", "there is no column 'velocity_m_s'"),
        ("", "this is no track"),
        ("time_s,height_m,velocity_m_s,height_sd_m,velocity_sd_m_s\n0,1,2,3,x\n", "this is no track"),
        ("time_s,height_m,velocity_m_s,height_sd_m,velocity_sd_m_s\n0,1,2,3,4\n", "needs two rows or more"),
        (
            "time_s,height_m,velocity_m_s,height_sd_m,velocity_sd_m_s\n0,1,2,3,4\n1,,2,3,4\n",
            "row 2: a track needs a finite number",
        ),
        (
            "time_s,height_m,velocity_m_s,height_sd_m,velocity_sd_m_s\n0,1,2,3,4\n99,1,2,3,4\n",
            "is it the track of another recording?",
        ),
    ],
)
def test_a_track_that_can_not_be_compared_is_refused(files, tmp_path, capsys, text, says):
    (tmp_path / "t.csv").write_text(text)
    arguments = [
        "compare",
        str(files / "squat.csv"),
        "--presets",
        "sg14-a",
        "--track",
        str(tmp_path / "t.csv"),
    ]
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line


def test_a_track_belongs_to_one_recording(files, capsys):
    twice = [str(files / "squat.csv")] * 2
    assert main(["compare", *twice, "--presets", "sg14-a", "--track", "t.csv"]) == 2
    assert "--track belongs to one recording, but there are 2" in capsys.readouterr().err
