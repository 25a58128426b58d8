"""`baroarma compare`: the bake-off."""

from __future__ import annotations

from functools import partial

import click

from baroarma.cli.common import (
    OutputFile,
    Refusal,
    announce_compiling,
    jobs_option,
    json_option,
    noise_option,
    print_json,
    read_recordings,
    recordings_argument,
    same_recordings,
    with_progress,
)
from baroarma.cli.loudness import say, say_next
from baroarma.cli.names import InputFile, Listing, Names, preset_titles
from baroarma.cli.track import load_noise


@click.command(
    cls=Listing,
    lists={"Presets": preset_titles},
    short_help="Compare presets on recordings.",
    epilog="Example:  baroarma compare ride.csv --noise noise.json --report ride.html",
)
@recordings_argument
@noise_option()
@click.option("--presets", type=Names("preset", "A,B,..."), help="Those to compare; default: all below.")
@click.option(
    "--reference-lag",
    type=float,
    default=0.0,
    show_default=True,
    metavar="S",
    help="How late the reference is; its errors are taken against the reference shifted back by so much.",
)
@click.option(
    "--track",
    "track_files",
    multiple=True,
    type=InputFile(),
    metavar="TRACK.csv",
    help="Compare a track that another program made of the recording, too (repeatable).",
)
@click.option("--report", type=OutputFile(), help="Write a page with the table and plots here.")
@jobs_option
@json_option
def compare(
    files: tuple[str, ...],
    mapping: tuple[str, ...],
    start: float | None,
    stop: float | None,
    noise_file: str | None,
    presets: tuple[str, ...] | None,
    reference_lag: float,
    track_files: tuple[str, ...],
    report: str | None,
    jobs: int,
    as_json: bool,
) -> None:
    """Run several presets on each RECORDING and show errors against its reference, if it has one.

    Track and reference are both zeroed over the first second.  Without a reference, closure tells where a
    ride that should end at 0 ends.  A --track, such as the firmware's, is shown beside the presets, with the
    one that it is nearest to.
    """
    from baroarma.comparison import compare as compare_presets
    from baroarma.comparison import read_track
    from baroarma.executors import in_order

    announce_compiling()
    noise = load_noise(noise_file)
    recordings = read_recordings(files, mapping, start, stop)
    if track_files and len(recordings) > 1:
        raise click.UsageError(f"--track belongs to one recording, but there are {len(recordings)}")
    tracks = tuple(read_track(path) for path in track_files)
    work = partial(compare_presets, presets=presets, noise=noise, reference_lag=reference_lag, tracks=tracks)
    found = list(with_progress(in_order(work, recordings, jobs=jobs), len(recordings), "comparing"))
    if as_json:
        documents = [comparison.to_dict() for comparison in found]
        print_json(documents[0] if len(documents) == 1 else {"recordings": documents})
    else:
        click.echo("\n\n".join(comparison.summary() for comparison in found))
    hopeless = [c for c in found if all(row.track is None for row in c.rows)]
    if report and not hopeless:
        from baroarma.comparison_report import write_comparison_report

        write_comparison_report(found, report)
        say(f"page: {report}")
    if hopeless:
        raise Refusal(
            "no preset could track "
            + "; ".join(
                f"{comparison.recording.name}: {comparison.rows[0].refusal}" for comparison in hopeless
            )
        )
    if not as_json:
        _say_next(same_recordings(files, mapping, start, stop), noise_file, report)


def _say_next(recordings: list[str], noise_file: str | None, report: str | None) -> None:
    """Identify the noise; then draw a page; then predict what the chain will do elsewhere."""
    if noise_file is None:
        say_next("identify", "REST.csv", "--out", "noise.json")
    elif report is None:
        say_next("compare", *recordings, "--noise", noise_file, "--report", "compare.html")
    else:
        say_next("predict", "--noise", noise_file)
