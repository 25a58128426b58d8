"""The page of the experiments is complete in itself."""

import re
from xml.etree import ElementTree

import numpy as np

from baroarma.experiments import Result, Row
from baroarma.experiments.report import write_report
from baroarma.experiments.scene import Scene, cut
from baroarma.zoomable import drawing

T = np.arange(500) / 50
SCENE = Scene(
    "SG14 Fig. 4", "Fall.", "time (s)", "height (m)", T, {"Method A": np.sin(T)}, reference=np.cos(T), raw=T
)
ROWS = (
    Row("Method A", "height RMSE (m)", 0.4, 0.15, 0.38, 0.08, 10, "within 1 SD"),
    Row("Method B", "height RMSE (m)", 0.08, 0.03, 0.5, None, 10, "differs: a < b & c"),
)
RESULT = Result("sg14-table-2", "no motion", ("sensors are simulated",), ROWS)


def test_a_page_holds_tables_reasons_figures_and_assumptions(tmp_path):
    write_report([RESULT], {"sg14-table-2": [SCENE]}, tmp_path / "page.html")
    html = (tmp_path / "page.html").read_text(encoding="utf-8")
    root = ElementTree.fromstring(html.removeprefix("<!DOCTYPE html>").lstrip())
    text = " ".join(" ".join(root.itertext()).split())
    for part in (
        "0.400 ± 0.150",
        "differs [1]",
        "a < b & c",
        "sensors are simulated",
        "SG14 Fig. 4",
        "Fall.",
    ):
        assert part in text
    assert html.count("<svg") == 1
    assert not re.search(r"https?:|<link|<img", html)


def test_a_scene_shows_reference_lines_and_raw_altitude():
    svg = drawing(SCENE.draw, "a", "").svg
    assert all(f">{word}<" in svg for word in ("raw", "Method A", "reference"))


def test_points_stand_on_logarithmic_axes():
    m = 2.0 ** np.arange(5)
    scene = Scene("", "", "M", "sd", m, {"white": 1 / m}, reference=1 / m, points=True, against="law")
    assert ">law<" in drawing(scene.draw, "b", "").svg


def test_a_cut_is_half_open():
    assert T[cut(T, 1, 2)][[0, -1]].tolist() == [1.0, 1.98]
