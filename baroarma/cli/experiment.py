"""`baroarma experiment`: the papers' tables beside ours."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import click

from baroarma.cli.common import OutputFile, announce_compiling, json_option, print_json, say, with_progress

if TYPE_CHECKING:
    from baroarma.experiments.experiment import Experiment
    from baroarma.experiments.result import Result
    from baroarma.experiments.trials import Measured


@click.command(short_help="Repeat the papers' experiments.")
@click.argument("name", metavar="NAME|all")
@click.option("--presets", metavar="A,B,...", help="Presets to run beside the papers' own methods.")
@click.option("--trials", type=click.IntRange(1), default=10, show_default=True, help="Trials of each.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="For other noise.")
@click.option(
    "--jobs", "--workers", "workers", type=click.IntRange(1), help="Processes; default: one per core."
)
@click.option("--report", type=OutputFile(), metavar="PAGE.html", help="Write a page with the figures.")
@json_option
def experiment(
    name: str,
    presets: str | None,
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
    if name != "all" and name not in known:
        raise click.UsageError(f"there is no experiment {name!r}; there are {', '.join(known)} and all")
    chosen = list(known.values()) if name == "all" else [known[name]]
    beside = _presets(presets, chosen)
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


def _presets(text: str | None, chosen: list[Experiment]) -> tuple[str, ...]:
    """Return the presets, checked; say when no chosen experiment tracks anything."""
    from baroarma.presets import find_preset

    names = tuple(dict.fromkeys(part.strip() for part in (text or "").split(",") if part.strip()))
    for preset in names:
        find_preset(preset)
    if names and not any(experiment.tracks for experiment in chosen):
        say("note: this experiment identifies noise and tracks nothing, so presets have no part in it")
    return names


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
