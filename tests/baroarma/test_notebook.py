"""Results in notebooks: a line, a table in the notebook's colours, nothing from a file taken for HTML."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

import baroarma as ba
from baroarma.barometer_lag import BarometerLag
from baroarma.comparison import Comparison, Row
from baroarma.estimators.calibration import Calibration
from baroarma.experiments.result import Result
from baroarma.experiments.result import Row as Number
from baroarma.finding import Finding
from baroarma.identification.averaging import averaging_study
from baroarma.identification.orders import order_table
from baroarma.identification.windows import identify_windows
from baroarma.metrics import errors
from baroarma.notebook import STYLE, about, number, remarks, tables
from baroarma.page import Table
from baroarma.track import Track

EVIL = '<script>alert(1)</script>"><img src=x onerror=alert(2)> & 気圧 $x$'
NOTE = Finding("gaps", "warning", EVIL)
NOISE = ba.NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50, sensor=EVIL, verdict=(NOTE,))
T = np.arange(9000) / 50
HEIGHT = replace(NOISE, sensor="").simulate(T, 1)


def results():
    """One result of each kind, with names and cells as bad as files can have them."""
    t = T[:200]
    recording = ba.Recording(
        t=t, pressure=np.full(200, 1e5), accel=np.ones((200, 3)), reference=t, name=EVIL, notes=(NOTE,)
    )
    signals = {name: np.ones(200) for name in ("height", "velocity", "height_sd", "velocity_sd")}
    track = Track(t, **signals, acceleration=np.ones(200), preset=EVIL, name=EVIL, findings=(NOTE,))
    rows = (Row(EVIL, track, errors(track, recording), 1.0), Row("b", None, None, None, EVIL))
    noise = replace(NOISE, sensor="", verdict=())
    prediction = replace(ba.predict_accuracy(noise, "simple", "sg14-a", 5.0), preset=EVIL, notes=(EVIL,))
    tuned = replace(ba.tune("sg14-a", noise, duration=5.0), preset=EVIL, notes=(EVIL,))
    windows = identify_windows(T, HEIGHT)
    line = Number(EVIL, EVIL, 0.4, 0.1, 0.3, None, 3, f"differs: {EVIL}")
    three = (0.1, 0.2, 0.3)
    return {
        "recording": recording,
        "identification": ba.Identification(recording, NOISE, (NOTE,), "structural"),
        "refused": ba.Identification(recording, None, (replace(NOTE, severity="error"),), "structural"),
        "noise model": NOISE,
        "arma": ba.ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1),
        "whitening": replace(noise.whitening_filter(), note=EVIL),
        "track": track,
        "comparison": Comparison(recording, rows, 0.0, (NOTE,)),
        "prediction": prediction,
        "tuning": tuned,
        "windows": replace(windows, findings=(NOTE,)),
        "orders": order_table(HEIGHT[:300], 0.1, 1, 1),
        "averaging": averaging_study(T, HEIGHT, (1, 256)),
        "calibration": Calibration(three, three, three, three, three, three, 8, 0.02),
        "experiment": Result(EVIL, EVIL, (EVIL,), (line,), (EVIL,)),
        "lag": BarometerLag(0.07, (0.06, 0.08), 45.0, 1.0),
        "imu": ba.ImuNoise.of_device("simple"),
    }


@pytest.fixture(scope="module")
def shown():
    return results()


KINDS = (
    "recording", "identification", "refused", "noise model", "arma", "whitening", "track", "comparison",
    "prediction", "tuning", "windows", "orders", "averaging", "calibration", "experiment", "lag", "imu",
)  # fmt: skip
WITHOUT_NAMES = ("arma", "orders", "averaging", "calibration", "lag", "imu")


def parsed(html):
    return ElementTree.fromstring(f"<body>{html}</body>")


@pytest.mark.parametrize("kind", KINDS)
def test_the_html_is_well_formed_and_shows_what_files_say_as_text(shown, kind):
    page = parsed(shown[kind]._repr_html_())
    assert page.find(".//script") is None
    assert page.find(".//img") is None
    if kind not in WITHOUT_NAMES:
        assert "<script>alert(1)</script>" in "".join(page.itertext())


@pytest.mark.parametrize("kind", KINDS)
def test_every_row_of_a_table_has_the_cells_of_its_head(shown, kind):
    for table in parsed(shown[kind]._repr_html_()).iter("table"):
        head = len(table.findall("thead/tr/th"))
        assert table.findall("tbody/tr")
        for row in table.findall("tbody/tr"):
            assert len(list(row)) == head


@pytest.mark.parametrize("kind", KINDS)
def test_the_repr_is_one_line_and_the_summary_is_text(shown, kind):
    assert "\n" not in repr(shown[kind])
    assert isinstance(shown[kind].summary(), str)


def test_the_tables_take_the_notebooks_own_colours(shown):
    html = shown["comparison"]._repr_html_()
    assert not re.search(r'\b(style|bgcolor|color)="', html)
    named = re.findall(r"(?<![-\w])(color|background(?:-color)?):\s*([^;}]+)", STYLE)
    assert {value.strip() for _, value in named} <= {"inherit", "transparent"}


def test_the_lines_of_the_tables_are_seen_on_white_and_on_black():
    # grey 128 at 40 %: 0.4 * 128 on black, 0.6 * 255 + 0.4 * 128 on white
    alpha = float(re.search(r"rgba\(128, 128, 128, ([\d.]+)\)", STYLE).group(1))
    on_black, on_white = alpha * 128, (1 - alpha) * 255 + alpha * 128
    assert on_black > 40  # faint, as lines of tables should be, but not gone
    assert on_white < 215


def test_units_stand_with_the_numbers(shown):
    units = {
        "recording": ("hPa", "m/s²", "Hz"),
        "noise model": ("m/√s", " s", " m"),
        "whitening": ("Hz",),
        "track": (" m", "m/s"),
        "comparison": ("height RMSE (m)", "velocity RMSE (m/s)", "time (us/sample)"),
        "prediction": ("height (m)", "velocity (m/s)"),
        "calibration": ("offset (m/s²)", "bias (°/s)"),
        "imu": ("m/s²/√Hz", "rad/s/√Hz"),
    }
    for kind, expected in units.items():
        text = "".join(parsed(shown[kind]._repr_html_()).itertext())
        assert all(unit in text for unit in expected), kind


def test_a_comparison_says_below_why_a_preset_was_refused(shown):
    scores, _, more = parsed(shown["comparison"]._repr_html_()).iter("table")
    cells = [["".join(cell.itertext()) for cell in row] for row in scores.findall("tbody/tr")]
    assert cells[1] == ["b", "-", "-", "-", "-", "-"]
    reasons = [["".join(cell.itertext()) for cell in row] for row in more.findall("tbody/tr")]
    assert reasons[0] == ["b", EVIL]


def test_no_findings_and_no_notes_make_no_table():
    assert about(()) == ()
    assert remarks([]) == ()
    assert [table.rows for table in about([NOTE])] == [(("warning (gaps)", EVIL),)]


def test_numbers_that_are_not_there_are_dashes():
    assert [number(v) for v in (None, float("nan"), 0.0, 1.0)] == ["–", "–", "0", "1"]


def test_several_tables_share_one_frame():
    one = Table(("what", "value"), (("a", "1"),))
    page = parsed(tables(one, one))
    assert len(page.findall("div[@class='baroarma']")) == 1
    assert len(list(page.iter("table"))) == 2
