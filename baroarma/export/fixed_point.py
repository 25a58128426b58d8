"""The whitening filter in fixed point: Q15 or Q31, for processors without a floating-point unit.

    acc = b0 x_k + b1 x_{k-1} - a1 y_{k-1} + rest,   y_k = floor(acc / 2^n),   rest = acc - 2^n y_k

with n = 15 or 31.  What the division leaves over goes into the next step, so that a steady height has no dead
band: the error of rounding has a zero at frequency 0.

Nothing overflows.  An input of full scale makes an output of at most l1 = |b0| + |b1 - a1 b0|/(1 - |a1|), the
sum of the moduli of the impulse response; the output's full scale is the input's times the next power of two,
2^k, and b0, b1 are divided by it.  That brings all coefficients below 1, and the sum into 32 or 64 bits.

b1 is rounded so that the DC gain stays what it is: it is the one number that a user notices.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from baroarma.whitening import WhiteningFilter

Format = Literal["q15", "q31"]
FULL_SCALES: Final[dict[str, float]] = {"q15": 64.0, "q31": 8192.0}
"""Heights in m at which the input saturates: 2 mm and 4 um for the last bit."""
_BITS: Final[dict[str, int]] = {"q15": 15, "q31": 31}


@dataclass(frozen=True)
class FixedPointFilter:
    """Hold a whitening filter in whole numbers; call it on whole numbers for what the C source would give.

    Parameters
    ----------
    form : {"q15", "q31"}
        Numbers of 16 or 32 bits.
    b0, b1, a1 : int
        Coefficients in units of 2^-15 or 2^-31.
    dc : int
        DC gain, likewise, with which the first sample starts the filter.
    shift : int
        k: the output's full scale is 2^k times the input's.
    exact : WhiteningFilter
        What it stands for.

    Examples
    --------
    >>> from baroarma.whitening import synthesise
    >>> w = synthesise(tau_p=0.664286, tau_o=0.158333, rate_hz=50, unity_gain_hz=25)
    >>> fixed = quantise(w, "q15")
    >>> fixed
    <FixedPointFilter q15 at 50 Hz: DC gain 0.2384, off by at most 0.00094 dB>
    >>> fixed([1000, 1000, 1000])
    [119, 119, 119]
    """

    form: Format
    b0: int
    b1: int
    a1: int
    dc: int
    shift: int
    exact: WhiteningFilter

    def __repr__(self) -> str:
        w = self.quantised
        return (
            f"<FixedPointFilter {self.form} at {w.rate_hz:g} Hz: DC gain {w.dc_gain:.4g}, "
            f"off by at most {self.deviation_db():.2g} dB>"
        )

    @property
    def bits(self) -> int:
        """Bits after the point, n."""
        return _BITS[self.form]

    @property
    def quantised(self) -> WhiteningFilter:
        """The filter with its coefficients as they are after rounding."""
        one, gain = 2.0**self.bits, 2.0**self.shift
        if len(self.exact.b) == 1:
            return replace(self.exact, b=(self.b0 * gain / one,))
        return replace(self.exact, b=(self.b0 * gain / one, self.b1 * gain / one), a=(1.0, self.a1 / one))

    def deviation_db(self) -> float:
        """Return by how many dB the rounded filter's gain is off at most, from 0 to Nyquist.

        Examples
        --------
        >>> from baroarma.whitening import synthesise
        >>> w = synthesise(tau_p=0.664286, tau_o=0.158333, rate_hz=50, unity_gain_hz=25)
        >>> quantise(w, "q31").deviation_db() < 1e-6 < quantise(w, "q15").deviation_db() < 1e-2
        True
        """
        frequency = np.concatenate([[0.0], np.geomspace(1e-5, 0.5, 2000)]) * self.exact.rate_hz
        ratio = np.abs(self.quantised.response(frequency) / self.exact.response(frequency))
        return float(np.max(np.abs(20 * np.log10(ratio))))

    def __call__(self, x: list[int] | NDArray[np.int64]) -> list[int]:
        """Filter whole numbers, bit by bit as the C source does; the output is in its own full scale."""
        out: list[int] = []
        before, y, rest = 0, 0, 0
        for k, now in enumerate(int(value) for value in x):
            if k == 0:
                before, y = now, (self.dc * now) >> self.bits
            total = self.b0 * now + self.b1 * before - self.a1 * y + rest
            y = total >> self.bits
            rest = total - (y << self.bits)
            before = now
            out.append(y)
        return out


def quantise(whitening: WhiteningFilter, form: Format) -> FixedPointFilter:
    """Round a whitening filter to fixed point.

    Parameters
    ----------
    whitening : WhiteningFilter
        The filter.
    form : {"q15", "q31"}
        Numbers of 16 or 32 bits.

    Raises
    ------
    ValueError
        If the form is neither, or its pole is so near 1 that the rounded filter would not be stable.

    Examples
    --------
    >>> from baroarma.noise_model import NoiseModel
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> q15 = quantise(noise.whitening_filter(unity_gain_hz=25), "q15")
    >>> q15.deviation_db() < 0.01  # of the rounded filter's gain from the exact one's
    True
    """
    if form not in _BITS:
        raise ValueError(f"fixed point is 'q15' or 'q31', not {form!r}")
    one = 2 ** _BITS[form]
    (b0, b1), a1 = (*whitening.b, 0.0)[:2], (*whitening.a, 0.0)[1]
    if not round(abs(a1) * one) < one:
        raise ValueError(f"the pole at {whitening.pole_hz:.3g} Hz is too low for {form}; take q31, or float")
    shift = _shift(b0, b1, a1)
    b0_, a1_ = round(b0 / 2**shift * one), round(a1 * one)
    gain = whitening.dc_gain / 2**shift
    b1_ = round(gain * (one + a1_)) - b0_ if len(whitening.b) > 1 else 0
    return FixedPointFilter(form, b0_, b1_, a1_, round(gain * one), shift, whitening)


def _shift(b0: float, b1: float, a1: float) -> int:
    """Return k: what brings the largest output below 1, and the sum of all products below 2."""
    margin = 1e-3  # for rounding: of coefficients, and of what one step leaves to the next
    largest = abs(b0) + abs(b1 - a1 * b0) / (1 - abs(a1))
    products = (abs(b0) + abs(b1)) / (2 - abs(a1))
    return max(0, math.ceil(math.log2(max(largest, products) * (1 + margin))))


def fixed_point_source(whitening: WhiteningFilter, form: Format) -> str:
    """Return the filter as C99, with the response of the rounded coefficients in its comment."""
    f = quantise(whitening, form)
    name = f"whitening_{form}"
    narrow, wide = ("int16_t", "int32_t") if form == "q15" else ("int32_t", "int64_t")
    scale = FULL_SCALES[form]
    return f"""#include <stdint.h>

