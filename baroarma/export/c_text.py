"""Numbers and names as C source: every digit that counts, and no comment that ends early."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

Value = float | Sequence[float]


@dataclass(frozen=True)
class Number:
    """Hold a constant of the exported source.

    Parameters
    ----------
    name : str
        In capitals, without the prefix ``BAROARMA_``.
    value : float, int, bool or sequence of float
        A whole number becomes a macro, so that it can size an array; all else is a typed constant.
    meaning : str
        What it is, with its unit.
    """

    name: str
    value: Value
    meaning: str

    def __str__(self) -> str:
        name = f"BAROARMA_{self.name}"
        if isinstance(self.value, int):
            return f"#define {name} {int(self.value)} /* {comment(self.meaning)} */"
        size, text = "", real(self.value) if isinstance(self.value, float) else reals(self.value)
        if not isinstance(self.value, float):
            size = f"[{len(self.value)}]"
        return f"static const baroarma_real {name}{size} = {text}; /* {comment(self.meaning)} */"


Numbers = tuple[Number, ...]


def real(value: float) -> str:
    """Return a number with all its digits, as a float or a double.

    Examples
    --------
    >>> real(0.1), real(1.0)
    ('(baroarma_real)0.1', '1')
    """
    value = float(value)
    if not math.isfinite(value):
        return "(baroarma_real)NAN" if math.isnan(value) else f"(baroarma_real){'-' * (value < 0)}INFINITY"
    if value == int(value) and abs(value) < 2**24:
        return str(int(value))
    return f"(baroarma_real){value!r}"


def reals(values: Iterable[float]) -> str:
    """Return numbers as an array's initialiser.

    Examples
    --------
    >>> reals([0.0, 0.5])
    '{0, (baroarma_real)0.5}'
    """
    return f"{{{', '.join(real(value) for value in values)}}}"


def comment(text: str) -> str:
    """Return a text that can stand in a C comment, whoever wrote it: plain characters only, on one line.

    Examples
    --------
    >>> comment("BMP280 */ int main(void)")
    'BMP280 _/ int main(void)'
    """
    return re.sub(r"[^A-Za-z0-9 .,:;()\[\]+^=<>'|&%#_-]", lambda found: _PLAIN.get(found[0], "_"), text)


_PLAIN = {"/": "/", "²": "^2", "³": "^3", "°": "deg", "\n": " "}
"""What may stand for a character that is not plain; a slash is harmless without a star."""
