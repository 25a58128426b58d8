"""Long recordings, part by part: from a file to what `identify` needs, or to a file with the track.

A part's rows are forgotten once they are used, so that memory does not grow with the IMU's data: 16 bytes a
row (time and cleaned pressure) stay.  The numbers are those of the whole recording at once.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from itertools import chain
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from baroarma.atomic import replacing
from baroarma.finding import Finding
from baroarma.fitness import imu_gaps, reading_notes
from baroarma.formats.long import LongRecording
from baroarma.recording import Recording
from baroarma.track import Track
from baroarma.tracker import ALIGNMENT, Tracker

StrPath = str | os.PathLike[str]
Progress = Callable[[int, int], None]
"""Is told how many rows are done, and how many there are."""


def read_rest(
    path: StrPath,
    *,
    mapping: Mapping[str, str] | None = None,
    start: float = -math.inf,
    stop: float = math.inf,
) -> Recording:
    """Read of a long file at rest what `identify` needs.

    Parameters
    ----------
    path : str or path
        A ``.parquet``, ``.csv`` or ``.csv.gz`` file.
    mapping, start, stop
        As for `LongRecording`.

    Returns
    -------
    Recording
        The barometer alone; if the IMU moved, the notes say so, and `identify` heeds them.

    Raises
    ------
    UnreadableError
        As `read`.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from baroarma import identify
    >>> from baroarma.formats import write_csv
    >>> from baroarma.simulation import simulate
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_csv(simulate("rest", duration=120, seed=1), Path(folder) / "rest.csv")
    ...     rest = read_rest(Path(folder) / "rest.csv")
    >>> rest  # pressure alone
    <Recording 'rest': 6000 rows, 119.98 s, pressure 6000 samples at 50 Hz>
    >>> identify(rest).ok
    True
    """
    from baroarma.identification.stillness import ImuSeconds

    imu = ImuSeconds()
    rest = LongRecording(path, mapping=mapping, start=start, stop=stop, visit=imu.take).barometer
    return replace(rest, notes=(*rest.notes, *imu.findings(rest.duration)))


@dataclass(frozen=True)
class TrackedFile:
    """Say what stands in a file of a track.

    Parameters
    ----------
    name, preset : str
        What was tracked, and by what.
    rows : int
        How many there are.
    lowest, highest : float
        Least and greatest height, m.
    findings : tuple of Finding
        What to know before believing it.

    Examples
    --------
    A day's track need not fit into memory; this is what stays of it, see `track_file`:

    >>> TrackedFile("day", "baroarma", rows=4_320_000, lowest=-0.5, highest=112.0, findings=())
    <Track of 'day' by baroarma: 4320000 rows, -0.5 to 112 m>
    """

    name: str
    preset: str
    rows: int
    lowest: float
    highest: float
    findings: tuple[Finding, ...]

    def __repr__(self) -> str:
        span = f"{self.lowest:.4g} to {self.highest:.4g} m"
        codes = "".join(f"; {finding.code}" for finding in self.findings)
        return f"<Track of {self.name!r} by {self.preset}: {self.rows} rows, {span}{codes}>"


def track_file(
    tracker: Tracker, log: LongRecording, out: StrPath | TextIO, *, progress: Progress | None = None
) -> TrackedFile:
    """Track a long recording, and write the track while it grows.

    Parameters
    ----------
    tracker : Tracker
        Is reset first.
    log : LongRecording
        What to track.
    out : str, path or text stream
        Gets the columns of ``track.csv`` (Parquet for ``.parquet``).  A file is complete or not there, also
        when the work is interrupted; a stream has the rows tracked so far.
    progress : callable, optional
        Called after each part.

    Returns
    -------
    TrackedFile
        With the findings of `Tracker.run`.

    Raises
    ------
    ValueError
        As `Tracker.run`; and for a preset that works off-line, on whole recordings only.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from baroarma.formats import write_csv
    >>> from baroarma.simulation import simulate
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     log, out = Path(folder) / "day.csv", Path(folder) / "track.csv"
    ...     write_csv(simulate("stairs", duration=20, seed=1), log)
    ...     track_file(Tracker.preset("sg14-a"), LongRecording(log), out).rows
    1000
    """
    if tracker.settings.height is None:
        raise ValueError(f"the preset {tracker.settings.name} needs the whole recording at once; use run")
    tracks, summary = _tracks(tracker, log), None
    with _writer(out) as write:
        for track in tracks:
            write(track)
            summary = _extended(summary, track)
            if progress is not None:
                progress(summary.rows, len(log.barometer))
    if summary is None:
        raise ValueError(f"{log.path}: there are no rows from {log.start} s to {log.stop} s")
    return summary


def _tracks(tracker: Tracker, log: LongRecording) -> Iterator[Track]:
    """Yield the parts' tracks; `feed` tells what the first part says against itself, we of the others."""
    tracker.reset()
    parts = log.parts()
    for k, part in enumerate(chain(_first(parts), parts)):
        track = tracker.feed(part)
        own = (*reading_notes(part), *imu_gaps(part)) if k else ()
        yield replace(track, findings=(*own, *track.findings))


