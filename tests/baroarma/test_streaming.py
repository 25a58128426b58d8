"""Part by part is the same as at once, and an interruption leaves no torn file."""

import io
import os
import signal
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest

from baroarma.cli import main
from baroarma.formats import csv, long, parquet, read, write_csv
from baroarma.formats.long import LongRecording
from baroarma.identification import identify
from baroarma.presets import PRESETS
from baroarma.simulation import BMP085, simulate
from baroarma.streaming import read_rest, track_file
from baroarma.tracker import Tracker

COLUMNS = ("height", "velocity", "height_sd", "velocity_sd", "acceleration")
ON_LINE = [name for name, preset in PRESETS.items() if preset.height is not None]


@pytest.fixture(scope="module")
def log():
    """Squats with a barometer slower than the IMU, samples lost and the IMU silent for a while."""
    recording = simulate("squat", duration=20, device="gy-87", rate_hz=100, seed=3)
    pressure, accel = recording.pressure.copy(), recording.accel.copy()
    pressure[700:730] = np.nan
    accel[990:1003] = accel[1400:1460] = np.nan
    return replace(recording, pressure=pressure, accel=accel)


@pytest.mark.parametrize("preset", ON_LINE)
@pytest.mark.parametrize("edges", [(0, 500, 1000, 1001, 1430, 2000), (0, 150, 715, 2000)])
def test_fed_part_by_part_a_tracker_gives_the_rows_of_one_run(log, preset, edges):
    tracker = Tracker.preset(preset, noise=BMP085.noise)
    whole = tracker.run(log)
    tracker.reset()
    parts = [tracker.feed(log.rows(slice(a, b))) for a, b in pairwise(edges)]
    for name in COLUMNS:
        column = np.concatenate([getattr(part, name) for part in parts])
        # the same operations in the same order; compiled loops may fuse them differently for one row
        np.testing.assert_allclose(column, getattr(whole, name), rtol=0, atol=1e-9, err_msg=name)


def test_a_part_out_of_order_is_refused_in_a_sentence(log):
    tracker = Tracker.preset("sg14-a")
    tracker.feed(log.between(0, 10))
    with pytest.raises(ValueError, match=r"begins at 5 s, not after 9.99 s"):
        tracker.feed(log.between(5, 15))


def test_a_step_between_two_parts_counts(log):
    whole, tracker = Tracker.preset("sg14-a").run(log), Tracker.preset("sg14-a")
    tracker.feed(log.rows(slice(0, 1000)))
    tracker.step(dt=0.01, pressure=log.pressure[1000], accel=log.accel[1000], gyro=log.gyro[1000])
    rest = tracker.feed(log.rows(slice(1001, 2000)))
    np.testing.assert_allclose(rest.height, whole.height[1001:], rtol=0, atol=1e-9)


@pytest.fixture
def small_parts(monkeypatch):
    monkeypatch.setattr(parquet, "ROWS", 377)
    monkeypatch.setattr(csv, "BLOCK", 50_001)
    monkeypatch.setattr(long, "LONG", 1)


@pytest.mark.parametrize("out", ["track.csv", "track.parquet"])
@pytest.mark.parametrize("preset", ["sg14-b", "baroarma"])
def test_the_streamed_track_is_the_file_that_the_whole_gives(log, tmp_path, small_parts, preset, out):
    write_csv(log, path := tmp_path / "log.csv.gz")
    tracker, told = Tracker.preset(preset, noise=BMP085.noise), []
    whole = tracker.run(read(path))
    found = track_file(tracker, LongRecording(path), tmp_path / out, progress=lambda *rows: told.append(rows))
    whole.save(tmp_path / f"whole_{out}")
    reader = pd.read_parquet if out.endswith(".parquet") else pd.read_csv
    written, at_once = reader(tmp_path / out), reader(tmp_path / f"whole_{out}")
    pd.testing.assert_frame_equal(written, at_once, check_exact=False, rtol=0, atol=1e-9)
    assert repr(found) == repr(whole)
    assert found.findings == whole.findings
    assert len(told) > 3
    assert told[-1] == (len(log), len(log))


def test_the_first_part_grows_until_it_can_align(log, tmp_path, monkeypatch):
    monkeypatch.setattr(parquet, "ROWS", 30)  # 0.3 s
    late = replace(log, pressure=np.where(log.t < 3, np.nan, log.pressure))
    write_csv(late, path := tmp_path / "log.parquet")
    tracker, out = Tracker.preset("sg14-a"), io.StringIO()
    found = track_file(tracker, LongRecording(path), out)
    whole = tracker.run(read(path))
    assert found.findings == whole.findings
    assert "late-barometer" in {finding.code for finding in found.findings}
    height = pd.read_csv(io.StringIO(out.getvalue())).height_m
    np.testing.assert_allclose(height, whole.height, rtol=0, atol=1e-9)


