"""Was the barometer at rest?  The IMU says so where there is one, otherwise the pressure itself.

The IMU's one-second windows are compared with the medians of their means, so that biases and the mounting
don't matter: a turning sensor shows in the gyro, a tilted or accelerated one in the mean specific force.

The pressure alone sees height changes between ten-second means.  Gusts change them by up to a metre, stairs
by two; what lies between is motion if it is far outside the recording's other changes, or if the changes go
one way: a random walk of N steps hardly ever covers more than 3 sqrt(N) of them.

Smaller bumps show once there is a model, in its prediction errors.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import pressure_altitude
from baroarma.finding import Finding
from baroarma.recording import Recording

Signal = NDArray[np.float64]

TURNING: Final = 0.1
"""Angular rate in rad/s (RMS over a second) of a sensor that moves."""
TILTING: Final = 0.3
"""Change of the mean specific force in m/s² of a sensor that moves: a tilt by 1.8 degrees."""
BLOCK: Final = 10.0
"""Length in s of the means that tell motion from noise by pressure."""
REST_CHANGE: Final = 1.2
"""Largest change in m of neighbouring means that needs no second look: wind on a launch pad reaches 0.64."""
SURE_CHANGE: Final = 2.0
"""A change in m that no wind makes within ten seconds."""
OUTSTANDING: Final = 6.0
"""A change beyond so many robust standard deviations of the others is none of them."""
DISTURBED: Final = 6.0
"""Prediction errors that add up to so many standard deviations in a second are not the noise's own: real
recordings at rest reach 4.6, and of Gaussian nights of eight hours one in 18 000 has such a second."""
ONE_WAY: Final = 3.0
"""Range of the means over the root sum of their squared changes; a random walk exceeds it in 1 % of cases."""
ROWS: Final = 1 << 18
"""Rows that are looked at together: more only need more memory."""


def judge_stillness(recording: Recording) -> list[Finding]:
    """Return a "moving" finding if the sensor did not rest.

    Parameters
    ----------
    recording : Recording
        At least two new pressure samples.
    """
    new, imu = recording.is_new, ImuSeconds()
    imu.take(recording)
    found = imu.findings(recording.duration)
    return found or _by_pressure(recording.t[new], pressure_altitude(recording.pressure[new]))


def judge_disturbance(t: Signal, residuals: Signal) -> list[Finding]:
    """Return a "moving" warning if a second of the recording is unlike all others: somebody touched it.

    Bumps that are too small for `judge_stillness` hide in the noise of one sample, but not in the sum of a
    second's prediction errors, each of variance 1.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times of the samples, s.
    residuals : ndarray, shape (n,)
        Standardised one-step prediction errors of the model at these times.
    """
    second, which, count = np.unique(np.floor(t - t[0]), return_inverse=True, return_counts=True)
    sums = np.abs(np.bincount(which, residuals) / np.sqrt(count))
    # where the model does not fit, errors add up everywhere
    usual = max(1.0, 1.4826 * float(np.median(sums)))
    worst = int(np.argmax(sums))
    if sums[worst] < DISTURBED * usual:
        return []
    message = (
        f"The recording is nearly at rest: near {t[0] + second[worst]:.4g} s the height changes as this "
        f"noise does not ({sums[worst] / usual:.3g} standard deviations within a second); a bump, a door or "
        "a gust is in the model now: cut it out or log again."
    )
    return [Finding("moving", "warning", message)]


class ImuSeconds:
    """Keep of an IMU what tells rest from motion: counts, sums and squares of each second, part by part."""

    def __init__(self) -> None:
        self._start = np.nan
        self._gyro: list[Signal] = []
        self._accel: list[Signal] = []

    def take(self, recording: Recording) -> None:
        """Take a recording's next rows."""
        if np.isnan(self._start):
            self._start = float(recording.t[0])
        for k in range(0, len(recording), ROWS):
            rows = slice(k, k + ROWS)
            second = np.floor(recording.t[rows] - self._start)
            for signal, sums in ((recording.gyro, self._gyro), (recording.accel, self._accel)):
                if signal is not None:
                    sums.append(_sums(second, signal[rows]))

    def findings(self, duration: float) -> list[Finding]:
        """Return a "moving" finding if the IMU did not rest during these seconds."""
        moving = np.union1d(self._turning(), self._tilting())
        if not len(moving):
            return []
        seconds = int(duration) + 1
        where = f"the IMU moves in {len(moving)} of {seconds} seconds, first at {moving[0]:.0f} s"
        if len(moving) < 3 or len(moving) < 0.01 * seconds:
            return [Finding("moving", "warning", f"The recording is nearly at rest: {where}.")]
        return [_no_rest(where)]

    def _turning(self) -> Signal:
        second, mean, square = _means(self._gyro)
        bias = _centre(mean)
        turning: Signal = second[square - 2 * mean @ bias + bias @ bias > TURNING**2]
        return turning

    def _tilting(self) -> Signal:
        """Return the seconds whose mean is off: noise and vibration vanish in it, tilts stay."""
        second, mean, _ = _means(self._accel)
        tilting: Signal = second[np.linalg.norm(mean - _centre(mean), axis=1) > TILTING]
        return tilting


