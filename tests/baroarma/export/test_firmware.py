"""Firmware as it is put together: what can be exported, what its files hold, and what is refused."""

import math
import re
import shutil
import subprocess
from dataclasses import replace

import pytest

from baroarma.export.firmware import exportable, firmware
from baroarma.simulation import BMP085

NOISE = BMP085.noise


def test_all_presets_of_the_papers_filters_can_be_exported():
    assert {"baroarma", "sg14-a", "sg14-b", "lee16", "lee16-kf"} <= set(exportable())


@pytest.mark.skipif(shutil.which("nm") is None, reason="there is no nm")
@pytest.mark.parametrize("preset", ["baroarma", "sg14-b"])
def test_there_is_no_heap_and_no_global_state(tmp_path, gcc, preset):
    firmware(preset, noise=NOISE, rate_hz=50).write(tmp_path)
    gcc(tmp_path, "baroarma.o", "-c", sources=("baroarma.c",))
    lines = subprocess.run(["nm", tmp_path / "baroarma.o"], capture_output=True, text=True, check=True).stdout
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
@pytest.mark.parametrize("preset", ["baroarma", "sg14-b"])
@pytest.mark.parametrize("core", CORES)
def test_microcontrollers_compilers_have_no_warning_either(tmp_path, core, preset):
    firmware(preset, noise=NOISE, rate_hz=50).write(tmp_path)
    warnings = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wdouble-promotion"]
    command = ["arm-none-eabi-gcc", "-std=c99", "-Os", "-mthumb", *CORES[core], *warnings, "-c", "baroarma.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
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