def test_a_track_that_leaves_the_barometer_late_is_found_out(log, tmp_path, small_parts):
    gone = replace(log, accel=log.accel + np.where(log.t[:, None] > 12, 4.0, 0.0) * [0, 0, 1])
    write_csv(gone, path := tmp_path / "log.parquet")
    tracker = Tracker.preset("sg14-a")
    found, whole = track_file(tracker, LongRecording(path), io.StringIO()), tracker.run(read(path))
    assert found.findings == whole.findings
    assert "diverged" in {finding.code for finding in found.findings}


def test_what_works_off_line_is_refused(log, tmp_path):
    write_csv(log, path := tmp_path / "log.csv")
    with pytest.raises(ValueError, match="needs the whole recording"):
        track_file(Tracker.preset("bourke08"), LongRecording(path), io.StringIO())


@pytest.mark.parametrize("moves", [0.0, 0.35], ids=["at rest", "moved"])
def test_a_rest_read_part_by_part_is_identified_as_the_whole_is(tmp_path, small_parts, moves):
    rest = simulate("rest", duration=200, seed=2)
    turning = np.where((rest.t > 100.5) & (rest.t < 120.2), moves, 0.0)
    write_csv(replace(rest, gyro=rest.gyro + turning[:, None]), path := tmp_path / "rest.csv")
    whole, in_parts = identify(read(path)), identify(read_rest(path))
    assert in_parts.verdict == whole.verdict
    assert in_parts.model == whole.model
    assert in_parts.ok == (not moves)
    assert "21 of 200 seconds" in str(in_parts.verdict) or not moves  # second 100 to second 120
    assert in_parts.recording.accel is None


def test_an_interruption_leaves_the_old_file_and_nothing_else(log, tmp_path, small_parts):
    write_csv(log, path := tmp_path / "log.csv")
    (out := tmp_path / "track.csv").write_text("old")

    def interrupt(done, total):
        raise KeyboardInterrupt

    for target in (out, tmp_path / "new.parquet"):
        with pytest.raises(KeyboardInterrupt):
            track_file(Tracker.preset("sg14-a"), LongRecording(path), target, progress=interrupt)
    assert out.read_text() == "old"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["log.csv", "track.csv"]


INTERRUPTED = """
import sys, time
from baroarma.cli import main
from baroarma.formats import csv, long
from baroarma.tracker import Tracker
long.LONG, csv.BLOCK, feed = 1, 50_000, Tracker.feed
def slow(tracker, part):
    print("part", flush=True)
    time.sleep(0.3)
    return feed(tracker, part)
Tracker.feed = slow
sys.exit(main(["track", sys.argv[1], "--preset", "sg14-a", "--out", sys.argv[2]]))
"""


@pytest.mark.skipif(os.name == "nt", reason="Windows sends no SIGINT to a process alone")
def test_ctrl_c_ends_the_command_without_a_torn_file(log, tmp_path):
    write_csv(log, path := tmp_path / "log.csv")
    command = [sys.executable, "-c", INTERRUPTED, str(path), str(tmp_path / "track.csv")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert [process.stdout.readline() for _ in range(3)] == ["part\n"] * 3
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "baroarma: interrupted; " in said
    assert [p.name for p in tmp_path.iterdir()] == ["log.csv"]


def test_the_command_line_streams_a_long_file_with_the_same_result(log, tmp_path, monkeypatch, capsys):
    write_csv(log, path := tmp_path / "log.parquet")
    arguments = ["track", str(path), "--preset", "sg14-a", "--start", "2", "--stop", "17"]
    assert main(arguments) == 0
    at_once = capsys.readouterr()
    monkeypatch.setattr(long, "LONG", 1)
    monkeypatch.setattr(parquet, "ROWS", 377)
    assert main(arguments) == 0
    in_parts = capsys.readouterr()
    assert in_parts.err == at_once.err
    for one, other in zip(in_parts.out.splitlines()[1:], at_once.out.splitlines()[1:], strict=True):
        np.testing.assert_allclose(
            [float(cell) for cell in one.split(",")], [float(cell) for cell in other.split(",")], atol=1e-9
        )


def test_the_command_line_identifies_a_long_file_with_the_same_result(tmp_path, monkeypatch, capsys):
    write_csv(simulate("rest", duration=120, seed=2), path := tmp_path / "rest.parquet")
    assert main(["identify", str(path), "--json", "--start", "10"]) == 0
    at_once = capsys.readouterr().out
    monkeypatch.setattr(long, "LONG", 1)
    monkeypatch.setattr(parquet, "ROWS", 377)
    assert main(["identify", str(path), "--json", "--start", "10"]) == 0
    assert capsys.readouterr().out == at_once
