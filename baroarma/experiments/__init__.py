"""The experiments of SG13, SG14 and Lee16, with the published numbers beside ours.

Simulated sensors stand in for hardware that we don't have; what is assumed is printed with each table, one
sensor preset serves a whole paper, and nothing is tuned per number.  `verdict` states how a number is judged.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from baroarma.experiments.experiment import Experiment, run_experiments
from baroarma.experiments.result import Result, Row, tally

__all__ = ["NAMES", "Experiment", "Result", "Row", "experiments", "run_experiments", "tally"]

NAMES = (
    *(f"sg13-table-{i}" for i in range(1, 5)),
    "sg13-figure-5",
    "sg13-table-5",
    "sg13-table-6",
    *(f"sg14-table-{i}" for i in (2, 3, 4)),
    "sg14-squat",
    "lee16-table-2",
)
"""What users type, in the order of the papers."""


@lru_cache(maxsize=1)
def experiments() -> Mapping[str, Experiment]:
    """Return all experiments by name.

    Examples
    --------
    >>> tuple(experiments()) == NAMES
    True
    """
    from baroarma.experiments import lee16, sg13, sg13_motion, sg14

    found = (
        *sg13.experiments(), *sg13_motion.experiments(), *sg14.experiments(), *lee16.experiments(),
    )  # fmt: skip
    return {experiment.name: experiment for experiment in found}
