"""Results in notebooks: tables that take the notebook's own colours, whether it is light or dark.

The cells come from files and are escaped by the templates of `page`.  A notebook that strips styles shows the
same tables without lines.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from baroarma.finding import Finding
from baroarma.page import Table, render

STYLE: Final = """<style>
.baroarma table { border-collapse: collapse; margin: .2em 0 .9em 0; background: transparent; color: inherit; }
.baroarma caption { caption-side: top; text-align: left; padding: .2em 0; color: inherit; font-weight: 600; }
.baroarma th, .baroarma td { text-align: left; vertical-align: top; padding: .2em 1.1em .2em 0;
  border: 0; border-bottom: 1px solid rgba(128, 128, 128, .4); font-variant-numeric: tabular-nums; }
.baroarma thead th { border-bottom-width: 2px; font-weight: 600; }
.baroarma tbody th { font-weight: 500; }
.baroarma th.short, .baroarma td.short { white-space: nowrap; }
.baroarma tbody tr { background: transparent; }
.baroarma .verdict { border-left: .35em solid #009E73; padding: .1em .8em; margin: .3em 0 .8em; }
.baroarma .verdict.info { border-left-color: #0072B2; }
.baroarma .verdict.warning { border-left-color: #E69F00; }
.baroarma .verdict.error { border-left-color: #D55E00; }
</style>
"""
"""It names no colour but those of lines, which stand out on white as on black."""


def tables(*shown: Table) -> str:
    """Return tables as HTML for notebooks.

    Examples
    --------
    >>> ">0.46 m</td>" in tables(Table(("parameter", "value"), (("white sd", "0.46 m"),)))
    True
    """
    return styled(render("notebook.html", box=None, tables=shown))


def styled(html: str) -> str:
    """Return a piece of HTML, made by the templates of `page`, as a notebook should show it."""
    return f'<div class="baroarma">\n{STYLE}{html}</div>'


def about(findings: Iterable[Finding]) -> tuple[Table, ...]:
    """Return what was noticed as a table, or none if that is nothing."""
    rows = tuple((f"{one.severity} ({one.code})", one.message) for one in findings)
    return (Table(("finding", "what it means"), rows),) if rows else ()


def remarks(notes: Iterable[str]) -> tuple[Table, ...]:
    """Return sentences as a table, or none if there is none."""
    rows = tuple((str(i), note) for i, note in enumerate(notes, 1))
    return (Table(("", "what to know"), rows),) if rows else ()


def number(value: float | None, digits: int = 4) -> str:
    """Return a number with so many significant digits; a dash for None and NaN.

    Examples
    --------
    >>> number(0.123456), number(None), number(12345.678)
    ('0.1235', '–', '1.235e+04')
    """
    return "–" if value is None or value != value else f"{value:.{digits}g}"
