"""Plots of tracks and bake-offs: bands hold the sds, references lie where the errors say."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest

from baroarma.comparison import Comparison, Row
from baroarma.metrics import errors
from baroarma.plotting import plot_errors, plot_traces, plot_track
from baroarma.plotting.canvas import COLOURS
from baroarma.recording import Recording
from baroarma.track import Track

mpl.use("Agg")
import matplotlib.pyplot as plt

T = np.arange(3000) / 50


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


def make(n=1000, *, preset="p", bias=0.0, name="ride"):
    t = T[:n]
    height = np.sin(t) + bias * (t > 2)
    return Track(t, height, np.cos(t), 0.1 + t / 100, np.full(n, 0.05), -np.sin(t), preset=preset, name=name)


def recording(**changes):
    pressure = np.full(len(T), 101325.0)
    signals = {"reference": np.sin(T) + 7, "reference_velocity": np.cos(T)}
    return Recording(t=T, pressure=pressure, name="ride", **{**signals, **changes})


def bake_off(reference=None, names=("good", "bad")):
    reference = reference or recording()
    tracks = [make(len(T), preset=name, bias=bias) for name, bias in zip(names, (0.0, 0.5), strict=True)]
    rows = tuple(Row(track.preset, track, errors(track, reference), 1.0) for track in tracks)
    return Comparison(reference, (*rows, Row("failed", None, None, None, "no IMU")), 0.0)


def line(ax, label):
    return next(one for one in ax.get_lines() if one.get_label() == label)


def test_height_and_velocity_are_drawn_with_bands_of_two_sds():
    track = make()
    height, velocity = track.plot().figure.axes
    for ax, quantity, unit in ((height, "height", "m"), (velocity, "velocity", "m/s")):
        assert line(ax, quantity).get_ydata() == pytest.approx(getattr(track, quantity))
        corners = ax.collections[0].get_paths()[0].vertices
        sd = getattr(track, f"{quantity}_sd")
        assert corners[:, 1].max() == pytest.approx((getattr(track, quantity) + 2 * sd).max())
        assert ax.get_ylabel() == f"{quantity} ({unit})"


def test_given_axes_take_the_height_alone():
    ax = plt.figure().subplots()
    assert make().plot(ax) is ax
    assert ax.figure.axes == [ax]


def test_the_reference_lies_at_the_tracks_level_over_its_first_second():
    height, velocity = make().plot(reference=recording()).figure.axes
    assert line(height, "reference").get_ydata() == pytest.approx(np.sin(T[:1000]), abs=1e-12)
    assert line(velocity, "reference").get_ydata() == pytest.approx(np.cos(T[:1000]), abs=1e-12)


def test_a_recording_without_reference_is_refused_in_a_sentence():
    without = recording(reference=None, reference_velocity=None)
    with pytest.raises(ValueError, match="ride has no reference at the track's times"):
        plot_track(make(), reference=without)


def test_a_spike_of_one_sample_among_a_million_stays_visible():
    n = 1_000_000
    height, sd = np.zeros(n), np.full(n, 0.1)
    height[654_321] = 50.0
    track = Track(np.arange(n) / 50, height, np.zeros(n), sd, sd, np.zeros(n))
    ax = plot_track(track)
    drawn = line(ax, "height")
    assert drawn.get_ydata().max() == 50.0
    assert ax.collections[0].get_paths()[0].vertices[:, 1].max() == pytest.approx(50.2)
    assert len(drawn.get_xdata()) < 2000


def test_traces_are_zeroed_as_the_errors_are_even_if_the_reference_begins_late():
    late = np.where(T > 10, np.sin(T) + 7, np.nan)
    found = bake_off(recording(reference=late, reference_velocity=None))
    ax = plot_traces(found, plt.figure().subplots(), "height")
    start = slice(501, 551)  # T[501] is the first above 10 s
    for row in found.rows[:2]:
        drawn = line(ax, row.preset).get_ydata()
        assert len(drawn) < 3000  # an envelope
        at_start = row.track.height[start].mean()
        assert drawn.max() == pytest.approx((row.track.height - at_start).max())
    reference = line(ax, "reference").get_ydata()
    assert np.nanmax(reference) == pytest.approx(np.nanmax(late) - late[start].mean())


def test_bars_have_the_lengths_of_the_errors_and_the_colours_of_the_traces():
    found = bake_off()
    traces, _, bars = found.plot().axes
    height, velocity = bars.containers[0], bars.containers[2]  # after each its entry of the legend
    for i, row in enumerate(found.rows[:2]):
        assert height[i].get_width() == row.errors.height_rmse
        assert velocity[i].get_width() == row.errors.velocity_rmse
        colour = mpl.colors.to_rgba(line(traces, row.preset).get_color())
        assert height[i].get_facecolor() == colour
        assert velocity[i].get_edgecolor() == colour
    assert [text.get_text() for text in bars.get_yticklabels()] == ["good", "bad"]
    assert bars.get_xlabel() == "rms error (m, m/s)"


def test_numbers_stand_at_the_bars_with_three_digits():
    texts = [text.get_text() for text in bake_off().plot().axes[2].texts]
    assert texts[1] == f"{bake_off().rows[1].errors.height_rmse:.3f}"


def test_without_reference_the_bars_say_where_the_ride_ends():
    found = bake_off(recording(reference=None, reference_velocity=None))
    ax = plot_errors(found, plt.figure().subplots())
    assert ax.get_xlabel() == "height (m)"
    assert [bar.get_width() for bar in ax.containers[0]] == [row.errors.closure for row in found.rows[:2]]


def test_names_from_files_are_drawn_as_they_are():
    figure = bake_off(names=("_track$1$.csv", "<script>")).plot()
    figure.canvas.draw()
    texts = [text.get_text().strip() for text in figure.axes[0].get_legend().get_texts()]
    assert texts[:2] == [r"_track\$1\$.csv", "<script>"]


def test_a_bake_off_in_which_nobody_could_track_still_has_its_axes():
    nobody = replace(bake_off(), rows=(Row("failed", None, None, None, "no IMU"),))
    figure = nobody.plot()
    figure.canvas.draw()
    assert len(figure.axes) == 3


def test_the_reference_has_the_same_look_everywhere():
    one = line(make().plot(reference=recording()), "reference")
    other = line(bake_off().plot().axes[0], "reference")
    third = line(recording().plot(), "reference")
    assert one.get_color() == other.get_color() == third.get_color()
    assert one.get_color() not in COLOURS


@pytest.mark.parametrize("part", [slice(100, 3000), slice(0, 400)])
def test_a_track_of_a_part_of_the_recording_is_drawn_where_it_is(part):
    reference = recording(reference=np.where(T > 10, np.sin(T) + 7, np.nan), reference_velocity=None)
    whole = make(len(T))
    names = ("height", "velocity", "height_sd", "velocity_sd", "acceleration")
    track = Track(T[part], *(getattr(whole, name)[part] for name in names), preset="part")
    row = Row("part", track, errors(track, reference), None)
    ax = plot_traces(Comparison(reference, (row,), 0.0), plt.figure().subplots(), "height")
    drawn = line(ax, "part")
    assert drawn.get_xdata()[0] == track.t[0]
    assert np.isfinite(drawn.get_ydata()).all()
