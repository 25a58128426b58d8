"""The catalogue of wrong contents: each fault is made in a file, read, tracked or identified, and is named.

`docs/faults.md` shows the sentences; the last test compares the page with what is said.
"""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest

import baroarma as ba
from baroarma.atmosphere import STANDARD_GRAVITY, altitude_pressure
from baroarma.cli import main
from baroarma.formats import UnreadableError, write_csv
from baroarma.simulation import BMP085, simulate

Frame = pd.DataFrame
ROOT = Path(__file__).resolve().parents[2]
ACC = ["acc_x_m_s2", "acc_y_m_s2", "acc_z_m_s2"]
GYR = ["gyr_x_rad_s", "gyr_y_rad_s", "gyr_z_rad_s"]
COUNTS = 2**32
WRAPPING = [("time_us", 1e6, 0), ("time_ms", 1e3, -(2**31)), ("time_s", 1e6, 0)]
"""Columns of a counter, its counts per second, its lowest count."""


@pytest.fixture(scope="module")
def logs(tmp_path_factory) -> Mapping[str, Frame]:
    """Honest logs as tables: gy-87's tilts and climbs of Lee16, squats, a rest with and without IMU."""
    folder, found = tmp_path_factory.mktemp("honest"), {}
    for name, log in {
        "tilts": simulate("lee16-e", duration=45, seed=1),
        "squats": simulate("squat", duration=60, seed=1),
        "climbs": simulate("lee16-c", duration=45, seed=1),
        "rest": simulate("rest", duration=60, seed=1),
        "barometer": simulate("rest", duration=60, imu=None, seed=1),
    }.items():
        write_csv(log, path := folder / f"{name}.csv")
        found[name] = pd.read_csv(path)
    return found


class Fault(NamedTuple):
    """Which log is broken, how, and what is noticed; severity "refused": it can't be read."""

    name: str
    log: str
    broken: Callable[[Frame], Frame]
    code: str
    says: str
    severity: str = "warning"

    def write(self, logs: Mapping[str, Frame], path: Path) -> Path:
        """Write the broken log."""
        self.broken(logs[self.log].copy()).to_csv(path, index=False)
        return path


def times(change: Callable[[pd.Series], pd.Series]) -> Callable[[Frame], Frame]:
    """Change the times."""
    return lambda f: f.assign(time_s=change(f.time_s))


def scaled(columns: list[str], factor: float) -> Callable[[Frame], Frame]:
    """Multiply columns, or signs."""
    return lambda f: f.assign(**{column: f[column] * factor for column in columns})


def taken_from(columns: list[str], signs: tuple[int, int, int], order: tuple[int, int, int]):
    """Exchange and flip axes."""
    return lambda f: f.assign(
        **{column: sign * f[columns[k]] for column, sign, k in zip(columns, signs, order, strict=True)}
    )


def put(column: str, rows: slice, value: float) -> Callable[[Frame], Frame]:
    """Write a value into some rows."""

    def broken(f: Frame) -> Frame:
        f[column] = f[column].astype(float)
        f.iloc[rows, f.columns.get_loc(column)] = value
        return f

    return broken


def clipped(columns: list[str], limit: float) -> Callable[[Frame], Frame]:
    """Saturate columns."""
    return lambda f: f.assign(**{column: f[column].clip(-limit, limit) for column in columns})


def shaken(f: Frame) -> Frame:
    """Return a log with swings of 3 g along x, and turns of 6 rad/s about y, for ten seconds."""
    swing = np.where((f.time_s > 20) & (f.time_s < 30), np.sin(7 * f.time_s), 0.0)
    return f.assign(acc_x_m_s2=f.acc_x_m_s2 + 30 * swing, gyr_y_rad_s=f.gyr_y_rad_s + 6 * swing)


def moved(columns: list[str], rows: int) -> Callable[[Frame], Frame]:
    """Let columns come some rows later than the others."""
    return lambda f: f.assign(**{column: np.roll(f[column], rows) for column in columns})


