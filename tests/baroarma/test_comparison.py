"""The bake-off: a row per preset, readable, with each note once."""

import json
from dataclasses import replace

import numpy as np
import pytest

import baroarma as ba
from baroarma.comparison import compare
from baroarma.finding import Finding
from baroarma.metrics import errors
from baroarma.presets import PRESETS
from baroarma.simulation import BMP085, simulate
from baroarma.tracker import Tracker

NOTE = Finding("held-samples", "warning", "Some were dropped.")


@pytest.fixture(scope="module")
def squat():
    return replace(simulate("squat", duration=20, seed=1), notes=(NOTE,))


@pytest.fixture(scope="module")
def found(squat):
    return compare(squat, presets=("sg14-b", "baroarma"), noise=BMP085.noise)


def test_each_row_holds_what_the_tracker_itself_gives(found, squat):
    for row in found.rows:
        track = Tracker.preset(row.preset, noise=BMP085.noise).run(squat)
        assert np.array_equal(row.track.height, track.height)
        assert row.errors == errors(track, squat)
        assert row.us_per_sample > 0


def test_the_json_is_the_documented_one_and_names_the_note_once(found):
    document = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert [row["preset"] for row in document["rows"]] == ["sg14-b", "baroarma"]
    keys = {"preset", "height_rmse_m", "velocity_rmse_m_s", "height_bias_m", "us_per_sample"}
    assert keys <= set(document["rows"][0])
    assert json.dumps(document).count("held-samples") == 1
    assert [f["code"] for f in document["rows"][0]["findings"]] == ["dc-gain"]


def test_the_table_is_aligned_and_names_the_note_once(found):
    lines = found.summary().splitlines()
    head, *rows = lines[1:4]
    assert head.split()[0] == "preset"
    assert {len(row) for row in rows} == {len(head)}
    assert found.summary().count("held-samples") == 1
    assert "  sg14-b: warning (dc-gain)" in found.summary()


def test_a_preset_that_can_not_is_named_with_its_reason():
    recording = simulate("rest", duration=10, imu=None, seed=1)
    found = compare(recording, presets=("baroarma", "lee16"), noise=BMP085.noise)
    assert found.rows[0].refusal == ""
    assert found.rows[1].track is None
    assert "no accelerometer and gyro" in found.rows[1].refusal
    assert found.rows[1].refusal in found.summary()
    assert found.to_dict()["rows"][1]["height_rmse_m"] is None


def test_without_reference_errors_are_null_and_closure_is_there(squat):
    found = compare(replace(squat, reference=None, reference_velocity=None), presets=("sg14-a",))
    row = found.to_dict()["rows"][0]
    assert row["height_rmse_m"] is row["velocity_rmse_m_s"] is row["height_bias_m"] is None
    assert row["closure_m"] == pytest.approx(np.mean(found.rows[0].track.height[-51:]))


def test_a_late_reference_is_named_until_it_is_accounted_for(shared_data):
    lift = ba.read(shared_data / "stampfly_tof_handheld" / "lift30cm_b.csv.gz")
    names = ("baroarma", "sg14-a", "lee16")
    before = compare(lift, presets=names)
    finding = next(f for f in before.findings if f.code == "reference-lag")
    lag = float(finding.message.split("be ")[1].split(" s")[0])
    assert 0.18 < lag < 0.25
    after = compare(lift, presets=names, reference_lag=lag)
    assert not after.findings
    for one, other in zip(before.rows, after.rows, strict=True):
        assert other.errors.velocity_rmse < one.errors.velocity_rmse


def test_all_presets_are_compared_unless_some_are_named(squat):
    assert [row.preset for row in compare(squat).rows] == list(PRESETS)
    with pytest.raises(ValueError, match="no preset 'x'"):
        compare(squat, presets=("baroarma", "x"))
    with pytest.raises(ValueError, match="nothing to compare"):
        compare(squat, presets=())


def test_the_frame_has_a_row_per_preset(found):
    frame = found.to_frame()
    assert list(frame["preset"]) == ["sg14-b", "baroarma"]
    assert "sg14-b" in found._repr_html_()


def test_one_preset_may_be_named_without_a_list(squat):
    alone = compare(squat, presets="sg14-a", noise=BMP085.noise)
    assert repr(alone) == "<Comparison on 'squat': sg14-a>"
