"""A track: height and vertical velocity over time, with their standard deviations."""

from __future__ import annotations

import os
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple, TextIO

import numpy as np
from numpy.typing import NDArray

from baroarma.atomic import replacing
from baroarma.finding import Finding
from baroarma.read_only import read_only

if TYPE_CHECKING:
    import pandas as pd
    import xarray
    from matplotlib.axes import Axes

    from baroarma.recording import Recording

Signal = NDArray[np.float64]
COLUMNS: Final = ("time_s", "height_m", "velocity_m_s", "height_sd_m", "velocity_sd_m_s")
"""The columns of ``track.csv``: the first fields of `Track`, in their order."""
ROWS: Final = 1 << 16
"""Rows that are written at a time."""


class TrackState(NamedTuple):
    """Hold a track's row, the state now: m and m/s, up, with standard deviations, and m/s², up.

    Parameters
    ----------
    height, velocity : float
        Height relative to the start in m and vertical velocity in m/s, up.
    height_sd, velocity_sd : float
        Their standard deviations, m and m/s.
    acceleration : float
        Vertical acceleration as it was integrated, m/s², up.

    Examples
    --------
    The k-th `Tracker.step` returns row k of the `Track` that `run` makes; None while it aligns:

    >>> from baroarma.simulation import BMP085, simulate
    >>> from baroarma.tracker import Tracker
    >>> log, tracker = simulate("squat", duration=5, seed=1), Tracker(noise=BMP085.noise)
    >>> steps = [
    ...     tracker.step(dt=0.02, accel=force, gyro=rate, pressure=pressure)
    ...     for force, rate, pressure in zip(log.accel, log.gyro, log.pressure)
    ... ]
    >>> steps[0] is None, abs(steps[-1].height - float(tracker.run(log).height[-1])) < 1e-9
    (True, True)
    """

    height: float
    velocity: float
    height_sd: float
    velocity_sd: float
    acceleration: float


@dataclass(frozen=True, eq=False, repr=False)
class Track:
    """Hold what a tracker made of a recording; one row per row of the recording, no NaN.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times of the recording, s.
    height, velocity : ndarray, shape (n,)
        Height relative to the first sample in m and vertical velocity in m/s, both positive up.
    height_sd, velocity_sd : ndarray, shape (n,)
        Their standard deviations.
    acceleration : ndarray, shape (n,)
        Vertical acceleration in m/s², up, as it was integrated; missing samples repeat the last one.
    preset : str
        What made it.
    name : str
        Name of the recording.
    findings : tuple of Finding
        What to know before believing it.

    Examples
    --------
    A tracker makes one; by hand it takes six columns:

    >>> track = Track(*np.zeros((6, 3)), preset="mine", name="ride")
    >>> track
    <Track of 'ride' by mine: 3 rows, 0 to 0 m>
    >>> track.to_frame().columns[1]
    'height_m'
    """

    t: Signal
    height: Signal
    velocity: Signal
    height_sd: Signal
    velocity_sd: Signal
    acceleration: Signal
    preset: str = ""
    name: str = ""
    findings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        for field in fields(self)[:6]:
            array = read_only(getattr(self, field.name))
            if array.shape != np.shape(self.t) or not np.isfinite(array).all():
                raise ValueError(f"{field.name} of a track must be {np.shape(self.t)} finite numbers")
            object.__setattr__(self, field.name, array)

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        span = f"{self.height.min():.4g} to {self.height.max():.4g} m" if len(self) else "empty"
        codes = "".join(f"; {finding.code}" for finding in self.findings)
        return f"<Track of {self.name!r} by {self.preset}: {len(self)} rows, {span}{codes}>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas DataFrame with the columns of ``track.csv``."""
        import pandas as pd

        values = (getattr(self, field.name) for field in fields(self))
        return pd.DataFrame(dict(zip(COLUMNS, values, strict=False)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write ``track.csv`` (or Parquet for ``.parquet``), complete or not at all.

        Parameters
        ----------
        path : str or path
            Where to; a file that is there is replaced.

        Examples
        --------
        >>> import tempfile
        >>> from baroarma.comparison import read_track
        >>> t = np.arange(5.0)
        >>> track = Track(t, t / 3, np.full(5, 1 / 3), *np.full((2, 5), 0.1), np.zeros(5))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     track.save(os.path.join(folder, "track.csv"))
        ...     bool((read_track(os.path.join(folder, "track.csv")).height == track.height).all())
        True
        """
        with replacing(path) as temporary:
            if Path(path).suffix == ".parquet":
                self.to_frame().to_parquet(temporary, index=False)
            else:
                with open(temporary, "w", encoding="utf-8", newline="\n") as file:
                    self.write_csv(file)

    def write_csv(self, file: TextIO, *, header: bool = True) -> None:
        """Write the rows of ``track.csv`` into an open file; floats read back exactly.

        Parameters
        ----------
        file : text file
            Open for writing.
        header : bool
            Whether the columns' names come first; False: to go on with a file.

        Examples
        --------
        >>> import sys
        >>> Track([0.0, 0.5], [0.0, 1 / 3], *np.zeros((3, 2)), [0.0, 0.0]).write_csv(sys.stdout)
        time_s,height_m,velocity_m_s,height_sd_m,velocity_sd_m_s
        0.0,0.0,0.0,0.0,0.0
        0.5,0.3333333333333333,0.0,0.0,0.0
        """
        if header:
            file.write(",".join(COLUMNS) + "\n")
        columns = [getattr(self, field.name) for field in fields(self)[:5]]
        for k in range(0, len(self), ROWS):
            texts = (map(repr, column[k : k + ROWS].tolist()) for column in columns)
            file.writelines(f"{row}\n" for row in map(",".join, zip(*texts, strict=True)))

    def summary(self) -> str:
        """Return the result in a few lines."""
        from baroarma.climbing import climb

        lines = [
            repr(self),
            f"  ends at {self.height[-1]:.3f} m (sd {self.height_sd[-1]:.2g}), "
            f"{self.velocity[-1]:+.3f} m/s (sd {self.velocity_sd[-1]:.2g})",
            f"  {climb(self).summary()}",
        ]
        return "\n".join([*lines, *(f"  {finding}" for finding in self.findings)])

    def _repr_html_(self) -> str:
        from baroarma.notebook import about, tables
        from baroarma.signal_table import track_table

        return tables(track_table(self), *about(self.findings))

    def to_xarray(self) -> xarray.Dataset:
        """Return an xarray Dataset over time, units in the attributes; needs the extra ``xarray``."""
        from baroarma.labelled import dataset

        return dataset(self, preset=self.preset, findings=[str(finding) for finding in self.findings])

    def plot(self, ax: Axes | None = None, *, reference: Recording | None = None) -> Axes:
        """Draw height and, without `ax`, velocity with their bands; see `baroarma.plotting.plot_track`."""
        from baroarma.plotting import plot_track

        return plot_track(self, ax, reference=reference)