def height(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Frame], Frame]:
    """Change the barometric height above the first one."""

    def broken(f: Frame) -> Frame:
        h = (1 - (f.pressure_pa / 101325.0) ** 0.190263) * 44330.77
        return f.assign(pressure_pa=altitude_pressure(100 + change((h - h[0]).to_numpy())))

    return broken


def slow_clock(f: Frame) -> Frame:
    """Let the barometer's stamps run 5 % slow: its readings come later and later in the rows."""
    rows = (np.arange(len(f)) / 1.05).astype(int)
    return f.assign(pressure_pa=f.pressure_pa.to_numpy()[rows])


def without(columns: list[str], start: float, stop: float) -> Callable[[Frame], Frame]:
    """Blank cells between two times."""
    return lambda f: f.assign(
        **{column: f[column].mask((f.time_s > start) & (f.time_s < stop)) for column in columns}
    )


PRESSURE = ["pressure_pa"]
FAULTS = [
    Fault(
        "time runs backwards",
        "squats",
        times(lambda t: t.where(t.index != 700, 1.0)),
        "",
        "runs backwards",
        "refused",
    ),
    Fault("time stands still", "squats", times(lambda t: (5 * t).round() / 5), "", "stands still", "refused"),
    Fault(
        "time is missing",
        "squats",
        times(lambda t: t.mask(t.index == 700)),
        "",
        "the time is missing",
        "refused",
    ),
    Fault("ms under the label s", "squats", times(lambda t: t * 1e3), "units", "slow for an IMU"),
    Fault("us under the label s", "squats", times(lambda t: t * 1e6), "units", "slow for an IMU"),
    Fault("ms, barometer alone", "barometer", times(lambda t: t * 1e3), "units", "slow for a barometer"),
    Fault(
        "ms since 1970",
        "squats",
        times(lambda t: 1.7e12 + 1e3 * t),
        "units",
        "look like ms, us or ns",
        "error",
    ),
    Fault("hPa (mbar)", "squats", scaled(PRESSURE, 1e-2), "units", "name the column pressure_hpa", "error"),
    Fault("kPa", "squats", scaled(PRESSURE, 1e-3), "units", "look like kPa", "error"),
    Fault("inHg", "squats", scaled(PRESSURE, 1 / 3386.39), "units", "inches of mercury", "error"),
    Fault("psi", "squats", scaled(PRESSURE, 1 / 6894.76), "units", "look like psi", "error"),
    Fault("bar", "squats", scaled(PRESSURE, 1e-5), "units", "look like bar", "error"),
    Fault(
        "Pa under the label hPa",
        "squats",
        lambda f: f.rename(columns={"pressure_pa": "pressure_hpa"}),
        "units",
        "Pa under the label hPa",
        "error",
    ),
    Fault(
        "a gauge's pressure",
        "barometer",
        lambda f: f.assign(pressure_pa=f.pressure_pa - f.pressure_pa.min() + 5),
        "units",
        "may be a gauge",
        "error",
    ),
    Fault(
        "a gauge below its zero",
        "barometer",
        lambda f: f.assign(pressure_pa=f.pressure_pa - f.pressure_pa.mean()),
        "",
        "readable is above 0",
        "refused",
    ),
    Fault("height in feet", "climbs", height(lambda h: h / 0.3048), "units", "look like feet"),
    Fault("height counted downwards", "climbs", height(np.negative), "axes", "counts the other way"),
    Fault(
        "g under the label m/s²",
        "squats",
        scaled(ACC, 1 / STANDARD_GRAVITY),
        "units",
        "g under the label m/s²",
    ),
    Fault(
        "m/s² under the label g", "squats", scaled(ACC, STANDARD_GRAVITY), "units", "m/s² under the label g"
    ),
    Fault(
        "gravity taken out",
        "rest",
        lambda f: f.assign(**{c: f[c] - f[c].mean() for c in ACC}),
        "units",
        "gravity seems to have been taken out",
    ),
    Fault(
        "deg/s under the label rad/s",
        "tilts",
        scaled(GYR, 180 / np.pi),
        "units",
        "deg/s under the label rad/s",
    ),
    Fault(
        "rad/s under the label deg/s",
        "tilts",
        scaled(GYR, np.pi / 180),
        "units",
        "rad/s under the label deg/s",
    ),
    Fault("gyro with its sign flipped", "tilts", scaled(GYR, -1.0), "axes", "are read as (-x, -y, -z)"),
    Fault("one axis of the gyro flipped", "tilts", scaled(GYR[:1], -1.0), "axes", "are read as (-x, y, z)"),
    Fault(
        "two axes of the gyro exchanged",
        "tilts",
        taken_from(GYR, (1, 1, 1), (1, 0, 2)),
        "axes",
        "are read as (y, x, z)",
    ),
    Fault(
        "one axis of the accelerometer flipped",
        "tilts",
        scaled(ACC[2:], -1.0),
        "axes",
        "or the accelerometer's as (x, y, -z)",
    ),
    Fault(
        "two axes of the accelerometer exchanged, one flipped",
        "tilts",
        taken_from(ACC, (-1, 1, 1), (1, 0, 2)),
        "axes",
        "or the accelerometer's as (y, -x, z)",
    ),
    Fault(
        "gyro and accelerometer on two clocks",
        "tilts",
        moved(GYR, 80),
        "clocks",
        "The gyro comes about 1.6 s after",
    ),
    Fault(
        "gyro and accelerometer of two recordings",
        "tilts",
        lambda f: f.assign(**{c: f[c].to_numpy()[::-1] for c in GYR}),
        "clocks",
        "put both on one clock",
    ),
    Fault(
        "barometer and accelerometer on two clocks",
        "climbs",
        moved(PRESSURE, 50),
        "clocks",
        "the barometer comes about 1",
    ),
    Fault("barometer's clock runs slow", "climbs", slow_clock, "clocks", "s after the accelerometer"),
    Fault(
        "a spike",
        "squats",
        put("pressure_pa", slice(700, 701), 45_000.0),
        "spikes",
        "has 1 spike, 1 reading in",
    ),
    Fault(
        "a burst",
        "squats",
        put("pressure_pa", slice(700, 730), 110_000.0),
        "spikes",
        "has 1 spike, 30 readings",
    ),
    Fault(
        "a spike of the accelerometer",
        "squats",
        put(ACC[1], slice(700, 701), 1e5),
        "spikes",
        "The specific force has spikes in 1 row,",
    ),
    Fault(
        "a spike of the gyro",
        "squats",
        put(GYR[1], slice(700, 701), 2e3),
        "spikes",
        "The angular rate has spikes in 1 row,",
    ),
    Fault(
        "a constant pressure",
        "squats",
        put("pressure_pa", slice(None), 101_325.0),
        "dead",
        "never changes from 101325 Pa",
    ),
    Fault(
        "a barometer that hung",
        "barometer",
        put("pressure_pa", slice(1000, 2500), 101_000.0),
        "dead",
        "stands still for 29.98 s",
    ),
    Fault(
        "an axis of the accelerometer that hung",
        "tilts",
        put(ACC[0], slice(1000, None), 0.5),
        "stuck",
        "The accelerometer's x stands still",
    ),
    Fault(
        "a gyro that hung",
        "tilts",
        lambda f: f.assign(**dict.fromkeys(GYR, 0.0)),
        "stuck",
        "The gyro's x, y, z stand still",
    ),
    Fault(
        "accelerometer beyond ±2 g",
        "squats",
        lambda f: clipped(ACC, 2 * STANDARD_GRAVITY)(shaken(f)),
        "saturation",
        "the end of its range (2 g)",
    ),
    Fault(
        "gyro beyond ±250 °/s",
        "squats",
        lambda f: clipped(GYR, np.deg2rad(250))(shaken(f)),
        "saturation",
        "the end of its range (250 °/s)",
    ),
    Fault(
        "gyro beyond an unknown range",
        "squats",
        lambda f: clipped(GYR, 3.3)(shaken(f)),
        "saturation",
        "the end of its range, in",
    ),
    Fault(
        "an absurd temperature",
        "squats",
        lambda f: f.assign(temperature_c=295.0),
        "units",
        "looks like kelvin",
        "info",
    ),
]
NO_GRAVITY = ("g under the label m/s²", "gravity taken out")
"""What no alignment can start from."""
UNREADABLE = [fault for fault in FAULTS if fault.severity == "refused"]
READABLE = [fault for fault in FAULTS if fault.severity != "refused"]


