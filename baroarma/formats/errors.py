"""The one error of reading: a file that can't be understood, said in one sentence; and what is too much."""

from __future__ import annotations

from typing import Final

FREE: Final = 64_000_000
"""Bytes that a packed file may always grow to."""
LARGEST_RATIO: Final = 200
"""How many times its size it may grow to beyond that: logs grow 3 to 50 times, zeros 1000 times."""


class UnreadableError(ValueError):
    """Raise when a file can't become a recording: the message names file, row, value and what to do.

    Examples
    --------
    >>> raise UnreadableError("rest.csv, line 7: pressure_pa is 'n/a'; leave it empty")
    Traceback (most recent call last):
    ...
    baroarma.formats.errors.UnreadableError: rest.csv, line 7: pressure_pa is 'n/a'; leave it empty
    """


def bomb_limit(size: int) -> int:
    """Return the bytes that a packed file of `size` bytes may grow to; what grows more was made to do harm.

    Examples
    --------
    >>> bomb_limit(1000), bomb_limit(1_000_000)
    (64000000, 200000000)
    """
    return max(FREE, LARGEST_RATIO * size)
