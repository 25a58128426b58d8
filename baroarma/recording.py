"""A recording: what the sensors of one device said, on one clock.

The pressure stays as logged, in Pa; `Recording.height` turns it into ISA metres.  NaN means "no new sample
at this instant": a row that only carries IMU data, or a barometer reading that the logger merely repeated
(found and blanked by `baroarma.read`, never here).
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.atmosphere import pressure_altitude, temperature_factor
from baroarma.finding import Finding
from baroarma.read_only import read_only

if TYPE_CHECKING:
    import pandas as pd
    import xarray
    from matplotlib.axes import Axes

Signal = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """Hold the signals of one recording; immutable, changed by `dataclasses.replace`.

    Parameters
    ----------
    t : array_like, shape (n,)
        Time in s, strictly increasing, finite.
    pressure : array_like, shape (n,)
        Pressure in Pa; NaN where there is no new sample.
    accel : array_like, shape (n, 3), optional
        Specific force in m/s² in the sensor's axes: at rest it points up.  NaN rows: no new sample.
    gyro : array_like, shape (n, 3), optional
        Angular rate in rad/s in the same axes.  NaN rows: no new sample.
    temperature : array_like, shape (n,), optional
        Temperature that the sensor reported, in °C.
    reference : array_like, shape (n,), optional
        True height in m, positive up, from something better than the barometer.
    reference_velocity : array_like, shape (n,), optional
        True vertical velocity in m/s, positive up.
    reference_attitude : array_like, shape (n, 4), optional
        True attitude, quaternions body to world, scalar last.
    name : str
        What to call it in tables and plots.
    notes : tuple of Finding
        What reading noticed, such as held samples; carried into every verdict.
    source : dict, optional
        Where it came from: ``{"name", "sha256"}``.

    Raises
    ------
    ValueError
        If time does not strictly increase, or a shape differs; the message names the row.

    Examples
    --------
    >>> rest = Recording(t=[0.0, 0.02, 0.04], pressure=[101325.0, 101326.0, float("nan")], name="bench")
    >>> rest
    <Recording 'bench': 3 rows, 0.04 s, pressure 2 samples at 50 Hz>
    """

    t: Signal
    pressure: Signal
    accel: Signal | None = None
    gyro: Signal | None = None
    temperature: Signal | None = None
    reference: Signal | None = None
    reference_velocity: Signal | None = None
    reference_attitude: Signal | None = None
    name: str = ""
    notes: tuple[Finding, ...] = ()
    source: dict[str, Any] | None = None

    def __post_init__(self) -> None:
        n = np.size(self.t)
        for field in fields(self)[:8]:
            value = getattr(self, field.name)
            if value is not None or field.name in ("t", "pressure"):
                shape = (n, *_TAIL.get(field.name, ()))
                object.__setattr__(self, field.name, _read_only(value, shape, field.name))
        _check_clock(self.t)

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        parts = [f"{len(self)} rows", f"{self.duration:.6g} s"]
        new = int(self.is_new.sum())
        rate = f" at {self.rate_hz:.4g} Hz" if new > 1 else ""
        parts.append(f"pressure {new} samples{rate}")
        parts += [w for w in ("accel", "gyro", "temperature", "reference") if getattr(self, w) is not None]
        return f"<Recording {self.name!r}: {', '.join(parts)}>"

    @property
    def duration(self) -> float:
        """Time from the first to the last row, s."""
        return float(self.t[-1] - self.t[0]) if len(self) else 0.0

    @property
    def is_new(self) -> NDArray[np.bool_]:
        """True where the barometer has a new sample, shape (n,).

        Examples
        --------
        >>> held = Recording(t=[0.0, 0.02, 0.04], pressure=[101325.0, float("nan"), 101320.0])
        >>> held.is_new.tolist()
        [True, False, True]
        """
        return np.isfinite(self.pressure)

    @property
    def rate_hz(self) -> float:
        """The barometer's own rate in Hz: one over the median interval between new samples.

        Raises
        ------
        ValueError
            If there are fewer than 2 samples.

        Examples
        --------
        A barometer of 25 Hz in a log of 50:

        >>> held = Recording(t=[0.0, 0.02, 0.04], pressure=[101325.0, float("nan"), 101320.0])
        >>> round(held.rate_hz, 6)
        25.0
        """
        t = self.t[self.is_new]
        if len(t) < 2:
            raise ValueError(f"{len(t)} pressure samples have no rate; at least 2 are needed")
        return float(1.0 / np.median(np.diff(t)))

    def height(self, temperature: float | None = None) -> Signal:
        """Return the pressure altitude of each row.

        Parameters
        ----------
        temperature : float, optional
            Temperature of the air in °C; height differences are then stretched from the ISA's to this
            air's.  Default: the ISA's own temperature.

        Returns
        -------
        ndarray, shape (n,)
            Height in m above the ISA's sea level, NaN where there is no new sample.

        Examples
        --------
        Air of 33 °C is 18 K warmer than the ISA's 288.15 K at sea level: heights stretch by a sixteenth.

        >>> log = Recording(t=[0.0, 1.0, 2.0], pressure=[101335.0, 101325.0, 101315.0])
        >>> log.height().round(2).tolist()
        [-0.83, 0.0, 0.83]
        >>> round(float(np.ptp(log.height(temperature=33.0)) / np.ptp(log.height())), 4)
        1.0625
        """
        height = pressure_altitude(self.pressure)
        if temperature is None or not self.is_new.any():
            return height
        middle = float(np.nanmedian(self.pressure))
        level = float(pressure_altitude(middle))
        return level + (height - level) * temperature_factor(middle, temperature)

    def relative_to(self, reference: Recording, *, lag: float | None = None) -> Recording:
        """Return the recording without the weather that a second, stationary barometer saw.

        Parameters
        ----------
        reference : Recording
            Of a barometer that did not move meanwhile.
        lag : float, optional
            How much the reference's clock is ahead, s; default: found by correlation, see
            `baroarma.differential.relative_to`.

        Returns
        -------
        Recording
            With the pressure that would have been read in constant weather, and notes about clock and noise.

        Examples
        --------
        Two barometers see the weather rise by 10 Pa; one of them is carried up by 8.33 m, 100 Pa, meanwhile:

        >>> t = np.arange(0.0, 120.0, 0.1)
        >>> weather = 101325 + t / 12
        >>> still, carried = Recording(t=t, pressure=weather), Recording(t=t, pressure=weather - t / 1.2)
        >>> height = carried.relative_to(still, lag=0.0).height()
        >>> round(float(height[-1] - height[0]), 1)
        8.3
        """
        from baroarma.differential import relative_to

        return relative_to(self, reference, lag=lag)

    def between(self, start: float, stop: float) -> Recording:
        """Return the rows with start <= t < stop (s, on the recording's own clock).

        Examples
        --------
        >>> whole = Recording(t=[0.0, 1.0, 2.0, 3.0], pressure=[101325.0] * 4, name="ride")
        >>> len(whole.between(1.0, 3.0))
        2
        """
        return self.rows((self.t >= start) & (self.t < stop))

    def rows(self, which: NDArray[Any] | slice) -> Recording:
        """Return a recording of the chosen rows (a mask, indices or a slice).

        Parameters
        ----------
        which : ndarray or slice
            A mask (n,), indices or a slice; what comes out must be in order of time.

        Examples
        --------
        >>> log = Recording(t=[0.0, 0.02, 0.04], pressure=[101325.0, float("nan"), 101320.0])
        >>> log.rows(log.is_new).t.tolist(), log.rows(slice(1)).t.tolist()
        ([0.0, 0.04], [0.0])
        """
        chosen = {
            f.name: getattr(self, f.name)[which]
            for f in fields(self)[:8]
            if getattr(self, f.name) is not None
        }
        if not (isinstance(which, slice) and (which.step or 1) > 0):
            return replace(self, **chosen)
        part = copy(self)  # shares memory: it is read-only, and its clock has been checked
        for name, values in chosen.items():
            object.__setattr__(part, name, values)
        return part

    def summary(self) -> str:
        """Return what each sensor said, as text: samples, rate, range."""
        from baroarma.signal_table import signal_rows

        lines = [repr(self), f"  {'signal':26}{'samples':>9}  {'rate':10}  range"]
        lines += [f"  {name:26}{n:>9}  {rate:10}  {span}" for name, n, rate, span in signal_rows(self)]
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])

    def _repr_html_(self) -> str:
        from baroarma.notebook import about, tables
        from baroarma.page import Table
        from baroarma.signal_table import signal_rows

        caption = f"{self.name or 'Recording'}: {len(self)} rows over {self.duration:.6g} s"
        head = ("signal", "samples", "rate", "range")
        return tables(Table(head, tuple(signal_rows(self)), caption), *about(self.notes))

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas DataFrame with the columns of a recording's file, a row per time.

        Examples
        --------
        >>> log = Recording(t=[0.0, 0.02], pressure=[101325.0, 101320.0], accel=[[0, 0, 9.8]] * 2)
        >>> list(log.to_frame().columns)
        ['time_s', 'pressure_pa', 'acc_x_m_s2', 'acc_y_m_s2', 'acc_z_m_s2']
        """
        import pandas as pd

        from baroarma.formats.columns import COLUMNS, WRITTEN

        found = {name: (getattr(self, COLUMNS[name].field), COLUMNS[name].axis) for name in WRITTEN}
        columns = {k: v if axis is None else v[:, axis] for k, (v, axis) in found.items() if v is not None}
        return pd.DataFrame(columns)

    def to_xarray(self) -> xarray.Dataset:
        """Return an xarray Dataset over time, units in the attributes; needs the extra ``xarray``."""
        from baroarma.labelled import dataset

        return dataset(self, findings=[str(note) for note in self.notes])

    def noting(self, *findings: Finding) -> Recording:
        """Return the recording with further notes; the signals are shared.

        Parameters
        ----------
        *findings : Finding
            They come after those there are.

        Examples
        --------
        >>> log = Recording(t=[0.0, 0.02], pressure=[101325.0, 101320.0])
        >>> seen = log.noting(Finding("windy", "info", "The window was open."))
        >>> [note.code for note in seen.notes], log.notes
        (['windy'], ())
        """
        other = copy(self)
        object.__setattr__(other, "notes", (*self.notes, *findings))
        return other

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the height, and without `ax` all sensors; see `baroarma.plotting.plot_recording`."""
        from baroarma.plotting import plot_recording

        return plot_recording(self, ax)


_TAIL = {"accel": (3,), "gyro": (3,), "reference_attitude": (4,)}


def _read_only(value: ArrayLike, shape: tuple[int, ...], name: str) -> Signal:
    array = read_only(value)
    if array.shape != shape:
        raise ValueError(f"{name} has shape {array.shape}; {shape} is needed, one row per time")
    return array


def _check_clock(t: Signal) -> None:
    if not np.isfinite(t).all():
        row = int(np.flatnonzero(~np.isfinite(t))[0])
        raise ValueError(f"time of row {row} is {t[row]}; every row needs a finite time in s")
    back = np.flatnonzero(np.diff(t) <= 0)
    if len(back):
        row = int(back[0]) + 1
        raise ValueError(
            f"time must increase from row to row, but row {row} says {t[row]:.6g} s after "
            f"{t[row - 1]:.6g} s; sort the rows or drop the repeated ones"
        )