def by_name(fault: Fault) -> str:
    return fault.name


@pytest.mark.parametrize("log", ["tilts", "squats", "climbs", "rest", "barometer"])
def test_honest_logs_have_nothing_to_be_told(logs, log, tmp_path):
    logs[log].to_csv(path := tmp_path / "log.csv", index=False)
    assert ba.read(path).notes == ()


@pytest.mark.parametrize("fault", UNREADABLE, ids=by_name)
def test_what_can_not_be_read_is_refused_with_line_and_cure(fault, logs, tmp_path, capsys):
    path = fault.write(logs, tmp_path / "log.csv")
    with pytest.raises(UnreadableError, match=fault.says) as refused:
        ba.read(path)
    assert re.search(r"log\.csv, line \d+: ", str(refused.value))
    for command in (["track"], ["identify"], ["compare"], ["convert"]):
        out = [str(tmp_path / "new.csv")] if command == ["convert"] else []
        assert main([*command, str(path), *out]) == 2
        assert str(refused.value) in capsys.readouterr().err


@pytest.mark.parametrize("fault", READABLE, ids=by_name)
def test_what_can_be_read_carries_the_fault_into_the_track(fault, logs, tmp_path):
    log = ba.read(fault.write(logs, tmp_path / "log.csv"))
    assert [(note.code, note.severity) for note in log.notes] == [(fault.code, fault.severity)]
    assert fault.says in log.notes[0].message
    tracker = ba.Tracker(noise=BMP085.noise)
    if fault.severity == "error":
        with pytest.raises(ValueError, match=re.escape(log.notes[0].message)):
            tracker.run(log)
    elif fault.name in NO_GRAVITY:
        with pytest.raises(ValueError, match="must be in m/s² and at rest, with gravity not removed"):
            tracker.run(log)
    else:
        track = tracker.run(log)
        assert (log.notes[0] in track.findings) == (fault.severity == "warning")
        assert np.isfinite([track.height, track.velocity, track.height_sd, track.velocity_sd]).all()