def _sums(second: Signal, signal: Signal) -> Signal:
    """Return rows of second, count, sums of x, y, z and sum of squares, (m, 6)."""
    good = np.isfinite(signal).all(axis=1)
    own, which, count = np.unique(second[good], return_inverse=True, return_counts=True)
    x = signal[good]
    sums = [np.bincount(which, weights, len(own)) for weights in (*x.T, np.sum(x**2, axis=1))]
    return np.column_stack([own, count, *sums])


def _means(parts: list[Signal]) -> tuple[Signal, Signal, Signal]:
    """Return seconds (m,), means (m, 3) and mean squares (m,); a border of parts may divide a second."""
    rows = np.concatenate([np.empty((0, 6)), *parts])
    second, which = np.unique(rows[:, 0], return_inverse=True)
    count, *sums, squares = (np.bincount(which, column, len(second)) for column in rows[:, 1:].T)
    return second, np.column_stack(sums) / count[:, None], squares / count


def _centre(mean: Signal) -> Signal:
    """Return the median of the seconds' means, which is the rest's, (3,)."""
    return np.median(mean, axis=0) if len(mean) else np.zeros(3)


def _by_pressure(t: Signal, height: Signal) -> list[Finding]:
    length = max(BLOCK, 10 * float(np.median(np.diff(t))))  # a mean of a slow sensor takes longer
    block, which, count = np.unique(np.floor((t - t[0]) / length), return_inverse=True, return_counts=True)
    full = count >= 3
    if full.sum() < 2:
        return []
    means, at = (np.bincount(which, height) / count)[full], block[full] * length
    # over a gap, or from a slow sensor, rest may change as a random walk does
    change = np.diff(means) / np.sqrt(np.diff(at) / BLOCK)
    biggest = int(np.argmax(np.abs(change)))
    size = float(np.abs(change[biggest]))
    usual = 1.4826 * float(np.median(np.abs(change)))
    one_way = float(np.ptp(means)) > ONE_WAY * float(np.linalg.norm(np.diff(means)))
    if size > SURE_CHANGE or (size > REST_CHANGE and (size > OUTSTANDING * usual or one_way)):
        metres, seconds = abs(means[biggest + 1] - means[biggest]), at[biggest + 1] - at[biggest]
        return [
            _no_rest(
                f"the height changes by {metres:.3g} m within {seconds:.3g} s near {at[biggest + 1]:.4g} s"
            )
        ]
    return []


def _no_rest(why: str) -> Finding:
    message = f"This is no rest recording: {why}; log the sensor where nothing moves it, or cut the rest out."
    return Finding("moving", "error", message)
