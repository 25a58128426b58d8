"""The papers' own processing: references from encoder and free fall, bias capture, plateaus, RMSE.

Height and velocity are positive up, so that SG14's h = L sin(theta) (Eq. 36) holds as printed, and its free
fall (Eq. 29) is v = -g t, h = -g t²/2.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY, altitude_pressure
from baroarma.recording import Recording

Signal = NDArray[np.float64]
REST: Final = 1.0
"""Seconds of rest at the start over which altitude and gyro are averaged [SG13, Sec. 2.4; SG14, Sec. 2.4]."""
THRESHOLD: Final = math.radians(5.0)
"""Angular rate at which encoder and gyro are aligned, rad/s [SG14, Sec. 2.3.3]."""
ENCODER_STEP: Final = 0.024
"""Seconds over which the encoder's angle is differentiated for that: six of its samples (chosen by us)."""
ENCODER_COUNTS: Final = 131_072
"""Steps per turn of the encoder (chosen by us): 5 °/s at 250 Hz are 0.02° per sample, which is lost in the
steps of a coarse one."""


def rmse(estimate: Signal, reference: Signal | float = 0.0) -> float:
    """Return the root mean square error [SG14, Eq. 28].

    Parameters
    ----------
    estimate : ndarray, shape (n,)
        Any unit.
    reference : ndarray, shape (n,), or float
        What it should be, in the same unit.

    Examples
    --------
    >>> rmse(np.array([3.0, -3.0, 3.0]))
    3.0
    """
    return float(np.sqrt(np.mean((estimate - reference) ** 2)))


def relative_altitude(recording: Recording) -> Signal:
    """Return the pressure altitude minus its mean over the first second (bias capture), m, (n,).

    Parameters
    ----------
    recording : Recording
        At rest for the first second.

    Examples
    --------
    >>> from baroarma.atmosphere import altitude_pressure
    >>> t = np.arange(20) / 10
    >>> lifted = Recording(t=t, pressure=altitude_pressure(np.where(t < 1, 200.0, 203.5)))
    >>> relative_altitude(lifted)[[0, -1]].round(6).tolist()
    [0.0, 3.5]
    """
    altitude = recording.height()
    return np.asarray(altitude - np.nanmean(altitude[recording.t - recording.t[0] < REST]))


def shrunk(recording: Recording, factor: float) -> Recording:
    """Return the recording with a barometer that reports `factor` times every change of altitude.

    What a DC gain does to slow motion and slow noise alike, without whitening anything.
    """
    from dataclasses import replace

    altitude, relative = recording.height(), relative_altitude(recording)
    return replace(recording, pressure=altitude_pressure(altitude + (factor - 1) * relative))


def with_axes_of_world(recording: Recording) -> Recording:
    """Return the recording of a sensor whose axes were the world's at the start.

    SG14 mounted it on the rod so (Sec. 2.3.3), and its vector selection goes by axes; simulated sensors sit
    at random.  Noise and bias are the same along all axes, so turning the samples is as good as remounting.

    Parameters
    ----------
    recording : Recording
        With accelerometer, gyro and reference attitude.

    Returns
    -------
    Recording
        The same motion, the first attitude being (0, 0, 0, 1).

    Examples
    --------
    >>> from baroarma.simulation import simulate
    >>> mounted = simulate("rest", duration=10, seed=1)
    >>> turned = with_axes_of_world(mounted)
    >>> abs(mounted.accel.mean(axis=0)).round(1).tolist(), abs(turned.accel.mean(axis=0)).round(1).tolist()
    ([8.9, 1.4, 3.8], [0.0, 0.0, 9.8])
    """
    from dataclasses import replace

    from scipy.spatial.transform import Rotation

    assert recording.accel is not None
    assert recording.gyro is not None
    assert recording.reference_attitude is not None
    attitude = Rotation.from_quat(np.array(recording.reference_attitude))  # SciPy wants a writable array
    mounting = attitude[0]
    return replace(
        recording,
        accel=mounting.apply(np.array(recording.accel)),
        gyro=mounting.apply(np.array(recording.gyro)),
        reference_attitude=(attitude * mounting.inv()).as_quat(),
    )


