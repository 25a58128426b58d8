"""Golden vectors: a short ride that Python tracked, for the exported firmware to repeat.

A second of rest for the alignment, half of one more, and four and a half on a circle that is faster than an
attitude filter likes, with samples left out: long enough for `robust` to level twice.  Inputs are decimals of
seven digits, so that C reads the very numbers that Python saw; a float rounds them as it rounds its sensor.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.export.c_text import real, reals
from baroarma.recording import Recording
from baroarma.tracker import ALIGNMENT, Tracker

Signal = NDArray[np.float64]
TOLERANCES: Final = {"float": 2e-3, "double": 1e-9}
"""How far C may be from Python, m and m/s: floats are good to 2 mm, doubles to rounding."""
_START, _LENGTH = 3.5, 6.0  # s: of a motion that begins after 5


def golden_header(tracker: Tracker, rate_hz: float) -> str:
    """Return the header with what goes in and what must come out.

    Parameters
    ----------
    tracker : Tracker
        What the firmware does; it is run here.
    rate_hz : float
        Rate of all samples, Hz.
    """
    ride = golden_ride(rate_hz)
    track = tracker.run(ride)
    answered = ride.t >= ride.t[0] + ALIGNMENT - 1e-6
    columns = (track.height, track.velocity, track.height_sd, track.velocity_sd)
    output = np.stack(columns, axis=1)[answered]
    assert ride.accel is not None
    assert ride.gyro is not None
    rows = np.column_stack([ride.accel, ride.gyro, ride.pressure])
    inputs = ",\n    ".join(reals(row) for row in rows)
    outputs = ",\n    ".join("{" + ", ".join(f"{x:.13g}" for x in row) + "}" for row in output)
    return f"""#define BAROARMA_GOLDEN_ROWS {len(rows)}
#define BAROARMA_GOLDEN_ANSWERS {len(output)}
#define BAROARMA_GOLDEN_TOLERANCE (BAROARMA_FLOAT ? {TOLERANCES["float"]!r} : {TOLERANCES["double"]!r})

static const baroarma_real BAROARMA_GOLDEN_DT = {real(1 / rate_hz)}; /* s */

/* specific force, m/s^2, angular rate, rad/s, pressure, Pa */
static const baroarma_real BAROARMA_GOLDEN_INPUT[BAROARMA_GOLDEN_ROWS][7] = {{
    {inputs}
}};

/* height, m, velocity, m/s, and their sds, from the first row after the alignment on */
static const double BAROARMA_GOLDEN_OUTPUT[BAROARMA_GOLDEN_ANSWERS][4] = {{
    {outputs}
}};
"""


def golden_ride(rate_hz: float) -> Recording:
    """Return the ride at a rate in Hz: the alignment complete, afterwards a few samples missing."""
    from baroarma.simulation import simulate

    whole = simulate("circle", duration=_START + _LENGTH, rate_hz=rate_hz, frequency_hz=1.0, seed=1)
    ride = whole.rows(slice(round(_START * rate_hz), None))
    assert ride.accel is not None
    assert ride.gyro is not None
    t = np.arange(len(ride)) / rate_hz
    moving = t >= ALIGNMENT
    row = np.arange(len(t))
    pressure = np.where(moving & (row % 5 == 3), np.nan, _decimal(ride.pressure))
    accel = np.where((moving & (row % 41 == 7))[:, None], np.nan, _decimal(ride.accel))
    gyro = np.where((moving & (row % 37 == 5))[:, None], np.nan, _decimal(ride.gyro))
    return replace(ride, t=t, pressure=pressure, accel=accel, gyro=gyro)


def _decimal(values: Signal) -> Signal:
    return np.array([float(f"{x:.7g}") for x in values.ravel()]).reshape(values.shape)
