"""Gyro against accelerometer: what turns must tilt.

Where gravity is most of the specific force, its direction u in the sensor's axes turns as du/dt = u x w.  So
between two half-second means, the accelerometer's change of u is what the gyro's rate predicts,

    u(t2) - u(t1) = M-turned integral of u x (M w) dt,

with M = 1.  If the gyro's axes are flipped or exchanged against the accelerometer's, or its unit is wrong, M
is another signed permutation, or has a factor of pi/180 or 180/pi, and the prediction with that M is right
instead.  If its clock is off, the rates of another time are.  None of these 143 others is believed unless it
halves the misfit over several tilts: linear accelerations, which spoil u, make no wrong M right.

A sign that all three axes of the accelerometer share doesn't matter, to this or to any height: -u x w is the
change of -u, and the force along the vertical stays the same.  An axis of the accelerometer that is flipped
looks like the gyro's two others flipped; where both are possible the sentence says so.
"""

from __future__ import annotations

import itertools
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.finding import Finding
from baroarma.glance import busiest_part, usual_interval
from baroarma.recording import Recording

Signal = NDArray[np.float64]

STEP: Final = 0.1
"""Seconds of the means that are multiplied, u x w."""
STEPS: Final = 5
"""Steps of an instant: means over half a second, in which footfalls vanish."""
SPAN: Final = 4
"""Instants from the first to the second of a pair: two seconds, which the gyro's bias hardly turns."""
NEAR_GRAVITY: Final = 0.1
"""Deviation of the specific force from its median, as a share, at which it is still mostly gravity."""
LEAST_TILT: Final = 0.15
"""Change of u, rad, of a pair that counts."""
FEWEST_TILTS: Final = 5
"""Pairs below which nothing is said."""
GOOD: Final = 0.1
"""Misfit, as a share of the tilt, that needs no other explanation."""
RIGHT: Final = 0.6
"""Misfit, as a share of the tilt, of an explanation that may be right: honest logs have 0.04 to 0.6."""
BETTER: Final = 0.5
"""Misfit of an explanation over that of M = 1 from which it is believed."""
ALIKE: Final = 1.15
"""Explanations within this factor of the best misfit fit alike, as where all tilts are about one axis."""
LARGE_TILT: Final = 0.4
"""rad; no steady acceleration makes such a tilt and leaves the modulus within `SURELY_GRAVITY`."""
SURELY_GRAVITY: Final = 0.05
CONTRADICTED: Final = 0.85
"""Misfit over large tilts that says that the gyro did not take part in them: 1 is a gyro of zeros."""
QUIET_RATE: Final = 0.1
"""rad/s rms of a first second whose mean is the gyro's bias."""
LONGEST_LAG: Final = 50
"""Steps, 5 s, by which the gyro's clock may be off and be found."""
LEAST_LAG: Final = 3
"""Steps, 0.3 s, of an offset that is told: shorter ones don't spoil a tilt."""

_LEVI_CIVITA: Final = np.array(
    [[[(i - j) * (j - k) * (k - i) / 2 for k in range(3)] for j in range(3)] for i in range(3)]
)
_TURNS: Final = tuple(
    np.eye(3)[list(order)] * np.array(signs)[:, None]
    for order in itertools.permutations(range(3))
    for signs in itertools.product((1.0, -1.0), repeat=3)
)
"""The 48 signed permutations, identity first."""
_UNITS: Final = {
    1.0: "",
    np.pi / 180: "deg/s under the label rad/s",
    180 / np.pi: "rad/s under the label deg/s",
}
"""What the rate must be multiplied by, and what that means."""


class _Pairs(NamedTuple):
    """Pairs of instants: change of u (n, 3), integrals of u_i w_j (n, 3, 3), is it surely a tilt (n,)."""

    change: Signal
    product: Signal
    sure: NDArray[np.bool_]

    def misfit(self, turn: Signal) -> float:
        """Return the mean misfit over the mean change if the true rate is turn @ w."""
        predicted = np.einsum("ijk,kl,njl->ni", _LEVI_CIVITA, turn, self.product)
        left = np.linalg.norm(self.change - predicted, axis=1)
        return float(left.mean() / np.linalg.norm(self.change, axis=1).mean())


