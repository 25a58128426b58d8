"""A page is data: sections of verdicts, tables, text, code and figures, drawn by one template.

`write_page` makes a single HTML file of it that refers to nothing outside itself.  All text is escaped by the
template: names and cells come from files, and files come from anywhere.  The page also tells the browser to
load nothing and to run one script only, the one that zooms figures, known by its hash.
"""

from __future__ import annotations

import base64
import hashlib
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Final

from baroarma.atomic import replacing
from baroarma.finding import Finding


@dataclass(frozen=True)
class Verdict:
    """A box that says in a word, a sentence and findings what to think of a result."""

    kind: ClassVar[str] = "verdict"
    sentence: str
    findings: tuple[Finding, ...] = ()
    refused: bool = False
    refusal: str = "No noise model"

    @property
    def severity(self) -> str:
        """The worst severity: "good", "info", "warning" or "error"."""
        present = {finding.severity for finding in self.findings} | ({"error"} if self.refused else set())
        return next((s for s in ("error", "warning", "info") if s in present), "good")

    @property
    def word(self) -> str:
        """The severity as a word for people."""
        return {"error": self.refusal, "warning": "Usable with care"}.get(self.severity, "Good")


LONG_CELL: Final = 28
"""Characters of a cell that is a sentence; tables of those become lists on a narrow screen."""


@dataclass(frozen=True)
class Table:
    """A table; the first cell of each row names it, and links to the row's anchor if there are anchors."""

    kind: ClassVar[str] = "table"
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str = ""
    anchors: tuple[str, ...] = ()

    @property
    def wordy(self) -> bool:
        """Whether it has sentences to read, not only values to compare."""
        return any(len(cell) > LONG_CELL for row in self.rows for cell in row)


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
    """A figure, SVG from `plotting.canvas.svg` and trusted as such, its caption, and its view for zooming."""

    svg: str
    caption: str
    view: str = ""

    @property
    def picture(self) -> Any:
        """The drawing as one picture, which the caption describes to those who can't see it."""
        from markupsafe import Markup, escape

        return Markup(self.svg.replace("<svg ", f'<svg role="img" aria-label="{escape(self.caption)}" ', 1))


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

    def name(self, block: Block) -> str:
        """Return the anchor of one of its blocks."""
        place = next(i for i, one in enumerate(self.blocks) if one is block)
        return f"{self.anchor or 'part'}-{place + 1}"


@dataclass(frozen=True)
class Page:
    """A page."""

    title: str
    sections: tuple[Section, ...]
    lead: str = ""

    @property
    def contents(self) -> tuple[tuple[str, str], ...]:
        """Anchor and title of each part, where there are so many that one wants to jump."""
        titled = tuple((s.anchor, s.title) for s in self.sections if s.anchor and s.title)
        linked = any(isinstance(b, Table) and b.anchors for s in self.sections for b in s.blocks)
        if len(self.sections) == 1:
            only = self.sections[0]
            titled = tuple((only.name(b), b.title) for b in only.blocks if isinstance(b, Text))
        return titled if len(titled) > 2 and not linked else ()

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
    script = _script()
    html = render("page.html", page=page, script=script, script_hash=_hash(script))
    with replacing(path) as temporary:
        temporary.write_text(html, encoding="utf-8")


def render(template: str, **values: Any) -> str:
    """Fill one of the templates, escaping everything but figures."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    html = environment.get_template(template).render(**values).encode("utf-8", "replace").decode()
    return re.sub(r"[\x00-\x08\x0b\x0c\x0e-\x1f]", "\ufffd", html)  # a name can hold what a page can't


def _script() -> Any:
    """The script of zoomable figures, as XML reads it, too."""
    from markupsafe import Markup

    lines = (_TEMPLATES / "zoom.js").read_text(encoding="utf-8")
    return Markup(f"//<![CDATA[\n{lines}//]]>\n")


def _hash(script: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


_TEMPLATES: Final = Path(__file__).parent / "templates"
