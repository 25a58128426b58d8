"""The skeleton that all pages share: well-formed, escaped, complete in itself, and allowed to do nothing."""

import base64
import hashlib
import re
from xml.etree import ElementTree

import pytest

from baroarma.finding import Finding
from baroarma.page import Code, Drawing, Figures, Page, Section, Table, Text, Verdict, write_page

EVIL = '"><script>alert(1)</script><img onerror=alert(1) src=x>&'


def parsed(path):
    html = path.read_text(encoding="utf-8")
    return ElementTree.fromstring(html.removeprefix("<!DOCTYPE html>").lstrip())


@pytest.fixture
def evil(tmp_path):
    """A page of every kind of block, all its words hostile."""
    figure = Drawing("<svg viewBox='0 0 1 1'></svg>", EVIL, EVIL)
    blocks = (
        Verdict(EVIL, (Finding(EVIL, "warning", EVIL),)),
        Text(EVIL, EVIL),
        Table((EVIL, EVIL), ((EVIL, EVIL),), EVIL),
        Code(EVIL),
        Figures((figure,)),
    )
    write_page(tmp_path / "page.html", Page(EVIL, (Section(blocks, EVIL, "first"),), lead=EVIL))
    return tmp_path / "page.html"


def test_every_word_is_shown_as_it_is(evil):
    html, tree = evil.read_text(), parsed(evil)
    shown = "".join(tree.find("body").itertext())
    title, lead, section, caption = 1, 1, 1, 1
    verdict, text, table, code = 3, 2, 5, 1
    assert shown.count(EVIL) == title + lead + section + verdict + text + table + code + caption
    assert html.count("<script") == 1
    assert "<img" not in html
    assert "Usable with care" in shown


def test_attributes_hold_what_they_are_given_and_nothing_else(evil):
    tree = parsed(evil)
    assert tree.find(".//figure").attrib == {"data-view": EVIL}
    assert tree.find(".//svg").get("aria-label") == EVIL
    assert tree.find(".//td").attrib == {"data-label": EVIL}
    assert not [name for e in tree.iter() for name in e.attrib if name.startswith("on")]


def test_the_browser_is_told_to_load_nothing_and_to_run_the_one_script_only(evil):
    tree = parsed(evil)
    policy = next(m.get("content") for m in tree.iter("meta") if m.get("http-equiv"))
    kept = re.search(r"<script>(.*?)</script>", evil.read_text(), re.DOTALL)[1]
    digest = base64.b64encode(hashlib.sha256(kept.encode()).digest()).decode()
    assert "default-src 'none'" in policy
    assert f"script-src 'sha256-{digest}'" in policy


def test_a_page_of_many_parts_begins_with_links_to_them():
    three = tuple(Section((), name, name) for name in "abc")
    assert Page("", three).contents == (("a", "a"), ("b", "b"), ("c", "c"))
    assert Page("", three[:2]).contents == ()
    single = Section((Text("x"), Code(""), Text("y"), Text("x")), anchor="only")
    assert Page("", (single,)).contents == (("only-1", "x"), ("only-3", "y"), ("only-4", "x"))


def test_a_table_that_links_to_the_parts_replaces_the_links():
    table = Table(("part",), (("a",), ("b",), ("c",)), anchors=("a", "b", "c"))
    sections = (Section((table,)), *(Section((), name, name) for name in "abc"))
    assert Page("", sections).contents == ()


def test_the_links_lead_to_headings(tmp_path):
    blocks = (Text("same"), Text("same"), Text("same"))
    write_page(tmp_path / "page.html", Page("", (Section(blocks),)))
    tree = parsed(tmp_path / "page.html")
    headings = [h.get("id") for h in tree.iter("h2")]
    assert [a.get("href") for a in tree.iter("a")] == [f"#{name}" for name in headings]
    assert len(set(headings)) == 3


def test_the_worst_finding_gives_the_box_its_colour():
    info, warning = (Finding("x", severity, "y") for severity in ("info", "warning"))
    assert [Verdict("", f).severity for f in ((), (info,), (info, warning))] == ["good", "info", "warning"]
    assert Verdict("", (warning,), refused=True).severity == "error"
    assert Verdict("", refused=True, refusal="No track").word == "No track"


def test_an_old_page_stays_until_the_new_one_is_complete(tmp_path, monkeypatch):
    path = tmp_path / "page.html"
    path.write_text("old")
    monkeypatch.setattr("pathlib.Path.replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        write_page(path, Page("new", ()))
    assert [p.name for p in tmp_path.iterdir()] == ["page.html"]
    assert path.read_text() == "old"
