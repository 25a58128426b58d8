"""Exported firmware: it compiles without a warning, follows Python, and survives what sensors do."""

import math
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

import baroarma as ba
from baroarma.export.firmware import exportable, firmware
from baroarma.formats import write_csv
from baroarma.simulation import BMP085, MOTIONS, simulate
from baroarma.tracker import Tracker

NOISE = BMP085.noise
ONE_FILTER = {"confirm_rest": False, "gate": math.inf}
CASES = {
    **{name: {"preset": name} for name in ("sg14-a", "sg14-b", "lee16", "lee16-kf")},
    "coloured": {"preset": "baroarma", "attitude": "tilt-kalman", "height_settings": ONE_FILTER},
}
RATES = {"coloured": 100.0}
"""It aligns in four parts, in C by time, in Python by samples: the same if four divide their number."""
TYPES = {"double": ("-DBAROARMA_FLOAT=0", 1e-9), "float": ("-DBAROARMA_FLOAT=1", 2e-3)}
"""Doubles follow Python to rounding, 1e-12 m a step of values that filters forget in seconds; for floats the
promise of the documentation, 2 mm, which a float of pressure spends 0.3 mm of."""


CHECKS = (
    "-O1",
    "-fsanitize=address,undefined,float-divide-by-zero,float-cast-overflow",
    "-fno-sanitize-recover=all",
)


def exported(case, folder, noise=NOISE, **options):
    rate_hz = RATES.get(case, 50.0)
    firmware(**{"noise": noise, "rate_hz": rate_hz, **CASES[case], **options}).write(folder)
    return folder


@pytest.fixture(scope="module")
def programs(tmp_path_factory, gcc):
    """Self-test (floats: with sanitizers) and replay of every case, as float and as double."""
    found = {}
    for case in CASES:
        folder = exported(case, tmp_path_factory.mktemp(case))
        for real, (option, _) in TYPES.items():
            found[case, real, "selftest"] = gcc(
                folder, f"selftest_{real}", option, *(CHECKS if real == "float" else ())
            )
            found[case, real, "replay"] = gcc(folder, f"replay_{real}", option, "-DBAROARMA_REPLAY")
    return found


def text_of(recording, folder):
    write_csv(recording, folder / "recording.csv")
    return (folder / "recording.csv").read_text()


def distance(found, track):
    height = np.abs(found["height_m"].to_numpy() - track.height).max()
    velocity = np.abs(found["velocity_m_s"].to_numpy() - track.velocity).max()
    return max(height, velocity)


def test_all_presets_of_the_papers_filters_can_be_exported():
    assert {"sg14-a", "sg14-b", "lee16", "lee16-kf"} <= set(exportable())


