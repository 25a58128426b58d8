"""What was identified, for people: the page, and the tables in notebooks."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from baroarma.noise_model import PARAMETERS, TERM_NAMES, TEST_NAMES, NoiseModel
from baroarma.page import (
    Block,
    Code,
    Figures,
    Page,
    Section,
    Table,
    Text,
    Verdict,
    render,
    write_page,
)
from baroarma.zoomable import SAMPLES, drawing

if TYPE_CHECKING:
    from baroarma.identification import Identification
    from baroarma.whitening import WhiteningFilter


def write_identification_report(
    founds: Sequence[Identification], path: str | os.PathLike[str], *, unity_gain_hz: float | None = None
) -> None:
    """Write a page about noise models: verdict, numbers, what to do with them, and plots.

    Parameters
    ----------
    founds : sequence of Identification
        What `identify` returned, with or without models; several get a table at the top.
    path : path-like
        Where to write the HTML page; it replaces an older one only when it is complete.
    unity_gain_hz : float, optional
        Frequency in Hz at which the whitening filters have gain 1; default: Nyquist, as SG13.

    Raises
    ------
    ValueError
        If there is nothing to report, or the frequency lies beyond a recording's Nyquist.
    """
    if not founds:
        raise ValueError("there is nothing to report; give at least one identification")
    many = len(founds) > 1
    sections = [_overview(founds)] if many else []
    for i, found in enumerate(founds):
        title = f"{i + 1}. {found.recording.name}" if many else ""
        options: Any = {"unity_gain_hz": unity_gain_hz, "samples": SAMPLES // len(founds)}
        sections.append(identification_section(found, title, _anchor(i), **options))
    subject = f"{len(founds)} recordings" if many else founds[0].recording.name or "a recording"
    write_page(path, Page(f"Barometer noise: {subject}", tuple(sections)))


def identification_section(
    found: Identification,
    title: str,
    anchor: str,
    *,
    unity_gain_hz: float | None = None,
    samples: int = SAMPLES,
) -> Section:
    """Return one recording's part of a page.

    Parameters
    ----------
    found : Identification
        With or without a model.
    title, anchor : str
        Heading, and a name that no other part of the page has.
    unity_gain_hz : float, optional
        Frequency in Hz at which the whitening filter has gain 1; default: Nyquist.
    samples : int
        Samples that the plot of the record keeps for zooming; see `zoomable.drawing`.
    """
    return Section(_blocks(found, anchor, unity_gain_hz, samples), title, anchor)


def model_table(model: NoiseModel) -> str:
    """Return a noise model as an HTML table for notebooks.

    Examples
    --------
    >>> "0.46 m" in model_table(NoiseModel(0, 0, 0.46, rate_hz=50))
    True
    """
    return render("notebook.html", box=None, tables=[_parameters(model)])


def identification_table(found: Identification) -> str:
    """Return verdict and noise model as HTML for notebooks."""
    tables = [_parameters(found.model)] if found.model else []
    return render("notebook.html", box=_verdict(found), tables=tables)


def comparison_table(founds: Sequence[Identification]) -> str:
    """Return several recordings' models as one HTML table, a row each."""
    return render("notebook.html", box=None, tables=[_comparison(founds)])


NAMES: Final = {
    "correlated_sd": ("Gauss-Markov sd", "m"),
    "correlation_time": ("correlation time", "s"),
    "white_sd": ("white sd", "m"),
    "drift_rate": ("drift rate", "m/√s"),
}


def _overview(founds: Sequence[Identification]) -> Section:
    models = sum(found.ok for found in founds)
    sentence = f"{models} of {len(founds)} recordings support a noise model."
    anchors = tuple(_anchor(i) for i in range(len(founds)))
    table = replace(_comparison(founds), anchors=anchors)
    return Section((Text("All recordings", sentence), table))


def _anchor(i: int) -> str:
    return f"recording-{i + 1}"


