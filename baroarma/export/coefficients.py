"""The whitening filter's coefficients as JSON, CSV, C source, CMSIS-DSP biquad and C in fixed point."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from typing import Final

from baroarma.export.fixed_point import fixed_point_source
from baroarma.whitening import WhiteningFilter


def render(whitening: WhiteningFilter, form: str) -> str:
    """Return the coefficients as text.

    Parameters
    ----------
    whitening : WhiteningFilter
        The filter.
    form : {"json", "csv", "c", "cmsis", "q15", "q31"}
        ``json``: the documented object; ``csv``: columns b, a; ``c``: a C99 function for one sample;
        ``cmsis``: the coefficient array of CMSIS-DSP's ``arm_biquad_cascade_df2T_init_f32`` (its feedback
        coefficients have the opposite sign); ``q15`` and ``q31``: a C99 function in fixed point, with the
        response of the rounded coefficients (`baroarma.export.fixed_point`).

    Raises
    ------
    ValueError
        For another form, or a filter that fixed point can't hold.

    Examples
    --------
    >>> from baroarma.whitening import synthesise
    >>> w = synthesise(tau_p=0.664286, tau_o=0.158333, rate_hz=50, unity_gain_hz=25)
    >>> print(render(w, "csv"), end="")
    b,a
    0.95475...,1.0
    -0.92643...,-0.88118...
    """
    if form not in FORMATS:
        raise ValueError(f"format {form!r} is unknown; choose one of {', '.join(FORMATS)}")
    return FORMATS[form](whitening)


def _json(w: WhiteningFilter) -> str:
    return json.dumps(w.to_dict(), indent=2, allow_nan=False) + "\n"


def _csv(w: WhiteningFilter) -> str:
    rows = [f"{b!r},{a!r}" for b, a in zip(w.b, w.a, strict=True)]
    return "\n".join(["b,a", *rows]) + "\n"


def _padded(w: WhiteningFilter, order: int) -> tuple[list[float], list[float]]:
    pad = [0.0] * (order + 1 - len(w.b))
    return [*w.b, *pad], [*w.a, *pad]


def _headline(w: WhiteningFilter) -> str:
    if w.zero_hz is None:
        return f"Whitening filter at {w.rate_hz:g} Hz: the noise is white already, the filter is 1."
    return (
        f"Whitening filter at {w.rate_hz:g} Hz: zero {w.zero_hz:.6g} Hz, pole {w.pole_hz:.6g} Hz, "
        f"unity gain at {w.unity_gain_hz:g} Hz.\n"
        f" * A steady height change is reported {w.dc_gain:.6g} times its size (DC gain)."
    )


def _c(w: WhiteningFilter) -> str:
    (b0, b1), (_, a1) = _padded(w, 1)
    return f"""/* {_headline(w)} */
typedef struct {{ float delay; int started; }} whitening_filter;  /* set both to 0 before the first sample */

static inline float whitening_filter_step(whitening_filter *w, float height_m)
{{
    const float b0 = {b0!r}f, b1 = {b1!r}f, minus_a1 = {-a1!r}f, dc_gain = {w.dc_gain!r}f;
    if (!w->started) {{  /* begin in the steady state of the first sample */
        w->delay = (b1 + minus_a1 * dc_gain) * height_m;
        w->started = 1;
    }}
    const float whitened = b0 * height_m + w->delay;
    w->delay = b1 * height_m + minus_a1 * whitened;
    return whitened;
}}
"""


def _cmsis(w: WhiteningFilter) -> str:
    (b0, b1, b2), (_, a1, a2) = _padded(w, 2)
    values = ", ".join(f"{c!r}f" for c in (b0, b1, b2, -a1, -a2))
    return f"""/* {_headline(w)} */
/* arm_biquad_cascade_df2T_init_f32(&instance, 1, whitening_coefficients, state); b0, b1, b2, -a1, -a2 */
static const float whitening_coefficients[5] = {{{values}}};
"""


FORMATS: Final[dict[str, Callable[[WhiteningFilter], str]]] = {
    "json": _json,
    "csv": _csv,
    "c": _c,
    "cmsis": _cmsis,
    "q15": partial(fixed_point_source, form="q15"),
    "q31": partial(fixed_point_source, form="q31"),
}
"""Renderers by the name that users type."""
