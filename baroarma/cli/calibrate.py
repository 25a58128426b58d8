"""`baroarma calibrate`: accelerometer scale and offset, gyro bias."""

from __future__ import annotations

import json

import click

from baroarma.cli.common import (
    OutputFile,
    Refusal,
    json_option,
    print_json,
    read_recordings,
    recordings_argument,
    same_recordings,
    write_text,
)
from baroarma.cli.loudness import say, say_next


@click.command(
    short_help="Calibrate accelerometer and gyro in the field.",
    epilog="Example:  baroarma calibrate tumble.csv --out calibration.json",
)
@recordings_argument
@click.option("--out", type=OutputFile(), help="Write the calibration as JSON here.")
@json_option
def calibrate(
    files: tuple[str, ...],
    mapping: tuple[str, ...],
    start: float | None,
    stop: float | None,
    out: str | None,
    as_json: bool,
) -> None:
    """Find the accelerometer's scale and offset and the gyro's bias from a RECORDING with several rests.

    Let the device rest for some seconds in at least six different orientations, one after the other.

    Exit code 1: the rests do not determine scale and offset.
    """
    from baroarma.estimators.calibration import calibrate as calibrate_recording

    recordings = read_recordings(files, mapping, start, stop)
    if len(recordings) != 1:
        raise click.UsageError(f"calibrate takes one recording at a time, but these are {len(recordings)}")
    try:
        found = calibrate_recording(recordings[0])
    except ValueError as error:
        raise Refusal(str(error)) from error
    if out:
        write_text(out, json.dumps(found.to_dict(), indent=2, allow_nan=False) + "\n")
        say(f"calibration: {out}")
    if as_json:
        print_json(found.to_dict())
        return
    click.echo(found.summary())
    if out:
        say("next: in Python, baroarma.estimators.calibration.calibrate(rests).apply(recording)")
    else:
        say_next("calibrate", *same_recordings(files, mapping, start, stop), "--out", "calibration.json")