def _blocks(
    found: Identification, anchor: str, unity_gain_hz: float | None, samples: int
) -> tuple[Block, ...]:
    blocks: list[Block] = [_verdict(found)]
    whitening = None
    if found.model is not None:
        whitening = found.model.whitening_filter(unity_gain_hz=unity_gain_hz)
        blocks += [
            Text("The noise, and what each number means for a filter", _advice(found)),
            _parameters(found.model, meaning=True),
            Text("For a Kalman filter that steps from sample to sample"),
            _kalman(found.model),
        ]
    blocks += [
        Text("Data and model" if found.ok else "The recording"),
        _figures(found, anchor, whitening, samples),
    ]
    if whitening is not None:
        blocks += [Text("Whitening filter", _price(whitening)), Code(_coefficients(whitening))]
    if found.fits:
        blocks += [Text("Which terms the data call for"), _terms(found)]
    if found.model is not None and found.model.whiteness_p:
        blocks += [Text("Are the prediction errors white?"), _whiteness(found.model.whiteness_p)]
    if found.windows is not None:
        blocks += [Text("Window by window"), Code(found.windows.summary())]
    return (*blocks, Text("Source"), _source(found))


def _verdict(found: Identification) -> Verdict:
    if found.model is None:
        return Verdict("This recording can't support a noise model.", found.verdict, refused=True)
    return Verdict(_story(found.model), found.verdict)


def _story(model: NoiseModel) -> str:
    parts = []
    if model.white_sd:
        parts.append(f"each raw sample scatters by {model.white_sd:.3g} m (white)")
    if model.has_gauss_markov:
        parts.append(
            f"an error of {model.correlated_sd:.3g} m comes and goes with a correlation time of "
            f"{model.correlation_time:.3g} s"
        )
    if model.drift_rate:
        parts.append(f"the height drifts by {model.drift_rate * math.sqrt(60):.3g} m in a minute")
    text = "; ".join(parts) + f".  Rate: {model.rate_hz:.4g} Hz."
    return text[0].upper() + text[1:]


def _advice(found: Identification) -> str:
    if not found.minutes_wanting:
        return ""
    return (
        f"{found.minutes_wanting:.0f} more minutes at rest would bring the interval of the correlation time "
        "to ±10 %."
    )


def _parameters(model: NoiseModel, *, meaning: bool = False) -> Table:
    rows = []
    for name, (label, unit) in NAMES.items():
        interval = "–" if model.ci95 is None else "{:.4g} to {:.4g}".format(*model.ci95[name])
        row = (label, f"{getattr(model, name):.4g} {unit}", f"{interval} {unit}" if model.ci95 else "–")
        rows.append((*row, _meaning(model, name)) if meaning else row)
    head = ("parameter", "value", "95 % interval", *(("what it means",) if meaning else ()))
    sensor = f" of {model.sensor}" if model.sensor else ""
    return Table(
        head, tuple(rows), f"Noise{sensor} of raw samples at {model.rate_hz:.4g} Hz ({model.method})"
    )


def _meaning(model: NoiseModel, name: str) -> str:
    value = float(getattr(model, name))
    if not value:
        return "The data do not call for it; leave it out, or keep its upper end in mind."
    if name == "white_sd":
        return (
            f"Use its square, {value**2:.4g} m², as R of one raw sample; averaging n samples divides it by n."
        )
    if name == "correlated_sd":
        return (
            "Averaging over less than many correlation times does not remove it: carry it as a state of "
            f"variance {value**2:.4g} m², or whiten it."
        )
    if name == "correlation_time":
        return "How long that error lasts: samples this far apart still correlate by 37 %."
    return (
        f"A random walk: {value * math.sqrt(60):.3g} m after a minute, {60 * value:.3g} m after an hour; "
        "no filter of the barometer alone removes it."
    )


def _kalman(model: NoiseModel) -> Table:
    """What the model is in a filter's matrices, at one step per raw sample."""
    dt = 1 / model.rate_hz
    rows = [("measurement", "R = white sd²", f"{model.white_sd**2:.6g} m²")]
    if model.has_gauss_markov:
        phi = math.exp(-dt / model.correlation_time)
        steady = model.correlated_sd**2
        rows += [
            ("Gauss-Markov state: transition", "F = exp(−Δt/τ)", f"{phi:.6g}"),
            (
                "Gauss-Markov state: process noise",
                "Q = sd²·(1 − F²)",
                f"{steady * -math.expm1(-2 * dt / model.correlation_time):.6g} m²",
            ),
            ("Gauss-Markov state: at the start", "P = sd²", f"{steady:.6g} m²"),
        ]
    if model.drift_rate:
        step = model.drift_rate**2 * dt
        rows.append(("drift state: process noise", "Q = drift rate²·Δt, with F = 1", f"{step:.6g} m²"))
    return Table(("part", "formula", "value"), tuple(rows), f"Δt = {dt:.6g} s; the states add to the height.")


