"""Trials: the same experiment over and over with new noise, in parallel, reproducible.

Everything random in a trial comes from `Trial.rng`, whose seed is made of the user's seed, the trial's number
and words that name the recording.  So results depend neither on the number of workers nor on which other
experiments run, and two tables about one recording see the same one.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from baroarma.executors import in_order

Key = tuple[str, str]
"""Label and quantity."""


@dataclass(frozen=True)
class Trial:
    """Name one trial.

    Parameters
    ----------
    seed : int
        The user's seed, 0 or more.
    number : int
        0, 1, ...
    presets : tuple of str
        Presets to run beside the paper's own methods.
    """

    seed: int
    number: int
    presets: tuple[str, ...] = ()

    def rng(self, *names: str) -> np.random.Generator:
        """Return the random numbers of the recording that the words name.

        Examples
        --------
        >>> Trial(0, 1).rng("rest").random() == Trial(0, 1, ("sg14-a",)).rng("rest").random()
        True
        """
        return np.random.default_rng((self.seed, self.number, zlib.crc32("/".join(names).encode())))


class Measurement(NamedTuple):
    """What one trial measured: the value and, where the paper's SD is one within a trial, that SD."""

    value: float
    spread: float | None = None


Measured = Mapping[Key, Measurement]
"""What a trial measured, by label and quantity."""


class Average(NamedTuple):
    """Mean over trials; SD over trials, or mean SD within them; number of trials that had a value."""

    mean: float | None
    sd: float | None
    trials: int


def median(found: Sequence[Measurement]) -> Average:
    """Return the p-value of a typical trial: the median, for a mean of p-values means nothing.

    Examples
    --------
    >>> median([Measurement(0.001), Measurement(0.002), Measurement(0.9)]).mean
    0.002
    """
    values = [m.value for m in found if math.isfinite(m.value)]
    return Average(float(np.median(values)) if values else None, None, len(values))


def average(found: Sequence[Measurement]) -> Average:
    """Average one quantity over trials; trials without a number are left out.

    Examples
    --------
    >>> average([Measurement(1.0), Measurement(3.0), Measurement(float("nan"))])
    Average(mean=2.0, sd=1.4142135623730951, trials=2)
    """
    good = [m for m in found if math.isfinite(m.value)]
    values = np.array([m.value for m in good])
    spreads = [m.spread for m in good if m.spread is not None]
    if not good:
        return Average(None, None, 0)
    if spreads:
        return Average(float(values.mean()), float(np.mean(spreads)), len(good))
    return Average(float(values.mean()), float(values.std(ddof=1)) if len(good) > 1 else None, len(good))


Task = tuple[Callable[[Trial], Measured], Trial]


def run_trials(
    tasks: Sequence[Task], workers: int | None = None, executor: Executor | None = None
) -> Iterator[Measured]:
    """Run trials and yield what they measured, in the order of the tasks.

    Parameters
    ----------
    tasks : sequence of (callable, Trial)
        Functions of a module, so that other processes find them.
    workers, executor
        Who does the work: `jobs` and `executor` of `baroarma.executors.in_order`.
    """
    return in_order(_run, tasks, jobs=workers, executor=executor)


def _run(task: Task) -> Measured:
    measure, trial = task
    return measure(trial)
