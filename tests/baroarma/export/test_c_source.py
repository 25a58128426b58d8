"""The exported C itself: it follows Python from sample to sample, and survives what sensors do."""

import math
import re
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import baroarma as ba
from baroarma.export.firmware import firmware
from baroarma.formats import write_csv
from baroarma.simulation import BMP085, MOTIONS, simulate
from baroarma.tracker import Tracker

NOISE = BMP085.noise
CASES = {
    **{name: {"preset": name} for name in ("baroarma", "sg14-a", "sg14-b", "lee16", "lee16-kf")},
    "all-settings": {
        "preset": "baroarma",
        "attitude_settings": {"latency": 0.01, "gyro_noise_sd": 0.01, "bias_sd": 0.001, "interval": 1.0},
        "height_settings": {
            "acceleration_sd": 0.1,
            "bias_sd": 0.05,
            "rest_sd": 0.004,
            "barometer_lag": 0.07,
            "level_prior_sd": 2.0,
            "floors": (-1.0, 0.0, 2.5),
            "gate": 4.0,
        },
    },
    "one-filter": {
        "preset": "baroarma",
        "attitude": "tilt-kalman",
        "height_settings": {"confirm_rest": False, "gate": math.inf},
    },
}
TYPES = {"double": ("-DBAROARMA_FLOAT=0", 1e-9), "float": ("-DBAROARMA_FLOAT=1", 2e-3)}
"""Doubles follow Python to rounding, 1e-12 m a step of values that filters forget in seconds; for floats the
promise of the documentation, 2 mm, which a float of pressure spends 0.3 mm of."""
CHECKS = (
    "-O0",
    "-fsanitize=address,undefined,float-divide-by-zero,float-cast-overflow",
    "-fno-sanitize-recover=all",
)
ROOM = "-DBAROARMA_EARLY_ROWS=200"
"""Room for every row of a second at 100 Hz, so that nothing is taken for evenly spaced."""
PROGRAMS = {
    "selftest": (),
    "checked selftest": CHECKS,
    "replay": ("-DBAROARMA_REPLAY", ROOM),
    "checked replay": ("-DBAROARMA_REPLAY", *CHECKS),
}


def exported(case, folder, noise=NOISE, **options):
    firmware(**{"noise": noise, "rate_hz": 50.0, **CASES[case], **options}).write(folder)
    return folder


@pytest.fixture(scope="module")
def programs(tmp_path_factory, gcc):
    """Return a program of a case, as float or as double."""
    folders = {case: exported(case, tmp_path_factory.mktemp(case)) for case in CASES}
    wanted = [(case, real, "replay") for case in CASES for real in TYPES]
    wanted += [(case, "double", "selftest") for case in CASES]
    wanted += [(case, "float", "checked selftest") for case in CASES]
    wanted += [("baroarma", real, "checked replay") for real in TYPES]

    def made(one):
        case, real, name = one
        return gcc(folders[case], f"{name} {real}".replace(" ", "_"), TYPES[real][0], *PROGRAMS[name])

    with ThreadPoolExecutor(2) as pool:
        return dict(zip(wanted, pool.map(made, wanted), strict=True))


@pytest.fixture(scope="module")
def real_ones(shared_data):
    """A lift and a hand, with samples as uneven as their loggers."""
    lift = [shared_data / f"srp_altimu10_elevator_rocket/elevator_{s}.csv.gz" for s in ("baro", "acc", "gyr")]
    return ba.read(*lift), ba.read(shared_data / "stampfly_tof_handheld/lift30cm_b.csv.gz")


def text_of(recording, folder):
    write_csv(recording, folder / "recording.csv")
    return (folder / "recording.csv").read_text()


def csv_of(t, pressure, accel, gyro):
    """Columns as text, whatever is in them."""
    names = ["time_s", "pressure_pa", *(f"acc_{i}_m_s2" for i in "xyz"), *(f"gyr_{i}_rad_s" for i in "xyz")]
    rows = np.column_stack([t, pressure, accel, gyro])
    lines = [",".join("" if np.isnan(x) else repr(float(x)) for x in row) for row in rows]
    return "\n".join([",".join(names), *lines]) + "\n"


def distance(found, track):
    height = np.abs(found["height_m"].to_numpy() - track.height).max()
    velocity = np.abs(found["velocity_m_s"].to_numpy() - track.velocity).max()
    return max(height, velocity)