/* {_report(f)} */

#define {name.upper()}_INPUT_M {scale:.1f} /* full scale of the input, m: x = height / this * 2^{f.bits} */
#define {name.upper()}_OUTPUT_M {scale * 2**f.shift:.1f} /* full scale of the output, m */

/* Set all to 0 before the first sample. */
typedef struct {{ {narrow} x, y; {wide} rest; int started; }} {name};

/* Floor of a / 2^{f.bits}, without shifting a negative number to the right. */
static inline {narrow} {name}_floor({wide} a)
{{
    const {wide} one = ({wide})1 << {f.bits};
    return ({narrow})(a >= 0 ? a / one : -((one - 1 - a) / one));
}}

/* Take a height, return it whitened; |x| is at most 2^{f.bits} - 1. */
static inline {narrow} {name}_step({name} *w, {narrow} x)
{{
    const {wide} one = ({wide})1 << {f.bits};
    {wide} sum;
    if (!w->started) {{  /* begin in the steady state of the first sample */
        w->x = x;
        w->y = {name}_floor(({wide}){f.dc} * x);
        w->started = 1;
    }}
    sum = ({wide}){f.b0} * x + ({wide}){f.b1} * w->x - ({wide}){f.a1} * w->y + w->rest;
    w->x = x;
    w->y = {name}_floor(sum);
    w->rest = sum - w->y * one;
    return w->y;
}}
"""


def _report(f: FixedPointFilter) -> str:
    exact, w = f.exact, f.quantised
    head = f"Whitening filter at {w.rate_hz:g} Hz in {f.form}"
    if exact.zero_hz is None:
        return f"{head}: the noise is white already, the filter is 1."
    unity, off = abs(complex(w.response(w.unity_gain_hz))), f.deviation_db()
    return f"""{head}; rounded, and exact in brackets:
 * zero {w.zero_hz:.6g} Hz [{exact.zero_hz:.6g}], pole {w.pole_hz:.6g} Hz [{exact.pole_hz:.6g}],
 * gain at {w.unity_gain_hz:g} Hz {unity:.6g} [1], anywhere off by at most {off:.2g} dB.
 * A steady height change is reported {w.dc_gain:.6g} [{exact.dc_gain:.6g}] times its size (DC gain)."""
