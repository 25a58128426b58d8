"""What stands in a `noise.json`: old files are read for ever, broken ones refused by every command."""

import copy
import json
import math
import os
import re
import threading
from pathlib import Path

import pytest

from baroarma.cli import main
from baroarma.noise_model import JSON_KEYS, PARAMETERS, TERM_NAMES, TEST_NAMES, NoiseModel

STORED = Path(__file__).with_name("stored")
WHOLE = json.loads((STORED / "noise_v1_structural.json").read_text())


@pytest.mark.parametrize("file", sorted(STORED.glob("noise_v*.json")), ids=lambda file: file.stem)
def test_a_stored_file_of_every_version_is_still_read(file, tmp_path, capsys):
    said = json.loads(file.read_text())
    noise = NoiseModel.load(file)
    for key, name in zip(JSON_KEYS, PARAMETERS, strict=True):
        assert getattr(noise, name) == said[key]
        if said.get("ci95"):
            assert noise.ci95[name] == tuple(said["ci95"][key])
    assert noise.rate_hz == said["rate_hz"]
    noise.save(tmp_path / "again.json")
    again = json.loads((tmp_path / "again.json").read_text())
    assert {key: again[key] for key in said} == said
    assert main(["whiten", str(file)]) == 0
    capsys.readouterr()


def changed(path, value):
    """Return the stored model with another value at a path of keys, such as ``ci95/white_sd_m``."""
    document = copy.deepcopy(WHOLE)
    *parents, last = path.split("/")
    at = document
    for key in parents:
        at = at[key]
    at[last] = value
    return json.dumps(document)


def without(key):
    return json.dumps({name: value for name, value in WHOLE.items() if name != key})


