"""Several streams of one recording on one clock.

The rows are the time stamps of the barometer and of the accelerometer together (stamps closer than a
microsecond are one row).  The pressure stands at the barometer's own rows only and is NaN elsewhere: it is
never interpolated, because a filter would take the interpolated value for new information.  Everything else
is interpolated linearly onto every row, as a strapdown that integrates it by the trapezoidal rule sees it,
and is NaN outside its stream's span and inside its gaps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.formats.errors import UnreadableError
from baroarma.formats.table import Table
from baroarma.recording import Recording

Signal = NDArray[np.float64]

SAME_TIME: Final = 1e-6
"""Time stamps closer than this, s, are one row."""
GAP_INTERVALS: Final = 5.0
GAP_SECONDS: Final = 0.1
"""An interval is a gap, not to be bridged, if longer than 5 of the stream's median intervals *and* 0.1 s."""


def merge(tables: Sequence[Table]) -> Recording:
    """Merge the tables of one recording, exactly one of which has the pressure.

    Parameters
    ----------
    tables : sequence of Table
        One table: its rows are kept as they are.  Several: one clock is made of them.

    Returns
    -------
    Recording
        Without name and source, with the tables' notes.

    Raises
    ------
    UnreadableError
        If no or several tables have pressure, a quantity is there twice, or a stream lies outside the rest.
    """
    streams = [table.signals() for table in tables]
    base = _the_barometer(tables, streams)
    if len(tables) == 1:
        return _recording(tables, streams[0])
    _refuse_doubles(tables, streams)
    own_t, pressure = streams[base]["t"], streams[base]["pressure"]
    t = union(own_t, next((stream["t"] for stream in streams if "accel" in stream), own_t))
    signals = {"t": t, "pressure": np.full(len(t), np.nan)}
    signals["pressure"][np.searchsorted(t, own_t)] = pressure
    for table, stream in zip(tables, streams, strict=True):
        _refuse_apart(table, stream["t"], own_t)
        for field in stream.keys() - {"t", "pressure"}:
            onto_clock = _attitude_onto if field == "reference_attitude" else onto
            signals[field] = onto_clock(t, stream["t"], stream[field])
    return _recording(tables, signals)


def _recording(tables: Sequence[Table], signals: Mapping[str, Any]) -> Recording:
    return Recording(**signals, notes=tuple(note for table in tables for note in table.notes))


def union(first: Signal, second: Signal) -> Signal:
    """Return all time stamps in order; of two within a microsecond the first stream's.

    Examples
    --------
    >>> union(np.array([0.0, 0.1]), np.array([0.05, 0.1000000001]))
    array([0.  , 0.05, 0.1 ])
    """
    after = np.searchsorted(first, second)
    ahead = np.abs(first[np.minimum(after, len(first) - 1)] - second)
    behind = np.abs(first[np.maximum(after - 1, 0)] - second)
    return np.sort(np.concatenate((first, second[np.minimum(ahead, behind) > SAME_TIME])))


def onto(t: Signal, own_t: Signal, value: Signal) -> Signal:
    """Interpolate a stream linearly onto other times; NaN outside its span and inside its gaps.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Where to.
    own_t : ndarray, shape (m,)
        The stream's times.
    value : ndarray, shape (m,) or (m, axes)
        Its samples; rows with NaN are no samples.

    Returns
    -------
    ndarray, shape (n,) or (n, axes)

    Examples
    --------
    >>> onto(np.array([0.5, 1.5, 3.0]), np.array([0.0, 1.0, 2.0]), np.array([0.0, 2.0, 4.0]))
    array([ 1.,  3., nan])
    """
    columns = value.reshape(len(own_t), -1)
    real = np.isfinite(columns).all(axis=1)
    own_t, columns = own_t[real], columns[real]
    out = np.full((len(t), columns.shape[1]), np.nan)
    if len(own_t):
        inside = _is_covered(t, own_t)
        for k in range(columns.shape[1]):
            out[inside, k] = np.interp(t[inside], own_t, columns[:, k])
    return out.reshape(len(t), *value.shape[1:])


def _attitude_onto(t: Signal, own_t: Signal, q: Signal) -> Signal:
    """Interpolate unit quaternions: q and -q are one attitude, hence first without jumps of sign."""
    jumps = np.sum(q[1:] * q[:-1], axis=1) < 0
    sign = np.where(np.concatenate(([0], np.cumsum(jumps))) % 2, -1.0, 1.0)
    out = onto(t, own_t, q * sign[:, None])
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    return out


def _is_covered(t: Signal, own_t: Signal) -> NDArray[np.bool_]:
    """Return True for times within the stream's span that no gap separates from a sample."""
    inside: NDArray[np.bool_] = (t >= own_t[0] - SAME_TIME) & (t <= own_t[-1] + SAME_TIME)
    if len(own_t) < 2:
        return inside
    intervals = np.diff(own_t)
    k = np.clip(np.searchsorted(own_t, t, side="right") - 1, 0, len(intervals) - 1)
    is_gap = intervals > max(GAP_INTERVALS * float(np.median(intervals)), GAP_SECONDS)
    between = (t > own_t[k] + SAME_TIME) & (t < own_t[k + 1] - SAME_TIME)
    inside &= ~(is_gap[k] & between)
    return inside


def _the_barometer(tables: Sequence[Table], streams: Sequence[dict[str, Signal]]) -> int:
    found = [k for k, stream in enumerate(streams) if "pressure" in stream]
    names = ", ".join(table.path for table in tables)
    if not found:
        raise UnreadableError(
            f"{names}: there is no pressure (pressure_pa, pressure_hpa or altitude_m) among the columns "
            f"{', '.join(repr(name) for table in tables for name in table.header)}; map one: pressure_pa=NAME"
        )
    if len(found) > 1:
        raise UnreadableError(
            f"{names}: {len(found)} of the files have pressure, one recording has one; read them one by one"
        )
    if np.isnan(streams[found[0]]["pressure"]).all():
        raise UnreadableError(
            f"{tables[found[0]].path}: every cell of the pressure column is empty; map another one"
        )
    return found[0]


def _refuse_doubles(tables: Sequence[Table], streams: Sequence[dict[str, Signal]]) -> None:
    seen: dict[str, str] = {}
    for table, stream in zip(tables, streams, strict=True):
        for field in stream.keys() - {"t", "pressure"}:
            other = seen.setdefault(field, table.path)
            if other != table.path:
                raise UnreadableError(
                    f"{table.path}: {field} is already in {other}; leave one of the files out"
                )


def _refuse_apart(table: Table, t: Signal, barometer_t: Signal) -> None:
    if t[0] > barometer_t[-1] or t[-1] < barometer_t[0]:
        raise UnreadableError(
            f"{table.path}: its times {t[0]:.6g} to {t[-1]:.6g} s lie outside the barometer's "
            f"{barometer_t[0]:.6g} to {barometer_t[-1]:.6g} s; put both on one clock first"
        )
