"""A finding: one thing that was noticed about a recording or a result, in a code and a sentence.

Reading a file, judging a rest recording and tracking all notice things the user should know.  They say
them in the same way, so that a table, a page and a program can show or test them alike.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Literal

Severity = Literal["info", "warning", "error"]


@dataclass(frozen=True)
class Finding:
    """Say what was noticed.

    Parameters
    ----------
    code : str
        A short name for programs, such as ``"held-samples"``.
    severity : {"info", "warning", "error"}
        ``info``: good to know; ``warning``: the numbers may be worse than they look; ``error``: the data do
        not support the request.
    message : str
        One sentence for people: what, where, and what to do.

    Examples
    --------
    >>> print(Finding("gaps", "warning", "3 gaps, the longest 2.6 s."))
    warning (gaps): 3 gaps, the longest 2.6 s.
    """

    code: str
    severity: Severity
    message: str

    def __str__(self) -> str:
        return f"{self.severity} ({self.code}): {self.message}"

    def to_dict(self) -> dict[str, str]:
        """Return the three fields as a dictionary, as they stand in JSON."""
        return asdict(self)
