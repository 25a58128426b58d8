"""`baroarma whiten`: SG13's numbers, any unity gain, every format, and refusals in a sentence."""

import cmath
import json

import pytest

from baroarma import NoiseModel
from baroarma.cli import main
from baroarma.export import FORMATS

SG13 = ["whiten", "--arma", "-0.86", "-0.52", "--interval", "0.1", "--rate", "50"]
NOISE = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)


@pytest.fixture
def noise_json(tmp_path):
    NOISE.save(tmp_path / "noise.json")
    return str(tmp_path / "noise.json")


def test_sg13s_filter_comes_from_its_arma(capsys):
    assert main([*SG13, "--unity-gain-at", "25"]) == 0
    captured = capsys.readouterr()
    body = json.loads(captured.out)
    assert set(body) == {"b", "a", "rate_hz", "unity_gain_hz", "dc_gain", "zero_hz", "pole_hz"}
    # method.md §2, printed to as many digits; SG13, Sec. 3.1 says about 0.21, from a = -0.87, b = -0.50
    assert body["b"] == pytest.approx([0.954754, -0.926435], abs=1e-6)
    assert body["a"] == pytest.approx([1, -0.881188], abs=1e-6)
    assert body["dc_gain"] == pytest.approx(0.23835, abs=1e-5)
    assert body["zero_hz"] == pytest.approx(0.23959, abs=1e-5)
    assert body["pole_hz"] == pytest.approx(1.00519, abs=1e-5)
    assert "0.2384 times its size" in captured.err


@pytest.mark.parametrize("frequency", [0, 0.5, 3, 25])
def test_the_gain_is_one_where_it_was_asked_for(capsys, noise_json, frequency):
    assert main(["whiten", noise_json, "--unity-gain-at", str(frequency)]) == 0
    body = json.loads(capsys.readouterr().out)
    z = cmath.exp(-2j * cmath.pi * frequency / 50)
    gain = (body["b"][0] + body["b"][1] * z) / (body["a"][0] + body["a"][1] * z)
    assert abs(gain) == pytest.approx(1, abs=1e-12)


def test_unity_gain_at_zero_leaves_heights_as_they_are_and_says_nothing_of_gain(capsys, noise_json):
    assert main(["whiten", noise_json, "--unity-gain-at", "0"]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line == f"next: baroarma track RECORDING.csv --noise {noise_json} --preset sg14-b"


def test_the_model_is_whitened_at_its_own_rate_and_nyquist_by_default(capsys, noise_json):
    assert main(["whiten", noise_json]) == 0
    body = json.loads(capsys.readouterr().out)
    assert (body["rate_hz"], body["unity_gain_hz"]) == (50, 25)
    assert body == NOISE.whitening_filter().to_dict()
    assert main(["whiten", noise_json, "--rate", "20"]) == 0
    assert json.loads(capsys.readouterr().out) == NOISE.whitening_filter(rate_hz=20).to_dict()


@pytest.mark.parametrize(
    ("argv", "sentence"),
    [
        ([*SG13, "--unity-gain-at", "25.1"], "choose a frequency from 0 to 25 Hz"),
        ([*SG13, "--unity-gain-at", "-1"], "choose a frequency from 0"),
        ([*SG13[:-1], "0"], "rate must be a positive number"),
        ([*SG13[:-2]], "--arma needs --interval and --rate"),
        (["whiten"], "give either"),
        ([*SG13, "noise.json"], "give either"),
        (["whiten", "noise.json", "--interval", "0.1"], "--interval belongs to --arma"),
        (["whiten", "no-such.json"], "no-such.json"),
        (["whiten", "--arma", "-1.2", "-0.5", "--interval", "0.1", "--rate", "50"], "not stationary"),
        (["whiten", "--arma", "nan", "-0.5", "--interval", "0.1", "--rate", "50"], "finite"),
        ([*SG13, "--json", "--format", "c"], "exclude each other"),
        ([*SG13, "--format", "matlab"], "'matlab'"),
        ([*SG13, "--out", "no-such-folder/w.json"], "there is no folder"),
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(capsys, argv, sentence):
    assert main(argv) == 2
    captured = capsys.readouterr()
    assert sentence in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""


@pytest.mark.parametrize(
    "content", ["", "{}", "[1]", '{"format": "baroarma.noise-model", "version": 2}', "\0\x80"]
)
def test_a_file_that_is_no_noise_model_is_exit_code_2(tmp_path, capsys, content):
    path = tmp_path / "noise.json"
    path.write_text(content)
    assert main(["whiten", str(path), "--out", str(tmp_path / "w.json")]) == 2
    assert str(path) in capsys.readouterr().err
    assert not (tmp_path / "w.json").exists()


def test_noise_without_a_gauss_markov_component_needs_no_filter_and_says_so(tmp_path, capsys):
    NoiseModel(0, 0, 0.4, 0.01, rate_hz=50).save(tmp_path / "white.json")
    assert main(["whiten", str(tmp_path / "white.json")]) == 0
    captured = capsys.readouterr()
    body = json.loads(captured.out)
    assert (body["b"], body["a"], body["dc_gain"]) == ([1.0], [1.0], 1.0)
    assert body["zero_hz"] is body["pole_hz"] is None
    assert "the filter is 1" in captured.err


def test_out_gets_what_stdout_would(tmp_path, capsys, noise_json):
    for form in FORMATS:
        assert main(["whiten", noise_json, "--format", form]) == 0
        text = capsys.readouterr().out
        assert main(["whiten", noise_json, "--format", form, "--out", str(tmp_path / form)]) == 0
        assert capsys.readouterr().out == ""
        assert (tmp_path / form).read_text() == text


def test_swapped_coefficients_are_pointed_out(capsys):
    arguments = ["--interval", "0.1", "--rate", "50", "--unity-gain-at", "25"]
    assert main(["whiten", "--arma", "-0.52", "-0.86", *arguments]) == 0
    assert "are the two swapped?" in capsys.readouterr().err
    assert main(["whiten", "--arma", "-0.86", "-0.52", *arguments]) == 0
    assert "swapped" not in capsys.readouterr().err
