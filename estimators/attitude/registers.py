"""Vectors of three and four numbers and symmetric matrices, as tuples that the compiler keeps in registers.

Of a symmetric matrix the upper triangle, row after row: six numbers for 3 x 3, ten for 4 x 4.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import inlined

Vector = tuple[float, ...] | NDArray[np.float64]


@inlined
def dot3(v: Vector, w: Vector) -> float:
    """Return v . w."""
    return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]


@inlined
def plus3(v: Vector, a: float, w: Vector) -> Vector:
    """Return v + a w."""
    return v[0] + a * w[0], v[1] + a * w[1], v[2] + a * w[2]


@inlined
def scaled3(a: float, v: Vector) -> Vector:
    """Return a v."""
    return a * v[0], a * v[1], a * v[2]


@inlined
def times3(P: Vector, v: Vector) -> Vector:
    """Return P v for a symmetric P, 3 x 3."""
    return (
        P[0] * v[0] + P[1] * v[1] + P[2] * v[2],
        P[1] * v[0] + P[3] * v[1] + P[4] * v[2],
        P[2] * v[0] + P[4] * v[1] + P[5] * v[2],
    )


@inlined
def plus_outer3(P: Vector, a: float, v: Vector) -> Vector:
    """Return P + a v v' for a symmetric P, 3 x 3."""
    a0, a1, a2 = a * v[0], a * v[1], a * v[2]
    return (
        P[0] + a0 * v[0],
        P[1] + a0 * v[1],
        P[2] + a0 * v[2],
        P[3] + a1 * v[1],
        P[4] + a1 * v[2],
        P[5] + a2 * v[2],
    )


@inlined
def dot4(v: Vector, w: Vector) -> float:
    """Return v . w."""
    return (v[0] * w[0] + v[1] * w[1]) + (v[2] * w[2] + v[3] * w[3])


@inlined
def plus4(v: Vector, a: float, w: Vector) -> Vector:
    """Return v + a w."""
    return v[0] + a * w[0], v[1] + a * w[1], v[2] + a * w[2], v[3] + a * w[3]


@inlined
def scaled4(a: float, v: Vector) -> Vector:
    """Return a v."""
    return a * v[0], a * v[1], a * v[2], a * v[3]


@inlined
def times4(P: Vector, v: Vector) -> Vector:
    """Return P v for a symmetric P, 4 x 4."""
    return (
        P[0] * v[0] + P[1] * v[1] + P[2] * v[2] + P[3] * v[3],
        P[1] * v[0] + P[4] * v[1] + P[5] * v[2] + P[6] * v[3],
        P[2] * v[0] + P[5] * v[1] + P[7] * v[2] + P[8] * v[3],
        P[3] * v[0] + P[6] * v[1] + P[8] * v[2] + P[9] * v[3],
    )


@inlined
def plus_outer4(P: Vector, a: float, v: Vector) -> Vector:
    """Return P + a v v' for a symmetric P, 4 x 4."""
    a0, a1, a2, a3 = a * v[0], a * v[1], a * v[2], a * v[3]
    return (
        P[0] + a0 * v[0],
        P[1] + a0 * v[1],
        P[2] + a0 * v[2],
        P[3] + a0 * v[3],
        P[4] + a1 * v[1],
        P[5] + a1 * v[2],
        P[6] + a1 * v[3],
        P[7] + a2 * v[2],
        P[8] + a2 * v[3],
        P[9] + a3 * v[3],
    )


@inlined
def sine(u: float) -> float:
    """Return sin(a)/a of u = a²: by its series for a < 1/2, which leaves out a^14/15!, less than 5e-17."""
    if u < 1 / 4:
        return 1 - u / 6 * (1 - u / 20 * (1 - u / 42 * (1 - u / 72 * (1 - u / 110 * (1 - u / 156)))))
    return math.sin(math.sqrt(u)) / math.sqrt(u)


@inlined
def versine(u: float) -> float:
    """Return (1 - cos(a))/a² of u = a², without loss of digits; as `sine`."""
    if u < 1 / 4:
        return (1 - u / 12 * (1 - u / 30 * (1 - u / 56 * (1 - u / 90 * (1 - u / 132 * (1 - u / 182)))))) / 2
    return 2 * (math.sin(math.sqrt(u) / 2) / math.sqrt(u)) ** 2
