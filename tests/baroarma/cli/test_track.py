"""`baroarma track`: files in, height out; row by row from a stream."""

import json
import subprocess
import sys

import numpy as np
import pytest

from baroarma.cli import main
from baroarma.formats import read, write_csv
from baroarma.presets import PRESETS
from baroarma.simulation import BMP085, simulate
from baroarma.tracker import Tracker

HEAD = "time_s,height_m,velocity_m_s,height_sd_m,velocity_sd_m_s"
COMMAND = [sys.executable, "-c", "from baroarma.cli import entry_point; entry_point()", "track"]


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("track")
    write_csv(simulate("squat", duration=8, seed=1), folder / "squat.csv")
    write_csv(simulate("rest", duration=8, seed=1, imu=None), folder / "rest.csv")
    BMP085.noise.save(folder / "noise.json")
    return folder


def test_the_track_goes_to_stdout_or_to_a_file(files, tmp_path, capsys):
    out, noise = tmp_path / "track.csv", str(files / "noise.json")
    assert main(["track", str(files / "squat.csv"), "--noise", noise]) == 0
    text = capsys.readouterr().out
    assert text.splitlines()[0] == HEAD
    assert main(["track", str(files / "squat.csv"), "--noise", noise, "--out", str(out)]) == 0
    assert out.read_text() == text
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "Track of 'squat' by baroarma" in captured.err
    track = Tracker(noise=BMP085.noise).run(read(files / "squat.csv"))
    # not by pandas, which before version 3 misses a number's last bit
    assert np.array_equal(np.loadtxt(out, delimiter=",", skiprows=1)[:, 1], track.height)


def test_json_is_one_document(files, capsys):
    assert main(["track", str(files / "squat.csv"), "--preset", "sg14-b", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["preset"] == "sg14-b"
    assert [f["code"] for f in document["findings"]] == ["dc-gain"]
    assert len(document["height_m"]) == len(document["time_s"]) == 400


def test_warnings_go_to_stderr(files, capsys):
    assert main(["track", str(files / "squat.csv"), "--preset", "sg14-b"]) == 0
    assert "warning (dc-gain)" in capsys.readouterr().err


def test_back_ends_are_chosen_by_name(files, capsys):
    arguments = [
        "--preset",
        "sg14-a",
        "--attitude",
        "tilt-kalman",
        "--height",
        "kalman",
        "--conditioning",
        "none",
    ]
    assert main(["track", str(files / "squat.csv"), *arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["preset"] == "tilt-kalman+kalman"


def test_the_help_names_presets_and_back_ends_plug_ins_included(capsys, monkeypatch):
    from baroarma.estimators import registry

    monkeypatch.setattr(registry, "height_names", lambda: (*registry.HEIGHT, "lowpass"))
    assert main(["track", "--help"]) == 0
    text = "".join(capsys.readouterr().out.split())
    for name in (*PRESETS, *registry.ATTITUDE, *registry.HEIGHT, "lowpass"):
        assert name in text


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (["rest.csv", "--preset", "sg14-a"], 1, "no accelerometer and gyro"),
        (["squat.csv", "--stop", "0.9"], 1, "all of it needed to align"),
        (["squat.csv", "--start", "99"], 2, "no rows"),
        (["none.csv"], 2, "no such file"),
        (["squat.csv", "--attitude", "magic"], 2, "there is no attitude estimator 'magic'"),
        (["squat.csv", "--height", "kalmann"], 2, "did you mean 'kalman'"),
        (["squat.csv", "--preset", "sg15"], 2, "sg15"),
        (["squat.csv", "rest.csv"], 2, "one recording at a time"),
        (["squat.csv", "--noise", "squat.csv"], 2, "squat.csv"),
    ],
)
def test_refusals_are_one_sentence_and_leave_no_file(
    files, tmp_path, capsys, monkeypatch, arguments, code, says
):
    monkeypatch.chdir(files)
    out = tmp_path / "track.csv"
    assert main(["track", *arguments, "--out", str(out)]) == code
    captured = capsys.readouterr()
    assert says in captured.err.splitlines()[-1]
    assert captured.out == ""
    assert not list(tmp_path.iterdir())


def test_pressure_alone_is_tracked_by_ours(files, capsys):
    noise = str(files / "noise.json")
    assert main(["track", str(files / "rest.csv"), "--noise", noise]) == 0
    assert "no-imu" in capsys.readouterr().err


def live(lines, *arguments):
    """Write each line and read its answer before the next is written, once answers begin."""
    process = subprocess.Popen(
        [*COMMAND, "-", *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        bufsize=1,
    )
    answers = []
    for k, line in enumerate(lines):
        process.stdin.write(line)
        process.stdin.flush()
        if k == 0 or k > 50:  # the header is answered by a header; 50 rows align
            answers.append(process.stdout.readline())
    process.stdin.close()
    rest, errors = process.stdout.read(), process.stderr.read()
    process.stdout.close()
    process.stderr.close()
    assert rest == ""
    assert process.wait() == 0, errors
    return answers


@pytest.mark.parametrize("name", ["squat", "rest"])
def test_a_stream_is_answered_row_by_row_before_the_next_one_comes(files, name):
    lines = (files / f"{name}.csv").read_text().splitlines(keepends=True)[:90]
    answers = live(lines, "--noise", str(files / "noise.json"))
    assert answers[0].strip() == HEAD
    values = np.array([[float(cell) for cell in answer.split(",")] for answer in answers[1:]])
    recording = read(files / f"{name}.csv")
    track = Tracker(noise=BMP085.noise).run(recording.rows(slice(89)))
    assert len(values) == 39
    np.testing.assert_allclose(values[:, 1], track.height[50:], rtol=1e-9, atol=1e-9)


def stream(files, edit):
    lines = (files / "squat.csv").read_text().splitlines()[:70]
    edit(lines)
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("at", "cell", "says"),
    [
        (65, "x", "line 66: 'x' in column pressure_pa is no number"),
        (30, "-3", "line 31: pressure_pa of -3 can't be"),
    ],
)
def test_a_bad_cell_in_a_stream_is_told_with_its_line(files, at, cell, says, monkeypatch, capsys):
    import io

    def spoil(lines):
        cells = lines[at].split(",")
        cells[lines[0].split(",").index("pressure_pa")] = cell
        lines[at] = ",".join(cells)

    monkeypatch.setattr("sys.stdin", io.StringIO(stream(files, spoil)))
    assert main(["track", "-"]) == 1
    captured = capsys.readouterr()
    assert says in captured.err
    assert "Traceback" not in captured.err
    assert len(captured.out.splitlines()) == 1 + 69 - 50 - (1 if at > 50 else 0)


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (["--preset", "bourke08"], 2, "works off-line"),
        (["--out", "x.parquet"], 2, "give x.parquet another suffix"),
        (["--json"], 2, "leave out --json"),
    ],
)
def test_what_a_stream_can_not_have_is_refused(files, arguments, code, says, monkeypatch, capsys, tmp_path):
    import io

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO(stream(files, lambda lines: None)))
    assert main(["track", "-", *arguments]) == code
    assert says in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_stream_without_imu_is_refused_by_the_papers_presets(files, monkeypatch, capsys):
    import io

    monkeypatch.setattr("sys.stdin", io.StringIO((files / "rest.csv").read_text()))
    assert main(["track", "-", "--preset", "lee16"]) == 1
    assert "no accelerometer and gyro" in capsys.readouterr().err