@pytest.mark.parametrize("fault", {fault.code: fault for fault in READABLE}.values(), ids=by_name)
def test_the_command_tells_it_and_writes_no_nan(fault, logs, tmp_path, capsys):
    path, out = fault.write(logs, tmp_path / "log.csv"), tmp_path / "track.csv"
    BMP085.noise.save(tmp_path / "noise.json")
    assert main(["track", str(path), "--noise", str(tmp_path / "noise.json"), "--out", str(out)]) == 0
    assert (fault.says in capsys.readouterr().err) == (fault.severity == "warning")
    assert np.isfinite(pd.read_csv(out).to_numpy()).all()


@pytest.mark.parametrize(
    "name", ["a constant pressure", "a barometer that hung", "hPa (mbar)", "ms since 1970"]
)
def test_no_noise_model_comes_of_what_is_no_pressure_or_no_time(name, logs, tmp_path, capsys):
    fault = next(fault for fault in FAULTS if fault.name == name)._replace(log="barometer")
    path, out = fault.write(logs, tmp_path / "log.csv"), tmp_path / "noise.json"
    found = ba.identify(ba.read(path))
    assert found.model is None
    assert [(f.code, f.severity) for f in found.verdict] == [(fault.code, "error")]
    assert main(["identify", str(path), "--out", str(out)]) == 1
    assert fault.says in capsys.readouterr().err
    assert not out.exists()


