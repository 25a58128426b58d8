"""The bake-off: presets, and others' tracks, on one recording, against its reference if it has one."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from baroarma.finding import Finding
from baroarma.metrics import Errors, errors, estimate_reference_lag
from baroarma.noise_model import NoiseModel
from baroarma.presets import PRESETS
from baroarma.recording import Recording
from baroarma.track import Track
from baroarma.tracker import Tracker

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

NOTICEABLE_LAG: Final = 0.03
"""A reference that is late by less (s) is not worth a word: about one sample of a laser."""
TRACK_COLUMNS: Final = ("time_s", "height_m", "velocity_m_s", "height_sd_m", "velocity_sd_m_s")
"""Columns of ``track.csv``."""
LARGEST: Final = 1e12
"""No time in s, height in m or velocity in m/s of a track."""
CLOCK: Final = 1e-3
"""By how much another program may round the recording's times, s."""
_HEADS: Final = ("height RMSE m", "velocity RMSE m/s", "height bias m", "closure m", "time us/sample")


@dataclass(frozen=True)
class Row:
    """Hold what one preset did, or another program.

    Parameters
    ----------
    preset : str
        Its name, or the track's.
    track : Track or None
        What it made; None when it could not, and `refusal` says why.
    errors : Errors or None
        Against the reference.
    us_per_sample : float or None
        Time of a second run (compiled) per row, microseconds; None for a track made elsewhere.
    refusal : str
        Why there is no track.

    Examples
    --------
    Where a preset can't, its row says why, and the others go on:

    >>> from baroarma.simulation import BMP085, simulate
    >>> rest = simulate("rest", duration=10, seed=1)
    >>> blind = replace(rest, accel=None, gyro=None)
    >>> row, ours = compare(blind, presets=("sg14-a", "baroarma"), noise=BMP085.noise).rows
    >>> row.refusal
    'rest has no accelerometer and gyro, which the preset sg14-a needs; ...'
    >>> len(ours.track)
    500
    """

    preset: str
    track: Track | None
    errors: Errors | None
    us_per_sample: float | None
    refusal: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return the row of the documented JSON."""
        e = self.errors or Errors(None, None, None, float("nan"))
        return {
            "preset": self.preset,
            "height_rmse_m": e.height_rmse,
            "velocity_rmse_m_s": e.velocity_rmse,
            "height_bias_m": e.height_bias,
            "closure_m": None if self.errors is None else e.closure,
            "us_per_sample": self.us_per_sample,
            "refusal": self.refusal or None,
        }


@dataclass(frozen=True, repr=False)
class Comparison:
    """Hold the rows of a bake-off.

    Parameters
    ----------
    recording : Recording
        What was tracked.
    rows : tuple of Row
        One per preset.
    reference_lag : float
        By how much the reference was shifted back, s.
    findings : tuple of Finding
        What to know, such as a reference that is late.

    Examples
    --------
    >>> from baroarma.simulation import BMP085, simulate
    >>> squats = simulate("squat", duration=30, seed=1)
    >>> table = compare(squats, presets=("sg14-a", "sg14-b", "baroarma"), noise=BMP085.noise)
    >>> min(table.rows, key=lambda row: row.errors.velocity_rmse).preset
    'baroarma'
    >>> list(table.to_frame().columns[:3])
    ['preset', 'height_rmse_m', 'velocity_rmse_m_s']
    """

    recording: Recording
    rows: tuple[Row, ...]
    reference_lag: float
    findings: tuple[Finding, ...] = ()

    def __repr__(self) -> str:
        return f"<Comparison on {self.recording.name!r}: {', '.join(row.preset for row in self.rows)}>"

    def to_dict(self) -> dict[str, Any]:
        """Return the documented JSON object."""
        return {
            "recording": self.recording.name,
            "reference_lag_s": self.reference_lag,
            "rows": [
                {**row.to_dict(), "findings": [f.to_dict() for f in self.about(row)]} for row in self.rows
            ],
            "findings": [finding.to_dict() for finding in (*self.recording.notes, *self.findings)],
        }

    def summary(self) -> str:
        """Return the table as text."""
        lines = [f"{self.recording.name}: {len(self.recording)} rows over {self.recording.duration:.4g} s"]
        width = max(len("preset"), *(len(row.preset) for row in self.rows))
        lines.append("  ".join(["preset".ljust(width), *_HEADS]))
        lines += [f"{row.preset.ljust(width)}  {_cells(row)}" for row in self.rows]
        lines += [f"  {finding}" for finding in (*self.recording.notes, *self.findings)]
        lines += [f"  {row.preset}: {finding}" for row in self.rows for finding in self.about(row)]
        return "\n".join(lines)

    def about(self, row: Row) -> tuple[Finding, ...]:
        """Return what to know about one row alone: without the recording's notes, which hold for all."""
        found = row.track.findings if row.track else ()
        return tuple(f for f in found if f not in self.recording.notes)

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        from baroarma.notebook import about, tables
        from baroarma.page import Table

        name = self.recording.name or "Recording"
        caption = f"{name}: {len(self.recording)} rows over {self.recording.duration:.4g} s"
        head = ("preset", *(_in_brackets(text) for text in _HEADS))
        shown = Table(head, tuple((row.preset, *_values(row)) for row in self.rows), caption)
        of_rows = [(row.preset, row.refusal) for row in self.rows if row.refusal]
        of_rows += [(row.preset, str(finding)) for row in self.rows for finding in self.about(row)]
        more = (Table(("preset", "what to know"), tuple(of_rows)),) if of_rows else ()
        return tables(shown, *about((*self.recording.notes, *self.findings)), *more)

    def to_frame(self) -> pd.DataFrame:
        """Return the table as a pandas DataFrame."""
        import pandas as pd

        return pd.DataFrame([row.to_dict() for row in self.rows])

    def plot(self) -> Figure:
        """Draw traces and bars; see `baroarma.plotting.plot_comparison`."""
        from baroarma.plotting import plot_comparison

        return plot_comparison(self)


