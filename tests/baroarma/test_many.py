"""Many recordings give what each gives alone."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from baroarma.cli import main
from baroarma.comparison import compare
from baroarma.formats import long, parquet, read, write_csv
from baroarma.identification import identify
from baroarma.many import compare_many, identify_many
from baroarma.simulation import BMP085, simulate, simulate_rest


@pytest.fixture(scope="module")
def rests(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rests")
    paths = [folder / f"rest{seed}.{suffix}" for seed, suffix in ((1, "csv"), (2, "parquet"), (3, "csv.gz"))]
    for seed, path in enumerate(paths, 1):
        write_csv(simulate_rest(duration=60, seed=seed), path)
    return paths


@pytest.mark.parametrize("jobs", [1, 2])
def test_identify_many_is_identify_of_each(rests, jobs):
    found = identify_many([rests[0], (rests[1],), read(rests[2])], jobs=jobs, terms=("white", "gm"))
    alone = [identify(read(path), terms=("white", "gm")) for path in rests]
    assert [one.model for one in found] == [one.model for one in alone]
    assert [one.recording.name for one in found] == ["rest1", "rest2", "rest3"]


def test_long_files_among_many_are_read_part_by_part(rests, monkeypatch):
    alone = identify_many(rests[:2], jobs=1, terms=("white",))
    monkeypatch.setattr(long, "LONG", 1)
    monkeypatch.setattr(parquet, "ROWS", 400)
    in_parts = identify_many(rests[:2], jobs=1, terms=("white",))
    assert [one.model for one in in_parts] == [one.model for one in alone]


def test_compare_many_is_compare_of_each():
    logs = [simulate("squat", duration=10, seed=seed) for seed in (1, 2, 3)]
    options = {"presets": ("sg14-a", "tanigawa08"), "noise": BMP085.noise}
    with ThreadPoolExecutor(2) as threads:
        found = compare_many(logs, executor=threads, **options)
    for one, log in zip(found, logs, strict=True):
        assert [row.errors for row in one.rows] == [row.errors for row in compare(log, **options).rows]


def test_the_command_line_says_the_same_with_any_number_of_jobs(rests, capsys):
    arguments = ["identify", *map(str, rests), "--terms", "white,gm", "--json"]
    assert main(arguments) == 0
    alone = capsys.readouterr().out
    assert main([*arguments, "--jobs", "2"]) == 0
    assert capsys.readouterr().out == alone
