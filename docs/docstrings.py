"""Docstrings as they stand in the source, made ready for Sphinx.

There an equation is an indented line after an empty one, ``|a|`` is a modulus, and a suffix stands in single
backticks.  reStructuredText would take them for a quotation, a substitution and a name without its dot; here
they become a literal block, bars and code.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from sphinx.application import Sphinx

UNDERLINE = re.compile(r"-{3,}$")
LIST = re.compile(r"(\* |- |\d+\. |\.\. )")
CODE = re.compile(r"(`+[^`]*`+)")
SUFFIX = re.compile(r"^`(\.[^`]*)`$")


def make_ready(app: Sphinx, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Change the lines of a docstring in place, before napoleon reads its sections."""
    lines[:] = _made_ready(lines)
    if what in ("attribute", "data", "property"):
        lines[:0] = ["..", ""]  # a comment, or napoleon takes what stands before a colon for a type


def _made_ready(lines: list[str]) -> Iterator[str]:
    prose, verbatim, paragraph = True, False, ""
    for previous, line, following in zip(["", *lines], lines, [*lines[1:], ""], strict=False):
        prose = prose and not UNDERLINE.match(following)  # until the first section
        if not previous.strip() and line.strip():
            equation = prose and line.startswith("    ") and not LIST.match(paragraph)
            if equation and not paragraph.endswith("::"):
                yield from ("::", "")
            verbatim = equation or line.lstrip().startswith(">>>")
        if line.strip() and not line.startswith(" "):
            paragraph = line
        yield line if verbatim else _inline(line)


def _inline(line: str) -> str:
    text_and_code = CODE.split(line)
    text_and_code[::2] = [text.replace("|", r"\|") for text in text_and_code[::2]]
    text_and_code[1::2] = [SUFFIX.sub(r"``\1``", code) for code in text_and_code[1::2]]
    return "".join(text_and_code)


def is_alias(app: Sphinx, what: str, name: str, value: Any, skip: bool, options: Any) -> bool | None:
    """Leave out a named tuple's fields that say nothing but "Alias for field number"."""
    return True if (getattr(value, "__doc__", None) or "").startswith("Alias for field") else None


def setup(app: Sphinx) -> dict[str, bool]:
    """Tell Sphinx; napoleon reads what this has written."""
    app.connect("autodoc-process-docstring", make_ready, priority=400)
    app.connect("autodoc-skip-member", is_alias)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
