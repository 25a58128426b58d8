"""Recordings with truth: a motion, seen by the sensors of a device."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from baroarma.recording import Recording
from baroarma.simulation.devices import DEVICES, Device
from baroarma.simulation.motions import DURATIONS, MountedMotion, mount
from baroarma.simulation.sensors import Barometer, Imu

Signal = NDArray[np.float64]
Seed = int | np.random.Generator | None


def simulate(
    motion: str,
    *,
    duration: float | None = None,
    rate_hz: float = 50.0,
    device: Device | str = "simple",
    barometer: Barometer | None = None,
    imu: Imu | Literal["of the device"] | None = "of the device",
    level: float = 100.0,
    seed: Seed = None,
    **motion_options: Any,
) -> Recording:
    """Simulate a recording with its truth.

    Parameters
    ----------
    motion : str
        One of `MOTIONS`.
    duration : float, optional
        Length, s; default: until the motion has ended (`DURATIONS`), 180 if it doesn't.
    rate_hz : float
        Rate of the rows, Hz, and of the sensors that have no rate of their own.
    device : Device or str
        The sensors, or one of `DEVICES`; default: SG13's BMP085 and a WIMU with noise and bias only.
    barometer : Barometer, optional
        Another barometer than the device's.
    imu : Imu or None
        Other inertial sensors than the device's; None: no IMU.
    level : float
        Height above sea level at the start, m.
    seed : int or numpy.random.Generator, optional
        For the same numbers again.
    **motion_options
        Of the motion; see `options_of`.

    Returns
    -------
    Recording
        With `reference` (0 at the start), `reference_velocity` and `reference_attitude`.

    Raises
    ------
    ValueError
        If motion, option or device is unknown, or there is no row; the message lists what there is.

    Examples
    --------
    >>> simulate("squat", duration=20, seed=1)
    <Recording 'squat': 1000 rows, 19.98 s, pressure 1000 samples at 50 Hz, accel, gyro, reference>
    >>> simulate("lift", duration=20, rate_hz=100, device="gy-87", speed=0.5, seed=1)
    <Recording 'lift': 2000 rows, 19.99 s, pressure 500 samples at 25 Hz, accel, gyro, reference>
    """
    rng = np.random.default_rng(seed)
    mounted = mount(motion, rng, **motion_options)
    device = _find(device)
    t = _rows(DURATIONS.get(motion, 180.0) if duration is None else duration, rate_hz)
    imu = device.imu if imu == "of the device" else imu
    return _record(mounted, t, barometer or device.barometer, imu, level, rng)


def simulate_rest(duration: float = 600.0, **options: Any) -> Recording:
    """Simulate a rest recording without IMU; options as in `simulate`.

    Parameters
    ----------
    duration : float
        Length, s.  Longer: slower noise can be identified.
    **options
        Of `simulate`.

    Returns
    -------
    Recording
        With `reference`, which is 0; with an IMU only where `imu` says so.

    Examples
    --------
    >>> simulate_rest(10, seed=1)
    <Recording 'rest': 500 rows, 9.98 s, pressure 500 samples at 50 Hz, reference>
    """
    return simulate("rest", duration=duration, **{"imu": None, **options})


def _record(
    mounted: MountedMotion,
    t: Signal,
    barometer: Barometer,
    imu: Imu | None,
    level: float,
    rng: np.random.Generator,
) -> Recording:
    accel, gyro = imu.sample(mounted, t, rng) if imu else (None, None)
    truth = mounted(t)
    return Recording(
        t=t,
        pressure=barometer.sample(lambda true: level + mounted(true).height, t, rng),
        accel=accel,
        gyro=gyro,
        reference=truth.height,
        reference_velocity=truth.velocity,
        reference_attitude=truth.attitude,
        name=mounted.motion,
    )


def _find(device: Device | str) -> Device:
    if isinstance(device, Device):
        return device
    if device not in DEVICES:
        raise ValueError(f"device {device!r} is unknown; choose one of {', '.join(DEVICES)}")
    return DEVICES[device]


def _rows(duration: float, rate_hz: float) -> Signal:
    if not (rate_hz > 0 and 1 <= duration * rate_hz <= 1e9):
        raise ValueError(f"{duration:g} s at {rate_hz:g} Hz make no recording; both must be positive")
    return np.arange(round(duration * rate_hz)) / rate_hz