def test_a_noise_model_survives_spikes(logs, tmp_path):
    logs["barometer"].to_csv(path := tmp_path / "honest.csv", index=False)
    honest = ba.identify(ba.read(path))
    spoilt = logs["barometer"].copy()
    for row in (300, 900, 1500, 1501):
        spoilt.loc[row, "pressure_pa"] += 5_000.0
    spoilt.to_csv(path := tmp_path / "log.csv", index=False)
    found = ba.identify(ba.read(path))
    assert "spikes" in {finding.code for finding in found.verdict}
    for term in ("white_sd", "correlated_sd", "drift_rate"):  # 4 of 3000 samples less
        assert getattr(found.model, term) == pytest.approx(getattr(honest.model, term), rel=0.05, abs=1e-3)


@pytest.mark.parametrize(
    "name", ["a spike", "a burst", "a spike of the gyro", "a spike of the accelerometer"]
)
def test_a_track_survives_spikes(name, logs, tmp_path):
    fault = next(fault for fault in FAULTS if fault.name == name)
    logs["squats"].to_csv(honest := tmp_path / "honest.csv", index=False)
    tracker = ba.Tracker(noise=BMP085.noise)
    true, found = tracker.run(ba.read(honest)), tracker.run(ba.read(fault.write(logs, tmp_path / "log.csv")))
    # with the bad samples left out instead of believed, both tracks are within their own sds of each other
    apart = np.abs(found.height - true.height) / np.hypot(found.height_sd, true.height_sd)
    assert apart.max() < 1.0


def test_a_sign_that_all_axes_of_the_accelerometer_share_does_not_matter(logs, tmp_path):
    """A flipped accelerometer can't be told, and needn't be: up is where it points at rest."""
    logs["tilts"].to_csv(honest := tmp_path / "honest.csv", index=False)
    scaled(ACC, -1.0)(logs["tilts"].copy()).to_csv(flipped := tmp_path / "flipped.csv", index=False)
    for preset in ("baroarma", "lee16-kf"):
        tracker = ba.Tracker.preset(preset, noise=BMP085.noise)
        one, other = tracker.run(ba.read(honest)), tracker.run(ba.read(flipped))
        np.testing.assert_allclose(other.height, one.height, rtol=0, atol=1e-9)  # rounding, over 2250 steps


def test_seconds_since_1970_are_as_good_as_any(logs, tmp_path):
    logs["squats"].to_csv(since_start := tmp_path / "a.csv", index=False)
    # at 1.7e9 s a double has steps of 2.4e-7 s
    times(lambda t: 1.7e9 + t)(logs["squats"].copy()).to_csv(since_1970 := tmp_path / "b.csv", index=False)
    tracker = ba.Tracker(noise=BMP085.noise)
    one, other = tracker.run(ba.read(since_start)), tracker.run(ba.read(since_1970))
    assert other.findings == one.findings
    np.testing.assert_allclose(other.height, one.height, rtol=0, atol=1e-4)


@pytest.mark.parametrize(("name", "per_second"), [("time_ms", 1e3), ("time_us", 1e6), ("timestamp_us", 1e6)])
def test_a_time_whose_name_tells_its_unit_is_read(name, per_second, logs, tmp_path):
    frame = logs["squats"]
    frame.rename(columns={"time_s": name}).assign(**{name: frame.time_s * per_second}).to_csv(
        path := tmp_path / "log.csv", index=False
    )
    log = ba.read(path)
    assert log.notes == ()
    np.testing.assert_allclose(log.t, frame.time_s, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "per_second", "begin"), [("time_us", 1e6, 0), ("time_ms", 1e3, -(2**31)), ("time_s", 1e6, 0)]
)
def test_a_counter_of_32_bits_is_counted_on(name, per_second, begin, logs, tmp_path):
    frame = logs["squats"]
    counts = (COUNTS - 30 * per_second + frame.time_s * per_second).round() % COUNTS + begin
    values = counts if name != "time_s" else counts / per_second
    frame.rename(columns={"time_s": name}).assign(**{name: values}).to_csv(
        path := tmp_path / "log.csv", index=False
    )
    log = ba.read(path)
    assert [(note.code, note.severity) for note in log.notes] == [("clocks", "info")]
    np.testing.assert_allclose(np.diff(log.t), 0.02, rtol=0, atol=1e-6)