BROKEN = {
    "empty": ("", " is no JSON (Expecting value: line 1 column 1 (char 0)); "),
    "cut off": (json.dumps(WHOLE)[:-40], " is no JSON (Expecting ',' delimiter"),
    "text": ("white_sd = 0.3", " is no JSON (Expecting value"),
    "binary": (b"\x89PNG\r\n\xff", " is no JSON ('utf-8' codec can't decode byte 0x89"),
    "UTF-16": (json.dumps(WHOLE).encode("utf-16"), " is no JSON ('utf-8' codec can't decode byte"),
    "nested": (
        "[" * 100_000,
        " is no JSON (nested too deeply); `baroarma identify --out` writes noise models",
    ),
    "too large": (json.dumps(WHOLE) + " " * (1 << 20), " is larger than 1048576 bytes; it can't"),
    "a key twice": (
        json.dumps(WHOLE).replace('"rate_hz"', '"white_sd_m": 1, "rate_hz"'),
        " is no JSON (the key 'white_sd_m' stands there twice)",
    ),
    "NaN": (changed("white_sd_m", math.nan), " is no JSON (NaN is no number)"),
    "infinity": (changed("ci95/white_sd_m", [0, math.inf]), " is no JSON (Infinity is no number)"),
    "a list": ("[1, 2]", ': this is no noise model: the key "format" must be "baroarma.noise-model"'),
    "another format": (changed("format", "geojson"), ": this is no noise model"),
    "another version": (
        changed("version", 0),
        ": there is no version 0 of noise models; the file must say 1",
    ),
    "a version of text": (changed("version", "1"), ": there is no version '1' of noise models"),
    "no version": (without("version"), ": there is no version None of noise models"),
    "a newer version": (
        changed("version", 2),
        ": version 2 was written by a newer baroarma; update: pip install --upgrade baroarma",
    ),
    "a key missing": (
        without("drift_rate_m_per_sqrt_s"),
        ": this noise model lacks the key 'drift_rate_m_per_sq",
    ),
    "no rate": (without("rate_hz"), ": this noise model lacks the key 'rate_hz'"),
    "text for a number": (
        changed("white_sd_m", "0.3"),
        ": white_sd_m is of the wrong kind: '0.3' is not a number",
    ),
    "true for a number": (
        changed("white_sd_m", True),
        ": white_sd_m is of the wrong kind: True is not a number",
    ),
    "null for a number": (changed("rate_hz", None), ": rate_hz is of the wrong kind: None is not a number"),
    "negative": (changed("white_sd_m", -0.1), ": white_sd must be a number >= 0, but it is -0.1"),
    "1e400": (
        changed("white_sd_m", 0).replace('"white_sd_m": 0,', '"white_sd_m": 1e400,'),
        ": white_sd_m must be fin",
    ),
    "10^400": (changed("white_sd_m", 10**400), ": white_sd_m must be finite, but it is inf"),
    "1e300": (changed("white_sd_m", 1e300), ": white_sd is 1e+300, which no altimeter has"),
    "1e-300": (changed("correlation_time_s", 1e-300), ": correlation_time is 1e-300, which no altimeter has"),
    "half a Gauss-Markov term": (
        changed("correlated_sd_m", 0),
        ": correlated_sd = 0.0 and correlation_time =",
    ),
    "intervals of text": (changed("ci95", "wide"), ": ci95 is of the wrong kind: 'wide' is not an object"),
    "an interval missing": (changed("ci95", {}), ": ci95 lacks the key 'correlated_sd_m'"),
    "an interval of one": (
        changed("ci95/white_sd_m", [1]),
        ": ci95 of white_sd_m is of the wrong kind: it needs two",
    ),
    "an interval upside down": (
        changed("ci95/white_sd_m", [2, 1]),
        ": ci95 of white_sd_m must be [low, high] with 0 <= low <= high, but it is [2, 1]",
    ),
    "a verdict of text": (changed("verdict", "fine"), ": verdict is of the wrong kind: 'fine' is not a list"),
    "a finding of text": (
        changed("verdict", ["fine"]),
        ": verdict is of the wrong kind: 'fine' is not an object",
    ),
    "a finding without code": (
        changed("verdict", [{"severity": "info"}]),
        ": a finding's code is of the wrong kind",
    ),
    "a severity of its own": (
        changed("verdict", [{"code": "a", "severity": "red", "message": "b"}]),
        ": a finding's severity is 'red'; it is info, warning or error",
    ),
    "a sensor of numbers": (changed("sensor", 280), ": sensor is of the wrong kind: 280 is not a text"),
    "p-values of text": (
        changed("whiteness_p/bartlett", "white"),
        ": whiteness_p bartlett is of the wrong kind",
    ),
    "a source of text": (
        changed("source", "a.csv"),
        ": source is of the wrong kind: 'a.csv' is not an object",
    ),
}


@pytest.mark.parametrize("fault", BROKEN)
def test_a_broken_file_is_refused_in_one_sentence_by_every_command(fault, tmp_path, capsys):
    content, sentence = BROKEN[fault]
    path, log = tmp_path / "noise.json", tmp_path / "log.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    log.write_text("time_s,pressure_pa\n0,1e5\n")
    out = ["--out", str(tmp_path / "out")]
    for argv in (["whiten", path], ["track", log, "--noise", path], ["predict", "--noise", path]):
        assert main([*map(str, argv), *(out if argv[0] != "predict" else [])]) == 2
        said = capsys.readouterr()
        assert said.out == ""
        assert said.err.startswith(f"baroarma: {path}{sentence}"), said.err
        assert said.err.count("\n") == 1
        assert len(said.err) < 400
    assert sorted(os.listdir(tmp_path)) == ["log.csv", "noise.json"]


def test_a_byte_order_mark_and_unknown_keys_do_no_harm(tmp_path):
    path = tmp_path / "noise.json"
    path.write_text("\ufeff" + json.dumps({**WHOLE, "comment": "bench 3"}), encoding="utf-8")
    assert NoiseModel.load(path) == NoiseModel.from_dict(WHOLE)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="there are no such devices")