def crossing(t: Signal, rate: Signal, threshold: float = THRESHOLD) -> float:
    """Return when |rate| first reaches a threshold, linearly between samples.

    Parameters
    ----------
    t, rate : ndarray, shape (n,)
        Time in s and angular rate in rad/s.
    threshold : float
        rad/s.

    Raises
    ------
    ValueError
        If it never does.

    Examples
    --------
    >>> crossing(np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.0, -2.0]), 0.5)
    1.25
    """
    size = np.abs(rate)
    if not (size >= threshold).any():
        raise ValueError(
            f"the angular rate stays below {threshold:.3g} rad/s; there is no motion to align by"
        )
    k = int(np.argmax(size >= threshold))
    if k == 0:
        return float(t[0])
    share = (threshold - size[k - 1]) / (size[k] - size[k - 1])
    return float(t[k - 1] + share * (t[k] - t[k - 1]))


def align_encoder(recording: Recording, encoder_t: Signal, angle: Signal) -> Signal:
    """Return the encoder's angle at the recording's times [SG14, Sec. 2.3.3].

    Both clocks are set to 0 where the angular rate passes 5 °/s, and the angle is interpolated by a cubic
    spline; before the encoder's first and after its last sample it is held.

    Parameters
    ----------
    recording : Recording
        With gyro, at rest for the first second.
    encoder_t, angle : ndarray, shape (m,)
        Time on the encoder's own clock, s, and angle, rad.

    Returns
    -------
    ndarray, shape (n,)
        Angle in rad.
    """
    from scipy.interpolate import CubicSpline

    assert recording.gyro is not None
    t = recording.t
    gyro = recording.gyro - np.nanmean(recording.gyro[t - t[0] < REST], axis=0)
    half = max(1, round(ENCODER_STEP / 2 / float(np.median(np.diff(encoder_t)))))
    rate = (angle[2 * half :] - angle[: -2 * half]) / (encoder_t[2 * half :] - encoder_t[: -2 * half])
    shift = crossing(encoder_t[half:-half], rate) - crossing(t, np.linalg.norm(gyro, axis=1))
    at = np.clip(t + shift, encoder_t[0], encoder_t[-1])
    return np.asarray(CubicSpline(encoder_t, angle)(at))


def circle_reference(t: Signal, angle: Signal, arm: float) -> tuple[Signal, Signal]:
    """Return height and vertical velocity on the circle [SG14, Eqs. 36, 37].

    h = L sin(theta) and its central difference; the ends take the one-sided difference.

    Examples
    --------
    >>> height, velocity = circle_reference(np.array([0.0, 0.1, 0.2]), np.array([0.0, 0.1, 0.2]), 0.3)
    >>> round(float(velocity[1]), 3)
    0.298
    """
    height = arm * np.sin(angle)
    return height, np.asarray(np.gradient(height, t))


def free_fall(recording: Recording, drop: float) -> tuple[slice, Signal, Signal]:
    """Return the rows of the first free fall and its reference [SG14, Sec. 3.2].

    It starts where |f| falls through g/2 and lasts sqrt(2 H/g).

    Parameters
    ----------
    recording : Recording
        With accelerometer.
    drop : float
        H, m.

    Returns
    -------
    rows : slice
        Rows within the window.
    height, velocity : ndarray, shape (rows,)
        -g tau²/2 and -g tau, tau since the start; height relative to the start.

    Raises
    ------
    ValueError
        If nothing falls.
    """
    assert recording.accel is not None
    t, g = recording.t, STANDARD_GRAVITY
    lacking = g - np.linalg.norm(recording.accel, axis=1)
    start = crossing(t, np.maximum(lacking, 0.0), g / 2)
    first, last = np.searchsorted(t, (start, start + math.sqrt(2 * drop / g)), side="right")
    tau = t[first:last] - start
    return slice(int(first), int(last)), -0.5 * g * tau**2, -g * tau


def plateaus(reference: Signal, level: float, tolerance: float = 0.01) -> NDArray[np.bool_]:
    """Return the rows where a true height stays at a level to within `tolerance` (m), (n,).

    SG13 took its plateaus from the plot; the truth of a simulation says where they are.
    """
    return np.asarray(np.abs(reference - level) < tolerance)