@pytest.mark.parametrize("program", [("double", "selftest"), ("float", "checked selftest")])
@pytest.mark.parametrize("case", CASES)
def test_the_self_test_passes_and_no_sanitizer_objects(programs, case, program):
    done = subprocess.run([programs[case, *program]], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("ok  ") == 16
    assert "FAIL" not in done.stdout


WRONG = {
    "sg14-a": ("GAIN[2]", "GATE", "GYRO_NOISE_SD", "ACCEL_NOISE_SD", "EXPONENT", "AVERAGE"),
    "baroarma": (
        "INITIAL_SD[10]",
        "RATE_ERROR",
        "VELOCITY_TIME",
        "INTERVAL",
        "LEFT_BIAS_SD",
        "SWAY",
        "MEMORY",
    ),
}


@pytest.mark.parametrize(("preset", "name"), [(preset, name) for preset in WRONG for name in WRONG[preset]])
def test_the_self_test_fails_when_a_constant_is_wrong(tmp_path, gcc, preset, name):
    folder = exported(preset, tmp_path)
    config = folder / "baroarma_config.h"
    wrong, count = re.subn(
        rf"(BAROARMA_{re.escape(name)}[ ={{]+(?:\(baroarma_real\))?)([\d.]+)",
        lambda found: found[1] + ("3" if name == "AVERAGE" else repr(0.9 * float(found[2]))),
        config.read_text(),
    )
    assert count == 1
    config.write_text(wrong)
    program = gcc(folder, "wrong", "-DBAROARMA_FLOAT=0", "-O0")
    done = subprocess.run([program], capture_output=True, text=True)
    assert done.returncode == 1
    assert "FAIL  the golden vectors from Python" in done.stdout


@pytest.mark.parametrize("real", TYPES)
@pytest.mark.parametrize("case", CASES)
def test_it_follows_python_on_every_simulated_motion(programs, replay, tmp_path, case, real):
    tracker = Tracker(noise=NOISE, **CASES[case])
    for motion in MOTIONS:
        recording = simulate(motion, duration=20, seed=2)
        found = replay(programs[case, real, "replay"], text_of(recording, tmp_path))
        assert distance(found, tracker.run(recording)) < TYPES[real][1], motion


def test_high_up_a_float_still_notices_a_slow_climb(programs, replay, tmp_path):
    # at 150 m a float's last digit is 15 um, and a step of 10 ms at 1 mm/s 10 um: without the second number
    # that keeps what the first is too coarse for, the height is off by 7 mm
    lift = simulate("lift", duration=160, rate_hz=100, climb=1500.0, speed=20.0, seed=1)
    found = replay(programs["one-filter", "float", "replay"], text_of(lift, tmp_path))
    assert distance(found, Tracker(noise=NOISE, **CASES["one-filter"]).run(lift)) < TYPES["float"][1]


@pytest.mark.parametrize("real", TYPES)
@pytest.mark.parametrize("case", ["baroarma", "sg14-a", "lee16", "lee16-kf"])
def test_it_follows_python_on_real_recordings(programs, replay, tmp_path, real_ones, case, real):
    for recording in real_ones:
        found = replay(programs[case, real, "replay"], text_of(recording, tmp_path))
        track = Tracker(noise=NOISE, **CASES[case]).run(recording)
        assert distance(found, track) < TYPES[real][1]


@pytest.mark.parametrize("case", CASES)
def test_missing_samples_and_steps_of_no_time_mean_what_they_mean_in_python(programs, replay, case):
    rng = np.random.default_rng(5)
    ride = simulate("squat", duration=20, seed=6)
    moving = ride.t > 3
    lost = {name: moving & (rng.random(len(ride)) < 0.2) for name in ("pressure", "accel", "gyro")}
    lost["gyro"] |= (ride.t > 8) & (ride.t < 9)  # long enough to lose the tilt
    lost["accel"] |= (ride.t > 12) & (ride.t < 13)  # and to forget the acceleration
    t = np.where(moving, np.repeat(ride.t[::2], 2)[: len(ride)], ride.t)
    pressure = np.where(lost["pressure"], np.nan, ride.pressure)
    force, rate = (np.where(lost[name][:, None], np.nan, getattr(ride, name)) for name in ("accel", "gyro"))
    found = replay(programs[case, "double", "replay"], csv_of(t, pressure, force, rate))
    tracker = Tracker(noise=NOISE, **CASES[case])
    for k in range(len(t)):
        dt = t[k] - t[k - 1] if k else np.nan
        state = tracker.step(dt=dt, pressure=pressure[k], accel=force[k], gyro=rate[k])
        if state is not None:
            assert found["height_m"][k] == pytest.approx(state.height, abs=1e-9), k
            assert found["velocity_sd_m_s"][k] == pytest.approx(state.velocity_sd, abs=1e-9), k


def every(n, column):
    """The column's every n-th sample; NaN between."""
    column = column.copy()
    column[np.arange(len(column)) % n > 0] = np.nan
    return column


@pytest.mark.parametrize("seconds", [(0.0, 0.7), (0.2, 1.0), (0.0, 2.5)], ids=["late", "early", "after"])
@pytest.mark.parametrize("few", [1, 3, 12])
def test_an_alignment_with_few_samples_tells_c_as_little_as_python(programs, replay, tmp_path, few, seconds):
    # 4 accelerometer samples don't tell its noise; all in one part of the second not the mean's uncertainty
    ride = simulate("stairs", duration=12, seed=3)
    missing = (ride.t >= seconds[0]) & (ride.t < seconds[1])
    start = ride.t < 1
    accel = np.where(start[:, None], every(few, ride.accel), ride.accel)
    if few == 3:
        accel[start & (ride.t > 0.45)] = np.nan
    ride = replace(ride, pressure=np.where(missing, np.nan, ride.pressure), accel=accel)
    found = replay(programs["baroarma", "double", "replay"], text_of(ride, tmp_path))
    assert distance(found, Tracker(noise=NOISE).run(ride)) < TYPES["double"][1]


def test_rows_between_altitudes_are_told_by_their_number(tmp_path, gcc, replay):
    # 100 altitudes' room for the 400 rows of the alignment's second, from a clock that is even
    ride = simulate("stairs", duration=12, rate_hz=400, seed=4)
    ride = replace(ride, pressure=every(4, ride.pressure))
    folder = exported("baroarma", tmp_path, rate_hz=100)
    program = gcc(folder, "replay", TYPES["double"][0], "-DBAROARMA_REPLAY", *CHECKS)
    track = Tracker(noise=NOISE).run(ride)
    assert distance(replay(program, text_of(ride, tmp_path)), track) < TYPES["double"][1]


def test_an_uneven_clock_costs_little_where_there_is_no_room_for_all_rows(tmp_path, gcc, replay, real_ones):
    folder = exported("baroarma", tmp_path, rate_hz=15)
    program = gcc(folder, "replay", TYPES["double"][0], "-DBAROARMA_REPLAY")
    for recording in real_ones:
        track = Tracker(noise=NOISE).run(recording)
        # the promise for floats serves this, too: intervals of 3 to 18 ms are taken for 9 each
        assert distance(replay(program, text_of(recording, tmp_path)), track) < TYPES["float"][1]


def test_a_barometer_faster_than_told_leaves_the_alignments_room_alone(tmp_path, gcc, replay):
    ride = simulate("squat", duration=12, rate_hz=100, seed=4)
    folder = exported("baroarma", tmp_path, rate_hz=20)
    program = gcc(folder, "replay", TYPES["double"][0], "-DBAROARMA_REPLAY", *CHECKS)
    found = replay(program, text_of(ride, tmp_path))
    # the offset is then known from 23 of 100 altitudes
    off = np.abs(found["height_m"].to_numpy() - Tracker(noise=NOISE).run(ride).height)
    assert 0 < off.max() < 5 * found["height_sd_m"].max()


@pytest.mark.parametrize("real", TYPES)
def test_whatever_sensors_say_there_is_a_number(programs, replay, real):
    rng = np.random.default_rng(7)
    n, strange = 4000, (np.nan, np.inf, -np.inf, 0.0, 1e-30, -1e30, 300.0)

    def spoilt(usual, share):
        return np.where(rng.random(usual.shape) < share, rng.choice(strange, usual.shape), usual)

    steps = rng.choice([0.02, 0.0, 1e-9, 0.3, 0.7, 5.0, -0.02, np.nan], n, p=[0.9, *[0.1 / 7] * 7])
    force = rng.normal([0.0, 0.0, 9.8], rng.choice([0.01, 30.0], (n // 100, 1)).repeat(100, axis=0), (n, 3))
    rate = rng.normal(0.0, rng.choice([0.001, 20.0], (n // 100, 1)).repeat(100, axis=0), (n, 3))
    pressure = 1e5 + rng.normal(0.0, rng.choice([3.0, 3e4], n // 100).repeat(100), n)
    rows = csv_of(np.nancumsum(steps), spoilt(pressure, 0.1), spoilt(force, 0.02), spoilt(rate, 0.02))
    found = replay(programs["baroarma", real, "checked replay"], rows)
    assert len(found) == n
    assert np.isfinite(found.drop(columns="time_s").to_numpy()).all()
    assert (found["height_sd_m"] > 0).mean() > 0.9


def test_without_gravity_at_the_start_the_alignment_begins_anew(programs, replay, tmp_path):
    ride = simulate("squat", duration=15, seed=3)
    falling = replace(ride, accel=np.where((ride.t < 0.9)[:, None], 0.01, ride.accel))
    found = replay(programs["lee16", "double", "replay"], text_of(falling, tmp_path))
    later = Tracker(noise=NOISE, **CASES["lee16"]).run(ride.rows(slice(50, None)))
    assert (found["height_m"][:100] == 0).all()
    assert np.abs(found["height_m"][50:].to_numpy() - later.height).max() < 1e-9
