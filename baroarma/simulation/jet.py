"""Functions of time that know their first two derivatives.

A motion is written once, as height and angles over time; velocity, acceleration and angular rates follow by
the sum, product and chain rules, exactly and at every instant:

    (f g)'' = f'' g + 2 f' g' + f g'',    (sin f)'' = f'' cos f - f'^2 sin f.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Signal = NDArray[np.float64]
Constant = float | Signal
"""A number, or one for each instant that does not change near it."""


@dataclass(frozen=True, eq=False)
class Jet:
    """Hold a function of time with its first and second derivative.

    Parameters
    ----------
    value, first, second : ndarray, shape (n,)
        The function and its derivatives, in its unit, per s and per s².

    Examples
    --------
    >>> t = clock(np.array([0.0, 2.0]))
    >>> (3.0 * t * t).second
    array([6., 6.])
    """

    value: Signal
    first: Signal
    second: Signal

    __array_ufunc__ = None  # NumPy's scalars and arrays leave the arithmetic to this class

    def __add__(self, other: Jet | Constant) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value + other, self.first, self.second)
        return Jet(self.value + other.value, self.first + other.first, self.second + other.second)

    def __mul__(self, other: Jet | Constant) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value * other, self.first * other, self.second * other)
        return Jet(
            self.value * other.value,
            self.first * other.value + self.value * other.first,
            self.second * other.value + 2 * self.first * other.first + self.value * other.second,
        )

    def __neg__(self) -> Jet:
        return self * -1.0

    def __sub__(self, other: Jet | Constant) -> Jet:
        return self + -other

    def __rsub__(self, other: Constant) -> Jet:
        return -self + other

    __radd__ = __add__
    __rmul__ = __mul__


def clock(t: Any) -> Jet:
    """Return time itself, t (n,) in s, as a function of time."""
    t = np.asarray(t, float)
    return Jet(t, np.ones_like(t), np.zeros_like(t))


def sin(f: Jet) -> Jet:
    """Return the sine of an angle in rad."""
    s, c = np.sin(f.value), np.cos(f.value)
    return Jet(s, f.first * c, f.second * c - f.first**2 * s)


def cos(f: Jet) -> Jet:
    """Return the cosine of an angle in rad."""
    s, c = np.sin(f.value), np.cos(f.value)
    return Jet(c, -f.first * s, -f.second * s - f.first**2 * c)