def _first(parts: Iterator[Recording]) -> Iterator[Recording]:
    """Yield one part that is long enough to align and has a pressure sample, or else all there is."""
    early: list[Recording] = []
    for part in parts:
        early.append(part)
        enough = early[-1].t[-1] - early[0].t[0] > 2 * ALIGNMENT
        if enough and any(one.is_new.any() for one in early):
            break
    if early:
        yield _joined(early)


def _joined(parts: list[Recording]) -> Recording:
    if len(parts) == 1:
        return parts[0]
    signals: dict[str, Any] = {
        field.name: np.concatenate([getattr(part, field.name) for part in parts])
        for field in fields(Recording)[:8]
        if getattr(parts[0], field.name) is not None
    }
    return replace(parts[0], **signals)


def _extended(known: TrackedFile | None, track: Track) -> TrackedFile:
    """Add a part's rows.  Whether the track leaves the barometer is said anew by each part, all else once."""
    low, high = float(track.height.min()), float(track.height.max())
    if known is None:
        return TrackedFile(track.name, track.preset, len(track), low, high, track.findings)
    others = tuple(finding for finding in known.findings if finding.code != "diverged")
    codes = {finding.code for finding in others}
    return replace(
        known,
        rows=known.rows + len(track),
        lowest=min(known.lowest, low),
        highest=max(known.highest, high),
        findings=(*others, *(finding for finding in track.findings if finding.code not in codes)),
    )


@contextmanager
def _writer(out: StrPath | TextIO) -> Iterator[Callable[[Track], None]]:
    """Give a function that appends a track to the output."""
    if isinstance(out, str | os.PathLike):
        with replacing(out) as temporary, _opened(temporary, Path(out).suffix) as write:
            yield write
    else:
        yield _CsvWriter(out)


@contextmanager
def _opened(path: Path, suffix: str) -> Iterator[Callable[[Track], None]]:
    if suffix != ".parquet":
        with open(path, "w", encoding="utf-8", newline="") as file:
            yield _CsvWriter(file)
        return
    writer = _ParquetWriter(path)
    try:
        yield writer
    finally:
        writer.close()


class _CsvWriter:
    def __init__(self, file: TextIO) -> None:
        self._file, self._header = file, True

    def __call__(self, track: Track) -> None:
        track.write_csv(self._file, header=self._header)
        self._header = False


class _ParquetWriter:
    """A row group per part; pyarrow needs to know the columns first."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._writer: Any = None

    def __call__(self, track: Track) -> None:
        import pyarrow
        import pyarrow.parquet

        table = pyarrow.Table.from_pandas(track.to_frame(), preserve_index=False)
        if self._writer is None:
            self._writer = pyarrow.parquet.ParquetWriter(self._path, table.schema)
        self._writer.write_table(table)

    def close(self) -> None:
        if self._writer is not None:
            self._writer.close()
