"""What the fuzzer found, once each."""

import gc
import json
import resource
import struct

import fuzz_seeds
import pytest

from baroarma.cli import main
from baroarma.formats import UnreadableError, read

SIGNALLING = bytes.fromhex("0000a07f")
"""A float32 NaN that the processor complains about whenever it is touched."""


@pytest.mark.parametrize("kind", ["ulg", "bin"])
def test_a_number_that_signals_is_no_sample_and_no_warning(kind, tmp_path):
    if kind not in fuzz_seeds.available():
        pytest.skip(f"the library that reads {kind} is not installed")
    first = struct.pack("<f", fuzz_seeds.signals()["pressure"][0])
    (path := tmp_path / f"a.{kind}").write_bytes(fuzz_seeds.seeds(kind)[0].replace(first, SIGNALLING, 1))
    found = read(path)
    assert int(found.is_new.sum()) == len(fuzz_seeds.signals()["t"]) - 1


@pytest.mark.parametrize("row", ["inf,0,0,1,1", "2,1e308,-1e308,1,1", "2,0,nan,1,1", "1,0,0,1,1"])
def test_a_foreign_track_with_a_number_that_cannot_be_is_refused(tmp_path, capsys, row):
    (track := tmp_path / "t.csv").write_text(
        f"time_s,height_m,velocity_m_s,height_sd_m,velocity_sd_m_s\n0,0,0,1,1\n1,0,0,1,1\n{row}\n"
    )
    (log := tmp_path / "log.csv").write_bytes(fuzz_seeds.seeds("csv")[0])
    assert main(["compare", str(log), "--presets", "sg14-a", "--track", str(track)]) == 2
    assert capsys.readouterr().err.startswith(f"baroarma: {track}")


@pytest.mark.parametrize("command", [["track"], ["identify"], ["identify", "--method", "windows"]])
@pytest.mark.parametrize("step", [1e8, 2e8, 1e12])
def test_rows_years_apart_take_no_memory_and_no_traceback(tmp_path, capsys, command, step):
    rows = "".join(f"{k * step},{101_325 + k % 7}\n" for k in range(320))
    (log := tmp_path / "log.csv").write_text("time_s,pressure_pa\n" + rows)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert main([command[0], str(log), *command[1:]]) in (0, 1, 2)
    # 320 rows are 5 kB; 100 MB are what importing may take. One number per second of 320e8 s would be 250 GB.
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 300_000
    assert "Traceback" not in capsys.readouterr().err


def test_a_track_that_runs_away_has_countable_floors(tmp_path, capsys):
    lines = fuzz_seeds.seeds("csv")[0].decode().splitlines()
    rows = [f"{1e7 * float(t)!r},{rest}" for t, rest in (line.split(",", 1) for line in lines[1:14])]
    (log := tmp_path / "log.csv").write_text("\n".join([lines[0], *rows, ""]))
    assert main(["track", str(log), "--preset", "sg14-b", "--json"]) == 0
    json.loads(capsys.readouterr().out, parse_constant=pytest.fail)


def test_a_log_that_is_refused_is_closed(tmp_path, recwarn):
    if "bin" not in fuzz_seeds.available():
        pytest.skip("the library that reads bin is not installed")
    whole, refused = fuzz_seeds.seeds("bin")[0], 0
    for at in range(3, 600, 7):
        (path := tmp_path / "a.bin").write_bytes(whole[:at] + b"\xff" + whole[at + 1 :])
        try:
            read(path)
        except UnreadableError:
            refused += 1
    gc.collect()
    assert refused > 10
    assert not [warning for warning in recwarn if "unclosed" in str(warning.message)]
