"""What signals say, in rows for people: how many samples, how often, from where to where."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.page import Table

if TYPE_CHECKING:
    from baroarma.recording import Recording
    from baroarma.track import Track

Signal = NDArray[np.float64]

SHOWN: Final = {
    "pressure": ("pressure", 1e-2, "hPa", 2),
    "accel": ("specific force", 1.0, "m/s²", 2),
    "gyro": ("angular rate", 1.0, "rad/s", 3),
    "temperature": ("temperature", 1.0, "°C", 1),
    "reference": ("reference height", 1.0, "m", 2),
    "reference_velocity": ("reference velocity", 1.0, "m/s", 2),
}
"""Name, scale, unit and decimals of a recording's signals; a reference attitude has no range."""


def signal_rows(recording: Recording) -> list[tuple[str, str, str, str]]:
    """Return name, samples, rate and range of each signal of a recording; of a vector, of its modulus.

    Examples
    --------
    >>> from baroarma import Recording
    >>> signal_rows(Recording(t=[0.0, 0.02, 0.04], pressure=[101325.0, 101326.0, 101327.0]))
    [('pressure', '3', '50 Hz', '1013.25 to 1013.27 hPa')]
    """
    rows = []
    for field, (name, scale, unit, digits) in SHOWN.items():
        values = getattr(recording, field)
        if values is None:
            continue
        if values.ndim > 1:
            values, name = np.sqrt(np.sum(values**2, axis=1)), f"{name} (modulus)"
        new = np.isfinite(values)
        n = int(np.count_nonzero(new))
        rate = f"{1 / np.median(np.diff(recording.t[new])):.4g} Hz" if n > 1 else "–"
        span = f"{_span(scale * values[new], digits)} {unit}" if n else "–"
        rows.append((name, str(n), rate, span))
    return rows


def track_table(track: Track) -> Table:
    """Return range, end and sd at the end of height and velocity as a table."""
    name = f"{track.name or 'Track'} by {track.preset or 'another program'}: {len(track)} rows"
    if not len(track):
        return Table(("state",), (), name)
    rows = tuple(
        (label, f"{_span(values, 3)} {unit}", f"{values[-1]:.3f} ± {sd[-1]:.2g} {unit}")
        for label, values, sd, unit in (
            ("height", track.height, track.height_sd, "m"),
            ("vertical velocity", track.velocity, track.velocity_sd, "m/s"),
        )
    )
    return Table(
        ("state", "range", "at the end, ± 1 sd"), rows, f"{name} over {track.t[-1] - track.t[0]:.6g} s"
    )


def _span(values: Signal, digits: int) -> str:
    return f"{values.min():.{digits}f} to {values.max():.{digits}f}"
