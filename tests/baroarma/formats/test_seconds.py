"""Times rise in seconds, past the end of 32-bit counters, in one table or many; other steps back stay."""

import numpy as np
import pytest

from baroarma.formats.seconds import Seconds


def counter(per_second, lowest):
    """Return 80 s of counts, 50 a second, that start again after 30 s."""
    counts = 2**32 - 30 * per_second + np.arange(4000) * per_second / 50
    return np.round(counts) % 2**32 + lowest


@pytest.mark.parametrize("lowest", [0, -(2**31)])
@pytest.mark.parametrize(("per_second", "written_as"), [(1e6, 1e6), (1e3, 1e3), (1e6, 1.0), (1e3, 1.0)])
@pytest.mark.parametrize("size", [7, 500, 4000])
def test_a_counter_is_counted_on_whatever_its_unit_and_the_parts(per_second, written_as, lowest, size):
    t, seconds = counter(per_second, lowest) / written_as, Seconds()
    parts = [seconds.take({"time_s": t[k : k + size]})["time_s"] for k in range(0, len(t), size)]
    steps = np.diff(np.concatenate(parts)) * written_as / per_second
    np.testing.assert_allclose(steps, 0.02, rtol=0, atol=1e-6)
    (note,) = seconds.notes("a.csv")
    assert "starts again 1 time" in note.message


def test_every_wrap_is_counted():
    t = (np.arange(1000) * 20.0) % (2**32 * 1e-6)
    seconds = Seconds()
    np.testing.assert_allclose(np.diff(seconds.take({"time_s": t})["time_s"]), 20.0, rtol=0, atol=1e-6)
    assert "starts again 4 times" in seconds.notes("a.csv")[0].message


@pytest.mark.parametrize("back", [1.0, 4292.0, 4300.0, 65.536])
def test_any_other_step_back_stays(back):
    t = 5000 + np.arange(100) / 50
    t[50:] -= back
    seconds = Seconds()
    np.testing.assert_array_equal(seconds.take({"time_s": t})["time_s"], t)
    assert seconds.notes("a.csv") == ()


def test_honest_times_are_left_as_they_are():
    t, seconds = np.arange(100) / 50, Seconds()
    taken = seconds.take({"pressure_pa": t + 1e5, "time_s": t})
    assert taken["time_s"] is t
    assert list(taken) == ["time_s", "pressure_pa"]