def tilt_findings(recording: Recording) -> list[Finding]:
    """Return what the accelerometer's tilts say about the gyro: "axes", its "units", or its "clocks".

    Nothing without both sensors, or without tilts.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from baroarma.simulation import simulate
    >>> log = simulate("squat", duration=60, seed=1)
    >>> tilt_findings(log)
    []
    >>> print(tilt_findings(replace(log, gyro=-log.gyro))[0])
    warning (axes): Accelerometer and gyro do not fit: over ... tilts they differ by ... times the tilt, but \
by ... if the gyro's columns are read as (...
    """
    steps = _steps(busiest_part(recording))
    pairs = None if steps is None else _pairs(steps)
    if steps is None or pairs is None or len(pairs.change) < FEWEST_TILTS:
        return []
    honest = pairs.misfit(_TURNS[0])
    if honest < GOOD:
        return []
    tried = [(pairs.misfit(factor * turn), factor, turn) for factor in _UNITS for turn in _TURNS]
    best = min(misfit for misfit, _, _ in tried)
    if best < min(RIGHT, BETTER * honest):
        alike = [(factor, turn) for misfit, factor, turn in tried if misfit < ALIKE * best]
        return [_named(*min(alike, key=_complexity), len(pairs.change), honest, best)]
    return [] if honest < RIGHT else _by_clock(steps, honest) or _contradiction(pairs)


class _Steps(NamedTuple):
    """Means over `STEP`: time (n,), specific force over its median (n, 3), turn, rad (n, 3)."""

    t: Signal
    force: Signal
    turn: Signal


def _steps(recording: Recording) -> _Steps | None:
    if recording.accel is None or recording.gyro is None:
        return None
    good = np.isfinite(recording.accel).all(axis=1) & np.isfinite(recording.gyro).all(axis=1)
    t, accel, gyro = (x if good.all() else x[good] for x in (recording.t, recording.accel, recording.gyro))
    interval = usual_interval(t)
    rows = max(round(STEP / interval), 1) if interval else 1
    n = len(t) // rows
    if n < (SPAN + 1) * STEPS or interval > 2 * STEP:
        return None
    first = gyro[: int(np.searchsorted(t, t[0] + 1.0))]
    bias = first.mean(axis=0) if float(np.sum(first.var(axis=0))) < QUIET_RATE**2 else np.zeros(3)
    force = accel[: n * rows].reshape(n, rows, 3).mean(axis=1)
    rate = gyro[: n * rows].reshape(n, rows, 3).mean(axis=1) - bias
    gravity = float(np.median(np.linalg.norm(force, axis=1)))
    if not gravity > 0:
        return None
    starts = t[: n * rows : rows]
    return _Steps(
        starts, force / gravity, rate * np.diff(starts, append=starts[-1] + rows * interval)[:, None]
    )


