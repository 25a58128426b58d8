"""Sensors that turn true motion into samples: noise, bias, scale, bandwidth, range, resolution, rate, clock.

Whatever a sensor does not have is 0 or None, and then costs neither time nor random numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import altitude_pressure
from baroarma.noise_model import NoiseModel
from baroarma.simulation.pose import Truth
from baroarma.simulation.streams import Clock, low_passed, poll, sample_times

Signal = NDArray[np.float64]


@dataclass(frozen=True)
class Barometer:
    """Describe a barometer.

    Parameters
    ----------
    noise : NoiseModel
        Noise of its raw samples, before its own filter; its drift stands for the weather.
    quantum : float
        Resolution in Pa; 0: none.
    offset_sd : float
        Spread of the units' constant errors, Pa; drawn once per recording.
    lowest, highest : float
        Range in Pa, beyond which it saturates.
    iir : float
        Coefficient c >= 1 of its recursive filter ``y += (x - y) / c``, as in Bosch's sensors; 1: none.
    rate_hz : float or None
        Its own rate; None: the log's.
    held : bool
        What a faster log has between two samples: the last one again, or NaN.
    clock : Clock
        Its clock against the log's.

    Examples
    --------
    One whose only flaw is its resolution of 10 Pa, that is 0.83 m:

    >>> coarse = Barometer(NoiseModel(0, 0, 0, rate_hz=50), quantum=10.0)
    >>> t = np.arange(3.0)
    >>> coarse.sample(lambda true: 0.83 * true, t, np.random.default_rng(1)).tolist()  # from 101325 Pa
    [101320.0, 101320.0, 101310.0]
    """

    noise: NoiseModel
    quantum: float = 1.0
    offset_sd: float = field(default=0.0, kw_only=True)
    lowest: float = field(default=0.0, kw_only=True)
    highest: float = field(default=inf, kw_only=True)
    iir: float = field(default=1.0, kw_only=True)
    rate_hz: float | None = field(default=None, kw_only=True)
    held: bool = field(default=False, kw_only=True)
    clock: Clock = field(default=Clock(), kw_only=True)

    def sample(self, height_at: Callable[[Signal], Signal], t: Signal, rng: np.random.Generator) -> Signal:
        """Return what a log with rows at t (n,) has of it, Pa.

        Parameters
        ----------
        height_at : callable
            True height in m above the ISA's sea level, (m,), at true times (m,).
        t : ndarray, shape (n,)
            The log's rows, s.
        rng : numpy.random.Generator
            For noise and offset.
        """
        stamps = sample_times(t, self.rate_hz)
        height = height_at(self.clock.true_time(stamps)) + self.noise.simulate(stamps, rng)
        pressure = altitude_pressure(height)
        if self.offset_sd:
            pressure += self.offset_sd * rng.normal()
        filtered = _recursive(pressure, self.iir)
        return poll(t, stamps, _digitise(filtered, self.lowest, self.highest, self.quantum), self.held)


@dataclass(frozen=True)
class Triad:
    """Describe what three axes do to a signal beside white noise and constant bias; units of the signal.

    Parameters
    ----------
    scale_sd : float
        Spread of the scale errors, 1; drawn once per recording and axis.
    drift_sd, drift_time : float
        Standard deviation and time constant (s) of a Gauss-Markov bias.
    limit : float
        Range: the signal saturates at plus and minus this.
    quantum : float
        Resolution; 0: none.
    bandwidth_hz : float or None
        Cut-off of the low-pass filter before sampling; None: no filter.
    order : int
        Order of that filter (Butterworth), 1 or 2.

    Examples
    --------
    A range of ±16 with a resolution of a half:

    >>> axes = Triad(limit=16.0, quantum=0.5)
    >>> axes.imperfect(np.array([[20.0, -17.0, 0.6]]), np.zeros(1), np.random.default_rng(1)).tolist()
    [[16.0, -16.0, 0.5]]
    """

    scale_sd: float = 0.0
    drift_sd: float = 0.0
    drift_time: float = 100.0
    limit: float = inf
    quantum: float = 0.0
    bandwidth_hz: float | None = None
    order: int = 2

    def imperfect(self, signal: Signal, stamps: Signal, rng: np.random.Generator) -> Signal:
        """Return a signal (n, 3), white noise and bias already in it, with the other errors.

        Parameters
        ----------
        signal : ndarray, shape (n, 3)
            In the sensor's axes.
        stamps : ndarray, shape (n,)
            When it was sampled, s.
        rng : numpy.random.Generator
            For scale errors and drift.
        """
        if self.scale_sd:
            signal = signal * (1 + self.scale_sd * rng.normal(size=3))
        if self.drift_sd:
            drift = NoiseModel(self.drift_sd, self.drift_time, 0.0, rate_hz=1.0)
            signal = signal + np.stack([drift.simulate(stamps, rng) for _ in range(3)], axis=1)
        return _digitise(signal, -self.limit, self.limit, self.quantum)


@dataclass(frozen=True)
class Imu:
    """Describe an accelerometer and a gyro: white noise per sample, a constant bias, and what else they have.

    Parameters
    ----------
    accel_sd, gyro_sd : float
        White noise of one sample, m/s² and rad/s.
    accel_bias_sd, gyro_bias_sd : float
        Spread of the biases of a unit, drawn once per recording and axis, m/s² and rad/s.
    accel, gyro : Triad
        Scale, drift, range, resolution, bandwidth; default: none of them.
    rate_hz : float or None
        Its own rate; None: the log's.
    held : bool
        What a faster log has between two samples: the last one again, or NaN.
    clock : Clock
        Its clock against the log's.

    Examples
    --------
    What a device that lies level feels of gravity, with noise; what its gyro says, with bias, too:

    >>> from baroarma.atmosphere import STANDARD_GRAVITY
    >>> def level(true):
    ...     up, still = np.tile([0.0, 0.0, STANDARD_GRAVITY], (len(true), 1)), np.zeros((len(true), 3))
    ...     quaternions = np.tile([0.0, 0.0, 0.0, 1.0], (len(true), 1))
    ...     return Truth(true, *still.T, quaternions, up, still)
    >>> imu = Imu(accel_sd=0.02, gyro_sd=0.001, accel_bias_sd=0.0, gyro_bias_sd=0.01)
    >>> accel, gyro = imu.sample(level, np.arange(5000) / 50, np.random.default_rng(1))
    >>> abs(accel.mean(axis=0)).round(2).tolist(), accel.std(axis=0).round(3).tolist()
    ([0.0, 0.0, 9.81], [0.02, 0.02, 0.02])
    >>> bool((abs(gyro.mean(axis=0)) > 5 * 0.001 / 5000**0.5).all())  # a bias, no noise
    True
    """

    accel_sd: float
    gyro_sd: float
    accel_bias_sd: float
    gyro_bias_sd: float
    accel: Triad = field(default=Triad(), kw_only=True)
    gyro: Triad = field(default=Triad(), kw_only=True)
    rate_hz: float | None = field(default=None, kw_only=True)
    held: bool = field(default=False, kw_only=True)
    clock: Clock = field(default=Clock(), kw_only=True)

    def sample(
        self, truth_at: Callable[[Signal], Truth], t: Signal, rng: np.random.Generator
    ) -> tuple[Signal, Signal]:
        """Return what a log with rows at t (n,) has of it: specific force and angular rate, each (n, 3).

        Parameters
        ----------
        truth_at : callable
            The truth at true times (m,).
        t : ndarray, shape (n,)
            The log's rows, s.
        rng : numpy.random.Generator
            For noise and biases.
        """
        stamps = sample_times(t, self.rate_hz)
        noise = rng.normal(size=(2, len(stamps), 3))
        bias = rng.normal(size=(2, 3))
        force = self._seen(lambda true: truth_at(true).force, stamps, self.accel)
        rate = self._seen(lambda true: truth_at(true).rate, stamps, self.gyro)
        force = force + self.accel_sd * noise[0] + self.accel_bias_sd * bias[0]
        rate = rate + self.gyro_sd * noise[1] + self.gyro_bias_sd * bias[1]
        accel = self.accel.imperfect(force, stamps, rng)
        gyro = self.gyro.imperfect(rate, stamps, rng)
        return poll(t, stamps, accel, self.held), poll(t, stamps, gyro, self.held)

    def _seen(self, signal_at: Callable[[Signal], Signal], stamps: Signal, triad: Triad) -> Signal:
        return low_passed(signal_at, stamps, self.clock, triad.bandwidth_hz, triad.order)


def _digitise(signal: Signal, lowest: float, highest: float, quantum: float) -> Signal:
    """Saturate, then round to the resolution."""
    signal = np.clip(signal, lowest, highest)
    return np.round(signal / quantum) * quantum if quantum else signal


def _recursive(signal: Signal, coefficient: float) -> Signal:
    """Run ``y += (x - y) / c``, settled on the first sample."""
    if coefficient == 1:
        return signal
    if not coefficient > 1:
        raise ValueError(f"the coefficient iir of a barometer must be at least 1, but it is {coefficient}")
    from scipy.signal import lfilter

    share = 1 / coefficient
    return np.asarray(lfilter([share], [1, share - 1], signal, zi=[(1 - share) * signal[0]])[0])
