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

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

Signal = NDArray[np.float64]
COLUMNS: Final = ("time_s", "height_m", "velocity_m_s", "height_sd_m", "velocity_sd_m_s")
"""The columns of ``track.csv``: the first fields of `Track`, in their order."""
ROWS: Final = 1 << 16
"""Rows that are written at a time."""


class TrackState(NamedTuple):
    """Hold a track's row, the state now: m and m/s, up, with standard deviations, and m/s², up."""

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
            array = np.array(getattr(self, field.name), dtype=float)
            if array.shape != np.shape(self.t) or not np.isfinite(array).all():
                raise ValueError(f"{field.name} of a track must be {np.shape(self.t)} finite numbers")
            array.flags.writeable = False
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
        """Write ``track.csv`` (or Parquet for ``.parquet``), complete or not at all."""
        with replacing(path) as temporary:
            if Path(path).suffix == ".parquet":
                self.to_frame().to_parquet(temporary, index=False)
            else:
                with open(temporary, "w", encoding="utf-8", newline="\n") as file:
                    self.write_csv(file)

    def write_csv(self, file: TextIO, *, header: bool = True) -> None:
        """Write the rows of ``track.csv`` into an open file; floats read back exactly."""
        if header:
            file.write(",".join(COLUMNS) + "\n")
        columns = [getattr(self, field.name) for field in fields(self)[:5]]
        for k in range(0, len(self), ROWS):
            texts = (map(repr, column[k : k + ROWS].tolist()) for column in columns)
            file.writelines(f"{row}\n" for row in map(",".join, zip(*texts, strict=True)))

    def summary(self) -> str:
        """Return the result in a few lines."""
        lines = [
            repr(self),
            f"  ends at {self.height[-1]:.3f} m (sd {self.height_sd[-1]:.2g}), "
            f"{self.velocity[-1]:+.3f} m/s (sd {self.velocity_sd[-1]:.2g})",
        ]
        return "\n".join([*lines, *(f"  {finding}" for finding in self.findings)])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the height with its band; see `baroarma.plotting.plot_track`."""
        from baroarma.plotting import plot_track

        return plot_track(self, ax)
