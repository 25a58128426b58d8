"""Pages: complete in themselves, well-formed, escaped, and with the numbers that the objects hold."""

import itertools
import math
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

import baroarma as ba
from baroarma.atmosphere import altitude_pressure
from baroarma.report import (
    comparison_table,
    identification_table,
    model_table,
    write_identification_report,
)
from baroarma.simulation import simulate_rest

NAME = "cost $x_1$ <script>alert('x')</script> & \"co\"\udcff\x07"
SHOWN = NAME.replace("\udcff", "?").replace("\x07", "\ufffd")


@pytest.fixture(scope="module")
def found():
    return ba.identify(replace(simulate_rest(120, seed=1), name=NAME))


@pytest.fixture(scope="module")
def refused():
    t = np.arange(3000) / 50
    rising = altitude_pressure(0.4 * t + np.random.default_rng(1).normal(size=3000))
    return ba.identify(ba.Recording(t=t, pressure=rising, name="lift"))


@pytest.fixture(scope="module")
def pages(found, refused, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    write_identification_report([found], folder / "one.html")
    write_identification_report([found, refused, found], folder / "many.html", unity_gain_hz=1.0)
    assert sorted(p.name for p in folder.iterdir()) == ["many.html", "one.html"]  # nothing temporary stays
    return {path.stem: path.read_text(encoding="utf-8") for path in folder.iterdir()}


def parsed(html):
    return ElementTree.fromstring(html.removeprefix("<!DOCTYPE html>").lstrip())


def text_of(html):
    return " ".join(" ".join(parsed(html).itertext()).split())


@pytest.mark.parametrize("name", ["one", "many"])
def test_links_stay_on_the_page_and_no_two_parts_have_one_name(pages, name):
    html = pages[name]
    assert html.startswith("<!DOCTYPE html>")
    assert not re.search(r"https?:|@import|<link|<img| src=", html)
    targets = set(re.findall(r'(?:href="|url\()([^")]*)', html))
    ids = re.findall(r' id="([^"]*)"', html)
    assert targets <= {f"#{i}" for i in ids}
    assert len(ids) == len(set(ids))


@pytest.mark.parametrize("name", ["one", "many"])
def test_a_page_is_well_formed_and_shows_a_hostile_name_as_it_is(pages, name):
    tree = parsed(pages[name])
    shown = [e.text for e in tree.iter("h1")] + [e.text for e in tree.iter("h2")]
    assert any(SHOWN in text for text in shown)
    assert [e.text for e in tree.iter("script")] == [parsed(pages["one"]).find("body/script").text]


@pytest.mark.parametrize("name", ["one", "many"])
def test_no_level_of_headings_is_left_out(pages, name):
    levels = [int(e.tag[1]) for e in parsed(pages[name]).iter() if re.fullmatch("h[1-6]", e.tag)]
    assert levels[0] == 1
    assert all(b <= a + 1 for a, b in itertools.pairwise(levels))
    assert levels.count(1) == 1


def test_the_page_gives_what_a_filter_needs(pages, found):
    text, model = text_of(pages["one"]), found.model
    whitening = model.whitening_filter()
    assert f"{model.white_sd**2:.6g} m²" in text
    assert f"{math.exp(-1 / (model.rate_hz * model.correlation_time)):.6g}" in text
    assert f"b = {list(whitening.b)}" in text
    assert f"under-reported by the factor {whitening.dc_gain:.4g}" in text
    for name in ("white_sd", "correlated_sd", "correlation_time", "drift_rate"):
        assert "{:.4g} to {:.4g}".format(*model.ci95[name]) in text
    for p in model.whiteness_p.values():
        assert f"{p:.2g}" in text
    for finding in found.verdict:
        assert finding.message in text
    assert f"baroarma {ba.__version__}" in text


def test_the_page_has_six_figures_per_model_and_one_of_a_refused_recording(pages):
    assert len(list(parsed(pages["one"]).iter("svg"))) == 6
    assert len(list(parsed(pages["many"]).iter("svg"))) == 6 + 1 + 6


def test_the_verdict_is_a_word_and_not_only_a_colour(pages):
    words = [
        e.find("p/strong").text for e in parsed(pages["many"]).iter("div") if e.find("p/strong") is not None
    ]
    assert words[1] == "No noise model."
    assert words[0] == words[2] != words[1]


def test_the_page_of_a_refused_recording_says_why(refused, tmp_path):
    write_identification_report([refused], tmp_path / "page.html")
    text = text_of((tmp_path / "page.html").read_text())
    assert refused.model is None
    assert "This is no rest recording: the height changes by" in text
    assert "Kalman" not in text


def test_several_recordings_begin_with_a_table_that_links_to_them(pages):
    table = next(parsed(pages["many"]).iter("table"))
    assert [a.get("href") for a in table.iter("a")] == ["#recording-1", "#recording-2", "#recording-3"]
    assert "2 of 3 recordings support a noise model" in pages["many"]


def test_the_unity_gain_goes_where_it_is_asked_for(pages, found):
    assert "unity_gain_hz = 1\n" in pages["many"]
    assert f"dc_gain = {found.model.whitening_filter(unity_gain_hz=1.0).dc_gain:.10g}" in pages["many"]


def test_what_cannot_be_reported_leaves_no_file(found, tmp_path):
    with pytest.raises(ValueError, match="choose a frequency from 0 to 25 Hz"):
        write_identification_report([found], tmp_path / "page.html", unity_gain_hz=40.0)
    with pytest.raises(ValueError, match="nothing to report"):
        write_identification_report([], tmp_path / "page.html")
    assert not list(tmp_path.iterdir())


def test_the_windows_method_brings_its_table(tmp_path):
    found = ba.identify(simulate_rest(120, seed=2), method="windows")
    write_identification_report([found], tmp_path / "page.html")
    text = text_of((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert found.windows.summary().splitlines()[0] in text


def test_tables_for_notebooks_are_escaped_and_complete(found, refused):
    named = replace(found.model, sensor="<img src=x>")
    assert "&lt;img src=x&gt;" in model_table(named)
    assert "<img" not in model_table(named)
    assert f"{named.white_sd:.4g} m" in model_table(named)
    assert "No noise model" in identification_table(refused)
    assert len(list(parsed(comparison_table([found, refused])).iter("tr"))) == 3
    assert "<script" not in comparison_table([found, refused])


def test_a_model_by_hand_has_no_intervals_to_show():
    cells = [e.text for e in parsed(model_table(ba.NoiseModel(0.2, 1.0, 0.4, rate_hz=50))).iter("td")]
    assert cells[1::2] == ["–"] * 4
