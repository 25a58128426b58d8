"""Simulated recordings with truth: a motion, seen by the sensors of a device."""

from __future__ import annotations

from typing import Any

import numpy as np

from baroarma.recording import Recording
from baroarma.simulation.motions import MOTIONS, move
from baroarma.simulation.sensors import BMP085, WIMU, Barometer, Imu

__all__ = ["BMP085", "MOTIONS", "WIMU", "Barometer", "Imu", "simulate", "simulate_rest"]


def simulate(
    motion: str,
    *,
    duration: float = 180.0,
    rate_hz: float = 50.0,
    barometer: Barometer = BMP085,
    imu: Imu | None = WIMU,
    level: float = 100.0,
    seed: int | np.random.Generator | None = None,
) -> Recording:
    """Simulate a recording with its truth.

    Parameters
    ----------
    motion : str
        One of `MOTIONS`.
    duration : float
        Length, s.
    rate_hz : float
        Rate of all sensors, Hz.
    barometer : Barometer
        The barometer; default: SG13's BMP085.
    imu : Imu or None
        The inertial sensors; None: no IMU.
    level : float
        Height above sea level at the start, m.
    seed : int or numpy.random.Generator, optional
        For the same numbers again.

    Returns
    -------
    Recording
        With `reference`, `reference_velocity` and `reference_attitude`.

    Examples
    --------
    >>> simulate("squat", duration=20, seed=1)
    <Recording 'squat': 1000 rows, 19.98 s, pressure 1000 samples at 50 Hz, accel, gyro, reference>
    """
    rng = np.random.default_rng(seed)
    t = np.arange(round(duration * rate_hz)) / rate_hz
    truth = move(motion, t, rng)
    accel, gyro = imu.sample(truth.force, truth.rate, rng) if imu else (None, None)
    return Recording(
        t=t,
        pressure=barometer.sample(t, level + truth.height, rng),
        accel=accel,
        gyro=gyro,
        reference=truth.height,
        reference_velocity=truth.velocity,
        reference_attitude=truth.attitude,
        name=motion,
    )


def simulate_rest(duration: float = 600.0, **options: Any) -> Recording:
    """Simulate a rest recording without IMU; options as in `simulate`."""
    return simulate("rest", duration=duration, **{"imu": None, **options})
