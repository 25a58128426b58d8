"""What the plots share: colours that all readers tell apart, paper, thinning, names."""

from itertools import combinations

import matplotlib as mpl
import numpy as np
import pytest

from baroarma.plotting import canvas

mpl.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.colors import to_rgba

# severity 1 of Machado, Oliveira & Fernandes 2009, "A physiologically-based model for simulation of color
# vision deficiency", IEEE TVCG 15(6), on linear RGB
SEEN_BY = {
    "everyone": np.eye(3),
    "protanopes": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
                   [-0.003882, -0.048116, 1.051998]],
    "deuteranopes": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
                     [-0.011820, 0.042940, 0.968881]],
}  # fmt: skip
TO_XYZ = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


def linear(colour):
    c = np.array(to_rgba(colour)[:3])
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def contrast(one, other):
    """WCAG 2.2's contrast ratio."""
    dark, light = sorted(float(linear(c) @ TO_XYZ[1]) for c in (one, other))
    return (light + 0.05) / (dark + 0.05)


def lab(colour, matrix):
    """CIELAB of what somebody sees of a colour, under D65."""
    xyz = np.array(TO_XYZ) @ np.clip(np.array(matrix) @ linear(colour), 0, 1) / (0.9505, 1.0, 1.089)
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def test_black_and_white_have_the_greatest_contrast():
    assert contrast("#000000", "#ffffff") == pytest.approx(21)


@pytest.mark.parametrize("paper", ["#ffffff", "#14181c"])  # matplotlib's, and the reports' in the dark
def test_every_colour_stands_out_on_light_and_on_dark_paper(paper):
    for colour in canvas.COLOURS:
        assert contrast(colour, paper) >= 3  # WCAG 2.2, 1.4.11


@pytest.mark.parametrize("reader", SEEN_BY)
def test_every_reader_tells_the_colours_apart(reader):
    for one, other in combinations(canvas.COLOURS, 2):
        distance = np.linalg.norm(lab(one, SEEN_BY[reader]) - lab(other, SEEN_BY[reader]))
        assert distance > 10, (one, other)  # four times the 2.3 that is just noticed [Mahy et al. 1994]


def test_two_dozen_lines_of_one_kind_all_differ():
    drawn = {tuple(canvas.one_of_many(i).values()) for i in range(24)}
    assert len(drawn) == 24


def test_a_new_figure_is_opaque_even_where_the_style_is_not():
    with mpl.rc_context({"figure.facecolor": "none"}):
        assert canvas.new_figure(4, 3).get_facecolor() == to_rgba("white")
        assert canvas.axes_or_new(None).figure.get_facecolor() == to_rgba("white")


def test_a_dark_style_keeps_its_dark_paper_and_light_ink():
    with plt.style.context("dark_background"):
        paper = canvas.new_figure(4, 3).get_facecolor()
        assert contrast(canvas.ink(), paper) > 10
        assert contrast(canvas.truth()["color"], paper) > 10


def test_a_band_encloses_all_that_it_thins():
    rng = np.random.default_rng(0)
    low, high = np.sort(rng.normal(size=(2, 10_007)), axis=0)
    t, thin_low, thin_high = canvas.band(np.arange(10_007.0), low, high, bins=100)
    at = np.searchsorted(t, np.arange(10_007.0), side="right") - 1
    assert len(t) == 100
    assert np.all(thin_low[at] <= low)
    assert np.all(thin_high[at] >= high)
    assert (thin_low.min(), thin_high.max()) == (low.min(), high.max())


def test_a_short_band_is_left_as_it_is():
    t = np.arange(5.0)
    assert canvas.band(t, t, t + 1)[1] is t


@pytest.mark.parametrize("name", ["$x^2$", "_hidden", "100 $", "<b>&amp;</b>"])
def test_a_legend_shows_any_name_as_it_is(name):
    ax = canvas.new_figure(4, 3).subplots()
    ax.plot([0, 1], [0, 1], label=canvas.legend_text(name))
    canvas.finish(ax, "t", "x (s)", "y (m)", columns=1)
    ax.figure.canvas.draw()
    (text,) = ax.get_legend().get_texts()
    shown, is_math = text._preprocess_math(text.get_text())
    assert (shown.strip(), is_math) == (name, False)


@pytest.mark.parametrize(("which", "scales"), [("x", ("log", "linear")), ("y", ("linear", "log"))])
def test_one_axis_alone_can_be_logarithmic_with_plain_numbers(which, scales):
    ax = canvas.new_figure(4, 3).subplots()
    ax.plot([0.1, 10], [0.1, 10])
    canvas.logarithmic(ax, which)
    assert (ax.get_xscale(), ax.get_yscale()) == scales
    axis = ax.xaxis if which == "x" else ax.yaxis
    assert axis.get_major_formatter()(0.01) == "0.01"
