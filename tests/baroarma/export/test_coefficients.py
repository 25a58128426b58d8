"""Exported coefficients: a C compiler and the CMSIS recursion give the stream's numbers."""

import csv
import io
import json
import re
import shutil
import subprocess

import numpy as np
import pytest

from baroarma import NoiseModel
from baroarma.export import FORMATS, render

GAUSS_MARKOV = NoiseModel(0.27, 0.75, 0.46, rate_hz=50).whitening_filter()
AT_DC = NoiseModel(0.27, 0.75, 0.46, rate_hz=50).whitening_filter(unity_gain_hz=0)
WHITE = NoiseModel(0, 0, 0.46, rate_hz=50).whitening_filter()
FILTERS = pytest.mark.parametrize("whitening", [GAUSS_MARKOV, AT_DC, WHITE], ids=repr)
FLAGS = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic"]


def heights():
    return (3 + 0.5 * np.random.default_rng(0).normal(size=500)).astype(np.float32)


def compiled(source, folder, x):
    """Feed x to a program line by line and return what it prints."""
    (folder / "main.c").write_text(source)
    subprocess.run(["gcc", *FLAGS, "-o", folder / "main", folder / "main.c"], check=True)
    fed = "\n".join(f"{v:.9g}" for v in x)
    done = subprocess.run([folder / "main"], input=fed, capture_output=True, text=True, check=True)
    return np.array(done.stdout.split(), float)


needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")


@FILTERS
@needs_gcc
def test_the_c_function_compiles_without_a_warning_and_gives_the_streams_numbers(whitening, tmp_path):
    main = """
#include <stdio.h>
int main(void)
{
    whitening_filter filter = {0.0f, 0};
    float height_m;
    while (scanf("%f", &height_m) == 1) printf("%.9g\\n", (double)whitening_filter_step(&filter, height_m));
    return 0;
}
"""
    x = heights()
    theirs = compiled(render(whitening, "c") + main, tmp_path, x)
    stream = whitening.stream()
    ours = [stream.step(float(v)) for v in x]
    # single precision: 6e-8 of values up to 5 per operation, the pole remembers 1/(1 - |a|), about 10 samples
    assert theirs == pytest.approx(ours, abs=10 * 4 * 5 * 6e-8)


@FILTERS
@needs_gcc
def test_the_cmsis_array_drives_cmsis_recursion(whitening, tmp_path):
    # the recursion of arm_biquad_cascade_df2T_f32, from CMSIS-DSP's documentation
    main = """
#include <stdio.h>
int main(void)
{
    const float *c = whitening_coefficients;
    float x, d1 = 0.0f, d2 = 0.0f;
    while (scanf("%f", &x) == 1) {
        const float y = c[0] * x + d1;
        d1 = c[1] * x + c[3] * y + d2;
        d2 = c[2] * x + c[4] * y;
        printf("%.9g\\n", (double)y);
    }
    return 0;
}
"""
    from scipy.signal import lfilter

    x = heights()
    theirs = compiled(render(whitening, "cmsis") + main, tmp_path, x)
    assert theirs == pytest.approx(lfilter(whitening.b, whitening.a, x.astype(float)), abs=10 * 4 * 5 * 6e-8)


@FILTERS
def test_the_numbers_in_every_format_are_exact(whitening):
    rows = list(csv.DictReader(io.StringIO(render(whitening, "csv"))))
    assert [float(r["b"]) for r in rows] == list(whitening.b)
    assert [float(r["a"]) for r in rows] == list(whitening.a)
    assert json.loads(render(whitening, "json")) == whitening.to_dict()
    numbers = [float(v) for v in re.findall(r"(-?[\d.e-]+)f\b", render(whitening, "cmsis").split("{")[1])]
    b, a = [*whitening.b, 0, 0], [*whitening.a, 0, 0]
    assert numbers == [*b[:3], -a[1], -a[2]]


@pytest.mark.parametrize("form", sorted(FORMATS))
def test_every_format_ends_with_a_line_and_c_tells_the_price(form):
    text = render(GAUSS_MARKOV, form)
    assert text.endswith("\n")
    if form in ("c", "cmsis"):
        assert f"{GAUSS_MARKOV.dc_gain:.6g} times its size" in text
        assert "the filter is 1" in render(WHITE, form)


def test_an_unknown_format_is_refused_with_the_list():
    with pytest.raises(ValueError, match="'xml' is unknown; choose one of json, csv, c, cmsis"):
        render(GAUSS_MARKOV, "xml")
