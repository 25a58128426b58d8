"""`baroarma simulate`: recordings with truth."""

from __future__ import annotations

import inspect
import json
from typing import Any

import click

from baroarma.cli.common import OutputFile, json_option, print_json
from baroarma.cli.loudness import say, say_next
from baroarma.cli.names import NAMES, Listing, Name


def _motions() -> dict[str, str]:
    """Return the motions, each with its first sentence and its options."""
    from baroarma.simulation import MOTIONS, options_of

    return {name: _described(motion, options_of(name)) for name, motion in MOTIONS.items()}


@click.command(
    cls=Listing,
    lists={"Motions, with their options for --set": _motions, "Devices": NAMES["device"]},
    short_help="Simulate a recording with its truth.",
    epilog="Example:  baroarma simulate stairs --set floors=5 --seed 1 --out stairs.csv",
)
@click.argument("motion", type=Name("motion", "MOTION"))
@click.option("--out", required=True, type=OutputFile(), help="CSV, .csv.gz or .parquet to write.")
@click.option("--seed", type=click.IntRange(min=0), metavar="N", help="For the same numbers again.")
@click.option(
    "--duration",
    type=float,
    metavar="S",
    help="Length in s; default: 600 at rest, else until the motion has ended, or 180.",
)
@click.option("--rate", type=float, default=50.0, show_default=True, metavar="HZ", help="Rate of the rows.")
@click.option(
    "--device",
    type=Name("device", "NAME"),
    default="simple",
    show_default=True,
    help="Whose sensors; see below.",
)
@click.option(
    "--imu/--no-imu", default=True, show_default=True, help="With accelerometer and gyro or without."
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="OPTION=VALUE",
    help="Set an option of the motion, such as speed=0.5 (repeatable).",
)
@json_option
def simulate(
    motion: str,
    out: str,
    seed: int | None,
    duration: float | None,
    rate: float,
    device: str,
    imu: bool,
    settings: tuple[str, ...],
    as_json: bool,
) -> None:
    """Simulate MOTION as the sensors of a device would record it.

    Every motion begins with 5 s of rest.
    """
    from baroarma.formats import write_csv
    from baroarma.simulation import check_options
    from baroarma.simulation import simulate as simulate_motion

    options = _options(settings)
    check_options(motion, options)
    if duration is None and motion == "rest":
        duration = 600.0
    recording = simulate_motion(
        motion,
        duration=duration,
        rate_hz=rate,
        device=device,
        imu="of the device" if imu else None,
        seed=seed,
        **options,
    )
    write_csv(recording, out)
    if as_json:
        print_json({"motion": motion, "out": out, "rows": len(recording), "seed": seed})
        return
    say(f"{recording!r} -> {out}")
    if motion == "rest":
        say_next("identify", out, "--out", "noise.json")
    else:
        say_next("compare", out, "--presets", "baroarma,sg14-a" if imu else "baroarma")


def _options(settings: tuple[str, ...]) -> dict[str, Any]:
    """Read OPTION=VALUE, the value as JSON writes numbers and lists."""
    options = {}
    for setting in settings:
        name, _, value = setting.partition("=")
        try:
            options[name] = json.loads(value)
        except json.JSONDecodeError as error:
            raise click.UsageError(
                f"--set takes OPTION=VALUE with a number or a list such as [1.5, 0], but got {setting!r}"
            ) from error
    return options


def _described(motion: Any, options: dict[str, Any]) -> str:
    first = (inspect.getdoc(motion) or "").partition("\n")[0]
    values = ", ".join(f"{name}={json.dumps(value)}" for name, value in options.items())
    return f"{first}  {values}".rstrip()