@pytest.mark.parametrize("real", TYPES)
@pytest.mark.parametrize("case", CASES)
def test_the_self_test_passes_and_no_sanitizer_objects(programs, case, real):
    done = subprocess.run([programs[case, real, "selftest"]], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("ok  ") == 16
    assert "FAIL" not in done.stdout


@pytest.mark.parametrize(
    "name", ["GAIN[2]", "GATE", "GYRO_NOISE_SD", "ACCEL_NOISE_SD", "EXPONENT", "AVERAGE"]
)
def test_the_self_test_fails_when_a_constant_is_wrong(tmp_path, gcc, name):
    folder = exported("sg14-a", tmp_path)
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
        recording = simulate(motion, duration=20, rate_hz=RATES.get(case, 50.0), seed=2)
        found = replay(programs[case, real, "replay"], text_of(recording, tmp_path))
        assert distance(found, tracker.run(recording)) < TYPES[real][1], motion


def test_high_up_a_float_still_notices_a_slow_climb(programs, replay, tmp_path):
    # at 150 m a float's last digit is 15 um, and a step of 10 ms at 1 mm/s 10 um: without the second number
    # that keeps what the first is too coarse for, the height is off by 7 mm
    lift = simulate("lift", duration=160, rate_hz=100, climb=1500.0, speed=20.0, seed=1)
    found = replay(programs["coloured", "float", "replay"], text_of(lift, tmp_path))
    assert distance(found, Tracker(noise=NOISE, **CASES["coloured"]).run(lift)) < TYPES["float"][1]


@pytest.mark.parametrize("real", TYPES)
@pytest.mark.parametrize("case", ["sg14-a", "lee16", "lee16-kf"])
def test_it_follows_python_on_real_recordings(programs, replay, tmp_path, shared_data, case, real):
    lift = [shared_data / f"srp_altimu10_elevator_rocket/elevator_{s}.csv.gz" for s in ("baro", "acc", "gyr")]
    hand = shared_data / "stampfly_tof_handheld/lift30cm_b.csv.gz"
    for recording in (ba.read(*lift), ba.read(hand)):
        found = replay(programs[case, real, "replay"], text_of(recording, tmp_path))
        track = Tracker(noise=NOISE, **CASES[case]).run(recording)
        assert distance(found, track) < TYPES[real][1]


@pytest.mark.parametrize("case", CASES)
def test_missing_samples_and_steps_of_no_time_mean_what_they_mean_in_python(programs, replay, case):
    rng = np.random.default_rng(5)
    ride = simulate("squat", duration=20, rate_hz=RATES.get(case, 50.0), seed=6)
    moving = ride.t > 3
    lost = {name: moving & (rng.random(len(ride)) < 0.2) for name in ("pressure", "accel", "gyro")}
    lost["gyro"] |= (ride.t > 8) & (ride.t < 9)  # long enough to lose the tilt
    lost["accel"] |= (ride.t > 12) & (ride.t < 13)  # and to forget the acceleration
    t = np.repeat(ride.t[::2], 2)[: len(ride)] if case != "coloured" else ride.t
    t = np.where(moving, t, ride.t)
    columns = {"time_s": t, "pressure_pa": np.where(lost["pressure"], np.nan, ride.pressure)}
    for i, axis in enumerate("xyz"):
        columns[f"acc_{axis}_m_s2"] = np.where(lost["accel"], np.nan, ride.accel[:, i])
        columns[f"gyr_{axis}_rad_s"] = np.where(lost["gyro"], np.nan, ride.gyro[:, i])
    names = ",".join(columns)
    rows = [
        ",".join("" if np.isnan(x) else repr(float(x)) for x in row)
        for row in zip(*columns.values(), strict=True)
    ]
    found = replay(programs[case, "double", "replay"], "\n".join([names, *rows]) + "\n")
    tracker = Tracker(noise=NOISE, **CASES[case])
    force, rate = (np.where(lost[name][:, None], np.nan, getattr(ride, name)) for name in ("accel", "gyro"))
    for k in range(len(t)):
        state = tracker.step(
            dt=t[k] - t[k - 1] if k else np.nan,
            pressure=columns["pressure_pa"][k],
            accel=force[k],
            gyro=rate[k],
        )
        if state is not None:
            assert found["height_m"][k] == pytest.approx(state.height, abs=1e-9), k
            assert found["velocity_sd_m_s"][k] == pytest.approx(state.velocity_sd, abs=1e-9), k


def test_without_gravity_at_the_start_the_alignment_begins_anew(programs, replay, tmp_path):
    ride = simulate("squat", duration=15, seed=3)
    falling = replace(ride, accel=np.where((ride.t < 0.9)[:, None], 0.01, ride.accel))
    found = replay(programs["lee16", "double", "replay"], text_of(falling, tmp_path))
    later = Tracker(noise=NOISE, **CASES["lee16"]).run(ride.rows(slice(50, None)))
    assert (found["height_m"][:100] == 0).all()
    assert np.abs(found["height_m"][50:].to_numpy() - later.height).max() < 1e-9


@pytest.mark.skipif(shutil.which("nm") is None, reason="there is no nm")
def test_there_is_no_heap_and_no_global_state(tmp_path, gcc):
    folder = exported("sg14-b", tmp_path)
    gcc(folder, "baroarma.o", "-c", sources=("baroarma.c",))
    lines = subprocess.run(["nm", folder / "baroarma.o"], capture_output=True, text=True, check=True).stdout
    symbols = [line.split()[-2:] for line in lines.splitlines()]
    mathematics = {"atan2f", "cosf", "expf", "expm1f", "hypotf", "log1pf", "logf", "sinf", "sincosf", "sqrtf"}
    # the compiler's own, and position-independent code's
    allowed = mathematics | {"_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail", "memset", "memcpy", "memmove"}
    assert {name for kind, name in symbols if kind == "U"} <= allowed
    assert {kind for kind, _ in symbols} <= {"T", "t", "r", "R", "U"}
    assert {name for kind, name in symbols if kind == "T"} == {"baroarma_init", "baroarma_step"}


CORES = {
    "cortex-m0plus": ["-mcpu=cortex-m0plus"],
    "cortex-m4": ["-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"],
    "cortex-m7": ["-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard"],
}


@pytest.mark.skipif(shutil.which("arm-none-eabi-gcc") is None, reason="there is no arm-none-eabi-gcc")
@pytest.mark.parametrize("core", CORES)
def test_microcontrollers_compilers_have_no_warning_either(tmp_path, core):
    folder = exported("sg14-b", tmp_path)
    warnings = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wdouble-promotion"]
    command = ["arm-none-eabi-gcc", "-std=c99", "-Os", "-mthumb", *CORES[core], *warnings, "-c", "baroarma.c"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def without_comments(text):
    return re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)


def test_a_sensors_name_can_not_leave_its_comment():
    evil = 'x */ int y; /* \\\n*/ #error no ??/\n" é'
    named = firmware("lee16", noise=replace(NOISE, sensor=evil), rate_hz=50)
    unnamed = firmware("lee16", noise=replace(NOISE, sensor=""), rate_hz=50)
    for (name, text), (_, plain) in zip(named.files, unnamed.files, strict=True):
        assert without_comments(text) == without_comments(plain), name
        assert text.isascii()
        assert "sensor x _/ int y; /_ " in text


def test_the_price_of_whitening_is_told():
    (note,) = firmware("sg14-b", noise=NOISE, rate_hz=50).notes
    assert note == "A steady height change is reported 0.193 times its size (DC gain)."
    assert firmware("sg14-a", noise=NOISE, rate_hz=50).notes == ()


def test_writing_again_replaces_the_files_and_a_missing_parent_is_refused(tmp_path):
    made = firmware("lee16", rate_hz=50)
    made.write(tmp_path / "firmware")
    made.write(tmp_path / "firmware")
    names = sorted(path.name for path in (tmp_path / "firmware").iterdir())
    assert names == sorted(name for name, _ in made.files)
    with pytest.raises(ValueError, match="there is no folder"):
        made.write(tmp_path / "none" / "firmware")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"preset": "bourke08"}, "bourke08 has no counterpart in C: it works off-line; there are"),
        ({"preset": "sonoh15"}, "the height estimator inertial-ekf"),
        ({"preset": "sg14-a", "attitude": "accelerometer-norm"}, "the attitude accelerometer-norm"),
        (
            {"preset": "sg14-a", "height_settings": {"slow_barometer": "hold"}},
            "setting slow_barometer='hold'",
        ),
        ({"preset": "sg14"}, "there is no preset 'sg14'"),
        ({"rate_hz": 1.0}, "rate must be 4 to 2000 Hz, but it is 1"),
        ({"rate_hz": math.nan}, "but it is nan"),
        ({"real": "half"}, "'float' or 'double', not with 'half'"),
    ],
)
def test_what_can_not_be_exported_is_refused_in_a_sentence(options, says):
    with pytest.raises(ValueError, match=re.escape(says)):
        firmware(**{"preset": "sg14-a", "rate_hz": 50.0, **options})
