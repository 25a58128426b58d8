"""How acceleration samples drive a height filter: held, at the start or the middle of a step, and quiet.

Between t_{k-1} and t_k the papers integrate the *previous* sample (Euler: SG14 Eq. 24, Lee16 Eq. 11), which
lags by half an interval; the midpoint (a_{k-1} + a_k)/2 doesn't.  A missing sample repeats the last one.

A sample that is wild between two that agree is taken out again as soon as the second of them comes: what it
did to the velocity lasts for a row.  (A knock may be as short, and then is lost.)

Lee16's zero-velocity rule: at rest when |a| < 0.1 m/s² on the closed interval of n = 12 steps, that is for
n + 1 samples in a row [Lee16, Eq. 14].
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import njit

Signal = NDArray[np.float64]
WILD: Final = 50.0
"""A sample that differs by so much from the one before, m/s², and the next one doesn't: a broken transfer, or
a knock shorter than the interval (chosen by us: 5 g)."""
BACK: Final = 0.2
"""Share of the jump within which the next one is back (chosen by us)."""


class Drive:
    """Turn acceleration samples into what the filter integrates, and tell when they are quiet.

    Parameters
    ----------
    midpoint : bool
        Integrate (a_{k-1} + a_k)/2 instead of a_{k-1}.
    zupt_steps : int
        Steps n of Lee16's rule; 0: never at rest.  More steps: later, but fewer false rests.
    zupt_threshold : float
        Largest |a| at rest, m/s².
    """

    def __init__(self, *, midpoint: bool = False, zupt_steps: int = 0, zupt_threshold: float = 0.1) -> None:
        self.midpoint, self.zupt_steps, self.zupt_threshold = midpoint, zupt_steps, zupt_threshold
        self.reset()

    @property
    def _steps(self) -> int:
        return self.zupt_steps or -1

    def reset(self) -> None:
        """Forget all samples."""
        self.before, self.last, self.quiet = 0.0, 0.0, 0

    def step(self, acceleration: float) -> tuple[float, float, bool]:
        """Take a sample (m/s² or NaN); return what drives the step that ends here, and the rest of `rows`."""
        memory = self.before, self.last, self.quiet
        rule = self.midpoint, self._steps, self.zupt_threshold
        u, change, at_rest, self.before, self.last, self.quiet = _next(float(acceleration), *memory, *rule)
        return u, change, at_rest

    def rows(self, acceleration: Signal) -> tuple[Signal, Signal, NDArray[np.bool_]]:
        """Take samples (n,); return what drives each step, how much it changed meanwhile, whether at rest."""
        n = len(acceleration)
        inputs, change, at_rest = np.empty(n), np.empty(n), np.zeros(n, np.bool_)
        self.before, self.last, self.quiet = _drive(
            acceleration,
            self.before,
            self.last,
            self.quiet,
            self.midpoint,
            self._steps,
            self.zupt_threshold,
            inputs,
            change,
            at_rest,
        )
        return inputs, change, at_rest


def as_signal(values: Signal | None, n: int) -> Signal:
    """Return the values as floats, (n,); None: all NaN."""
    return np.full(n, np.nan) if values is None else np.asarray(values, float)


def nominal_interval(dt: float | None) -> float:
    """Return the interval in s that a filter's matrices are set up for, or say what is wrong with it."""
    if dt is None:
        raise ValueError("the nominal interval is missing: give dt= in s, or noise=, whose rate then says it")
    if not (math.isfinite(dt) and dt > 0):
        raise ValueError(f"the nominal interval must be a positive number of seconds, but it is {dt}")
    return float(dt)


@njit(cache=True)
def _next(
    a: float, before: float, last: float, quiet: int, midpoint: bool, steps: int, threshold: float
) -> tuple[float, float, bool, float, float, int]:
    """Take one sample; return what `Drive.step` does, the last two samples, and for how many it is quiet."""
    now = last if math.isnan(a) else a
    quiet = quiet + 1 if abs(now) < threshold else 0
    change, jump = abs(now - last), abs(last - before)
    if jump > WILD and abs(now - before) < BACK * jump:  # the midpoint has had half of it
        last = 2 * before - last if midpoint else before
    else:
        before = last
    u = (last + now) / 2 if midpoint else last
    return u, change, steps >= 0 and quiet > steps, before, now, quiet


@njit(cache=True)
def _drive(
    a: Signal,
    before: float,
    last: float,
    quiet: int,
    midpoint: bool,
    steps: int,
    threshold: float,
    inputs: Signal,
    change: Signal,
    at_rest: NDArray[np.bool_],
) -> tuple[float, float, int]:
    for k in range(len(a)):
        inputs[k], change[k], at_rest[k], before, last, quiet = _next(
            a[k], before, last, quiet, midpoint, steps, threshold
        )
    return before, last, quiet