def _pairs(steps: _Steps, lag: int = 0) -> _Pairs | None:
    """Return the pairs that tilt, the gyro's clock `lag` steps ahead of the accelerometer's."""
    n = (len(steps.t) - abs(lag)) // STEPS * STEPS
    first, ahead = max(-lag, 0), max(lag, 0)
    force, turn = steps.force[first : first + n], steps.turn[ahead : ahead + n]
    up = force / np.maximum(np.linalg.norm(force, axis=1, keepdims=True), 1e-9)
    product = up[:, :, None] * turn[:, None, :]
    until = np.cumsum(product, axis=0) - product / 2  # at the middle of each step
    at = steps.t[first : first + n : STEPS]
    force, until = (x.reshape(n // STEPS, STEPS, *x.shape[1:]).mean(axis=1) for x in (force, until))
    change, modulus = force[SPAN:] - force[:-SPAN], np.abs(np.linalg.norm(force, axis=1) - 1)
    off, size = np.maximum(modulus[SPAN:], modulus[:-SPAN]), np.linalg.norm(change, axis=1)
    lasts = at[SPAN:] - at[:-SPAN]
    count = (off < NEAR_GRAVITY) & (size > LEAST_TILT) & (lasts < 1.25 * float(np.median(lasts)))
    sure = (off < SURELY_GRAVITY) & (size > LARGE_TILT)
    return _Pairs(change[count], (until[SPAN:] - until[:-SPAN])[count], sure[count])


def _complexity(explanation: tuple[float, Signal]) -> tuple[bool, int, int]:
    """Of explanations that fit alike, take the one with the least that is wrong."""
    factor, turn = explanation
    return factor != 1, int(np.sum(np.diag(turn) == 0)), int(np.sum(turn < 0))


def _named(factor: float, turn: Signal, tilts: int, honest: float, best: float) -> Finding:
    """Say which other axes and unit fit."""
    lead = f"Accelerometer and gyro do not fit: over {tilts} tilts they differ by {honest:.2g} times the tilt"
    but = f", but by {best:.2g} if the gyro's columns are read as {_axes(turn)}"
    if factor != 1:
        but = "" if np.array_equal(turn, np.eye(3)) else but
        return Finding(
            "units", "warning", f"{lead}; it looks like {_UNITS[factor]}{but}: rename the gyro's columns."
        )
    text = f"{lead}{but}{_or_in_accel(turn)}; put that right, or the height is wrong wherever it turns."
    return Finding("axes", "warning", text)


def _axes(turn: Signal) -> str:
    """Return what stands in which place, as ``(y, x, -z)``."""
    names = []
    for row in turn:
        k = int(np.argmax(np.abs(row)))
        names.append(("-" if row[k] < 0 else "") + "xyz"[k])
    return f"({', '.join(names)})"


def _or_in_accel(turn: Signal) -> str:
    """Return the accelerometer's fault that looks the same, if one does: u' = S u turns by det(S) S w."""
    if np.linalg.det(turn) < 0:
        return ""
    cure = min(turn.T, -turn.T, key=lambda fault: np.sum(fault < 0))
    return f", or the accelerometer's as {_axes(cure)}"


def _by_clock(steps: _Steps, honest: float) -> list[Finding]:
    """Look for a shift of the gyro's clock that explains the tilts."""
    misfits = {}
    for lag in range(-LONGEST_LAG, LONGEST_LAG + 1):
        pairs = _pairs(steps, lag) if len(steps.t) - abs(lag) > 2 * SPAN * STEPS else None
        if pairs is not None and len(pairs.change) >= FEWEST_TILTS:
            misfits[lag] = pairs.misfit(_TURNS[0])
    best = min(misfits, key=lambda lag: misfits[lag], default=0)
    if abs(best) < LEAST_LAG or not misfits[best] < min(RIGHT, BETTER * honest):
        return []
    text = (
        f"The gyro comes about {abs(best) * STEP:.2g} s {'after' if best > 0 else 'before'} the "
        f"accelerometer: moved by that, they differ by {misfits[best]:.2g} times the tilt, as they are by "
        f"{honest:.2g}; put both on one clock."
    )
    return [Finding("clocks", "warning", text)]


def _contradiction(pairs: _Pairs) -> list[Finding]:
    """Return a finding if the gyro took no part in tilts that surely are some."""
    large = _Pairs(pairs.change[pairs.sure], pairs.product[pairs.sure], pairs.sure[pairs.sure])
    if len(large.change) < FEWEST_TILTS or (misfit := large.misfit(_TURNS[0])) < CONTRADICTED:
        return []
    text = (
        f"Accelerometer and gyro do not belong together: of {len(large.change)} large tilts the gyro "
        f"explains nothing (they differ by {misfit:.2g} times the tilt), in whatever axes, unit or time; "
        "check that the files are of one recording and the gyro is alive."
    )
    return [Finding("clocks", "warning", text)]
