"""The soak in short: minutes instead of days, what must not grow, and what recovers from faults."""

import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from baroarma import Tracker
from baroarma.presets import PRESETS
from baroarma.simulation import BMP085

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
MINUTES = 10 * 3000
"""Rows of ten minutes."""


@pytest.fixture(scope="module")
def soak():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(BENCHMARKS)
        import soak

        yield soak
    sys.modules.pop("soak", None)
    sys.modules.pop("soak_world", None)


@pytest.fixture(scope="module")
def hours(soak):
    """Six times ten minutes of mixed motions in chunks, two of them row by row, too."""
    return soak.endure("baroarma", 6, stepped_parts=2, seed=5, rows=MINUTES, say=lambda _: None)


def test_row_by_row_is_chunk_by_chunk(hours):
    # the same sums in another order; 1e-9 is the contract's tolerance
    assert max(row["apart"] for row in hours[:2]) < 1e-9


def test_velocity_is_as_wrong_as_its_sd_says_and_stays_so(hours):
    rms = [row["velocity_rms"] for row in hours]
    # undisturbed the sd is 0.01 m/s; an error of 0.03 over ten minutes would be lost tilt or a missed rest
    assert max(rms) < 0.03
    nees = [row["velocity_nees"] for row in hours]
    # 1 if the sds were exact; rests believed make it smaller, a single mistaken second would make it 10
    assert 0.05 < np.mean(nees) < 2.0


def test_the_height_s_error_grows_like_the_barometer_s_drift_and_not_faster(hours):
    # hourly changes over what the drift makes in the time: six of them, chi-square of 6, 99.9 %: 22.5
    assert np.sum(np.square([row["height_walk"] for row in hours])) < 22.5


def test_the_covariance_stays_one(hours):
    # correlations are symmetric and not negative, to rounding: one state is 1e4 times as uncertain as another
    for row in hours:
        asymmetry, least = row["covariance"]
        assert asymmetry < 1e-12
        assert least > -1e-9


def test_a_tracker_that_steps_for_long_holds_no_more_memory(soak):
    world = soak.World(3)
    part = world.hour(MINUTES)
    tracker = Tracker(noise=BMP085.noise)
    soak.steps(tracker, part.rows(slice(0, 2500)), 0.0)
    tracemalloc.start()
    try:
        for start in range(2500, 9000, 500):
            if start == 3000:  # by now what the state itself holds is counted
                before, _ = tracemalloc.get_traced_memory()
            soak.steps(tracker, part.rows(slice(start, start + 500)), part.t[start - 1])
        after, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # 6000 steps: a single float kept per step would be 144 kB.  What is replaced counts as new once: calls of
    # compiled functions renew some 600 pieces of 57 bytes, one after the other, 35 kB in all
    assert after - before < 72_000


RECOVERS = {"absurd values", "barometer gone", "barometer spikes", "barometer stuck", "barometer zeros"}
"""Kinds after which nothing but waiting for the barometer is needed."""


@pytest.fixture(scope="module")
def events(soak):
    return soak.recover("baroarma", 1, seed=4, say=lambda _: None)


def test_every_kind_of_fault_has_happened(soak, events):
    from soak_world import FAULTS  # beside soak

    assert {event["kind"] for event in events} == set(FAULTS)


@pytest.mark.parametrize("kind", sorted(RECOVERS))
def test_the_velocity_is_back_within_five_seconds(soak, events, kind):
    # alone: another fault's aftermath, up to half a minute of a stuck IMU, is counted where it began
    times = [event["recovery_s"] for event in events if event["kind"] == kind]
    assert np.median(times) <= soak.RECOVERED


def test_most_faults_are_over_within_five_seconds(soak, events):
    within = np.mean([event["recovery_s"] <= soak.RECOVERED for event in events])
    # 0.93 of 24 hours' 1989 events (docs/soak.md); of 84 a share as low as 0.80 is 4.5 sds away
    assert within > 0.80


@pytest.mark.parametrize("preset", [n for n, p in PRESETS.items() if p.height and p.height != "inertial-ekf"])
def test_no_preset_loses_its_numbers_in_faults(soak, preset):
    world, rng = soak.World(6), np.random.default_rng(6)
    part = world.hour(MINUTES)
    faulty, *_ = soak.faults(part, rng)
    track = Tracker.preset(preset, noise=BMP085.noise).run(faulty)
    assert np.isfinite(track.height).all()
    assert np.isfinite(track.height_sd).all()
    # half a minute after the last fault nothing is left of any: papers' filters forget in 2 to 3 s
    assert abs(track.velocity[-1]) < 20.0
