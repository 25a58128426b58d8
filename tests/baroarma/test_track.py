"""A track tells its own story and is written as documented."""

import numpy as np
import pandas as pd
import pytest

from baroarma.finding import Finding
from baroarma.track import Track


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
