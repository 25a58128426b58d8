"""The whitening filter in fixed point: C gives the model's bits, the response is told, nothing overflows."""

import subprocess

import numpy as np
import pytest

from baroarma import NoiseModel
from baroarma.export import quantise, render
from baroarma.export.fixed_point import FULL_SCALES

SG13 = NoiseModel(0.27, 0.75, 0.46, rate_hz=50)
FILTERS = {
    "unity at Nyquist": SG13.whitening_filter(),
    "unity at DC": SG13.whitening_filter(unity_gain_hz=0),
    "slow at 400 Hz": NoiseModel(0.27, 7.5, 0.46, rate_hz=400).whitening_filter(unity_gain_hz=1),
    "no white noise": NoiseModel(0.27, 0.75, 0.0, rate_hz=400).whitening_filter(unity_gain_hz=1),
    "white already": NoiseModel(0, 0, 0.46, rate_hz=50).whitening_filter(),
}
EACH = pytest.mark.parametrize("whitening", FILTERS.values(), ids=FILTERS.keys())
FORM = pytest.mark.parametrize("form", ["q15", "q31"])


def worst_input(whitening, full, n=2000):
    """The signs of the impulse response, turned around: no input of that size has a larger output."""
    response = whitening(np.concatenate([[0.0], np.eye(1, n)[0]]))[1:]
    return [int(full * s) for s in np.where(response[::-1] >= 0, 1, -1)]


@EACH
@FORM
def test_c_gives_the_models_bits_without_overflow(gcc, tmp_path, whitening, form):
    narrow = "int16_t" if form == "q15" else "int32_t"
    main = f"""
#include <stdio.h>
int main(void)
{{
    whitening_{form} filter = {{0, 0, 0, 0}};
    long x;
    while (scanf("%ld", &x) == 1) {{
        printf("%ld\\n", (long)whitening_{form}_step(&filter, ({narrow})x));
    }}
    return 0;
}}
"""
    (tmp_path / "main.c").write_text(render(whitening, form) + main)
    program = gcc(tmp_path, "main", "-fsanitize=undefined", "-fno-sanitize-recover=all")
    fixed = quantise(whitening, form)
    full = 2**fixed.bits - 1
    noise = np.random.default_rng(0).integers(-full, full, 500).tolist()
    x = [*noise, *worst_input(whitening, full), *worst_input(whitening, -full), 0, 0, 1, -1]
    fed = "\n".join(map(str, x))
    done = subprocess.run([program], input=fed, capture_output=True, text=True, check=True)
    assert [int(line) for line in done.stdout.split()] == fixed(x)
    assert max(map(abs, fixed(x))) <= full


@EACH
@FORM
def test_the_output_is_the_exact_filters_to_the_last_bits(whitening, form):
    fixed = quantise(whitening, form)
    full = 2.0**fixed.bits
    heights = np.cumsum(np.random.default_rng(1).normal(0, 0.05, 2000))
    x = np.round(heights / FULL_SCALES[form] * full).astype(np.int64)
    out = np.array(fixed(x.tolist())) / full * FULL_SCALES[form] * 2**fixed.shift
    exact = fixed.quantised(x / full * FULL_SCALES[form])
    # the rounding e of a step appears as e_k - e_{k-1}, filtered by the pole: at most 2/(1 - |a|) of the last
    # bit; and the start is off by one, which dies out
    a = abs(fixed.quantised.a[1]) if len(fixed.quantised.a) > 1 else 0.0
    assert np.abs(out - exact).max() <= 3 / (1 - a) * FULL_SCALES[form] * 2**fixed.shift / full


@EACH
@FORM
def test_a_steady_height_has_no_dead_band(whitening, form):
    fixed = quantise(whitening, form)
    for x in (1, 37, -1001):
        out = fixed([x] * 40_000)[20_000:]
        # the remainder is carried on, so that the mean is exact but for the last remainder in 20 000
        gain = (fixed.b0 + fixed.b1) / (2**fixed.bits + fixed.a1)
        assert np.mean(out) == pytest.approx(
            gain * x, abs=1e-3 + 2 / 20_000 / (1 - abs(fixed.a1) / 2**fixed.bits)
        )


@EACH
def test_the_quantised_response_is_what_an_independent_calculation_gives(whitening):
    from scipy.signal import freqz

    for form, most in (("q15", 1.0), ("q31", 1e-4)):  # dB: what 15 bits do to a pole near 1, and 31
        fixed = quantise(whitening, form)
        frequency = np.linspace(0, np.pi, 5001)
        gain = [np.abs(freqz(w.b, w.a, frequency)[1]) for w in (fixed.quantised, fixed.exact)]
        off = np.abs(20 * np.log10(gain[0] / gain[1])).max()
        assert off <= fixed.deviation_db() * 1.001 + 1e-9  # the grids differ, and 1e-9 dB is rounding
        assert fixed.deviation_db() < most


@EACH
@FORM
def test_the_dc_gain_is_kept_to_the_last_bit_of_a_coefficient(whitening, form):
    fixed = quantise(whitening, form)
    # b1 is the nearest whole number, so that b0 + b1 is off by half of one
    step = 0.5 * 2**fixed.shift / (2**fixed.bits + fixed.a1)
    assert abs(fixed.quantised.dc_gain - fixed.exact.dc_gain) <= step * (1 + 1e-6)


def test_the_source_reports_the_response_of_the_rounded_coefficients():
    text = render(FILTERS["unity at Nyquist"], "q15")
    fixed = quantise(FILTERS["unity at Nyquist"], "q15").quantised
    assert f"pole {fixed.pole_hz:.6g} Hz [1.09936]" in text
    assert f"reported {fixed.dc_gain:.6g} [0.193027] times its size (DC gain)" in text
    assert "the filter is 1" in render(FILTERS["white already"], "q31")


def test_what_can_not_be_rounded_is_refused():
    slow = NoiseModel(1e-3, 1e4, 10.0, rate_hz=1000).whitening_filter()
    with pytest.raises(ValueError, match=r"the pole at .* Hz is too low for q15; take q31, or float"):
        quantise(slow, "q15")
    with pytest.raises(ValueError, match="'q7'"):
        quantise(slow, "q7")
