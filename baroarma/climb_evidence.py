"""Barometer against accelerometer: what is pushed up must rise.

The second difference of a height's means over tau is the vertical acceleration, smoothed over three tau,
times tau².  The specific force's modulus, less its median, is near enough to it to compare the two:

* their correlation is negative: one of them has its sign wrong (a height that counts downwards);
* it is high only if one is moved in time: their clocks differ, or the barometer is very late;
* it is high, but the heights are about three times too large: they are in feet;
* it is low at any lag, though both see strong motion: they are not of one recording.

Slow motion, rests and walks on level ground say nothing, and nothing is said.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.clocks import binned_means
from baroarma.finding import Finding
from baroarma.glance import busiest_part
from baroarma.recording import Recording

Signal = NDArray[np.float64]

STEP: Final = 0.25
"""Seconds of the means that are compared, and of the lags that are tried."""
SPANS: Final = (4, 8)
"""Steps of tau, 1 and 2 s: the longer shows gentle lifts, the shorter is surer."""
LONGEST_LAG: Final = 20
"""Steps, 5 s, by which the clocks may differ and be found."""
STRONG: Final = 0.5
"""m by which a change counts as motion, by the accelerometer."""
BEYOND_NOISE: Final = 4.0
"""The barometer, noisier, must see so many times more alone."""
FEWEST: Final = 24
"""Steps of motion per second of tau below which nothing is said."""
SURE: Final = 0.7
"""Correlation of an explanation that may be right; honest logs have 0.67 to 1."""
WORSE: Final = 0.6
"""Correlation without a shift over that with it, from which the shift is believed: honest logs have 0.98."""
LEAST_LAG: Final = 2
"""Steps, 0.5 s, of an offset that is told; a barometer's own filter is late by less."""
FEET: Final = (2.5, 4.3)
"""Heights over what the accelerometer makes of them, of feet (3.28): honest logs have 0.6 to 1.4."""
UNRELATED: Final = 0.35
"""Greatest correlation at any lag of two recordings that have nothing in common."""


class _Changes(NamedTuple):
    """Second differences of the height, m: by the accelerometer, and by the barometer, (n,) each."""

    pushed: Signal
    risen: Signal
    tau: float

    def correlations(self) -> Signal:
        """Return the correlation at all lags of the barometer, from -`LONGEST_LAG` on."""
        lags = range(-LONGEST_LAG, LONGEST_LAG + 1)
        return np.array([self._correlation(lag) for lag in lags])

    def _correlation(self, lag: int) -> float:
        n = len(self.pushed) - abs(lag)
        x, y = self.pushed[max(-lag, 0) :][:n], self.risen[max(lag, 0) :][:n]
        moved = (np.abs(x) > STRONG) | (np.abs(y) > BEYOND_NOISE * STRONG)
        x, y = x[moved], y[moved]
        return float(x @ y / np.sqrt(max(float(x @ x) * float(y @ y), 1e-30)))

    def slope(self) -> float:
        """Return the barometer's height over the accelerometer's."""
        return float(self.pushed @ self.risen / max(float(self.pushed @ self.pushed), 1e-30))

    def enough(self, which: Signal, size: float = STRONG) -> bool:
        """Return whether one of the two sees enough motion of a size in m."""
        return bool(np.sum(np.abs(which) > size) >= FEWEST * self.tau)


def climb_findings(recording: Recording) -> list[Finding]:
    """Return what the accelerometer says about the heights: sign ("axes"), clock ("clocks"), feet ("units").

    Examples
    --------
    >>> from dataclasses import replace
    >>> from baroarma.simulation import simulate
    >>> log = simulate("squat", duration=120, seed=1)
    >>> climb_findings(log)
    []
    >>> late = replace(log, pressure=np.roll(log.pressure, 50))  # a second at 50 Hz
    >>> print(climb_findings(late)[0])
    warning (clocks): From 0 to 120 s the barometer comes about 1.25 s after the accelerometer...
    """
    if recording.accel is None:
        return []
    part = busiest_part(recording)
    half = len(part) // 2
    for rows in (slice(None), slice(half), slice(half, None)):  # clocks that drift differ only in a half
        chosen = part.rows(rows)
        for span in SPANS:
            changes = _changes(chosen, span)
            if changes is not None and (found := _judged(changes, chosen)):
                return [found]
    return []


