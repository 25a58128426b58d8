"""Times in seconds that only rise: from other units by the column's name, past the end of 32-bit counters.

A microcontroller counts microseconds or milliseconds in 32 bits.  After 71.6 minutes, or 49.7 days, the count
starts again at 0 (or at -2^31), and so do the times made of it.  A step back by just that period, whatever
unit it was written in, is the counter's; every other one is left for the reader to refuse.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.finding import Finding
from baroarma.formats.columns import COLUMNS, TIME

Signal = NDArray[np.float64]

PERIODS: Final = (2**32 * 1e-6, 2**32 * 1e-3, 2.0**32)
"""Where a count of us or ms ends, s, and where either does if it was not converted."""
LONGEST_STEP: Final = 100.0
"""Usual intervals that may lie between the last time before the end and the first after it."""


class Seconds:
    """Convert the times of one file, table by table, as if they were one.

    Examples
    --------
    >>> seconds = Seconds()
    >>> seconds.take({"time_s": np.array([4294.95, 4294.96, 0.002704])})["time_s"].round(6).tolist()
    [4294.95, 4294.96, 4294.97]
    >>> print(seconds.notes("log.csv")[0])
    info (clocks): log.csv: the time starts again 1 time, first after 4294.96 s, as a 32-bit counter does; \
it was counted on.
    """

    def __init__(self) -> None:
        self._last, self._added, self._wraps, self._first = math.nan, 0.0, 0, math.nan

    def take(self, values: Mapping[str, Signal]) -> dict[str, Signal]:
        """Return the columns, the time first, in s and past its counter's end."""
        name = next(name for name in values if COLUMNS[name].field == "t")
        to_si = COLUMNS[name].to_si
        t = values[name] if to_si is None else to_si(values[name])
        return {TIME: self._counted_on(t)} | {
            other: value for other, value in values.items() if other != name
        }

    def notes(self, path: str) -> tuple[Finding, ...]:
        """Return what was noticed in all tables."""
        if not self._wraps:
            return ()
        text = (
            f"{Path(path).name}: the time starts again {self._wraps} time{'s' if self._wraps > 1 else ''}, "
            f"first after {self._first:.10g} s, as a 32-bit counter does; it was counted on."
        )
        return (Finding("clocks", "info", text),)

    def _counted_on(self, t: Signal) -> Signal:
        steps = np.diff(t, prepend=self._last)
        back = np.flatnonzero(steps < 0)
        if len(back):
            rising = steps[steps > 0]
            near = LONGEST_STEP * float(np.median(rising)) if len(rising) else 1.0
            period = next(
                (p for p in PERIODS if np.all((steps[back] + p > 0) & (steps[back] + p <= near))), 0.0
            )
            if period:
                return self._with(t, back, period)
        self._last = float(t[-1]) if len(t) else self._last
        return t + self._added if self._added else t

    def _with(self, t: Signal, back: NDArray[np.intp], period: float) -> Signal:
        """Add a period from each step back on."""
        if not self._wraps:
            self._first = float(t[back[0] - 1]) if back[0] else self._last
        self._wraps += len(back)
        added = np.zeros(len(t))
        added[back] = period
        whole: Signal = t + self._added + np.cumsum(added)
        self._last, self._added = float(t[-1]), self._added + len(back) * period
        return whole