def test_a_pipe_can_be_read_and_what_has_no_end_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    writer = threading.Thread(target=lambda: (tmp_path / "pipe").write_text(json.dumps(WHOLE)))
    writer.start()
    assert NoiseModel.load(tmp_path / "pipe") == NoiseModel.from_dict(WHOLE)
    writer.join()
    with pytest.raises(ValueError, match="/dev/zero is larger than 1048576 bytes"):
        NoiseModel.load("/dev/zero")
    with pytest.raises(ValueError, match="/dev/null is no JSON"):
        NoiseModel.load("/dev/null")


def test_every_whiteness_test_that_a_file_tells_has_a_name():
    assert set(TEST_NAMES) == set(WHOLE["whiteness_p"])
    assert set(TERM_NAMES) == {"white", "drift", "gm", "gm2"}


@pytest.mark.parametrize(
    ("spoilt", "sentence"),
    [
        (changed("version", True), "there is no version True of noise models; the file must say 1"),
        (changed("version", 1.0), "there is no version 1.0 of noise models"),
        (changed("version", -1), "there is no version -1 of noise models"),
        (changed("method", None), "method is of the wrong kind: None is not a text"),
        (changed("ci95/white_sd_m", {"low": 0}), "ci95 of white_sd_m is of the wrong kind: {'low': 0} is"),
        (changed("ci95/white_sd_m", [0, 1, 2]), "ci95 of white_sd_m is of the wrong kind: it needs two"),
        (changed("ci95/white_sd_m", [-1, 2]), "but it is [-1, 2]"),
        (changed("ci95/white_sd_m", [0, "x"]), "ci95 of white_sd_m is of the wrong kind: 'x' is not a"),
        (changed("whiteness_p", [0.5]), "whiteness_p is of the wrong kind: [0.5] is not an object"),
    ],
)  # fmt: skip
def test_a_wrong_value_is_told_with_its_key(spoilt, sentence, tmp_path):
    path = tmp_path / "noise.json"
    path.write_text(spoilt)
    with pytest.raises(ValueError, match=re.escape(sentence)):
        NoiseModel.load(path)


def test_what_a_model_needs_is_told_when_a_key_is_missing():
    needed = "correlated_sd_m, correlation_time_s, white_sd_m, drift_rate_m_per_sqrt_s, rate_hz"
    with pytest.raises(ValueError, match=f"lacks the key 'rate_hz'; it needs {needed}$"):
        NoiseModel.from_dict(json.loads(without("rate_hz")))


def test_what_may_be_left_out_has_its_default():
    needed = {key: WHOLE[key] for key in ("format", "version", *JSON_KEYS, "rate_hz")}
    noise = NoiseModel.from_dict(needed)
    assert (noise.ci95, noise.method, noise.sensor, noise.verdict) == (None, "by hand", "", ())
    assert (noise.whiteness_p, noise.source) == (None, None)
    assert NoiseModel.from_dict({**needed, "rate_hz": 50}).rate_hz == 50.0
    equal = {key: [0.5, 0.5] for key in JSON_KEYS}
    nothing = {key: [0, 0] for key in JSON_KEYS}
    assert set(NoiseModel.from_dict({**needed, "ci95": equal}).ci95.values()) == {(0.5, 0.5)}
    assert set(NoiseModel.from_dict({**needed, "ci95": nothing}).ci95.values()) == {(0.0, 0.0)}


def test_as_many_bytes_as_allowed_are_read(tmp_path):
    path = tmp_path / "noise.json"
    path.write_text(json.dumps(WHOLE).ljust(1 << 20))
    assert NoiseModel.load(path) == NoiseModel.from_dict(WHOLE)
    path.write_text(json.dumps(WHOLE).ljust((1 << 20) + 1))
    with pytest.raises(ValueError, match="is larger than 1048576 bytes"):
        NoiseModel.load(path)
