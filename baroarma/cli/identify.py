"""`baroarma identify`: rest recordings in, noise models and verdicts out."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from baroarma.cli.common import (
    OutputFile,
    Refusal,
    announce_compiling,
    jobs_option,
    json_option,
    pairs,
    print_json,
    read_recordings,
    recordings_argument,
    same_recordings,
    span,
    with_progress,
)
from baroarma.cli.loudness import say, say_next

if TYPE_CHECKING:
    from baroarma.identification import Identification
    from baroarma.noise_model import NoiseModel
    from baroarma.recording import Recording

_SETTINGS = {
    "window": (int, "samples per window", 300),
    "average": (int, "points of the moving average", 4),
    "decimate": (int, "keep every n-th averaged sample", 5),
    "detrend_s": (float, "seconds per level that is removed", 60),
    "trim": (float, "fraction of windows left out of the mean", 0.1),
}
_BY_RATE = ("average", "decimate")
_ADAPTED = " at 50 Hz, adapted to other rates"


def _window_settings(command: Any) -> Any:
    for name, (kind, meaning, printed) in reversed(_SETTINGS.items()):
        option = "--" + name.removesuffix("_s")
        text = f"windows: {meaning}; default: {printed:g}{_ADAPTED if name in _BY_RATE else ''}."
        metavar = {"detrend_s": "S", "trim": "FRACTION"}.get(name, "N")
        command = click.option(option, name, type=kind, metavar=metavar, help=text)(command)
    return command


@click.command(
    short_help="Learn the noise of a motionless barometer.",
    epilog="Example:  baroarma identify rest.csv --out noise.json --report page.html",
)
@recordings_argument
@click.option(
    "--method",
    type=click.Choice(["structural", "windows"]),
    default="structural",
    show_default=True,
    help="Maximum likelihood on the raw samples, or the windows recipe of Sabatini & Genovese 2013.",
)
@click.option(
    "--terms",
    default="auto",
    show_default=True,
    metavar="auto|TERMS",
    help="structural: let BIC choose, or name the terms: white,gm,drift.",
)
@click.option(
    "--split",
    type=click.Choice(["exact", "bilinear"]),
    default="exact",
    show_default=True,
    help="windows: how an ARMA(1,1) becomes Gauss-Markov plus white noise.",
)
@_window_settings
@click.option("--temperature", type=float, metavar="°C", help="Of the air, in °C; default: the ISA's.")
@click.option("--out", type=OutputFile(), help="Write the noise model here (noise.json).")
@click.option("--report", type=OutputFile(), help="Write a page with numbers and plots here (HTML).")
@click.option("--diagnostics", is_flag=True, help="Print second opinions, too (some seconds more).")
@jobs_option
@json_option
def identify(
    files: tuple[str, ...],
    mapping: tuple[str, ...],
    start: float | None,
    stop: float | None,
    terms: str,
    out: str | None,
    report: str | None,
    diagnostics: bool,
    jobs: int,
    as_json: bool,
    **options: Any,
) -> None:
    """Learn the noise of a motionless barometer from RECORDINGs at rest.

    A file with pressure starts a recording; files without (acc, gyr) belong to the one before.  Several
    recordings give a table; --out then writes their pooled model.

    If a recording can't support a model, the verdict says why, nothing is written and the exit code is 1.
    """
    _refuse_idle_options(terms, options)
    if diagnostics and as_json:
        raise click.UsageError("--diagnostics is text; it has no place in --json")
    from baroarma.executors import in_order

    announce_compiling()
    rests = _rests(files, mapping, start, stop)
    work = partial(_identify_one, terms=terms, options=options)
    found = list(with_progress(in_order(work, rests, jobs=jobs), len(rests), "identifying"))
    model = _pooled(found)
    _show(found, model, as_json)
    if model is None:
        raise Refusal(_reasons(found) + (" Nothing was written." if out or report else ""))
    if diagnostics:
        for one in found:
            click.echo(one.diagnostics())
    if report:
        from baroarma.report import write_identification_report

        write_identification_report(found, report)
        say(f"page: {report}")
    if out:
        model.save(out)
        say(f"noise model: {out}")
    if not as_json:
        _say_next(same_recordings(files, mapping, start, stop), model, out)


def _say_next(rests: list[str], model: NoiseModel, out: str | None) -> None:
    """Keep the model; then whiten, if it has Gauss-Markov noise; else track."""
    if out is None:
        say_next("identify", *rests, "--out", "noise.json")
    elif model.has_gauss_markov:
        say_next(
            "whiten", out, "--rate", f"{model.rate_hz:.6g}", "--unity-gain-at", f"{model.rate_hz / 2:.6g}"
        )
    else:
        say_next("track", "RECORDING.csv", "--noise", out)


def _refuse_idle_options(terms: str, options: dict[str, Any]) -> None:
    """Refuse options that the chosen method would not look at, and terms that don't exist."""
    for_windows = [name for name in _SETTINGS if options[name] is not None]
    for_windows += ["split"] if options["split"] != "exact" else []
    if options["method"] == "structural" and for_windows:
        raise click.UsageError(f"--{for_windows[0].removesuffix('_s')} belongs to --method windows")
    if options["method"] == "windows" and terms != "auto":
        raise click.UsageError("--terms belongs to --method structural")
    unknown = set(_split(terms)) - {"white", "gm", "drift"}
    if terms != "auto" and unknown:
        raise click.UsageError(
            f"--terms {terms}: {', '.join(sorted(unknown))!r} is no term; give auto or some of white,gm,drift"
        )


