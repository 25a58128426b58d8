"""`baroarma demo`: the main job from end to end on simulated data."""

from __future__ import annotations

from pathlib import Path

import click

from baroarma.cli.common import json_option, print_json, say, write_text


@click.command(short_help="Show the main job on simulated data.")
@click.option(
    "--out",
    type=click.Path(file_okay=False),
    default="demo",
    show_default=True,
    help="Folder for the results.",
)
@click.option(
    "--seed", type=click.IntRange(min=0), default=1, show_default=True, help="For the same numbers again."
)
@json_option
def demo(out: str, seed: int, as_json: bool) -> None:
    """Simulate a rest log, identify its noise, synthesise the whitening filter, draw the page.

    Ends with OUT/report.html; under a minute.
    """
    from baroarma.export import render
    from baroarma.formats import read, write_csv
    from baroarma.identification import identify
    from baroarma.report import write_identification_report
    from baroarma.simulation import BMP085, simulate_rest

    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    say(f"1. A barometer at rest for 20 minutes: {BMP085.noise!r} -> {folder / 'rest.csv'}")
    write_csv(simulate_rest(1200, seed=seed), folder / "rest.csv")
    say("2. Identify its noise (the first run compiles, some seconds) ...")
    found = identify(read(folder / "rest.csv"))
    assert found.model is not None
    found.model.save(folder / "noise.json")
    say(found.summary())
    whitening = found.model.whitening_filter()
    write_text(folder / "whitening.json", render(whitening, "json"))
    say(f"3. Whitening filter: {whitening!r} -> {folder / 'whitening.json'}")
    page = folder / "report.html"
    write_identification_report([found], page)
    say(f"4. Open {page}")
    if as_json:
        print_json({"noise": found.model.to_dict(), "whitening": whitening.to_dict(), "report": str(page)})
