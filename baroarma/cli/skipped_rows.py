"""What `baroarma track -` says of the rows that it can't read."""

from __future__ import annotations

from typing import Final

from baroarma.cli.loudness import say
from baroarma.formats.errors import UnreadableError

TOLD: Final = 5
"""Rows that are told one by one; those after them are counted."""


class SkippedRows:
    """Tell of skipped rows: the first few one by one, then how many there were.

    Parameters
    ----------
    is_told_late : bool
        Tell them when the `with` block ends, because a plot has the terminal until then.

    Examples
    --------
    >>> with SkippedRows(is_told_late=False) as skipped:
    ...     skipped(UnreadableError("standard input, line 82: 2 cells, but the header has 8 columns"))
    >>> skipped.summary()
    '1 row skipped that could not be read; look for a loose cable or a wrong baud rate'
    """

    def __init__(self, *, is_told_late: bool) -> None:
        self.count = 0
        self._is_told_late = is_told_late
        self._late: list[str] = []

    def __enter__(self) -> SkippedRows:
        return self

    def __exit__(self, *failure: object) -> None:
        for line in self._late:
            say(line)

    def __call__(self, error: UnreadableError) -> None:
        """Take what is wrong with a row."""
        self.count += 1
        if self.count > TOLD:
            return
        more = "; further ones are only counted" if self.count == TOLD else ""
        line = f"warning (skipped-row): {error}{more}"
        if self._is_told_late:
            self._late.append(line)
        else:
            say(line)

    def summary(self) -> str:
        """Return how many there were, and where to look, as a sentence."""
        rows = "1 row" if self.count == 1 else f"{self.count} rows"
        return f"{rows} skipped that could not be read; look for a loose cable or a wrong baud rate"