def _price(whitening: WhiteningFilter) -> str:
    if whitening.zero_hz is None:
        return whitening.note
    return (
        f"Mind the gain at DC: a steady height change is under-reported by the factor "
        f"{whitening.dc_gain:.4g}; of 10 m, {10 * whitening.dc_gain:.3g} m are left.  Where height matters, "
        "carry the correlated noise as a state instead, which distorts nothing."
    )


def _coefficients(whitening: WhiteningFilter) -> str:
    lines = [f"{name} = {list(getattr(whitening, name))}" for name in ("b", "a")]
    for name in ("rate_hz", "unity_gain_hz", "dc_gain", "zero_hz", "pole_hz"):
        value = getattr(whitening, name)
        if value is not None:
            lines.append(f"{name} = {value:.10g}")
    return "\n".join(lines)


def _figures(found: Identification, anchor: str, whitening: WhiteningFilter | None, samples: int) -> Figures:
    from baroarma import plotting

    names = ["record"] if found.model is None else ["record", "acf", "psd", "allan", "residuals"]
    drawn: dict[str, Any] = {name: partial(getattr(plotting, f"plot_{name}"), found) for name in names}
    if whitening is not None:
        drawn["whitening"] = partial(plotting.plot_whitening, whitening)
    return Figures(
        tuple(drawing(draw, f"{anchor}-{n}", _CAPTIONS[n], samples=samples) for n, draw in drawn.items())
    )


_CAPTIONS: Final = {
    "record": "All samples (their envelope, where there are many) and means over ten seconds.",
    "acf": "Model and band come from simulations, treated like the data: the levels of long blocks removed.",
    "psd": "The data's band is 95 %; the terms show which of them rules at which frequency.",
    "allan": "Scatter of neighbouring averages against their length; at the minimum it has done its best.",
    "residuals": "Structure that the model misses bends the curve out of the band.",
    "whitening": "What lies below the zero is damped to the gain at DC, real height changes included.",
}


def _terms(found: Identification) -> Table:
    least = found.fits[0].bic
    rows = tuple((" + ".join(TERM_NAMES[t] for t in f.terms), f"{f.bic - least:.1f}") for f in found.fits)
    caption = (
        "By BIC: smaller is better, and a difference of 10 is decisive.  The model reported is the best of "
        "those with at most one Gauss-Markov term."
    )
    return Table(("terms", "BIC above the best"), rows, caption)


def _whiteness(p: dict[str, float]) -> Table:
    rows = tuple((TEST_NAMES.get(name, name), f"{value:.2g}", _in_words(value)) for name, value in p.items())
    return Table(("test", "p", "meaning"), rows, "A p-value below 0.01 says that the model misses structure.")


def _in_words(p: float) -> str:
    return "looks white" if p >= 0.01 else "not white"


def _source(found: Identification) -> Table:
    recording = found.recording
    source = recording.source or {}
    rows = [
        ("name", str(source.get("name") or recording.name or "–")),
        ("SHA-256", str(source.get("sha256") or "–")),
        ("duration", f"{recording.duration:.6g} s"),
        ("samples", f"{int(recording.is_new.sum())} of pressure in {len(recording)} rows"),
        ("method", found.method),
    ]
    if found.temperature is not None:
        rows.append(("air temperature", f"{found.temperature:.4g} °C"))
    return Table(("what", "value"), tuple(rows))


def _comparison(founds: Sequence[Identification]) -> Table:
    head = ("recording", "verdict", "duration", *(f"{label} ({unit})" for label, unit in NAMES.values()))
    rows = []
    for i, found in enumerate(founds, 1):
        codes = ", ".join(finding.code for finding in found.verdict)
        word = _verdict(found).word + (f" ({codes})" if codes else "")
        cells = tuple(_cell(found.model, name) for name in PARAMETERS)
        rows.append((f"{i}. {found.recording.name}", word, f"{found.recording.duration:.4g} s", *cells))
    return Table(head, tuple(rows), "Values with 95 % intervals; 0: the data do not call for the term.")


def _cell(model: NoiseModel | None, name: str) -> str:
    if model is None:
        return "–"
    value = f"{getattr(model, name):.3g}"
    return value if model.ci95 is None else value + " [{:.3g}, {:.3g}]".format(*model.ci95[name])
