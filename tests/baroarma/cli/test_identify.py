"""`baroarma identify`: models out of good files, one sentence out of bad ones."""

import gzip
import json
import subprocess
import sys

import numpy as np
import pytest

from baroarma import NoiseModel, read
from baroarma.cli import main
from baroarma.formats import write_csv
from baroarma.noise_model import JSON_KEYS
from baroarma.simulation import simulate, simulate_rest


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    for seed, name in ((1, "monday"), (2, "tuesday")):
        write_csv(simulate_rest(120, seed=seed), folder / f"{name}.csv")
    write_csv(simulate("squat", duration=30, seed=1), folder / "squat.csv")
    return folder


def rows(pressure="{p}", time="{t}", n=600, header="time_s,pressure_pa"):
    p = 101325 + np.random.default_rng(0).normal(0, 5, n)
    lines = [f"{time.format(t=k / 50)},{pressure.format(p=p[k])}" for k in range(n)]
    return "\n".join([header, *lines]) + "\n"


def spoilt(row, line):
    lines = rows().splitlines()
    lines[row] = line
    return "\n".join(lines) + "\n"


BAD = {
    "empty": ("", 2),
    "binary": (bytes(range(256)) * 40, 2),
    "damaged gzip": (gzip.compress(rows().encode())[:-400], 2),
    "ragged": (spoilt(300, "5.98,101325,7"), 2),
    "text in a cell": (spoilt(300, "5.98,broken"), 2),
    "time running backwards": (spoilt(300, "0.001,101325"), 2),
    "no pressure": (rows(header="time_s,temperature_c"), 2),
    "no time": (rows(header="clock,pressure_pa"), 2),
    "hPa labelled Pa": (rows(pressure="1013.2"), 1),
    "inf": (spoilt(300, "5.98,inf"), 2),
    "1e300": (spoilt(300, "5.98,1e300"), 2),
    "time 1e300": (spoilt(600, "1e300,101325"), 2),
    "only a header": ("time_s,pressure_pa\n", 2),
    "no sample anywhere": (rows(pressure="nan"), 2),
    "five rows": (rows(n=5), 1),
    "constant": (rows(pressure="101325"), 1),
}


@pytest.mark.parametrize("name", BAD)
@pytest.mark.parametrize("json_flag", [[], ["--json"]], ids=["text", "json"])
def test_a_bad_file_is_one_sentence_a_code_and_no_output(name, json_flag, tmp_path, capsys):
    content, code = BAD[name]
    path = tmp_path / ("log.csv.gz" if "gzip" in name else "log.csv")
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    out, page = tmp_path / "noise.json", tmp_path / "page.html"
    got = main(["identify", str(path), "--out", str(out), "--report", str(page), *json_flag])
    captured = capsys.readouterr()
    assert captured.err.startswith("baroarma: ")
    assert captured.err.count("\n") == 1
    assert "Traceback" not in captured.err
    assert got in {1, 2}
    assert got == code, captured.err
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    if json_flag and code == 1:  # the verdict is still one JSON document
        assert json.loads(captured.out)["correlated_sd_m"] is None
    elif json_flag:
        assert captured.out == ""


def test_a_folder_and_a_missing_file_are_exit_code_2(tmp_path, capsys):
    for path, reason in ((tmp_path, "this is a folder"), (tmp_path / "none.csv", "no such file")):
        assert main(["identify", str(path)]) == 2
        assert reason in capsys.readouterr().err


