"""What a page's script gets of a figure: places of the axes, and long lines as they were."""

import base64
import json
import zlib
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.textpath import TextPath

from baroarma.plotting.canvas import envelope
from baroarma.zoomable import NO_SAMPLE, STEPS_X, STEPS_Y, code, drawing

T = np.arange(20_000) / 50


def decoded(text):
    raw = zlib.decompress(base64.b64decode(text))
    n = len(raw) // 6
    y = np.frombuffer(raw, "<i2", offset=4 * n).astype(float)
    return np.cumsum(np.frombuffer(raw, "<i4", n)) / STEPS_X, np.where(y == NO_SAMPLE, np.nan, y) / STEPS_Y


def long_line(ax, y, label="a"):
    ax.plot(*envelope(T, y), label=label)
    ax.set_xlim(T[0], T[-1])
    ax.set_ylim(-4, 4)
    ax.set_xlabel("time (s)")
    ax.set_ylabel("height (m)")


def test_a_coded_line_is_exact_to_its_steps():
    rng = np.random.default_rng(1)
    places = np.stack((np.sort(rng.random(1000)), rng.random(1000)), axis=1)
    places[5, 1] = np.nan
    x, y = decoded(code(places))
    assert np.abs(x - places[:, 0]).max() <= 0.5 / STEPS_X + 1e-15
    assert np.nanmax(np.abs(y - places[:, 1])) <= 0.5 / STEPS_Y + 1e-15
    assert np.flatnonzero(np.isnan(y)).tolist() == [5]


def test_every_sample_of_a_long_line_is_kept_while_the_picture_shows_its_envelope():
    y = np.random.default_rng(1).normal(size=len(T))
    figure = drawing(lambda ax: long_line(ax, y), "a", "")
    found_t, found_y = decoded(json.loads(figure.view)["curves"][0])
    assert np.abs(found_t * T[-1] - T).max() < 1e-4
    assert np.abs(found_y * 8 - 4 - y).max() < 8 / STEPS_Y
    assert len(figure.svg) < 90_000


def test_a_short_line_needs_no_curve():
    figure = drawing(lambda ax: ax.plot([0, 1], [0, 1]), "a", "")
    assert json.loads(figure.view)["curves"] == []


def test_a_figure_keeps_no_more_samples_than_it_may_and_loses_no_peak():
    y = np.zeros(len(T))
    y[12_345] = 3
    lines = (y, -y)
    figure = drawing(lambda ax: [long_line(ax, line) for line in lines], "a", "", samples=4000)
    curves = [decoded(text) for text in json.loads(figure.view)["curves"]]
    assert [len(x) for x, _ in curves] == [2000, 2000]
    assert np.max(curves[0][1]) * 8 - 4 == pytest.approx(3, abs=8 / STEPS_Y)
    assert np.min(curves[1][1]) * 8 - 4 == pytest.approx(-3, abs=8 / STEPS_Y)


def test_plots_draw_as_they_did_once_the_figure_is_done():
    before = len(envelope(T, T)[0])
    drawing(lambda ax: long_line(ax, np.sin(T)), "a", "")
    with pytest.raises(ZeroDivisionError):
        drawing(lambda _: 1 / 0, "a", "")
    assert len(envelope(T, T)[0]) == before


def test_the_view_says_where_the_axes_are_and_what_they_measure():
    def draw(ax):
        ax.loglog([1, 100], [0.1, 10])
        ax.set_xlabel("frequency (Hz)")
        ax.set_xlim(1, 100)

    figure = drawing(draw, "a", "")
    view, tree = json.loads(figure.view), ElementTree.fromstring(figure.svg)
    assert view["x"] == {"label": "frequency (Hz)", "limits": [1.0, 100.0], "log": True}
    clip = tree.find(".//clipPath/rect")  # matplotlib's own word on where its axes are
    assert view["box"] == pytest.approx([float(clip.get(k)) for k in ("x", "y", "width", "height")], abs=1e-3)


def test_ticks_labels_and_grid_are_marked_and_nothing_else_is():
    def draw(ax):
        ax.plot([0, 1], [0, 1], label="line")
        ax.grid()
        ax.set_xlabel("time (s)")
        ax.legend()

    tree = ElementTree.fromstring(drawing(draw, "a", "").svg)
    for axis in "xy":
        words = [e.text for e in tree.iter("text") if e.get("class") == f"tick-{axis}"]
        assert words == sorted(words, key=float)
        lines = [e for e in tree.iter("path") if e.get("class") == f"tick-{axis}" and e.get("clip-path")]
        dashes = [e for e in tree.iter("use") if e.get("class") == f"tick-{axis}"]
        assert len(words) == len(lines) == len(dashes) > 2
        places = [float(e.get(axis)) for e in dashes]
        assert all(a < b for a, b in pairwise(places)) or axis == "y"
    assert "#01020" not in ElementTree.tostring(tree, "unicode")


def test_a_broad_legend_stays_in_the_figure():
    def draw(ax):
        for word in ("a long name of a preset", "another name, quite long", "a third, hardly shorter"):
            ax.plot([0, 1], [0, 1], label=word)
        ax.legend(ncols=3, loc="lower left", bbox_to_anchor=(0, 1)).set_in_layout(False)

    tree = ElementTree.fromstring(drawing(draw, "a", "").svg)
    width = float(tree.get("viewBox").split()[2])
    last = next(e for e in tree.iter("text") if e.text == "a third, hardly shorter")
    assert float(last.get("x")) + TextPath((0, 0), last.text, size=10).get_extents().width < width
