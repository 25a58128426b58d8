"""The noise of an IMU in six numbers: what a prediction needs to know about accelerometer and gyro.

White noise is given as a two-sided density d, as in `NoiseModel`: a sample of it has the sd d sqrt(rate), and
an integrated gyro wanders by d rad in a second.  A data sheet's density is one-sided; divide it by sqrt(2).

A rest recording tells the density by the means m_i of successive fifths of a second,

    d² = 0.2 s · median (m_{i+1} - m_i)² / (2 · 0.455),

the Allan variance there, taken by the median (0.455: that of a chi-square variable with one degree of
freedom), so that a bump does not count: long enough for the sensor's own low-pass filter to hide nothing,
short enough for no bias to have moved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.recording import Recording

Signal = NDArray[np.float64]

SHORT: Final = 0.2
"""Length in s of the means that tell the white noise."""
WANDER_TIME: Final = 100.0
"""Time in s over which biases move (chosen by us, as the simulated devices have it)."""
SHORTEST_REST: Final = 10.0
"""Rest in s that is needed at least; the density is then known to about 7 %."""
TURNED: Final = 0.1
"""Change of a second's mean angular rate, rad/s, that no bias makes."""
TILTED: Final = 0.3
"""Change of a second's mean specific force, m/s², that no bias makes: a tilt by 1.8 degrees."""
_CHI_SQUARE_MEDIAN: Final = 0.45494


@dataclass(frozen=True, repr=False)
class ImuNoise:
    """Describe the noise of an accelerometer and a gyro.

    Parameters
    ----------
    accel_density : float
        Accelerometer's white noise, m/s²/sqrt(Hz), two-sided.
    gyro_density : float
        Gyro's white noise, rad/s/sqrt(Hz), two-sided.
    accel_bias_sd : float
        Spread of the accelerometer's bias, m/s².  A rest takes its vertical part away; the horizontal part
        stays as a tilt.
    gyro_bias_sd : float
        How far the gyro's bias moves from where a rest found it, rad/s.
    accel_wander_sd : float
        How far the accelerometer's bias moves from where a rest found it, m/s²: the sd of a Gauss-Markov
        process of `WANDER_TIME` s.
    rate_hz : float
        Rate of the samples, Hz.

    Raises
    ------
    ValueError
        If a value is negative or not finite, or the accelerometer has no noise at all.

    Examples
    --------
    >>> imu = ImuNoise.of_device("simple")
    >>> print(repr(imu).partition("; ")[0])
    <ImuNoise at 50 Hz: accel 0.003467 m/s²/√Hz, bias 0.01961 m/s², wander 0 m/s²
    >>> round(imu.accel_sd / STANDARD_GRAVITY, 6)
    0.0025
    """

    accel_density: float
    gyro_density: float = 0.0
    accel_bias_sd: float = 0.0
    gyro_bias_sd: float = 0.0
    accel_wander_sd: float = 0.0
    rate_hz: float = field(kw_only=True)

    def __post_init__(self) -> None:
        for name in (f.name for f in fields(self)):
            value = float(getattr(self, name))
            if not (math.isfinite(value) and value >= 0):
                raise ValueError(f"{name} must be a number >= 0, but it is {value}")
            object.__setattr__(self, name, value)
        for name in ("accel_density", "rate_hz"):
            if getattr(self, name) == 0:
                raise ValueError(f"{name} must be positive, but it is 0: no accelerometer is free of noise")

    def __repr__(self) -> str:
        return (
            f"<ImuNoise at {self.rate_hz:.4g} Hz: accel {self.accel_density:.4g} m/s²/√Hz, "
            f"bias {self.accel_bias_sd:.4g} m/s², wander {self.accel_wander_sd:.4g} m/s²; "
            f"gyro {self.gyro_density:.4g} rad/s/√Hz, bias {self.gyro_bias_sd:.4g} rad/s>"
        )

    @property
    def accel_sd(self) -> float:
        """White noise of one accelerometer sample, m/s²."""
        return self.accel_density * math.sqrt(self.rate_hz)

    @property
    def gyro_sd(self) -> float:
        """White noise of one gyro sample, rad/s."""
        return self.gyro_density * math.sqrt(self.rate_hz)

    def summary(self) -> str:
        """Return densities, sds and biases as text."""
        rows = (f"  {name:26}{accel:22}{gyro}" for name, accel, gyro in self._rows())
        return "\n".join([f"IMU at {self.rate_hz:.4g} Hz", f"  {'':26}{'accelerometer':22}gyro", *rows])

    def _repr_html_(self) -> str:
        from baroarma.notebook import tables
        from baroarma.page import Table

        head = ("", "accelerometer", "gyro")
        return tables(Table(head, tuple(self._rows()), f"Noise of an IMU at {self.rate_hz:.4g} Hz"))

    def _rows(self) -> list[tuple[str, str, str]]:
        return [
            (
                "white, two-sided density",
                f"{self.accel_density:.4g} m/s²/√Hz",
                f"{self.gyro_density:.4g} rad/s/√Hz",
            ),
            ("white, sd of a sample", f"{self.accel_sd:.4g} m/s²", f"{self.gyro_sd:.4g} rad/s"),
            ("bias, sd", f"{self.accel_bias_sd:.4g} m/s²", f"{self.gyro_bias_sd:.4g} rad/s"),
            ("wander after a rest, sd", f"{self.accel_wander_sd:.4g} m/s²", "in the bias"),
        ]

    def to_dict(self) -> dict[str, float]:
        """Return the values by name and unit."""
        return {
            "accel_density_m_s2_sqrt_hz": self.accel_density,
            "gyro_density_rad_s_sqrt_hz": self.gyro_density,
            "accel_bias_sd_m_s2": self.accel_bias_sd,
            "gyro_bias_sd_rad_s": self.gyro_bias_sd,
            "accel_wander_sd_m_s2": self.accel_wander_sd,
            "rate_hz": self.rate_hz,
        }

    @classmethod
    def of_device(cls, name: str, *, rate_hz: float = 50.0) -> ImuNoise:
        """Return the noise of a device's IMU, by its name in `baroarma.simulation.DEVICES`.

        Parameters
        ----------
        name : str
            Such as "simple" or "wimu".
        rate_hz : float
            Rate in Hz of a log of it, for an IMU without a rate of its own.

        Raises
        ------
        ValueError
            If there is no such device, or it has no IMU; the message lists the devices.
        """
        from baroarma.simulation import DEVICES

        if name not in DEVICES:
            raise ValueError(f"device {name!r} is unknown; choose one of {', '.join(DEVICES)}")
        imu = DEVICES[name].imu
        if imu is None:
            raise ValueError(f"the device {name!r} has no IMU; there is nothing to predict with")
        rate_hz = rate_hz if imu.rate_hz is None else min(rate_hz, imu.rate_hz)
        return cls(
            accel_density=imu.accel_sd / math.sqrt(rate_hz),
            gyro_density=imu.gyro_sd / math.sqrt(rate_hz),
            accel_bias_sd=imu.accel_bias_sd,
            gyro_bias_sd=imu.gyro.drift_sd,
            accel_wander_sd=imu.accel.drift_sd,
            rate_hz=rate_hz,
        )

    @classmethod
    def from_recording(cls, rest: Recording, *, gravity: float = STANDARD_GRAVITY) -> ImuNoise:
        """Measure the noise in a motionless recording of at least ten seconds.

        One recording shows one unit: `accel_bias_sd` is by how much its mean specific force differs from
        `gravity` in m/s² (standard gravity is off by up to 0.03 m/s²; ``baroarma.gravity`` knows the
        latitude's), `gyro_bias_sd` and
        `accel_wander_sd` how far the means of its seconds wander beyond the white noise: minutes of rest
        show more of that than ten seconds.

        Raises
        ------
        ValueError
            If there is no IMU, the recording is too short, or the sensor moved.

        Examples
        --------
        >>> from baroarma.simulation import simulate
        >>> imu = ImuNoise.from_recording(simulate("rest", duration=120, seed=1))
        >>> round(imu.accel_density / ImuNoise.of_device("simple").accel_density, 1), round(imu.rate_hz)
        (1.0, 50)
        """
        if rest.accel is None or rest.gyro is None:
            raise ValueError(
                f"{_name(rest)} has no accelerometer and gyro to measure; log a rest with both, or say their "
                "noise by hand with ImuNoise(...)"
            )
        rate_hz, accel = _samples(rest, rest.accel)
        gyro_hz, gyro = _samples(rest, rest.gyro)
        _refuse_motion(rest, _means(accel, rate_hz, 1.0), _means(gyro, gyro_hz, 1.0))
        return cls(
            accel_density=_density(accel, rate_hz),
            gyro_density=_density(gyro, gyro_hz),
            accel_bias_sd=abs(float(np.linalg.norm(accel.mean(axis=0))) - gravity),
            gyro_bias_sd=_wander(gyro, gyro_hz),
            accel_wander_sd=_wander(accel, rate_hz),
            rate_hz=rate_hz,
        )