def columns(capsys):
    return json.loads(capsys.readouterr().out)


def test_smooth_is_the_trackers_own_with_or_without_a_lag(files, capsys):
    log, noise = read(files / "squat.csv"), ["--noise", str(files / "noise.json"), "--json"]
    for arguments, lag in (
        (["--smooth"], np.inf),
        (["--smooth-lag", "0.5"], 0.5),
        (["--smooth-lag", "0"], 0.0),
    ):
        assert main(["track", str(files / "squat.csv"), *noise, *arguments]) == 0
        found = columns(capsys)
        assert found["preset"] == "baroarma, smoothed"
        assert found["height_m"] == Tracker(noise=BMP085.noise).smooth(log, lag=lag).height.tolist()


@pytest.mark.parametrize(
    ("arguments", "settings"),
    [
        (["--level-prior-sd", "0.2"], {"level_prior_sd": 0.2}),
        (["--floors", "-3.2,0,3.2"], {"floors": (-3.2, 0.0, 3.2)}),
        (["--barometer-lag", "0.2"], {"barometer_lag": 0.2}),
    ],
)
def test_what_is_known_reaches_the_filter(files, capsys, arguments, settings):
    path, noise = str(files / "squat.csv"), ["--noise", str(files / "noise.json"), "--json"]
    assert main(["track", path, *noise, *arguments]) == 0
    found = columns(capsys)
    assert found["preset"] == "baroarma (own settings)"
    expected = Tracker(noise=BMP085.noise, height_settings=settings).run(read(path))
    assert found["height_m"] == expected.height.tolist()
    plain = Tracker(noise=BMP085.noise).run(read(path))
    assert expected.height.tolist() != plain.height.tolist()


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (["--preset", "sg14-a", "--smooth"], 1, "Complementary has no smoother; coloured-kalman has one"),
        (["--preset", "bourke08", "--smooth"], 1, "off-line already, and can't smooth"),
        (["--preset", "sg14-a", "--floors", "0,3"], 2, "has no setting 'floors'"),
        (["--preset", "bourke08", "--level-prior-sd", "0.2"], 2, "no back-ends to choose or set"),
        (["--floors", "0,three"], 2, "'0,three' is no list of numbers such as 0,3.2,6.4"),
        (["--floors", "0,nan"], 2, "'0,nan' is no list of numbers such as 0,3.2,6.4"),
        (["--smooth-lag", "-1"], 2, "-1"),
        (["--level-prior-sd", "0"], 2, "level-prior-sd"),
        (["--barometer-lag", "-0.1"], 2, "barometer-lag"),
    ],
)
def test_what_can_not_be_smoothed_or_known_is_refused_in_one_sentence(
    files, tmp_path, capsys, arguments, code, says
):
    out = tmp_path / "track.csv"
    assert main(["track", str(files / "squat.csv"), *arguments, "--out", str(out)]) == code
    captured = capsys.readouterr()
    assert says in captured.err
    assert len(captured.err.splitlines()) == 1
    assert captured.out == ""
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("arguments", [["--smooth"], ["--smooth-lag", "0"], ["--smooth-lag", "2"]])
def test_a_stream_can_not_be_smoothed(files, arguments, monkeypatch, capsys):
    import io

    monkeypatch.setattr("sys.stdin", io.StringIO(stream(files, lambda lines: None)))
    assert main(["track", "-", *arguments]) == 2
    assert "leave out --json, --map, --smooth" in capsys.readouterr().err
