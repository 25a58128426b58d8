"""The checks together: one fault, one finding; and cheap enough to run on every log."""

import time
from dataclasses import replace

import numpy as np
import pytest

from baroarma.contents import content_findings, examined, imu_findings
from baroarma.simulation import MOTIONS, simulate


@pytest.mark.parametrize("motion", MOTIONS)
def test_no_simulated_motion_is_accused_unless_it_leaves_its_range(motion):
    for seed, device in enumerate(("simple", "gy-87", "bmp390-icm42688")):
        found = content_findings(simulate(motion, duration=40, device=device, seed=seed))
        assert {f.code for f in found} <= ({"saturation"} if motion == "free-fall" else set()), device


def test_a_wrong_unit_is_not_said_again_by_every_sensor():
    log = simulate("lee16-c", duration=45, seed=1)
    for wrong in (
        replace(log, pressure=log.pressure / 100),
        replace(log, t=1000 * log.t),
        replace(log, accel=log.accel / 9.80665),
        replace(log, temperature=np.full(len(log), 295.0)),
    ):
        assert [finding.code for finding in examined(wrong).notes] == ["units"]


def test_a_temperature_in_kelvin_hides_no_other_fault():
    log = simulate("lee16-e", duration=45, seed=1)
    wrong = replace(log, temperature=np.full(len(log), 295.0), gyro=-log.gyro)
    assert [finding.code for finding in examined(wrong).notes] == ["units", "axes"]


def test_a_part_of_an_imu_is_judged_as_the_whole():
    log = simulate("lee16-e", duration=45, seed=1)
    wrong = replace(log, gyro=-log.gyro)
    assert imu_findings(wrong) == content_findings(wrong)
    assert imu_findings(log) == ()


def test_what_was_examined_has_the_same_signals():
    log = simulate("squat", duration=30, seed=1)
    seen = examined(log)
    assert seen.accel is log.accel
    assert seen.notes == ()


def test_a_log_a_hundred_times_as_long_costs_as_much_per_row_at_most():
    short = simulate("squat", duration=100, seed=1)
    t = np.arange(100 * len(short)) / 50
    tiled = {name: np.concatenate([getattr(short, name)] * 100) for name in ("pressure", "accel", "gyro")}
    long = replace(short, t=t, reference=None, reference_velocity=None, reference_attitude=None, **tiled)

    def seconds(log):
        spent = []
        for _ in range(3):
            start = time.process_time()
            content_findings(log)
            spent.append(time.process_time() - start)
        return min(spent)

    assert seconds(long) < 100 * seconds(short)
