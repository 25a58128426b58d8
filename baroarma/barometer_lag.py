"""How late a barometer is: the time constant of its own low-pass filter, from a log with motion.

A barometer that smooths (a BMP280 with its filter on, an LPS25H's average) reports the height of a moment
ago.  `coloured-kalman` can carry the low-passed height in its state; the likelihood of the altitudes, as a
function of the time constant, says which one the log supports.  The interval is that of the profile
likelihood: what lies less than 1.92 below the maximum.  It knows of noise and bias, not of the IMU's scale
errors, and covers the truth less often than it says where those matter or rests come and go: in 15 of 20 logs
of squats with pauses and a BMI270's errors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from baroarma.estimators.height.coloured_kalman import ColouredKalman
from baroarma.noise_model import NoiseModel
from baroarma.recording import Recording
from baroarma.tracker import Tracker

HALF_CHI2: Final = 1.9207
"""Half of the 95 % quantile of chi² with one degree of freedom."""
_GRID: Final = 12
_PRECISION: Final = 1e-3  # s


@dataclass(frozen=True)
class BarometerLag:
    """Hold a barometer's time constant.

    Parameters
    ----------
    seconds : float
        Where the likelihood is greatest, s.
    ci95 : tuple of float
        95 % interval, s.
    gain : float
        How much log-likelihood it gains on a barometer without lag.
    longest : float
        Where the search ended, s.

    Examples
    --------
    `coloured-kalman` takes it, also as `Tracker(height_settings={"barometer_lag": ...})`, and has the
    low-passed height in its state:

    >>> lag = BarometerLag(seconds=0.07, ci95=(0.06, 0.08), gain=45.0, longest=1.0)
    >>> lag
    <BarometerLag 0.070 s [0.060, 0.080]: pass barometer_lag=0.07>
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> ColouredKalman(noise=noise, dt=0.02, barometer_lag=lag.seconds).states[3]
    'low_passed'
    """

    seconds: float
    ci95: tuple[float, float]
    gain: float
    longest: float

    def __repr__(self) -> str:
        low, high = self.ci95
        return f"<BarometerLag {self.seconds:.3f} s [{low:.3f}, {high:.3f}]: {self.verdict()}>"

    def summary(self) -> str:
        """Return time constant, interval and evidence as text."""
        rows = "\n".join(f"  {name:28}{value}" for name, value in self._rows())
        return f"A barometer's time constant: {self.verdict()}\n{rows}"

    def _repr_html_(self) -> str:
        from baroarma.notebook import tables
        from baroarma.page import Table

        return tables(Table(("what", "value"), tuple(self._rows()), f"Barometer's lag: {self.verdict()}"))

    def _rows(self) -> list[tuple[str, str]]:
        return [
            ("time constant", f"{self.seconds:.3f} s"),
            ("95 % interval", "{:.3f} to {:.3f} s".format(*self.ci95)),
            ("log-likelihood over no lag", f"{self.gain:.3g}"),
            ("searched up to", f"{self.longest:g} s"),
        ]

    def verdict(self) -> str:
        """Return what to do with it, in a sentence.

        Examples
        --------
        >>> BarometerLag(0.07, (0.06, 0.08), 45.0, 1.0).verdict()
        'pass barometer_lag=0.07'
        >>> BarometerLag(0.4, (0.0, 1.0), 0.3, 1.0).verdict()
        'this log has too little vertical motion to tell; log some squats or stairs'
        """
        if self.ci95[1] >= self.longest:
            return "this log has too little vertical motion to tell; log some squats or stairs"
        if self.gain < HALF_CHI2:
            return f"none that this log shows; at most {self.ci95[1]:.2g} s"
        return f"pass barometer_lag={self.seconds:.2g}"


def estimate_barometer_lag(
    recording: Recording, noise: NoiseModel, *, attitude: str = "robust", longest: float = 1.0
) -> BarometerLag:
    """Estimate the time constant of a barometer's own low-pass filter, or its latency, by maximum likelihood.

    Parameters
    ----------
    recording : Recording
        With IMU, a rest at the start and vertical motion after it.
    noise : NoiseModel
        The barometer's, identified from a rest.
    attitude : str
        Attitude estimator.
    longest : float
        Longest time constant to consider, s.

    Returns
    -------
    BarometerLag
        Time constant, interval and what to do with it.

    Raises
    ------
    ValueError
        If the recording has no IMU.

    Examples
    --------
    >>> from baroarma.simulation import DEVICES, simulate
    >>> log = simulate("squat", duration=60, device="bmp390-bmi270", seed=1)
    >>> estimate_barometer_lag(log, DEVICES["bmp390-bmi270"].barometer.noise)
    <BarometerLag 0.0... s [0.0..., 0.0...]: pass barometer_lag=0.0...>
    """
    from scipy.optimize import brentq, minimize_scalar

    if recording.accel is None or recording.gyro is None:
        raise ValueError(
            f"{recording.name or 'the recording'} has no IMU, against which a barometer could be late"
        )

    def evidence(lag: float) -> float:
        settings = {"barometer_lag": lag, "gate": math.inf}
        tracker = Tracker(noise=noise, attitude=attitude, height="coloured-kalman", height_settings=settings)
        tracker.run(recording)
        estimator = tracker.estimator
        assert isinstance(estimator, ColouredKalman)
        return estimator.evidence

    grid = np.concatenate(([0.0], np.geomspace(longest / 100, longest, _GRID - 1)))
    values = np.array([evidence(lag) for lag in grid])
    best = int(np.argmax(values))
    low, high = grid[max(best - 1, 0)], grid[min(best + 1, _GRID - 1)]
    found = minimize_scalar(lambda lag: -evidence(lag), bounds=(low, high), options={"xatol": _PRECISION})
    top, seconds = max((-float(found.fun), float(found.x)), (float(values[best]), float(grid[best])))

    def below(lag: float) -> float:
        return top - HALF_CHI2 - evidence(lag)

    lower = brentq(below, 0.0, seconds, xtol=_PRECISION) if top - values[0] > HALF_CHI2 else 0.0
    upper = brentq(below, seconds, longest, xtol=_PRECISION) if top - values[-1] > HALF_CHI2 else longest
    return BarometerLag(seconds, (float(lower), float(upper)), top - float(values[0]), longest)
