"""The page of a bake-off."""

import re
from dataclasses import replace

import pytest

import baroarma as ba
from baroarma.comparison_report import write_comparison_report
from baroarma.simulation import BMP085, simulate


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    squats = simulate("squat", duration=30, seed=1)
    named = replace(squats, name="<b>$x$</b>")
    ride = replace(squats, name="ride", reference=None, reference_velocity=None)
    path = tmp_path_factory.mktemp("page") / "page.html"
    comparisons = [
        ba.compare(recording, presets=("sg14-b", "baroarma"), noise=BMP085.noise)
        for recording in (named, ride)
    ]
    write_comparison_report(comparisons, path)
    return comparisons, path.read_text()


def test_the_page_refers_to_nothing_outside(page):
    assert not re.search(r"https?://", page[1])
    assert "<b>$x$" not in page[1]


def test_the_page_has_the_numbers_and_the_price_of_whitening(page):
    comparisons, html = page
    for row in comparisons[0].rows:
        assert f"{row.errors.velocity_rmse:.3f}" in html
    assert "DC gain" in html


def test_without_a_reference_the_page_says_so(page):
    first, second = page[1].split('id="recording-2"')
    assert "it has no reference" in second
    assert "Where the ride ends" in second
    for word in ("height RMSE", "shorter is better", "reference are both"):
        assert word in first
        assert word not in second


def test_what_no_preset_can_track_is_not_called_good(page, tmp_path):
    lost = [replace(row, track=None, errors=None, refusal="needs a gyro") for row in page[0][0].rows]
    write_comparison_report([replace(page[0][0], rows=tuple(lost))], tmp_path / "page.html")
    html = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "No track." in html
    assert html.count("<td") == html.count(">needs a gyro</td>") == 2


def test_nothing_to_report_is_refused(tmp_path):
    with pytest.raises(ValueError, match="at least one comparison"):
        write_comparison_report([], tmp_path / "page.html")
