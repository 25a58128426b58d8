"""`baroarma experiment`: the papers' tables beside ours."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import click

from baroarma.cli.common import OutputFile, announce_compiling, json_option, print_json, with_progress
from baroarma.cli.loudness import say, say_next
from baroarma.cli.names import Name, Names

if TYPE_CHECKING:
    from baroarma.experiments.experiment import Experiment
    from baroarma.experiments.result import Result
    from baroarma.experiments.trials import Measured


@click.command(
    short_help="Repeat the papers' experiments.",
    epilog="Example:  baroarma experiment sg14-table-4 --presets baroarma --report table-4.html",
)
@click.argument("name", type=Name("experiment", "NAME|all"))
@click.option(
    "--presets", type=Names("preset", "A,B,..."), help="Presets to run beside the papers' own methods."
)
@click.option(
    "--trials", type=click.IntRange(1), default=10, show_default=True, metavar="N", help="Trials of each."
)
@click.option(
    "--seed", type=click.IntRange(0), default=0, show_default=True, metavar="N", help="For other noise."
)
@click.option(
    "--jobs",
    "--workers",
    "workers",
    type=click.IntRange(1),
    metavar="N",
    help="Processes; default: one per core.",
)
@click.option("--report", type=OutputFile(), metavar="PAGE.html", help="Write a page with the figures.")
@json_option
def experiment(
    name: str,
    presets: tuple[str, ...] | None,
    trials: int,
    seed: int,
    workers: int | None,
    report: str | None,
    as_json: bool,
) -> None:
    """Repeat an experiment of the papers on simulated sensors, and show published and reproduced numbers.

    NAME is sg13-table-1 to sg13-table-6, sg13-figure-5, sg14-table-2 to sg14-table-4, sg14-squat,
    lee16-table-2, or all.
    """
    from baroarma.experiments import experiments, run_experiments, tally

    announce_compiling()
    known = experiments()
    chosen = list(known.values()) if name == "all" else [known[name]]
    beside = presets or ()
    if beside and not any(experiment.tracks for experiment in chosen):
        say("note: this experiment identifies noise and tracks nothing, so presets have no part in it")
    results = run_experiments(
        chosen,
        trials=trials,
        seed=seed,
        presets=beside,
        workers=workers,
        progress=_with_progress,
    )
    if report:
        _write(report, results, chosen, seed, beside)
    if as_json:
        documents = [result.to_dict() for result in results]
        print_json(documents if name == "all" else documents[0])
        return
    click.echo("\n\n".join(result.summary() for result in results))
    if len(results) > 1:
        click.echo(f"\nall: {tally(results)}")
    if report is None:
        with_presets = ["--presets", ",".join(beside)] if beside else []
        say_next("experiment", name, *with_presets, "--report", f"{name}.html")
    elif not beside and any(experiment.tracks for experiment in chosen):
        say_next("experiment", name, "--presets", "baroarma", "--report", report)
    else:
        say_next("simulate", "squat", "--out", "squat.csv")


def _write(
    report: str, results: list[Result], chosen: list[Experiment], seed: int, presets: tuple[str, ...]
) -> None:
    from baroarma.experiments.report import write_report
    from baroarma.experiments.trials import Trial

    scenes = {e.name: e.draw(Trial(seed, 0, presets)) for e in chosen if e.draw is not None}
    write_report(results, scenes, report)
    say(f"report -> {report}")


def _with_progress(found: Iterable[Measured], total: int) -> Iterable[Measured]:
    return with_progress(found, total, "trials")
