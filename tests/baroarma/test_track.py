"""A track tells its own story and is written as documented."""

from io import StringIO

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from baroarma import Recording
from baroarma.climbing import climb
from baroarma.finding import Finding
from baroarma.track import COLUMNS, Track


def make(n=4, **changes):
    signals = {name: np.linspace(0.1, 1, n) for name in ("height", "velocity", "acceleration")}
    sds = {"height_sd": np.full(n, 0.1), "velocity_sd": np.full(n, 0.01)}
    return Track(**{"t": np.arange(n) / 3, **signals, **sds, "preset": "p", "name": "walk", **changes})


@pytest.mark.parametrize("suffix", [".csv", ".txt", ".csv.gz", ".parquet"])
def test_a_track_reads_back_exactly_whatever_the_suffix(tmp_path, suffix):
    track, path = make(), tmp_path / f"track{suffix}"
    track.save(path)
    back = pd.read_parquet(path) if suffix == ".parquet" else pd.read_csv(path, compression=None)
    assert list(back) == ["time_s", "height_m", "velocity_m_s", "height_sd_m", "velocity_sd_m_s"]
    assert np.array_equal(back.to_numpy(), track.to_frame().to_numpy())
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_nothing_is_left_behind_when_it_can_not_be_written(tmp_path):
    (tmp_path / "taken").mkdir()
    with pytest.raises(OSError, match="taken"):
        make().save(tmp_path / "taken")
    assert [p.name for p in tmp_path.iterdir()] == ["taken"]


def test_a_track_has_no_nan_and_one_row_per_time():
    with pytest.raises(ValueError, match=r"velocity of a track must be \(4,\) finite numbers"):
        make(velocity=np.array([0, 1, np.nan, 2]))
    with pytest.raises(ValueError, match="height_sd"):
        make(height_sd=np.ones(3))


def test_its_signals_can_not_be_changed():
    given = np.zeros(4)
    track = make(height=given)
    given[:] = 7
    assert not track.height.any()
    with pytest.raises(ValueError, match="read-only"):
        track.height[0] = 1


def test_what_to_know_stands_in_repr_and_summary():
    track = make(findings=(Finding("dc-gain", "warning", "Too small."),))
    assert repr(track) == "<Track of 'walk' by p: 4 rows, 0.1 to 1 m; dc-gain>"
    assert "ends at 1.000 m (sd 0.1), +1.000 m/s (sd 0.01)" in track.summary()
    assert "warning (dc-gain): Too small." in track.summary()


@pytest.mark.parametrize("rows", [1, 3, 4, 5])
def test_the_rows_are_written_in_portions_of_any_size(rows, monkeypatch):
    monkeypatch.setattr("baroarma.track.ROWS", rows)
    whole, bare = StringIO(), StringIO()
    track = make()
    track.write_csv(whole)
    track.write_csv(bare, header=False)
    head, *lines = whole.getvalue().splitlines()
    assert head == "time_s,height_m,velocity_m_s,height_sd_m,velocity_sd_m_s"
    assert bare.getvalue() == "".join(f"{line}\n" for line in lines)
    assert [[float(cell) for cell in line.split(",")] for line in lines] == track.to_frame().values.tolist()


def test_parquet_has_the_columns_of_the_csv_and_no_index(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    make().save(tmp_path / "track.parquet")
    schema = parquet.read_schema(tmp_path / "track.parquet")
    assert schema.names == list(COLUMNS)
    assert schema.pandas_metadata["index_columns"] == []


def test_an_empty_track_says_so():
    bare = Track(*np.zeros((6, 3)))
    assert (bare.preset, bare.name, bare.findings) == ("", "", ())
    none = np.empty(0)
    assert repr(Track(*[none] * 6, preset="p", name="n")) == "<Track of 'n' by p: 0 rows, empty>"
    assert repr(make(preset="", name="")) == "<Track of '' by : 4 rows, 0.1 to 1 m>"


def test_the_summary_tells_end_climb_and_findings_a_line_each():
    rising = np.array([0.0, 1.0, 2.0, 4.0])
    notes = (Finding("gaps", "info", "One."), Finding("rest", "warning", "None."))
    sds = np.array([0.3, 0.2, 0.15, 0.1])
    track = make(height=rising, velocity=-rising, findings=notes, height_sd=sds, velocity_sd=sds / 10)
    first, end, climbed, *findings = track.summary().splitlines()
    assert first == repr(track)
    assert first.endswith("0 to 4 m; gaps; rest>")
    assert end == "  ends at 4.000 m (sd 0.1), -4.000 m/s (sd 0.01)"
    assert climbed == f"  {climb(track).summary()}"
    assert findings == ["  info (gaps): One.", "  warning (rest): None."]
    html = track._repr_html_()
    for cell in ("walk by p: 4 rows", ">height<", ">One.<", ">None.<"):
        assert cell in html


def test_every_column_is_checked_and_the_time_too():
    for field in ("t", "height", "velocity", "height_sd", "velocity_sd", "acceleration"):
        with pytest.raises(ValueError, match=rf"{field} of a track must be \(4,\) finite numbers"):
            make(**{field: np.full(4, np.inf)})


def test_a_dataset_has_the_signals_and_where_they_are_from():
    pytest.importorskip("xarray")
    track = make(findings=(Finding("gaps", "info", "One."),))
    found = track.to_xarray()
    assert found.height.values.tolist() == track.height.tolist()
    assert found.attrs == {"name": "walk", "preset": "p", "findings": ["info (gaps): One."]}


def test_it_is_drawn_where_it_is_told_beside_its_reference():
    track = make()
    bare, beside = Figure().subplots(1, 2)
    assert track.plot(bare) is bare
    reference = Recording(t=track.t, pressure=np.full(4, 1e5), reference=track.height)
    assert track.plot(beside, reference=reference) is beside
    assert len(beside.lines) == len(bare.lines) + 1