def test_a_bad_file_is_the_same_as_a_program(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(BAD["text in a cell"][0])
    program = "from baroarma.cli import entry_point; entry_point()"
    done = subprocess.run(
        [sys.executable, "-c", program, "identify", str(path), "--out", str(tmp_path / "n.json")],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("baroarma: ")
    assert done.stderr.count("\n") == 1
    assert "broken" in done.stderr
    assert not (tmp_path / "n.json").exists()


def test_moving_recordings_are_refused_with_nothing_written(folder, tmp_path, capsys):
    argv = ["identify", *(str(folder / f"{n}.csv") for n in ("monday", "squat", "tuesday"))]
    assert main([*argv, "--out", str(tmp_path / "n.json"), "--report", str(tmp_path / "p.html")]) == 1
    captured = capsys.readouterr()
    assert captured.err.startswith("baroarma: squat: This is no rest recording: the IMU moves")
    assert captured.err.endswith("Nothing was written.\n")
    assert list(tmp_path.iterdir()) == []
    assert "monday" in captured.out  # the table shows the others all the same


@pytest.mark.parametrize("option", ["--out", "--report"])
def test_an_output_in_no_folder_is_exit_code_2(folder, tmp_path, capsys, option):
    assert main(["identify", str(folder / "monday.csv"), option, str(tmp_path / "none" / "x")]) == 2
    captured = capsys.readouterr()
    assert "there is no folder" in captured.err
    assert captured.out == ""


def test_one_recording_gives_a_summary_and_a_model_that_loads(folder, tmp_path, capsys):
    out = tmp_path / "noise.json"
    assert main(["identify", str(folder / "monday.csv"), "--out", str(out)]) == 0
    captured = capsys.readouterr()
    assert "Noise of a barometric altimeter at 50 Hz (structural)" in captured.out
    said, what_next = captured.err.splitlines()
    assert said == f"noise model: {out}"
    assert what_next == f"next: baroarma whiten {out} --rate 50 --unity-gain-at 25"
    assert NoiseModel.load(out).source["name"] == "monday.csv"


def test_one_recordings_json_has_the_models_keys_at_the_top(folder, tmp_path, capsys):
    out = tmp_path / "noise.json"
    assert main(["identify", str(folder / "monday.csv"), "--json", "--out", str(out)]) == 0
    body, saved = json.loads(capsys.readouterr().out), json.loads(out.read_text())
    assert set(JSON_KEYS) < set(body)
    assert {key: body[key] for key in saved} == saved


def test_several_recordings_give_a_table_and_a_pooled_model(folder, tmp_path, capsys):
    out = tmp_path / "noise.json"
    files = [str(folder / f"{name}.csv") for name in ("monday", "tuesday")]
    assert main(["identify", *files, "--out", str(out)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[:4]] == ["recording", "monday", "tuesday", "pooled"]
    assert NoiseModel.load(out).method == "pooled"
    assert main(["identify", *files, "--json"]) == 0
    body = json.loads(capsys.readouterr().out)
    assert [r["recording"] for r in body["recordings"]] == ["monday", "tuesday"]
    assert body["pooled"]["white_sd_m"] == NoiseModel.load(out).white_sd


def test_a_report_is_written_for_one_and_for_several(folder, tmp_path, capsys):
    for names in (("monday",), ("monday", "tuesday")):
        page = tmp_path / f"{len(names)}.html"
        assert main(["identify", *(str(folder / f"{n}.csv") for n in names), "--report", str(page)]) == 0
        assert all(name in page.read_text() for name in names)
        assert capsys.readouterr().err.startswith(f"page: {page}\nnext: baroarma identify ")


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--terms", "pink"], "'pink' is no term"),
        (["--terms", ""], "no term"),
        (["--terms", "white,gm", "--method", "windows"], "--terms belongs to --method structural"),
        (["--window", "200"], "--window belongs to --method windows"),
        (["--detrend", "60"], "--detrend belongs to --method windows"),
        (["--split", "bilinear"], "--split belongs to --method windows"),
        (["--method", "windows", "--window", "5"], "too short for ARMA"),
        (["--method", "windows", "--trim", "2"], "trim must be a fraction"),
        (["--method", "guess"], "'guess'"),
        (["--start", "500"], "no rows"),
        (["--map", "pressure_pa=Baro"], "'Baro'"),
    ],
)
def test_options_that_cannot_be_are_exit_code_2(folder, capsys, options, sentence):
    assert main(["identify", str(folder / "monday.csv"), *options]) == 2
    err = capsys.readouterr().err
    assert sentence in err
    assert err.count("\n") == 1


def test_terms_settings_temperature_and_cuts_reach_the_identification(folder, capsys):
    def identified(*options):
        assert main(["identify", str(folder / "monday.csv"), "--json", *options]) == 0
        return json.loads(capsys.readouterr().out)

    assert identified("--terms", "white, drift")["correlated_sd_m"] == 0
    assert identified("--start", "20", "--stop", "100")["source"]["duration_s"] == pytest.approx(79.98)
    plain, warm = identified(), identified("--temperature", "40")
    assert warm["white_sd_m"] > 1.05 * plain["white_sd_m"]
    windows = identified("--method", "windows", "--window", "150", "--split", "bilinear", "--trim", "0")
    assert windows["windows"]["settings"]["window"] == 150
    assert windows["windows"]["settings"]["trim"] == 0
    assert windows["windows"]["split"] == "bilinear"


def test_files_without_pressure_belong_to_the_one_before(tmp_path, capsys):
    squat = simulate("squat", duration=30, seed=1)
    write_csv(simulate_rest(30, seed=1), tmp_path / "x_baro.csv")
    acc = "\n".join(
        ["time_s,acc_x_m_s2,acc_y_m_s2,acc_z_m_s2"]
        + [f"{t},{a[0]},{a[1]},{a[2]}" for t, a in zip(squat.t, squat.accel, strict=True)]
    )
    (tmp_path / "x_acc.csv").write_text(acc + "\n")
    files = [str(tmp_path / f"x_{sensor}.csv") for sensor in ("baro", "acc")]
    assert read(*files).accel is not None
    assert main(["identify", *files]) == 1
    assert "x: This is no rest recording: the IMU moves" in capsys.readouterr().err
