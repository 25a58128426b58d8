"""A page is data: sections of verdicts, tables, text, code and figures, drawn by one template.

`write_page` makes a single HTML file of it that refers to nothing outside itself.  All text is escaped by the
template: names and cells come from files, and files come from anywhere.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from baroarma.atomic import replacing
from baroarma.finding import Finding


@dataclass(frozen=True)
class Verdict:
    """A box that says in a word, a sentence and findings what to think of a result."""

    kind: ClassVar[str] = "verdict"
    sentence: str
    findings: tuple[Finding, ...] = ()
    refused: bool = False

    @property
    def severity(self) -> str:
        """The worst severity: "good", "info", "warning" or "error"."""
        present = {finding.severity for finding in self.findings} | ({"error"} if self.refused else set())
        return next((s for s in ("error", "warning", "info") if s in present), "good")

    @property
    def word(self) -> str:
        """The severity as a word for people."""
        return {"error": "No noise model", "warning": "Usable with care"}.get(self.severity, "Good")


@dataclass(frozen=True)
class Table:
    """A table; the first cell of each row names it, and links to the row's anchor if there are anchors."""

    kind: ClassVar[str] = "table"
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str = ""
    anchors: tuple[str, ...] = ()


@dataclass(frozen=True)
class Text:
    """A heading and, where there is something to say, a paragraph."""

    kind: ClassVar[str] = "text"
    title: str
    text: str = ""


@dataclass(frozen=True)
class Code:
    """Lines to copy, spacing kept."""

    kind: ClassVar[str] = "code"
    text: str


@dataclass(frozen=True)
class Drawing:
    """A figure, SVG from `plotting.canvas.svg` and trusted as such, and its caption."""

    svg: str
    caption: str

    def __post_init__(self) -> None:
        from markupsafe import Markup

        object.__setattr__(self, "svg", Markup(self.svg))  # our own drawing, escaped inside


@dataclass(frozen=True)
class Figures:
    """Figures side by side, as many as the window is wide."""

    kind: ClassVar[str] = "figures"
    figures: tuple[Drawing, ...]


Block = Verdict | Table | Text | Code | Figures


@dataclass(frozen=True)
class Section:
    """A part of a page."""

    blocks: tuple[Block, ...]
    title: str = ""
    anchor: str = ""


@dataclass(frozen=True)
class Page:
    """A page."""

    title: str
    sections: tuple[Section, ...]
    lead: str = ""

    @property
    def footer(self) -> str:
        """Who made it."""
        from baroarma import __version__

        return f"Made by baroarma {__version__}.  This page is complete in itself: keep, send or print it."


def write_page(path: str | os.PathLike[str], page: Page) -> None:
    """Write a page as one self-contained HTML file, complete or not at all.

    Parameters
    ----------
    path : path-like
        Where to write; an older page stays until the new one is complete.
    page : Page
        What to write.

    Examples
    --------
    >>> import tempfile
    >>> table = Table(("preset", "height RMSE (m)"), (("kalman", "0.30"), ("coloured-kalman", "0.20")))
    >>> page = Page("Bake-off", (Section((Text("Heights"), table)),))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_page(Path(folder) / "page.html", page)
    ...     (Path(folder) / "page.html").read_text(encoding="utf-8")[:15]
    '<!DOCTYPE html>'
    """
    html = render("page.html", page=page)
    with replacing(path) as temporary:
        temporary.write_text(html, encoding="utf-8")


def render(template: str, **values: Any) -> str:
    """Fill one of the templates, escaping everything but figures."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    folder = Path(__file__).parent / "templates"
    environment = Environment(
        loader=FileSystemLoader(folder), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    html = environment.get_template(template).render(**values).encode("utf-8", "replace").decode()
    return re.sub(r"[\x00-\x08\x0b\x0c\x0e-\x1f]", "\ufffd", html)  # a name can hold what a page can't