def _cells(row: Row) -> str:
    if row.errors is None:
        return row.refusal
    return "  ".join(text.rjust(len(head)) for text, head in zip(_values(row), _HEADS, strict=True))


def _values(row: Row) -> tuple[str, ...]:
    e = row.errors or Errors(None, None, None, float("nan"))
    closure = None if row.errors is None else e.closure
    values = (e.height_rmse, e.velocity_rmse, e.height_bias, closure, row.us_per_sample)
    return tuple("-" if value is None else f"{value:.3f}" for value in values)


def _in_brackets(head: str) -> str:
    quantity, _, unit = head.rpartition(" ")
    return f"{quantity} ({unit})"


def compare(
    recording: Recording,
    *,
    presets: Sequence[str] | None = None,
    noise: NoiseModel | None = None,
    reference_lag: float = 0.0,
    tracks: Sequence[Track] = (),
) -> Comparison:
    """Run several presets on one recording.

    Parameters
    ----------
    recording : Recording
        What to track.
    presets : sequence of str or str, optional
        Names of presets, or the name of one; default: all.
    noise : NoiseModel, optional
        The barometer's noise.
    reference_lag : float
        How late the reference is, s; errors are taken against the reference shifted back by so much.
    tracks : sequence of Track
        What other programs made of the same recording, such as exported firmware; see `read_track`.

    Returns
    -------
    Comparison
        With a row per preset and one per track, which says how near it is to the nearest preset, and a
        finding when the reference seems to be late by another lag.

    Raises
    ------
    ValueError
        For an unknown preset or none, and for a track of another recording's times.

    Examples
    --------
    >>> from baroarma.simulation import BMP085, simulate
    >>> squats = simulate("squat", duration=30, seed=1)
    >>> [row.preset for row in compare(squats, presets=("sg14-a", "baroarma"), noise=BMP085.noise).rows]
    ['sg14-a', 'baroarma']
    """
    names = tuple(PRESETS) if presets is None else (presets,) if isinstance(presets, str) else tuple(presets)
    if not names:
        raise ValueError(f"there is nothing to compare; name some of {', '.join(PRESETS)}")
    trackers = [Tracker.preset(name, noise=noise) for name in names]
    rows = tuple(_row(tracker, recording, reference_lag) for tracker in trackers)
    given = tuple(_given_row(track, recording, rows, reference_lag) for track in tracks)
    return Comparison(recording, (*rows, *given), reference_lag, _late(rows, recording, reference_lag))


