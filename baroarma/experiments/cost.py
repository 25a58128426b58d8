"""What a step costs: the additions, multiplications and divisions of the two height filters, counted.

Lee16 says that its complementary filter takes 12.5 % of the Kalman filter's computation, without saying what
was counted.  Time depends on machine, language and hour; operations don't: here both steps run on numbers
that count what is done to them, matrices dense as the papers write them.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np


class Counting:
    """A number that counts the operations done to it; all of them share one counter."""

    def __init__(self, counter: Counter[str], value: float = 1.0) -> None:
        self.counter, self.value = counter, value

    def _count(self, name: str, value: float) -> Counting:
        self.counter[name] += 1
        return Counting(self.counter, value)

    def __add__(self, other: Counting) -> Counting:
        return self._count("add", self.value + other.value)

    def __sub__(self, other: Counting) -> Counting:
        return self._count("add", self.value - other.value)

    def __mul__(self, other: Counting) -> Counting:
        return self._count("multiply", self.value * other.value)

    def __truediv__(self, other: Counting) -> Counting:
        return self._count("divide", self.value / other.value)


def complementary_cost() -> int:
    """Return the operations of a step of Lee16's Eqs. 11 and 12, K dt and the matrices being constant."""
    c: Counter[str] = Counter()
    F, B, K, b, x = (_array(c, shape) for shape in ((2, 2), (2, 2), (2,), (2,), (2,)))
    z, dt, a = (Counting(c) for _ in range(3))
    error = z - x[0]
    F @ x + B @ (K * error) + b * (dt * a)
    return c.total()


def kalman_cost() -> int:
    """Return the operations of a step of the two-state Kalman filter with one measurement."""
    c: Counter[str] = Counter()
    F, P, Q, eye, x, b, h = (_array(c, shape) for shape in ((2, 2),) * 4 + ((2,),) * 3)
    z, a, r = (Counting(c) for _ in range(3))
    x = F @ x + b * a
    P = F @ P @ F.T + Q
    K = (P @ h) / (h @ P @ h + r)
    x = x + K * (z - h @ x)
    P = (eye - np.outer(K, h)) @ P
    return c.total()


def cost_ratio() -> float:
    """Return the complementary filter's operations in percent of the Kalman filter's.

    Examples
    --------
    >>> 20 < cost_ratio() < 40
    True
    """
    return 100 * complementary_cost() / kalman_cost()


def _array(counter: Counter[str], shape: tuple[int, ...]) -> Any:
    array = np.empty(shape, object)
    for index in np.ndindex(shape):
        array[index] = Counting(counter)
    return array
