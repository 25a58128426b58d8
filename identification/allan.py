"""The Allan deviation of a height record, with its confidence band, by allantools.

The overlapping Allan deviation of *heights* averaged over tau (allantools calls such data "freq", because for
clocks they are frequencies).  White noise falls as tau^-1/2, a Gauss-Markov component has a hump near 1.9
correlation times, drift rises as tau^1/2: what `NoiseModel.allan_deviation` draws for a model.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.identification.preprocessing import new_samples, stretches

Signal = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class AllanDeviation:
    """Hold an Allan deviation and its 95 % band; arrays of shape (k,).

    Parameters
    ----------
    tau : ndarray
        Averaging times, s.
    deviation, low, high : ndarray
        Allan deviation of height and the ends of its band, m.
    duration : float
        Length of the gap-free stretch it comes from, s.

    Examples
    --------
    White noise of 1 m falls as the root of the averaging time:

    >>> found = allan_deviation(np.arange(4000) / 10, np.random.default_rng(1).normal(size=4000))
    >>> white = np.sqrt(0.1 / found.tau)
    >>> bool(((found.low < white) & (white < found.high)).all())
    True
    """

    tau: Signal
    deviation: Signal
    low: Signal
    high: Signal
    duration: float

    def __repr__(self) -> str:
        span = f"{self.tau[0]:.4g} to {self.tau[-1]:.4g} s"
        return f"<AllanDeviation at {len(self.tau)} averaging times, {span}, from {self.duration:.4g} s>"


def allan_deviation(t: ArrayLike, height: ArrayLike, *, jitter: float = 0.5) -> AllanDeviation:
    """Return the overlapping Allan deviation of the longest gap-free stretch of a height record.

    Averaging times double from one sample to an eighth of the stretch.  The band is the chi-square interval
    with Greenhall's equivalent degrees of freedom, the smaller of those for white noise and for a random
    walk: the noise here lies between the two, so that the band is rather too wide than too narrow.

    Parameters
    ----------
    t, height : array_like, shape (n,)
        Times in s and heights in m of new samples; rows whose height is NaN are left out.
    jitter : float
        Deviation of an interval from the median one that makes it a gap, as a fraction of it.

    Raises
    ------
    ValueError
        If the longest stretch has fewer than 16 samples.

    Examples
    --------
    >>> allan_deviation(np.arange(1000) / 10, np.random.default_rng(0).normal(size=1000))
    <AllanDeviation at 7 averaging times, 0.1 to 6.4 s, from 99.9 s>
    """
    t, height = new_samples(t, height)
    part = max(stretches(t, jitter), key=lambda s: s.stop - s.start)
    t, height = t[part], height[part]
    n = len(t)
    if n < 16:
        raise ValueError(f"the longest gap-free stretch has {n} samples; an Allan deviation needs 16")
    import allantools

    rate = (n - 1) / (t[-1] - t[0])
    points = 2 ** np.arange(int(math.log2(n / 8)) + 1)
    tau, deviation, _, _ = allantools.oadev(
        height - height[0], rate=rate, data_type="freq", taus=points / rate
    )
    band = np.array([_band(float(d), int(m), n) for d, m in zip(deviation, points, strict=True)])
    return AllanDeviation(tau, deviation, band[:, 0], band[:, 1], float(t[-1] - t[0]))


def _band(deviation: float, points: int, n: int) -> tuple[float, float]:
    import allantools

    edf = min(allantools.edf_greenhall(alpha, 2, points, n + 1, overlapping=True) for alpha in (0, -2))
    low, high = allantools.confidence_interval(deviation, edf=edf, ci=0.95)
    return float(low), float(high)