def test_streams_that_do_not_overlap_are_refused(logs, tmp_path):
    frame = logs["squats"]
    frame[["time_s", "pressure_pa"]].to_csv(baro := tmp_path / "x_baro.csv", index=False)
    other = frame[["time_s", *ACC]].assign(time_s=frame.time_s + 500)
    other.to_csv(acc := tmp_path / "x_acc.csv", index=False)
    with pytest.raises(UnreadableError, match="lie outside the barometer's"):
        ba.read(baro, acc)


def test_streams_of_two_recordings_are_told_apart(logs, tmp_path):
    logs["squats"][["time_s", "pressure_pa"]].to_csv(baro := tmp_path / "x_baro.csv", index=False)
    lift = simulate("lee16-c", duration=45, seed=5)
    pd.DataFrame({"time_s": lift.t, **dict(zip(ACC, lift.accel.T, strict=True))}).to_csv(
        acc := tmp_path / "x_acc.csv", index=False
    )
    (note,) = ba.read(baro, acc).notes
    assert note.code == "clocks"


@pytest.mark.parametrize("seconds", [5.0, 12.0])
def test_a_burst_of_nan_in_the_imu_is_told_with_the_track(seconds, logs, tmp_path):
    without(ACC + GYR, 20, 19.99 + seconds)(logs["squats"].copy()).to_csv(
        path := tmp_path / "log.csv", index=False
    )
    track = ba.Tracker(noise=BMP085.noise).run(ba.read(path))
    (finding,) = [finding for finding in track.findings if finding.code == "gaps"]
    assert f"silent 1 time, longest for {seconds:.3g} s from 20 s on" in finding.message
    assert np.isfinite(track.height).all()


def test_a_burst_of_nan_in_the_pressure_leaves_the_track_within_its_sds(logs, tmp_path):
    without(PRESSURE, 20, 50)(logs["squats"].copy()).to_csv(path := tmp_path / "log.csv", index=False)
    log = ba.read(path)
    track = ba.Tracker(noise=BMP085.noise).run(log)
    z = (track.height - log.reference)[log.t > 20] / track.height_sd[log.t > 20]
    assert np.abs(z).max() < 4.0  # of 2000 dependent values, some 100 of them independent, 1 in 160 has more


def test_too_few_rows_are_told_by_every_command(logs, tmp_path, capsys):
    logs["squats"][:20].to_csv(path := tmp_path / "log.csv", index=False)
    assert len(ba.read(path)) == 20
    told = {"identify": "are too few for a noise model", "track": "all of it needed to align"}
    for command, says in told.items():
        assert main([command, str(path)]) == 1
        assert says in capsys.readouterr().err


def test_the_page_shows_what_the_user_sees(logs, tmp_path):
    """The numbers may differ by machine; every word must be there."""
    page = (ROOT / "docs" / "faults.md").read_text(encoding="utf-8")
    for fault in FAULTS:
        path = fault.write(logs, tmp_path / "log.csv")
        try:
            says = ba.read(path).notes[0].message
        except UnreadableError as error:
            says = str(error).replace(str(path), "log.csv")
        assert f"| {fault.name} | {fault.severity}" in page
        assert without_numbers(says) in without_numbers(page), fault.name


def without_numbers(text: str) -> str:
    return re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", " ".join(text.split()))
