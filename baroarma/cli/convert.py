"""`baroarma convert`: recordings of any format in, our CSV or Parquet out."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import click

from baroarma.cli.common import (
    OutputFile,
    json_option,
    print_json,
    read_recordings,
    recordings_argument,
)
from baroarma.cli.loudness import say, say_next

if TYPE_CHECKING:
    from baroarma.recording import Recording


@click.command(
    short_help="Convert a log to our CSV or Parquet.",
    epilog="Example:  baroarma convert flight.ulg flight.csv",
)
@recordings_argument
@click.argument("out", type=OutputFile())
@json_option
def convert(
    files: tuple[str, ...],
    mapping: tuple[str, ...],
    start: float | None,
    stop: float | None,
    out: str,
    as_json: bool,
) -> None:
    """Convert a RECORDING to one file OUT: CSV, or what .csv.gz or .parquet says.

    A RECORDING is a CSV or Parquet file; a log of PX4 (.ulg) or ArduPilot (.bin); an export of phyphox or
    Sensor Logger (.zip, or its folder); or a ROS bag.  Several files are streams of one recording.

    What is written is what the other commands see: all streams on one clock, in SI units, an empty cell where
    there is no new sample.
    """
    from baroarma.formats import write_csv

    for file in files:
        if os.path.exists(file) and os.path.exists(out) and os.path.samefile(file, out):
            raise click.UsageError(f"{out} is what is to be converted; write to another file")
    recordings = read_recordings(files, mapping, start, stop)
    if len(recordings) != 1:
        names = ", ".join(recording.name for recording in recordings)
        raise click.UsageError(
            f"convert takes one recording at a time, but these are {len(recordings)}: {names}"
        )
    for finding in recordings[0].notes:
        say(str(finding))
    write_csv(recordings[0], out)
    if as_json:
        print_json(_document(recordings[0], out))
        return
    say(f"{recordings[0]!r} -> {out}")
    if recordings[0].accel is None:
        say_next("identify", out, "--out", "noise.json")
    else:
        say_next("track", out, "--out", "track.csv")


def _document(recording: Recording, out: str) -> dict[str, Any]:
    samples = int(recording.is_new.sum())
    signals = ("accel", "gyro", "temperature", "reference", "reference_velocity", "reference_attitude")
    return {
        "recording": recording.name,
        "source": recording.source,
        "out": out,
        "rows": len(recording),
        "duration_s": recording.duration,
        "pressure_samples": samples,
        "pressure_rate_hz": recording.rate_hz if samples > 1 else None,
        "signals": [name for name in signals if getattr(recording, name) is not None],
        "findings": [finding.to_dict() for finding in recording.notes],
    }
