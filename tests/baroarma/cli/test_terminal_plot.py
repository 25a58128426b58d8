"""The drawing shows what the track says, in any terminal."""

import numpy as np
import pytest

from baroarma.cli.terminal_plot import BRAILLE, LEAST_SPAN, MARGIN, Rows, draw, rows_of


def track(t, height, velocity=None, sd=0.0):
    t = np.asarray(t, float)
    height = np.broadcast_to(np.asarray(height, float), t.shape)
    velocity = np.zeros(t.shape) if velocity is None else velocity
    return Rows(t, height, velocity, np.full(t.shape, float(sd)), np.full(t.shape, 0.01))


def panels(text):
    """The lines of the two drawings, without their scales, and the scales' numbers, line by line."""
    lines = text.plain.split("\n")
    middle = next(k for k, line in enumerate(lines) if line.startswith("velocity"))
    both = lines[1:middle], lines[middle + 1 : -1]
    return [[line[MARGIN:] for line in part] for part in both], [
        [line[: MARGIN - 1].strip() for line in part] for part in both
    ]


def line_of(text):
    """The same text with nothing but the line: the band and all else are blanks."""
    kept = [" "] * len(text.plain)
    for span in text.spans:
        if "default" in str(span.style):
            kept[span.start : span.end] = text.plain[span.start : span.end]
    joined = "".join(kept)
    return "\n".join(joined[a:b] for a, b in line_ends(text.plain))


def line_ends(plain):
    start = 0
    for line in plain.split("\n"):
        yield start, start + len(line)
        start += len(line) + 1


def dots(lines):
    """Decode Braille by hand: True where there is a dot, row after row."""
    found = np.zeros((4 * len(lines), 2 * max(map(len, lines))), bool)
    for row, line in enumerate(lines):
        for column, character in enumerate(line):
            code = ord(character) - 0x2800
            if code > 0:
                found[4 * row : 4 * row + 4, 2 * column : 2 * column + 2] = (code & BRAILLE) > 0
    return found


def test_the_dots_are_where_the_numbers_are():
    t = np.linspace(0, 10, 2001)
    text = draw(track(t, np.sin(t)), width=100, height=43)
    lines = line_of(text).split("\n")[1:21]
    found = dots([line[MARGIN:].ljust(100 - MARGIN) for line in lines])
    rows, columns = found.shape
    assert (rows, columns) == (80, 184)
    t_of = (np.arange(columns) + 0.5) * 10 / columns
    for column in range(columns):
        (lit,) = np.nonzero(found[:, column])
        height_of = 1 - (lit + 0.5) * 2 / rows  # the scale spans -1 to 1: sd is 0
        slope_and_a_dot = 10 / columns + 2 / rows
        assert abs(height_of - np.sin(t_of[column])).max() < slope_and_a_dot
        assert np.all(np.diff(lit) == 1)


def test_no_peak_is_lost_among_a_hundred_thousand_rows():
    height = np.zeros(100_000)
    height[61_803] = 5.0
    (upper, _), _ = panels(draw(track(np.arange(100_000) / 50, height), width=80, height=24))
    assert upper[0].strip()
    assert upper[0].index(upper[0].strip()) == int(0.61803 * 72)


@pytest.mark.parametrize("has_braille", [True, False])
def test_it_fits_every_terminal(has_braille):
    rows = track(np.arange(0, 30, 0.02), np.sin(np.arange(0, 30, 0.02)), sd=0.3)
    for width in (1, 5, 31, 32, 33, 79, 200):
        for height in (1, 2, 8, 9, 10, 24, 61):
            lines = draw(rows, width=width, height=height, has_braille=has_braille).plain.split("\n")
            assert len(lines) <= height
            assert max(map(len, lines)) <= width


def test_a_terminal_too_small_for_a_drawing_shows_numbers():
    plain = draw(track([0, 1], [0, 1.25]), width=31, height=24).plain
    assert plain.split("\n")[0].startswith("height +1.25 m, sd 0.00")


def test_without_braille_everything_is_ascii():
    t = np.arange(0, 10, 0.1)
    text = draw(track(t, t, sd=2), width=80, height=24, has_braille=False).plain
    assert text.isascii()
    assert "*" in text
    assert "." in text.split("\n")[3]


def test_the_scales_numbers_stand_where_the_line_has_that_value():
    t = np.linspace(0, 7, 701)
    lines = line_of(draw(track(t, t), width=80, height=24)).split("\n")[1:11]
    _, (numbers, _) = panels(draw(track(t, t), width=80, height=24))
    labelled = [k for k, number in enumerate(numbers) if number]
    assert len(labelled) >= 3
    for k in labelled:
        columns = [c for c, character in enumerate(lines[k][MARGIN:]) if character.strip()]
        shown = np.array([columns[0], columns[-1] + 1]) * 7 / 72  # the height is the time here
        assert shown[0] - 7 / 72 <= float(numbers[k]) <= shown[1] + 7 / 72


def test_the_times_stand_where_they_are():
    t = np.linspace(3, 23, 1001)
    line = draw(track(t, 0), width=88, height=24).plain.split("\n")[-1]
    for label, at in (("5 s", 2), ("10 s", 7), ("20 s", 17)):
        assert line.index(label) == MARGIN + at * 80 // 20


def test_times_since_1970_are_told_in_full():
    line = draw(track(np.linspace(1.7e9, 1.7e9 + 20, 1001), 0), width=88, height=24).plain.split("\n")[-1]
    assert "1700000005 s" in line


def test_a_window_that_has_not_filled_yet_is_blank_on_the_left():
    (upper, _), _ = panels(draw(track(np.arange(90, 100, 0.1), 0), width=80, height=24, span=20.0))
    assert not any(line[:35].strip() for line in upper)
    assert any(line[37:].strip() for line in upper)


def test_noise_is_not_drawn_as_if_it_were_motion():
    rows = track(np.arange(10), 1e-3 * np.arange(10))
    _, (numbers, _) = panels(draw(rows, width=80, height=24))
    values = [float(number) for number in numbers if number]
    assert max(values) - min(values) >= LEAST_SPAN / 2


def test_a_wide_band_leaves_the_line_its_third_of_the_scale():
    t = np.linspace(0, 10, 101)
    text = draw(track(t, np.sin(t), sd=50.0), width=80, height=33)
    lit = [k for k, line in enumerate(line_of(text).split("\n")[1:16]) if line[MARGIN:].strip()]
    assert len(lit) >= 5


def test_one_row_is_enough():
    assert "height +2.00 m" in draw(rows_of([(5.0, 2.0, 0.1, 0.3, 0.2)]), width=80, height=24).plain
