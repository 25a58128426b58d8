"""The one error of reading: a file that can't be understood, said in one sentence."""

from __future__ import annotations


class UnreadableError(ValueError):
    """Raise when a file can't become a recording: the message names file, row, value and what to do.

    Examples
    --------
    >>> raise UnreadableError("rest.csv, line 7: pressure_pa is 'n/a'; leave it empty")
    Traceback (most recent call last):
    ...
    baroarma.formats.errors.UnreadableError: rest.csv, line 7: pressure_pa is 'n/a'; leave it empty
    """
