"""`baroarma track`: recordings in, height and vertical velocity out; row by row from stdin."""

from __future__ import annotations

import io
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
    noise_option,
    pairs,
    print_json,
    progress_bar,
    read_recordings,
    recordings_argument,
    same_recordings,
    span,
)
from baroarma.cli.loudness import say, say_next
from baroarma.cli.names import NAMES, Listing, Name, Parameter, preset_titles

if TYPE_CHECKING:
    from baroarma.noise_model import NoiseModel
    from baroarma.recording import Recording
    from baroarma.track import Track
    from baroarma.tracker import Tracker


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
POSITIVE = click.FloatRange(min=0, min_open=True)


@click.command(
    cls=Listing,
    lists={
        "Presets": preset_titles,
        "Attitude estimators": NAMES["attitude estimator"],
        "Height estimators": NAMES["height estimator"],
    },
    short_help="Estimate height and vertical velocity.",
    epilog="Example:  baroarma track walk.csv --noise noise.json --out track.csv",
)
@recordings_argument
@noise_option()
@click.option(
    "--preset",
    type=Name("preset"),
    default="baroarma",
    show_default=True,
    help="One of those below.",
)
@click.option(
    "--attitude",
    type=Name("attitude estimator"),
    help="Another attitude estimator than the preset's.",
)
@click.option("--height", type=Name("height estimator"), help="Another height estimator.")
@click.option(
    "--conditioning",
    type=click.Choice(["none", "average", "average+whitening"]),
    help="Another conditioning of the altitude.",
)
@click.option("--smooth", is_flag=True, help="Let each row know what came after it (coloured-kalman).")
@click.option(
    "--smooth-lag", type=SECONDS, metavar="S", help="... up to so many seconds after it; implies --smooth."
)
@click.option(
    "--level-prior-sd",
    type=POSITIVE,
    metavar="M",
    help="The height wanders about the start by so much.",
)
@click.option(
    "--floors", type=Numbers(), metavar="M,M,...", help="Heights of known floors above the start, in m."
)
@click.option(
    "--barometer-lag", type=SECONDS, metavar="S", help="Time constant of the barometer's own low-pass filter."
)
@click.option("--plot", is_flag=True, help="Draw height and velocity in the terminal, too.")
@click.option(
    "--window", type=POSITIVE, metavar="S", help="plot: the last S seconds; default: 20 with -, else all."
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
    plot: bool,
    window: float | None,
    out: str | None,
    as_json: bool,
) -> None:
    """Estimate height and vertical velocity of a RECORDING from its IMU and barometer.

    With - as RECORDING, CSV rows are read from stdin and answered one by one; the first second, at rest,
    aligns and has no answer.  There a cell without a new sample must be empty: a reading that the logger
    merely repeats can't be told from a new one as it comes.  A row that can't be read is skipped and told;
    the exit code is then 1.

    --plot draws on stderr, so that stdout stays CSV.  Where both are one terminal, the plot alone is shown.
    """
    from baroarma.formats.long import is_long
    from baroarma.tracker import Tracker

    if window is not None and not plot:
        raise click.UsageError("--window belongs to --plot")
    announce_compiling()
    lag = smooth_lag if smooth_lag is not None else math.inf if smooth else None
    known = {"level_prior_sd": level_prior_sd, "floors": floors, "barometer_lag": barometer_lag}
    tracker = Tracker(
        noise=load_noise(noise_file),
        preset=preset,
        attitude=attitude,
        height=height,
        conditioning=conditioning,
        height_settings={name: value for name, value in known.items() if value is not None},
    )
    if files == ("-",):
        if as_json or mapping or any(value is not None for value in (lag, start, stop)):
            raise click.UsageError(
                "with - rows are answered as CSV as they come; leave out --json, --map, --smooth, --start "
                "and --stop"
            )
        _live(tracker, plot, window, out)
        return
    needs_all = lag is not None or as_json or plot or tracker.settings.height is None
    if not needs_all and len(files) == 1 and is_long(files[0], pairs(mapping)):
        _in_parts(tracker, files[0], mapping, start, stop, out)
    else:
        found = _whole(tracker, read_recordings(files, mapping, start, stop), lag)
        _show(found, plot, window, out, as_json)
    if not as_json:
        _say_next(same_recordings(files, mapping, start, stop), noise_file, preset)


def load_noise(path: str | None) -> NoiseModel | None:
    """Load a noise model if a path was given."""
    from baroarma.noise_model import NoiseModel

    return None if path is None else NoiseModel.load(path)


def _whole(tracker: Tracker, recordings: list[Recording], lag: float | None) -> Track:
    """Track one recording; with a lag, each row with the help of what came after it."""
    if len(recordings) > 1:
        names = ", ".join(r.name for r in recordings)
        raise click.UsageError(
            f"track takes one recording at a time, but these are {len(recordings)}: {names}"
        )
    try:
        return tracker.run(recordings[0]) if lag is None else tracker.smooth(recordings[0], lag=lag)
    except ValueError as error:
        raise Refusal(str(error)) from error


def _show(found: Track, plot: bool, window: float | None, out: str | None, as_json: bool) -> None:
    from baroarma.cli.live import show_track, terminal
    from baroarma.climbing import climb

    for finding in found.findings:
        say(str(finding))
    if out:
        found.save(out)
        say(f"{found!r} -> {out}")
        say(climb(found).summary())
    console = terminal() if plot else None
    if console:
        show_track(found, console, window)
    if as_json:
        print_json(_document(found))
    elif not out and not (console and sys.stdout.isatty()):
        found.write_csv(sys.stdout)


def _document(found: Track) -> dict[str, Any]:
    from baroarma.climbing import climb

    columns = {str(name): column.tolist() for name, column in found.to_frame().items()}
    findings = [finding.to_dict() for finding in found.findings]
    return {"preset": found.preset, "findings": findings, "climb": climb(found).to_dict(), **columns}


def _say_next(recording: list[str], noise_file: str | None, preset: str) -> None:
    """Without a noise model: identify one; with one: compare with other presets."""
    if noise_file is None:
        say_next("identify", "REST.csv", "--out", "noise.json")
    else:
        others = dict.fromkeys((preset, "baroarma", "sg14-a", "tanigawa08"))
        say_next("compare", *recording, "--noise", noise_file, "--presets", ",".join(others))


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


def _live(tracker: Tracker, plot: bool, window: float | None, out: str | None) -> None:
    """Answer the rows of stdin."""
    from baroarma.cli.live import WINDOW, LivePlot, terminal, track_live

    if tracker.settings.height is None:
        raise click.UsageError(f"the preset {tracker.settings.name} works off-line; with - take another one")
    if out and out.endswith(".parquet"):
        raise click.UsageError(f"with - the rows are written as CSV as they come; give {out} another suffix")
    if tracker.noise is None and tracker.settings.needs_noise:
        say("warning (default-noise): without --noise that of a BMP085 is taken; identify your barometer's")
    if isinstance(sys.stdin, io.TextIOWrapper):
        sys.stdin.reconfigure(errors="replace")  # a byte that is no text spoils its row, not the stream
    console = terminal() if plot else None
    track_live(tracker, sys.stdin, out, LivePlot(console, window or WINDOW) if console else None)