def read_track(path: str | os.PathLike[str]) -> Track:
    r"""Read a track that another program wrote with the columns of ``track.csv``; its name is the file's.

    The acceleration, which isn't in the file, is the velocity's derivative.

    Parameters
    ----------
    path : str or path
        The file.

    Raises
    ------
    ValueError
        If a column is missing, a value is no number, or there are fewer than two rows; the message names the
        file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "mcu.csv")
    ...     with open(path, "w") as file:
    ...         _ = file.write("time_s,height_m,velocity_m_s,height_sd_m,velocity_sd_m_s\n")
    ...         _ = file.write("0.00,0,0,0.1,0.1\n0.02,0.01,0.5,0.1,0.1\n")
    ...     read_track(path)
    <Track of '' by mcu.csv: 2 rows, 0 to 0.01 m>
    """
    import pandas as pd

    try:
        frame = pd.read_csv(path)
        t, height, velocity, *sds = (frame[name].to_numpy(float) for name in TRACK_COLUMNS)
    except KeyError as error:
        raise ValueError(
            f"{path}: there is no column {error}; a track has {', '.join(TRACK_COLUMNS)}"
        ) from error
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError, ValueError) as error:
        raise ValueError(f"{path}: this is no track: {error}") from error
    good = (np.abs(np.array([t, height, velocity, *sds])) < LARGEST).all(axis=0)
    if not good.all():
        raise ValueError(
            f"{path}, row {int(np.argmin(good)) + 1}: a track needs a finite number in each column"
        )
    if len(t) < 2 or not (np.diff(t) > 0).all():
        raise ValueError(
            f"{path}: a track needs two rows or more whose times increase, but it has {len(t)} rows"
        )
    try:
        acceleration = np.gradient(velocity, t)
        return Track(t, height, velocity, sds[0], sds[1], acceleration, preset=Path(path).name)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _given_row(track: Track, recording: Recording, rows: tuple[Row, ...], reference_lag: float) -> Row:
    """Return the row of a track made elsewhere, with how near it is to the nearest preset."""
    span, known = (track.t[0], track.t[-1]), (recording.t[0], recording.t[-1])
    if span[0] < known[0] - CLOCK or span[1] > known[1] + CLOCK:
        raise ValueError(
            f"{track.preset}: its times run from {span[0]:g} to {span[1]:g} s, those of {recording.name} "
            f"from {known[0]:g} to {known[1]:g} s; is it the track of another recording?"
        )
    nearness = _nearness(track, [row.track for row in rows if row.track is not None])
    track = replace(track, name=recording.name, findings=(*track.findings, *nearness))
    return Row(track.preset, track, errors(track, recording, reference_lag=reference_lag), None)


def _nearness(track: Track, others: list[Track]) -> tuple[Finding, ...]:
    apart = []
    for other in others:
        height, velocity = (np.interp(track.t, other.t, column) for column in (other.height, other.velocity))
        off = np.abs(track.height - height).max(), np.abs(track.velocity - velocity).max()
        apart.append((*map(float, off), other.preset))
    if not apart:
        return ()
    height_off, velocity_off, preset = min(apart)
    message = f"It is nearest to {preset}: at most {height_off:.2g} m and {velocity_off:.2g} m/s apart."
    return (Finding("nearest-preset", "info", message),)


def _row(tracker: Tracker, recording: Recording, reference_lag: float) -> Row:
    name = tracker.settings.name
    try:
        tracker.run(recording)  # compiles
        start = time.perf_counter()
        track = tracker.run(recording)
        elapsed = time.perf_counter() - start
    except ValueError as error:
        return Row(name, None, None, None, str(error))
    found = errors(track, recording, reference_lag=reference_lag)
    return Row(name, track, found, 1e6 * elapsed / len(recording))


def _late(rows: tuple[Row, ...], recording: Recording, reference_lag: float) -> tuple[Finding, ...]:
    """Say when the reference is late, by the median over the presets that can tell."""
    tracks = [row.track for row in rows if row.track is not None and recording.accel is not None]
    # a whitened barometer shifts the phase of slow motion, which would look like a lag
    tracks = [track for track in tracks if "dc-gain" not in {finding.code for finding in track.findings}]
    lags = [lag for track in tracks if (lag := estimate_reference_lag(track, recording)) is not None]
    if not lags or abs(statistics.median(lags) - reference_lag) < NOTICEABLE_LAG:
        return ()
    lag = statistics.median(lags)
    message = (
        f"The reference seems to be {lag:.2f} s late against the IMU, and {reference_lag:.2f} s is accounted "
        f"for; errors with reference_lag={lag:.2f} would be fairer."
    )
    return (Finding("reference-lag", "warning", message),)
