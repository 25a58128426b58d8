"""How a climb is told: every number where it belongs."""

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
from matplotlib.figure import Figure

from baroarma.climbed import Climb


def test_up_and_down_are_not_confused():
    up = Climb(1.5, 0.25, 0.5, 0.125, 2, 1, np.arange(3.0), np.array([0, 1.5, 1.25]), "a <b>")
    assert repr(up) == "<Climb of 'a <b>': up 1.50 ± 0.50 m, down 0.25 ± 0.12 m, floors 2 up, 1 down>"
    assert up.summary() == (
        "climbs 1.50 m (sd 0.5), descends 0.25 m (sd 0.12) in 2 swings; floors: 2 up, 1 down"
    )
    assert "in 1 swing;" in replace(up, t=up.t[:2], height=up.height[:2]).summary()
    assert up.to_dict() == {
        "ascent_m": 1.5,
        "ascent_sd_m": 0.5,
        "descent_m": 0.25,
        "descent_sd_m": 0.125,
        "floors_up": 2,
        "floors_down": 1,
        "turning_points": {"time_s": [0, 1, 2], "height_m": [0, 1.5, 1.25]},
    }
    root = ElementTree.fromstring(up._repr_html_())
    assert root.find("caption").text == "a <b>"
    assert [[cell.text for cell in row] for row in root.iter("tr")] == [
        [None, "m", "sd m", "floors"],
        ["up", "1.50", "0.50", "2"],
        ["down", "0.25", "0.12", "1"],
    ]
    ax = Figure().subplots()
    assert up.plot(ax) is ax


def test_nothing_is_told_in_plain_words():
    none = Climb(0.0, 0.0, 0.0, 0.0, 0, 0, np.empty(0), np.empty(0))
    assert none.summary() == (
        "climbs 0.00 m (sd 0), descends 0.00 m (sd 0) without a swing; floors: 0 up, 0 down"
    )
    nameless = Climb(1.0, 0.0, 0.1, 0.0, 0, 0, np.arange(2.0), np.arange(2.0))
    assert nameless.name == ""
    text = "".join(ElementTree.fromstring(nameless._repr_html_()).itertext())
    assert text == "msd mfloorsup1.000.100down0.000.000"
