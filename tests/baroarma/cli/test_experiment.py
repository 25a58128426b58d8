"""`baroarma experiment`."""

import json

import pytest

from baroarma.cli import main


def run(capsys, *arguments):
    code = main(["experiment", *arguments])
    out, err = capsys.readouterr()
    return code, out, err


def test_one_seed_gives_the_same_numbers_whatever_the_workers(capsys):
    arguments = "sg14-table-3", "--trials", "2", "--seed", "5", "--json", "--workers"
    first, second = (run(capsys, *arguments, workers) for workers in ("1", "2"))
    assert first == second
    assert first[0] == 0
    assert run(capsys, "sg14-table-3", "--trials", "2", "--seed", "6", "--json", "--workers", "1") != first


def test_json_is_one_object_as_documented(capsys):
    code, out, err = run(capsys, "sg14-table-2", "--trials", "1", "--workers", "1", "--json")
    document = json.loads(out)
    assert (code, err) == (0, "")
    assert document["experiment"] == "sg14-table-2"
    row = next(r for r in document["rows"] if (r["label"], r["quantity"]) == ("Method A", "height RMSE (m)"))
    assert (row["published"], row["published_sd"], row["trials"]) == (0.40, 0.15, 1)
    assert row["reproduced_sd"] is None


def test_the_terminal_shows_the_table_and_the_page_is_written(capsys, tmp_path):
    page = tmp_path / "page.html"
    code, out, err = run(
        capsys,
        "sg14-table-3",
        "--trials",
        "1",
        "--workers",
        "1",
        "--presets",
        "tanigawa08",
        "--report",
        str(page),
    )
    assert code == 0
    assert "0.050 ± 0.020" in out
    assert "tanigawa08" in out
    assert "report ->" in err
    assert page.read_text(encoding="utf-8").count("<svg") == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("sg15-table-1",), "there is no experiment 'sg15-table-1'"),
        (("sg14-table-2", "--presets", "magic"), "there is no preset 'magic'"),
        (("sg14-table-2", "--trials", "0"), "0 is not in the range"),
    ],
)
def test_wrong_usage_is_told_in_a_sentence(capsys, arguments, words):
    code, out, err = run(capsys, *arguments)
    assert (code, out) == (2, "")
    assert words in err
    assert "Traceback" not in err


def test_presets_have_no_part_in_identification(capsys):
    code, _, err = run(capsys, "sg13-figure-5", "--trials", "1", "--workers", "1", "--presets", "sg14-a")
    assert code == 0
    assert "presets have no part in it" in err
