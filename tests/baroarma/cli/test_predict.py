"""`baroarma predict`: a table, a document, a plot, a sentence."""

import json

import pytest

import baroarma as ba
from baroarma.cli import main
from baroarma.formats import write_csv
from baroarma.simulation import BMP085, simulate


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("predict")
    BMP085.noise.save(folder / "noise.json")
    write_csv(simulate("rest", duration=20, seed=1), folder / "rest.csv")
    write_csv(simulate("squat", duration=20, seed=1), folder / "squat.csv")
    return folder


@pytest.fixture
def run(files, monkeypatch, capsys):
    monkeypatch.chdir(files)

    def call(*arguments):
        code = main(["predict", "--noise", "noise.json", "--duration", "10", *arguments])
        return code, *capsys.readouterr()

    return call


def test_the_table_is_that_of_python(run):
    code, out, err = run("--preset", "sg14-a", "--horizontal-acceleration", "1")
    found = ba.predict_accuracy(BMP085.noise, "simple", "sg14-a", 10.0, horizontal_acceleration=1.0)
    assert (code, out) == (0, found.summary() + "\n")
    assert err == "next: baroarma predict --noise noise.json --preset sg14-a --imu simple --tune\n"


def test_json_is_one_document_with_the_sds_over_time(run):
    code, out, _ = run("--preset", "lee16", "--imu", "wimu", "--json")
    document = json.loads(out)
    expected = ba.predict_accuracy(BMP085.noise, "wimu", "lee16", 10.0).to_dict()
    assert (code, document) == (0, expected)
    assert len(document["time_s"]) == len(document["height_sd_m"]) == 500


def test_a_recording_of_the_imu_at_rest_will_do(run):
    code, out, _ = run("--preset", "sg14-a", "--imu", "rest.csv", "--json")
    found = ba.ImuNoise.from_recording(ba.read("rest.csv"))
    assert code == 0
    assert json.loads(out)["imu"] == found.to_dict()


def test_tuning_shows_before_and_after(run):
    code, out, _ = run("--preset", "sg14-a", "--tune", "--json")
    document = json.loads(out)
    assert code == 0
    assert set(document["height_settings"]) == {"acceleration_sd", "altitude_sd"}
    assert document["after"]["velocity_rms_m_s"] < document["before"]["velocity_rms_m_s"]
    assert "nothing to tune" in run("--tune")[1]


def test_the_plot_goes_to_a_file(run, files):
    code, _, err = run("--preset", "sg14-a", "--plot", "sds.svg")
    assert code == 0
    assert err.startswith("plot: sds.svg\nnext: ")
    assert (files / "sds.svg").read_text(encoding="utf-8").lstrip().startswith("<?xml")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--preset", "zhang12"], "errors of 'zhang12' depend on the motion"),
        (["--preset", "none"], "there is no preset 'none'"),
        (["--imu", "squat.csv"], "squat is not at rest"),
        (["--imu", "nothing.csv"], "nothing.csv is no file and no device"),
        (["--duration", "1"], "run of 1 s"),
        (["--noise", "rest.csv"], "rest.csv"),
        (["--plot", "x.tex"], "'tex' is not supported"),
    ],
    ids=lambda value: "-".join(value) if isinstance(value, list) else None,
)
def test_refusals_are_one_sentence(run, arguments, says):
    code, out, err = run(*arguments)
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert says in line
