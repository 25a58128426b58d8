"""What happens to the pressure altitude before it is fused: an average, a whitening filter, or nothing.

SG14's conditioning block [Fig. 2, Sec. 2.1.2]: an M-point moving average over *new* samples (Method A), or
that average cascaded with the whitening filter (Method B).  The mean over the first second of rest has been
subtracted before ("bias capture"), so that the filters start at 0.

The whitening filter reports a steady height change only `dc_gain` times its size; whoever uses it says so.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.arma import ArmaModel
from baroarma.compiled import njit
from baroarma.noise_model import NoiseModel
from baroarma.whitening import WhiteningFilter, WhiteningStream

CONDITIONINGS: Final = ("none", "average", "average+whitening")
"""What a user may choose."""
AVERAGE: Final = 4
"""Points of the moving average [SG13, SG14: printed]."""
FARTHEST: Final = 35_000.0
"""Metres from the start at which no barometer works: 0 Pa from a sensor that restarts is 44 km, a broken
transfer any number (chosen by us)."""
SG14_ARMA: Final = ArmaModel(ar=(-0.87,), ma=(-0.50,), sd=1.0, dt=0.1)
"""The whitening filter that the papers really used, DC gain 0.21 (chosen by us from their printed gain)."""


def sg14_whitening(noise: NoiseModel | None, rate_hz: float) -> WhiteningFilter:
    """Return Method B's whitening filter: of the identified noise, else the papers' own; unity at Nyquist.

    Parameters
    ----------
    noise : NoiseModel or None
        The altimeter's noise; None: SG14's.
    rate_hz : float
        Rate of the barometer's new samples, Hz.
    """
    source = SG14_ARMA if noise is None else noise
    return source.whitening_filter(rate_hz=rate_hz, unity_gain_hz=rate_hz / 2)


def conditioner_of(name: str, noise: NoiseModel | None, rate_hz: float) -> Conditioner:
    """Return a new conditioner by name, one of `CONDITIONINGS`; the rest as in `sg14_whitening`."""
    whitening = sg14_whitening(noise, rate_hz) if name == "average+whitening" else None
    return Conditioner(average=1 if name == "none" else AVERAGE, whitening=whitening)


class Conditioner:
    """Condition the altitude, one sample at a time or all at once, with the same numbers.

    Parameters
    ----------
    average : int
        Points of the moving average over new samples; fewer at the start.
    whitening : WhiteningFilter, optional
        Filter behind the average.

    Examples
    --------
    >>> Conditioner(average=2).run(np.array([1.0, 3.0, np.nan, 5.0])).tolist()
    [1.0, 2.0, nan, 4.0]
    """

    def __init__(self, *, average: int = 1, whitening: WhiteningFilter | None = None) -> None:
        self.whitening = whitening
        self._recent: deque[float] = deque(maxlen=average)
        self._stream = whitening.stream() if whitening else None

    def step(self, altitude: float) -> float:
        """Take one altitude in m; NaN (no new sample), or one too far, gives NaN and changes nothing."""
        if not abs(altitude) <= FARTHEST:
            return math.nan
        self._recent.append(altitude)
        total = 0.0
        for value in self._recent:
            total += value
        mean = total / len(self._recent)
        return self._stream.step(mean) if self._stream else mean

    def run(self, altitude: NDArray[np.float64]) -> NDArray[np.float64]:
        """Take all altitudes (n,), NaN where there is no new sample."""
        far = np.abs(altitude) > FARTHEST
        if far.any():
            altitude = np.where(far, np.nan, altitude)
        if self._recent.maxlen == 1 and self._stream is None:
            return altitude
        recent, out = np.zeros(self._recent.maxlen or 1), np.empty(len(altitude))
        count = len(self._recent)
        recent[:count] = self._recent
        count = _average(altitude, recent, count, out)
        self._recent.extend(recent[:count].tolist())
        if self._stream is not None:
            self._whiten(self._stream, out)
        return out

    @staticmethod
    def _whiten(stream: WhiteningStream, means: NDArray[np.float64]) -> None:
        """Filter in place, and leave the stream where `step` would."""
        new = np.flatnonzero(np.isfinite(means))
        if len(new) == 0:
            return
        if stream.delay is None:
            stream.start(float(means[new[0]]))
        delay = np.array(stream.delay, float)
        _filter(means, np.array(stream.b), np.array(stream.a), delay)
        stream.delay = delay.tolist()


@njit(cache=True)
def _average(
    altitude: NDArray[np.float64], recent: NDArray[np.float64], count: int, out: NDArray[np.float64]
) -> int:
    """Fill `out` with means of the last samples; `recent` holds `count` of them, oldest first."""
    for k in range(len(altitude)):
        out[k] = altitude[k]
        if math.isnan(altitude[k]):
            continue
        if count == len(recent):
            count -= 1
            for i in range(count):
                recent[i] = recent[i + 1]
        recent[count] = altitude[k]
        count += 1
        total = 0.0
        for i in range(count):
            total += recent[i]
        out[k] = total / count
    return count


@njit(cache=True)
def _filter(
    x: NDArray[np.float64], b: NDArray[np.float64], a: NDArray[np.float64], delay: NDArray[np.float64]
) -> None:
    """Do in place what `WhiteningStream.step` does, in its order: direct form II transposed."""
    order = len(delay)
    for k in range(len(x)):
        if math.isnan(x[k]):
            continue
        y = b[0] * x[k] + (delay[0] if order > 0 else 0.0)
        for i in range(order):
            later = delay[i + 1] if i + 1 < order else 0.0
            delay[i] = later + b[i + 1] * x[k] - a[i + 1] * y
        x[k] = y
