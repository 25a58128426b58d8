"""What happens to the pressure altitude before it is fused: an average, a whitening filter, or nothing.

SG14's conditioning block [Fig. 2, Sec. 2.1.2]: an M-point moving average over *new* samples (Method A), or
that average cascaded with the whitening filter (Method B).  The mean over the first second of rest has been
subtracted before ("bias capture"), so that the filters start at 0.

The whitening filter reports a steady height change only `dc_gain` times its size; whoever uses it says so.
"""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.arma import ArmaModel
from baroarma.noise_model import NoiseModel
from baroarma.whitening import WhiteningFilter

CONDITIONINGS: Final = ("none", "average", "average+whitening")
"""What a user may choose."""
AVERAGE: Final = 4
"""Points of the moving average [SG13, SG14: printed]."""
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
        self._stream = whitening and whitening.stream()

    def step(self, altitude: float) -> float:
        """Take one altitude in m; NaN (no new sample) gives NaN and changes nothing."""
        if np.isnan(altitude):
            return altitude
        self._recent.append(altitude)
        mean = sum(self._recent) / len(self._recent)
        return self._stream.step(mean) if self._stream else mean

    def run(self, altitude: NDArray[np.float64]) -> NDArray[np.float64]:
        """Take all altitudes (n,), NaN where there is no new sample."""
        return np.array([self.step(value) for value in altitude.tolist()])
