"""`baroarma track`: recordings in, height and vertical velocity out; row by row from stdin."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, Any

import click

from baroarma.cli.common import (
    OutputFile,
    Refusal,
    announce_compiling,
    busy,
    json_option,
    pairs,
    print_json,
    progress_bar,
    read_recordings,
    recordings_argument,
    say,
    span,
)

if TYPE_CHECKING:
    from baroarma.noise_model import NoiseModel
    from baroarma.track import Track
    from baroarma.tracker import Tracker

    Parameter = click.ParamType[str]
else:  # older releases of click have no type arguments
    Parameter = click.ParamType


class Name(Parameter):
    """A preset's or back-end's name; which there are, plug-ins too, is looked up when the help is shown."""

    name = "name"

    def __init__(self, kind: str) -> None:
        self.kind = kind

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        """Return the names as they stand in the help."""
        return f"[{'|'.join(self._names())}]"

    def _names(self) -> tuple[str, ...]:
        if self.kind == "preset":
            from baroarma.presets import PRESETS

            return tuple(PRESETS)
        from baroarma.estimators import registry

        return registry.attitude_names() if self.kind == "attitude" else registry.height_names()


class Numbers(Parameter):
    """Numbers with commas between them."""

    name = "numbers"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return a tuple of floats."""
        try:
            numbers = tuple(float(number) for number in value.split(","))
        except ValueError:
            numbers = (math.nan,)
        if not all(map(math.isfinite, numbers)):
            self.fail(f"{value!r} is no list of numbers such as 0,3.2,6.4", param, ctx)
        return numbers


SECONDS = click.FloatRange(min=0)
METRES = click.FloatRange(min=0, min_open=True)


@click.command(short_help="Estimate height and vertical velocity.")
@recordings_argument
@click.option("--noise", "noise_file", metavar="N.json", help="Noise model that `baroarma identify` wrote.")
@click.option("--preset", type=Name("preset"), default="baroarma", show_default=True, help="A paper's chain.")
@click.option("--attitude", type=Name("attitude"), help="Another attitude estimator than the preset's.")
@click.option("--height", type=Name("height"), help="Another height estimator.")
@click.option(
    "--conditioning",
    type=click.Choice(["none", "average", "average+whitening"]),
    help="Another conditioning of the altitude.",
)
@click.option("--smooth", is_flag=True, help="Let each row know what came after it (coloured-kalman).")
@click.option("--smooth-lag", type=SECONDS, help="... up to so many seconds after it; implies --smooth.")
@click.option("--level-prior-sd", type=METRES, help="The height wanders about the start by so many metres.")
@click.option(
    "--floors", type=Numbers(), metavar="M,M,...", help="Heights of known floors above the start, m."
)
@click.option(
    "--barometer-lag", type=SECONDS, help="Time constant of the barometer's own low-pass filter, s."
)
@click.option("--out", type=OutputFile(), help="Write the track here; default: CSV to stdout.")
@json_option
def track(
    files: tuple[str, ...],
    mapping: tuple[str, ...],
    start: float | None,
    stop: float | None,
    noise_file: str | None,
    preset: str,
    attitude: str | None,
    height: str | None,
    conditioning: str | None,
    smooth: bool,
    smooth_lag: float | None,
    level_prior_sd: float | None,
    floors: tuple[float, ...] | None,
    barometer_lag: float | None,
    out: str | None,
    as_json: bool,
) -> None:
    """Estimate height and vertical velocity of a RECORDING from its IMU and barometer.

    With - as RECORDING, CSV rows are read from stdin and answered one by one; the first second, at rest,
    aligns and has no answer.  There a cell without a new sample must be empty: a reading that the logger
    merely repeats can't be told from a new one as it comes.
    """
    from baroarma.formats.long import is_long
    from baroarma.tracker import Tracker

    announce_compiling()
    noise = load_noise(noise_file)
    known = {"level_prior_sd": level_prior_sd, "floors": floors, "barometer_lag": barometer_lag}
    tracker = Tracker(
        noise=noise,
        preset=preset,
        attitude=attitude,
        height=height,
        conditioning=conditioning,
        height_settings={name: value for name, value in known.items() if value is not None},
    )
    if files == ("-",):
        given = (smooth_lag, start, stop)
        if out or as_json or mapping or smooth or any(value is not None for value in given):
            raise click.UsageError(
                "with - rows are answered on stdout as CSV as they come; leave out --out, --json, --map, "
                "--smooth, --start and --stop"
            )
        _live(tracker)
        return
    in_parts = not (smooth or smooth_lag is not None or as_json or tracker.settings.height is None)
    if in_parts and len(files) == 1 and is_long(files[0], pairs(mapping)):
        _in_parts(tracker, files[0], mapping, start, stop, out)
        return
    recordings = read_recordings(files, mapping, start, stop)
    if len(recordings) > 1:
        names = ", ".join(r.name for r in recordings)
        raise click.UsageError(
            f"track takes one recording at a time, but these are {len(recordings)}: {names}"
        )
    try:
        if smooth or smooth_lag is not None:
            found = tracker.smooth(recordings[0], lag=math.inf if smooth_lag is None else smooth_lag)
        else:
            found = tracker.run(recordings[0])
    except ValueError as error:
        raise Refusal(str(error)) from error
    for finding in found.findings:
        say(str(finding))
    if out:
        found.save(out)
        say(f"{found!r} -> {out}")
    if as_json:
        print_json(_document(found))
    elif not out:
        found.write_csv(sys.stdout)


def load_noise(path: str | None) -> NoiseModel | None:
    """Load a noise model if a path was given."""
    from baroarma.noise_model import NoiseModel

    return None if path is None else NoiseModel.load(path)


def _document(found: Track) -> dict[str, Any]:
    columns = {str(name): column.tolist() for name, column in found.to_frame().items()}
    findings = [finding.to_dict() for finding in found.findings]
    return {"preset": found.preset, "findings": findings, **columns}


def _in_parts(
    tracker: Tracker,
    file: str,
    mapping: tuple[str, ...],
    start: float | None,
    stop: float | None,
    out: str | None,
) -> None:
    """Track a long file while it is read."""
    from baroarma.formats import UnreadableError
    from baroarma.formats.long import LongRecording
    from baroarma.streaming import track_file

    with busy(f"reading {file}"):
        since, until = span(start, stop)
        log = LongRecording(file, mapping=pairs(mapping), start=since, stop=until)
    try:
        with progress_bar("tracking") as progress:
            found = track_file(tracker, log, out or sys.stdout, progress=progress)
    except UnreadableError:
        raise
    except ValueError as error:
        raise Refusal(str(error)) from error
    for finding in found.findings:
        say(str(finding))
    if out:
        say(f"{found!r} -> {out}")


def _live(tracker: Tracker) -> None:
    """Answer each row of stdin with a row of ``track.csv`` before the next one is read."""
    from baroarma.formats.rows import sample_reader

    if tracker.settings.height is None:
        raise click.UsageError(f"the preset {tracker.settings.name} works off-line; with - take another one")
    click.echo("time_s,height_m,velocity_m_s,height_sd_m,velocity_sd_m_s")
    last = math.nan
    for sample in sample_reader(sys.stdin):
        try:
            state = tracker.step(
                dt=sample.t - last, pressure=sample.pressure, accel=sample.accel, gyro=sample.gyro
            )
        except ValueError as error:
            raise Refusal(str(error)) from error
        last = sample.t
        if state is not None:
            values = ",".join(repr(float(value)) for value in state[:4])
            click.echo(f"{sample.t!r},{values}")
