"""What signals say: their samples, rates and ranges."""

import numpy as np

from baroarma import Recording
from baroarma.signal_table import signal_rows, track_table
from baroarma.track import Track

T = np.arange(5) * 0.1
NAN = float("nan")


def test_each_signal_has_its_own_rate_and_range():
    accel = np.tile([0.0, 3.0, 4.0], (5, 1))
    rec = Recording(
        t=T, pressure=[1e5, NAN, 1.001e5, NAN, 1e5], accel=accel, temperature=[20, 21, 22, 23, 24]
    )
    assert signal_rows(rec) == [
        ("pressure", "3", "5 Hz", "1000.00 to 1001.00 hPa"),
        ("specific force (modulus)", "5", "10 Hz", "5.00 to 5.00 m/s²"),
        ("temperature", "5", "10 Hz", "20.0 to 24.0 °C"),
    ]


def test_a_signal_without_samples_has_dashes():
    assert signal_rows(Recording(t=T, pressure=np.full(5, NAN))) == [("pressure", "0", "–", "–")]
    assert signal_rows(Recording(t=[], pressure=[])) == [("pressure", "0", "–", "–")]


def test_the_summary_of_a_recording_holds_a_line_per_signal_and_its_notes():
    from baroarma.finding import Finding

    rec = Recording(t=T, pressure=np.full(5, 1e5), notes=(Finding("gaps", "info", "One."),))
    lines = rec.summary().splitlines()
    assert lines[0] == repr(rec)
    assert lines[2].split()[:4] == ["pressure", "5", "10", "Hz"]
    assert lines[-1] == "  info (gaps): One."


def test_a_track_tells_range_and_end_with_sd():
    height = np.array([0.0, 2.0, -1.0, 0.5, 1.0])
    track = Track(T, height, height, np.full(5, 0.25), np.full(5, 0.5), height, preset="p", name="n")
    table = track_table(track)
    assert table.caption == "n by p: 5 rows over 0.4 s"
    assert table.rows[0] == ("height", "-1.000 to 2.000 m", "1.000 ± 0.25 m")


def test_an_empty_track_has_no_rows():
    none = np.empty(0)
    assert track_table(Track(none, none, none, none, none, none)).rows == ()
