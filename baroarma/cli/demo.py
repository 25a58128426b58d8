"""`baroarma demo`: the main job from end to end on simulated data."""

from __future__ import annotations

from pathlib import Path

import click

from baroarma.cli.common import json_option, print_json, write_text
from baroarma.cli.loudness import say, say_next


@click.command(short_help="Show the main job on simulated data.", epilog="Example:  baroarma demo --out demo")
@click.option(
    "--out",
    type=click.Path(file_okay=False),
    metavar="DIR",
    default="demo",
    show_default=True,
    help="Folder for the results.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=1,
    show_default=True,
    metavar="N",
    help="For the same numbers again.",
)
@json_option
def demo(out: str, seed: int, as_json: bool) -> None:
    """Do the main job on simulated data: identify, whiten, track, compare, and draw the page.

    Ends with OUT/report.html; under a minute.
    """
    from baroarma.comparison import compare
    from baroarma.comparison_report import comparison_section
    from baroarma.export import render
    from baroarma.formats import read, write_csv
    from baroarma.identification import identify
    from baroarma.page import Page, write_page
    from baroarma.report import identification_section
    from baroarma.simulation import BMP085, simulate, simulate_rest

    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    say(f"1. A barometer at rest for 20 minutes: {BMP085.noise!r} -> {folder / 'rest.csv'}")
    write_csv(simulate_rest(1200, seed=seed), folder / "rest.csv")
    say("2. Its noise, identified (the first run compiles, some seconds) ...")
    found = identify(read(folder / "rest.csv"))
    assert found.model is not None
    found.model.save(folder / "noise.json")
    say(found.summary())
    whitening = found.model.whitening_filter()
    write_text(folder / "whitening.json", render(whitening, "json"))
    say(f"3. The whitening filter: {whitening!r} -> {folder / 'whitening.json'}")
    write_csv(simulate("squat", duration=60, seed=seed), folder / "squat.csv")
    say(f"4. A minute of squats -> {folder / 'squat.csv'}, tracked with that noise ...")
    bake_off = compare(read(folder / "squat.csv"), noise=found.model, presets=PRESETS)
    track = bake_off.rows[0].track
    assert track is not None
    track.save(folder / "track.csv")
    say(bake_off.summary())
    page = folder / "report.html"
    sections = (
        identification_section(found, "The barometer at rest", "rest"),
        comparison_section(bake_off, "squat"),
    )
    write_page(page, Page("baroarma on simulated data", sections))
    say(f"5. Open {page}")
    if as_json:
        documents = {"noise": found.model.to_dict(), "whitening": whitening.to_dict()}
        print_json({**documents, "comparison": bake_off.to_dict(), "report": str(page)})
    else:
        say_next("identify", "REST.csv", "--out", "noise.json", "--report", "page.html")


PRESETS = ("baroarma", "sg14-a", "sg14-b", "lee16", "tanigawa08")
"""What the demo compares: one of each kind that is fast enough."""
