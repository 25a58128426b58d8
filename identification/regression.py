"""Regression of a rest's height on slow courses, in noise that is learned from what the regression leaves.

Coefficients and noise are fitted in turns until they agree: generalised least squares, in which the noise
model's Kalman filter whitens heights and columns alike, then maximum likelihood of the noise.  For a course
with a time constant the columns are the course and its derivative with respect to that, so that the interval
knows the constant to be uncertain, too.

The drift is known from this log only.  If the sd of log(drift) is s, it is as good as known from nu = 1/(2
s²) independent steps, of which p slow columns take theirs: Student's t with nu - p degrees of freedom, and a
variance larger by nu/(nu - p), allow for that.  (Of 200 simulated logs each, 94 to 96 % of the 95 % intervals
cover the truth; of 40 with the normal quantile, 87 %.)
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.identification.intervals import log_sd
from baroarma.identification.problem import Problem, Terms
from baroarma.identification.structural import StructuralFit, fit_terms
from baroarma.noise_model import Interval

Signal = NDArray[np.float64]
Course = Callable[[float], Signal]
"""What the height follows, at the times of its samples, as a function of the time constant in s."""
NOISES: Final[tuple[Terms, ...]] = (("white", "drift"), ("white", "drift", "gm"))
"""Noises that BIC chooses from; all have the weather's drift, without which slow courses look significant."""
ROUNDS: Final = 12
"""Most rounds of regression and noise; two to five are usual."""
AGREED: Final = 0.01
"""Change of the first coefficient, in its sds, at which the rounds end."""
SHORTEST_LAG: Final = 10.0
"""Shortest time constant that is tried, s: the smoothed temperature shows no shorter one."""
LAGS: Final = 14
"""Time constants tried, from there to a quarter of the log."""


class Regression(NamedTuple):
    """A regression and the noise of what it leaves."""

    coefficients: Signal
    sds: Signal
    noise: StructuralFit
    interval: Interval

    @property
    def slope(self) -> float:
        """The first coefficient, that of the course."""
        return float(self.coefficients[0])

    def significant(self, which: int, n: int) -> float:
        """Return a coefficient that BIC would keep among n samples, else 0."""
        value, sd = float(self.coefficients[which]), float(self.sds[which])
        return value if value**2 > math.log(n) * sd**2 else 0.0


def slow_columns(course: Course, lag: float) -> list[Signal]:
    """Return the slow columns: the course and, if there is a time constant, its derivative."""
    return [course(lag), (course(1.1 * lag) - course(lag / 1.1))] if lag else [course(0.0)]


def regress(
    t: Signal, height: Signal, slow: list[Signal], quick: list[Signal], noise: StructuralFit
) -> Regression:
    """Fit regression and noise in turns, starting from a noise."""
    X = np.stack([*slow, *quick], axis=1)
    before = math.inf
    for _ in range(ROUNDS):
        coefficients, sds = least_squares(t, height, X, noise.theta)
        noise = choose_noise(t, height - X @ coefficients, noise)
        if abs(coefficients[0] - before) < AGREED * sds[0]:
            break
        before = coefficients[0]
    left = Problem(t, height - X @ coefficients)
    middle, half = float(coefficients[0]), _quantile(left, noise, len(slow)) * float(sds[0])
    return Regression(coefficients, sds, noise, (middle - half, middle + half))


def _quantile(left: Problem, noise: StructuralFit, taken: int) -> float:
    """Return how many sds the 95 % interval reaches, the drift being known from this log only."""
    from scipy.special import stdtrit

    known = 0.5 / float(log_sd(left, noise)[1]) ** 2
    free = max(known - taken, 1.0)
    return float(stdtrit(free, 0.975)) * math.sqrt(max(known / free, 1.0))


def least_squares(t: Signal, height: Signal, X: Signal, theta: Signal) -> tuple[Signal, Signal]:
    """Return coefficients and sds by generalised least squares: ordinary ones of what the noise whitens."""
    white = np.stack([Problem(t, column).innovations(theta) for column in (height, *X.T)], axis=1)
    inverse = np.linalg.pinv(white[:, 1:].T @ white[:, 1:])
    return inverse @ (white[:, 1:].T @ white[:, 0]), np.sqrt(np.diag(inverse))


def choose_noise(t: Signal, height: Signal, near: StructuralFit | None = None) -> StructuralFit:
    """Return the noise that BIC chooses; `near`: one that it can't be far from."""
    problem = Problem(t, height)
    fits = [
        fit_terms(problem, terms, near.theta if near and near.terms == terms else None) for terms in NOISES
    ]
    return min(fits, key=lambda fit: fit.bic)


def regress_with_lag(
    t: Signal, height: Signal, course: Course, quick: list[Signal], noise: StructuralFit
) -> tuple[float, Regression]:
    """Find the time constant, the regression and the noise in turns."""
    lag = math.inf
    for _ in range(ROUNDS):
        before, lag = lag, _best_lag(t, height, course, quick, noise)
        if lag == before:
            break
        fit = regress(t, height, slow_columns(course, lag), quick, noise)
        noise = fit.noise
    return lag, fit


def _best_lag(t: Signal, height: Signal, course: Course, quick: list[Signal], noise: StructuralFit) -> float:
    """Return the time constant whose regression leaves least, the noise being given."""
    target = Problem(t, height).innovations(noise.theta)
    others = [Problem(t, column).innovations(noise.theta) for column in quick]

    def left(lag: float) -> float:
        X = np.stack([Problem(t, course(lag)).innovations(noise.theta), *others], axis=1)
        return float(np.sum((target - X @ np.linalg.lstsq(X, target, rcond=None)[0]) ** 2))

    return float(min(np.geomspace(SHORTEST_LAG, (t[-1] - t[0]) / 4, LAGS), key=left))
