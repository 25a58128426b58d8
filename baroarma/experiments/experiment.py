"""An experiment: what one trial measures, what is tested over all trials, what is assumed, what is drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import islice

from baroarma.experiments.literature import Published, published_in
from baroarma.experiments.result import Result, Row
from baroarma.experiments.scene import Scene
from baroarma.experiments.trials import (
    Average,
    Key,
    Measured,
    Measurement,
    Trial,
    average,
    median,
    run_trials,
)
from baroarma.experiments.verdict import judge


def no_tests(found: Sequence[Measured]) -> Mapping[Key, float]:
    """Test nothing: what an `Experiment` without tests of its own does.

    Parameters
    ----------
    found : sequence of dict of (str, str) to Measurement
        What the trials measured, of which nothing is taken.
    """
    return {}


@dataclass(frozen=True)
class Experiment:
    """Describe one table or figure of a paper.

    Parameters
    ----------
    name, title : str
        What users type, and a line about it.
    assumptions : tuple of str
        What stands in for hardware that we don't have, and how the paper was read.
    measure : callable
        Trial -> what it measured, by label and quantity.  A function of a module, so that it can be sent to
        another process.
    test : callable
        What all trials measured -> p-values by label and quantity.
    draw : callable
        Trial -> the paper's figures for it.
    tracks : bool
        Whether trackers run in it, so that `presets` can join.

    Examples
    --------
    A new table is a function of the trial, and what it shall be called:

    >>> def toss(trial):
    ...     return {("coin", "heads (1)"): Measurement(trial.rng("coin").integers(0, 2, 1000).mean())}
    >>> tosses = Experiment("tosses", "Tossing a coin", ("the coin is fair",), toss, tracks=False)
    >>> row = tosses.result([toss(Trial(0, number)) for number in range(10)]).rows[0]
    >>> abs(row.reproduced - 0.5) < 0.02, row.trials  # four sds of the mean, sqrt(0.25/1000/10)
    (True, 10)
    """

    name: str
    title: str
    assumptions: tuple[str, ...]
    measure: Callable[[Trial], Measured]
    test: Callable[[Sequence[Measured]], Mapping[Key, float]] = no_tests
    draw: Callable[[Trial], tuple[Scene, ...]] | None = None
    tracks: bool = True

    def result(self, found: Sequence[Measured]) -> Result:
        """Put what the trials measured beside the published numbers.

        Parameters
        ----------
        found : sequence of dict of (str, str) to Measurement
            Of each trial, by label and quantity.

        Raises
        ------
        KeyError
            If a published number was not measured.
        """
        averages = {key: _typical(key)([m[key] for m in found if key in m]) for key in _keys(found)}
        averages |= {key: Average(_number(p), None, len(found)) for key, p in self.test(found).items()}
        numbers = published_in(self.name)
        if missing := set(numbers) - set(averages):
            raise KeyError(f"{self.name} does not reproduce {sorted(missing)}")
        rows = [_row(key, averages[key], number) for key, number in numbers.items()]
        rows += [_row(key, ours, None) for key, ours in averages.items() if key not in numbers]
        return Result(self.name, self.title, self.assumptions, tuple(rows), _notes(numbers.values()))


def run_experiments(
    experiments: Sequence[Experiment],
    *,
    trials: int = 10,
    seed: int = 0,
    presets: Sequence[str] = (),
    workers: int | None = 1,
    executor: Executor | None = None,
    progress: Callable[[Iterable[Measured], int], Iterable[Measured]] = lambda found, total: found,
) -> list[Result]:
    """Run experiments, all their trials in one pool.

    Parameters
    ----------
    experiments : sequence of Experiment
        What to run.
    trials : int
        Trials of each; the papers' N = 10.  More sharpen our means, not the published ones.
    seed : int
        The same seed gives the same numbers, whatever the other arguments.
    presets : sequence of str
        Presets to run beside the paper's own methods, where something is tracked.
    workers : int, optional
        Processes; None: one per core.
    executor : concurrent.futures.Executor, optional
        Does the work instead, such as a Dask cluster's.
    progress : callable
        Wraps the iterator over all trials; told their number.

    Returns
    -------
    list of Result
        One per experiment.

    Examples
    --------
    The same seed gives the same numbers:

    >>> def toss(trial):
    ...     return {("coin", "heads (1)"): Measurement(trial.rng("coin").integers(0, 2, 1000).mean())}
    >>> tosses = Experiment("tosses", "Tossing a coin", ("the coin is fair",), toss, tracks=False)
    >>> run_experiments([tosses], trials=3)[0].rows == run_experiments([tosses], trials=3)[0].rows
    True
    >>> run_experiments([tosses], trials=3)[0].rows == run_experiments([tosses], trials=3, seed=1)[0].rows
    False
    """
    numbers = [Trial(seed, number, tuple(presets)) for number in range(trials)]
    tasks = [(experiment.measure, trial) for experiment in experiments for trial in numbers]
    found: Iterator[Measured] = iter(progress(run_trials(tasks, workers, executor), len(tasks)))
    return [experiment.result(list(islice(found, trials))) for experiment in experiments]


def _keys(found: Sequence[Measured]) -> dict[Key, None]:
    return dict.fromkeys(key for measured in found for key in measured)


def _notes(numbers: Iterable[Published]) -> tuple[str, ...]:
    """Return what is odd about the numbers, each oddity once, with the first row that has it."""
    first: dict[str, Published] = {}
    for number in numbers:
        if number.note:
            first.setdefault(number.note, number)
    return tuple(f"{n.table}, {n.label}, {n.quantity}: {note}" for note, n in first.items())


def _typical(key: Key) -> Callable[[Sequence[Measurement]], Average]:
    return median if key[1].endswith("(p)") else average


def _row(key: Key, ours: Average, number: Published | None) -> Row:
    verdict = judge(number, ours.mean, ours.sd, ours.trials) if number else ""
    value, sd = (number.value, number.sd) if number else (None, None)
    return Row(*key, value, sd, ours.mean, ours.sd, ours.trials, verdict)


def _number(p: float) -> float | None:
    return None if p != p else p