def _samples(rest: Recording, signal: Signal) -> tuple[float, Signal]:
    """Return the rate in Hz of a sensor's new samples, and these, (m, 3)."""
    new = np.isfinite(signal).all(axis=1)
    t = rest.t[new]
    if len(t) < 2 or t[-1] - t[0] < SHORTEST_REST:
        lasts = t[-1] - t[0] if len(t) else 0.0
        raise ValueError(
            f"{_name(rest)} has {lasts:.3g} s of IMU samples; at least {SHORTEST_REST:g} s of rest are needed"
        )
    return float(1 / np.median(np.diff(t))), signal[new]


def _means(signal: Signal, rate_hz: float, duration: float) -> Signal:
    """Average (n, 3) over successive durations in s, (m, 3)."""
    points = max(1, round(duration * rate_hz))
    n = len(signal) // points
    return np.asarray(signal[: n * points].reshape(n, points, 3).mean(axis=1))


def _density(signal: Signal, rate_hz: float) -> float:
    """Return the square root of the two-sided density of the white noise (module docstring)."""
    points = max(1, round(SHORT * rate_hz))
    change = np.diff(_means(signal, rate_hz, points / rate_hz), axis=0)
    variance = float(np.median(change**2)) / (2 * _CHI_SQUARE_MEDIAN)
    return math.sqrt(variance * points / rate_hz)


def _wander(signal: Signal, rate_hz: float) -> float:
    """Return by how much the means of seconds spread beyond the white noise."""
    seconds = _means(signal, rate_hz, 1.0)
    beyond = float(np.mean(np.var(seconds, axis=0, ddof=1))) - _density(signal, rate_hz) ** 2
    return math.sqrt(max(beyond, 0.0))


def _refuse_motion(rest: Recording, force: Signal, rate: Signal) -> None:
    tilted = float(np.linalg.norm(force - np.median(force, axis=0), axis=1).max())
    turned = float(np.linalg.norm(rate - np.median(rate, axis=0), axis=1).max())
    if tilted > TILTED or turned > TURNED:
        raise ValueError(
            f"{_name(rest)} is not at rest (a second's mean of the specific force is off by {tilted:.2g} "
            f"m/s², of the angular rate by {turned:.2g} rad/s); cut the rest out or log the sensor where it "
            "lies still"
        )


def _name(rest: Recording) -> str:
    return rest.name or "the recording"