def _split(terms: str) -> tuple[str, ...]:
    return tuple(term.strip() for term in terms.split(","))


def _rests(
    files: tuple[str, ...], mapping: tuple[str, ...], start: float | None, stop: float | None
) -> list[Callable[[], Recording]]:
    """Return functions that give the recordings; long files are read when it is their turn."""
    from baroarma.formats.long import is_long
    from baroarma.streaming import read_rest

    names = pairs(mapping)
    if not all(is_long(file, names) for file in files):
        return [partial(_as_is, recording) for recording in read_recordings(files, mapping, start, stop)]
    since, until = span(start, stop)
    return [partial(read_rest, file, mapping=names, start=since, stop=until) for file in files]


def _as_is(recording: Recording) -> Recording:
    return recording


def _identify_one(rest: Callable[[], Recording], terms: str, options: dict[str, Any]) -> Identification:
    from baroarma.identification import WindowSettings
    from baroarma.identification import identify as identify_recording

    recording, settings = rest(), None
    if options["method"] == "windows" and int(recording.is_new.sum()) > 1:
        changes = {name: value for name in _SETTINGS if (value := options[name]) is not None}
        settings = WindowSettings.for_rate(recording.rate_hz, **changes)
    return identify_recording(
        recording,
        method=options["method"],
        terms="auto" if terms == "auto" else _split(terms),  # type: ignore[arg-type]
        split=options["split"],
        settings=settings,
        temperature=options["temperature"],
    )


def _pooled(found: list[Identification]) -> NoiseModel | None:
    """Return the one model, or the pooled one; None if a recording has none."""
    from baroarma.identification import pool

    models = [f.model for f in found if f.model is not None]
    if len(models) < len(found):
        return None
    return models[0] if len(models) == 1 else pool(models)


def _reasons(found: list[Identification]) -> str:
    """Return one sentence or more per refused recording."""
    return " ".join(
        f"{refused.recording.name}: {finding.message}"
        for refused in found
        for finding in refused.verdict
        if refused.model is None and finding.severity == "error"
    )


def _show(found: list[Identification], model: NoiseModel | None, as_json: bool) -> None:
    several = len(found) > 1
    if as_json and several:
        print_json({"recordings": [f.to_dict() for f in found], "pooled": model and model.to_dict()})
    elif as_json:
        print_json(found[0].to_dict())
    elif several:
        from baroarma.identification.population import table

        click.echo(table(found, model))
    else:
        click.echo(found[0].summary())
