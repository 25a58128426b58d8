"""`baroarma export`: a preset as firmware, or one noise model's numbers for other programs."""

from __future__ import annotations

import shlex
from typing import Literal

import click

from baroarma.cli.common import json_option, noise_option, print_json
from baroarma.cli.loudness import say, say_next
from baroarma.cli.names import Name


@click.command(
    short_help="Write firmware, or settings for other programs.",
    epilog="Example:  baroarma export firmware --noise noise.json --preset baroarma --rate 50 --out firmware",
)
@click.argument("what", type=click.Choice(["firmware", "hints"]))
@noise_option()
@click.option("--preset", type=Name("preset", "P"), help="firmware: which chain, such as sg14-b.")
@click.option("--rate", type=float, metavar="HZ", help="firmware: rate of the barometer's new samples.")
@click.option(
    "--float/--double",
    "single",
    default=None,
    help="firmware: what to compute with; default: float.",
)
@click.option("--out", type=click.Path(file_okay=False), metavar="DIR", help="firmware: folder to write to.")
@click.option(
    "--pressure", type=float, metavar="PA", help="hints: where the simulated sensor is; default: sea level."
)
@json_option
def export(
    what: str,
    noise_file: str | None,
    preset: str | None,
    rate: float | None,
    single: bool | None,
    out: str | None,
    pressure: float | None,
    as_json: bool,
) -> None:
    """Write C99 source of a preset, or say what to enter in PX4, ArduPilot, Gazebo and MATLAB.

    `export firmware` writes source, header and self-test; `gcc *.c -lm` in the folder builds the test.
    `export hints` prints settings with their reasons.
    """
    if what == "firmware":
        _refuse("firmware", {"--pressure": pressure})
        _firmware(noise_file, preset, rate, "double" if single is False else "float", out, as_json)
    else:
        _refuse("hints", {"--preset": preset, "--rate": rate, "--float and --double": single, "--out": out})
        _hints(noise_file, pressure, as_json)


def _refuse(what: str, options: dict[str, object]) -> None:
    for name, value in options.items():
        if value is not None:
            raise click.UsageError(f"{name} has no meaning for export {what}; leave it out")


def _firmware(
    noise_file: str | None,
    preset: str | None,
    rate: float | None,
    real: Literal["float", "double"],
    out: str | None,
    as_json: bool,
) -> None:
    from baroarma.cli.track import load_noise
    from baroarma.export.firmware import exportable, firmware

    if preset is None or rate is None or out is None:
        raise click.UsageError(
            f"export firmware needs --preset, --rate and --out; presets are {', '.join(exportable())}"
        )
    made = firmware(preset, noise=load_noise(noise_file), rate_hz=rate, real=real)
    made.write(out)
    for note in made.notes:
        say(f"note: {note}")
    if as_json:
        names = [name for name, _ in made.files]
        print_json(
            {"preset": made.preset, "rate_hz": rate, "real": real, "notes": [*made.notes], "files": names}
        )
    else:
        say(f"{made!r} -> {out}")
        say(f"next: cd {shlex.quote(out)} && gcc *.c -lm -o selftest && ./selftest")


def _hints(noise_file: str | None, pressure: float | None, as_json: bool) -> None:
    from baroarma.atmosphere import SEA_LEVEL_PRESSURE
    from baroarma.export.hints import hints
    from baroarma.noise_model import NoiseModel

    if noise_file is None:
        raise click.UsageError("export hints needs --noise N.json")
    found = hints(NoiseModel.load(noise_file), pressure=SEA_LEVEL_PRESSURE if pressure is None else pressure)
    if as_json:
        print_json({"hints": [hint.to_dict() for hint in found]})
    else:
        click.echo("\n\n".join(str(hint) for hint in found))
        say_next("predict", "--noise", noise_file)
