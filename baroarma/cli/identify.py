"""`baroarma identify`: rest recordings in, noise models and verdicts out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from baroarma.cli.common import (
    Refusal,
    json_option,
    print_json,
    read_recordings,
    recordings_argument,
    say,
    with_progress,
)

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


def _window_settings(command: Any) -> Any:
    for name, (kind, meaning, printed) in reversed(_SETTINGS.items()):
        option = "--" + name.removesuffix("_s")
        text = f"windows: {meaning} [{printed:g} at 50 Hz, adapted elsewhere]"
        command = click.option(option, name, type=kind, help=text)(command)
    return command


@click.command(short_help="Learn the noise of a motionless barometer.")
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
@click.option("--temperature", type=float, metavar="°C", help="Temperature of the air; default: the ISA's.")
@click.option("--out", type=click.Path(dir_okay=False), help="Write the noise model here (noise.json).")
@click.option("--report", type=click.Path(dir_okay=False), help="Write a page with numbers and plots here.")
@json_option
def identify(
    files: tuple[str, ...],
    mapping: tuple[str, ...],
    start: float | None,
    stop: float | None,
    terms: str,
    out: str | None,
    report: str | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Learn the noise of a motionless barometer from RECORDINGs at rest.

    A file with pressure starts a recording; files without (acc, gyr) belong to the one before.  Several
    recordings give a table; --out then writes their pooled model.

    Exit code 1: a recording can't support a model; the verdict says why.
    """
    recordings = read_recordings(files, mapping, start, stop)
    found = [_identify_one(r, terms, options) for r in with_progress(recordings, "identifying")]
    _show(found, as_json)
    if report:
        from baroarma.report import write_identification_report

        write_identification_report(found, report)
        say(f"page: {report}")
    refused = [f for f in found if f.model is None]
    if refused:
        reasons = [f.message for r in refused for f in r.verdict if f.severity == "error"]
        names = ", ".join(r.recording.name for r in refused)
        raise Refusal(f"{names}: {' '.join(reasons)}{' No noise model was written.' if out else ''}")
    if out:
        _pooled(found).save(out)
        say(f"noise model: {out}")


def _identify_one(recording: Recording, terms: str, options: dict[str, Any]) -> Identification:
    from baroarma.identification import WindowSettings
    from baroarma.identification import identify as identify_recording

    changes = {name: value for name in _SETTINGS if (value := options[name]) is not None}
    windows = options["method"] == "windows"
    if changes and not windows:
        raise click.UsageError(f"--{next(iter(changes)).removesuffix('_s')} belongs to --method windows")
    if windows and terms != "auto":
        raise click.UsageError("--terms belongs to --method structural")
    settings = None
    if windows and int(recording.is_new.sum()) > 1:
        settings = WindowSettings.for_rate(recording.rate_hz, **changes)
    return identify_recording(
        recording,
        method=options["method"],
        terms="auto" if terms == "auto" else tuple(terms.split(",")),  # type: ignore[arg-type]
        split=options["split"],
        settings=settings,
        temperature=options["temperature"],
    )


def _pooled(found: list[Identification]) -> NoiseModel:
    from baroarma.identification import pool

    models = [f.model for f in found if f.model is not None]
    return models[0] if len(models) == 1 else pool(models)


def _show(found: list[Identification], as_json: bool) -> None:
    several = len(found) > 1
    pooled = _pooled(found) if several and all(f.ok for f in found) else None
    if as_json:
        if several:
            documents = [f.to_dict() for f in found]
            print_json({"recordings": documents, "pooled": pooled and pooled.to_dict()})
        else:
            print_json(found[0].to_dict())
    elif several:
        from baroarma.identification.population import table

        click.echo(table(found, pooled))
    else:
        click.echo(found[0].summary())
