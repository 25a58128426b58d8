"""`baroarma simulate`: recordings with truth."""

from __future__ import annotations

import click

from baroarma.cli.common import OutputFile, json_option, print_json, say


@click.command(short_help="Simulate a recording with its truth.")
@click.argument("motion")
@click.option("--out", required=True, type=OutputFile(), help="CSV, .csv.gz or .parquet to write.")
@click.option("--seed", type=click.IntRange(min=0), help="For the same numbers again.")
@click.option("--duration", type=float, metavar="S", help="Length; default: 600 at rest, 180 in motion.")
@click.option("--rate", type=float, default=50.0, show_default=True, metavar="HZ", help="Sampling rate.")
@click.option(
    "--imu/--no-imu", default=True, show_default=True, help="With accelerometer and gyro or without."
)
@json_option
def simulate(
    motion: str, out: str, seed: int | None, duration: float | None, rate: float, imu: bool, as_json: bool
) -> None:
    """Simulate MOTION as the device of Sabatini & Genovese would record it.

    Motions: rest, squat.
    """
    from baroarma.formats import write_csv
    from baroarma.simulation import WIMU
    from baroarma.simulation import simulate as simulate_motion

    if duration is None:
        duration = 600.0 if motion == "rest" else 180.0
    if not (rate > 0 and 1 <= duration * rate <= 1e9):
        raise click.UsageError(f"{duration:g} s at {rate:g} Hz make no recording; both must be positive")
    recording = simulate_motion(motion, duration=duration, rate_hz=rate, imu=WIMU if imu else None, seed=seed)
    write_csv(recording, out)
    if as_json:
        print_json({"motion": motion, "out": out, "rows": len(recording), "seed": seed})
    else:
        say(f"{recording!r} -> {out}")