def _changes(recording: Recording, span: int) -> _Changes | None:
    assert recording.accel is not None
    new, good = recording.is_new, np.isfinite(recording.accel).all(axis=1)
    if int(new.sum()) < FEWEST or int(good.sum()) < FEWEST:
        return None
    t_h, t_a = recording.t[new], recording.t[good]
    start, stop = max(t_h[0], t_a[0]), min(t_h[-1], t_a[-1])
    if stop - start < (4 * span + 2 * LONGEST_LAG) * STEP or len(t_h) < 2 * (stop - start):
        return None
    height = binned_means(t_h, recording.height()[new], start, stop, STEP)
    force = binned_means(t_a, np.linalg.norm(recording.accel[good], axis=1), start, stop, STEP)
    box = np.full(span, 1 / span)
    mean = np.convolve(height, box, "valid")
    risen = mean[2 * span :] - 2 * mean[span:-span] + mean[: -2 * span]
    smooth = np.convolve(np.convolve(box, box), box)  # three boxes: what second differences of means weigh by
    pushed = np.convolve(force - np.median(force), smooth, "valid")
    tau = span * STEP
    return _Changes(tau**2 * pushed[1:-1], risen, tau)  # three boxes end one step earlier at either end


def _judged(changes: _Changes, recording: Recording) -> Finding | None:
    if not changes.enough(changes.pushed):
        return None
    where = f"From {recording.t[0]:.4g} to {recording.t[-1]:.4g} s"
    r = changes.correlations()
    return _by_size(changes, r, where) or _by_clock(r, where) or _by_nothing(changes, r, where)


def _by_size(changes: _Changes, r: Signal, where: str) -> Finding | None:
    """Name a height that goes the other way, or too far."""
    now, lag = float(r[LONGEST_LAG]), int(np.argmax(r)) - LONGEST_LAG
    if -now > SURE and -now > 0.98 * np.abs(r).max():
        text = (
            f"{where} the height falls when the accelerometer is pushed up (correlation {now:.2f}): one of "
            f"them counts the other way, or they are about {abs(lag) * STEP:.3g} s apart; check the height's "
            "sign."
        )
        return Finding("axes", "warning", text)
    if now > SURE and FEET[0] < changes.slope() < FEET[1]:
        text = (
            f"{where} the heights change {changes.slope():.2g} times as much as the accelerometer says: they "
            "look like feet; multiply them by 0.3048."
        )
        return Finding("units", "warning", text)
    return None


def _by_clock(r: Signal, where: str) -> Finding | None:
    """Name a shift in time with which the two agree."""
    now, lag, best = float(r[LONGEST_LAG]), int(np.argmax(r)) - LONGEST_LAG, float(r.max())
    if best < SURE or now > WORSE * best or abs(lag) < LEAST_LAG:
        return None
    text = (
        f"{where} the barometer comes about {abs(lag) * STEP:.3g} s {'after' if lag > 0 else 'before'} the "
        f"accelerometer (correlation {best:.2f} when moved by that, {now:.2f} as they are); put both on one "
        "clock."
    )
    return Finding("clocks", "warning", text)


def _by_nothing(changes: _Changes, r: Signal, where: str) -> Finding | None:
    """Name two that both move a lot, but never together."""
    strong = changes.enough(changes.pushed, 2 * STRONG) and changes.enough(changes.risen, 2 * STRONG)
    if np.abs(r).max() > UNRELATED or not strong:
        return None
    text = (
        f"{where} barometer and accelerometer have nothing in common (correlation {r.max():.2f} at best, "
        f"within {LONGEST_LAG * STEP:g} s); check that they are of one recording."
    )
    return Finding("clocks", "warning", text)
