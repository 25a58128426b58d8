"""Was the barometer at rest?  The IMU says so where there is one, otherwise the pressure itself.

The IMU's one-second windows are compared with the recording's own medians, so that biases and the mounting
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


def judge_stillness(recording: Recording) -> list[Finding]:
    """Return a "moving" finding if the sensor did not rest.

    Parameters
    ----------
    recording : Recording
        At least two new pressure samples.
    """
    new = recording.is_new
    return _by_imu(recording) or _by_pressure(recording.t[new], recording.height()[new])


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


def _by_imu(recording: Recording) -> list[Finding]:
    start = np.floor(recording.t - recording.t[0])
    moving = np.union1d(_turning_seconds(start, recording.gyro), _tilting_seconds(start, recording.accel))
    if not len(moving):
        return []
    seconds = int(recording.duration) + 1
    where = f"the IMU moves in {len(moving)} of {seconds} seconds, first at {moving[0]:.0f} s"
    if len(moving) < 3 or len(moving) < 0.01 * seconds:
        return [Finding("moving", "warning", f"The recording is nearly at rest: {where}.")]
    return [_no_rest(where)]


def _turning_seconds(start: Signal, gyro: Signal | None) -> Signal:
    seconds, off = _off_median(start, gyro)
    second, which, count = np.unique(seconds, return_inverse=True, return_counts=True)
    rms = np.sqrt(np.bincount(which, np.sum(off**2, axis=1)) / count)
    turning: Signal = second[rms > TURNING]
    return turning


def _tilting_seconds(start: Signal, accel: Signal | None) -> Signal:
    """Average over each second: noise and vibration vanish, tilt and acceleration stay."""
    seconds, off = _off_median(start, accel)
    second, which, count = np.unique(seconds, return_inverse=True, return_counts=True)
    means = [np.bincount(which, axis) / count for axis in off.T]
    tilting: Signal = second[np.linalg.norm(means, axis=0) > TILTING]
    return tilting


def _off_median(start: Signal, signal: Signal | None) -> tuple[Signal, Signal]:
    """Return the second that each sample lies in, (m,), and the sample minus the median, (m, 3)."""
    if signal is None or not (good := np.isfinite(signal).all(axis=1)).any():
        return np.empty(0), np.empty((0, 3))
    return start[good], signal[good] - np.median(signal[good], axis=0)


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
