"""The parts that firmware is put together from: for each estimator in Python its counterpart in C.

A part is a few files of `c_source`, in order, and the constants that they read, taken from the estimator
object itself.  Every attitude is a structure ``baroarma_attitude`` with the functions

    attitude_start(s, rest)      attitude_step(s, dt, accel, gyro) -> vertical acceleration,

every conditioning a ``baroarma_conditioning`` with ``conditioning_start(s)``, ``conditioning_step(s, z)`` and
``conditioning_shift(s, zero)``, every height a ``baroarma_height`` with the state ``x`` and its covariance
``P``, height and velocity first, and

    height_start(s, rest)      height_step(s, dt, altitude, acceleration, acceleration_sd),

where ``rest`` is what the alignment has told.

A new estimator is: its C, and its line in one of the tables below.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from baroarma.estimators.attitude.kernels import LEVELLING_SD, LONGEST_HOLD
from baroarma.estimators.conditioning import AVERAGE
from baroarma.estimators.height.coloured_kalman import LEFT_BIAS_SD
from baroarma.estimators.height.complementary import LONGEST_WEIGHT
from baroarma.export.c_text import Number

Numbers = tuple[Number, ...]


@dataclass(frozen=True)
class Part:
    """Hold what the exported source needs for one estimator.

    Parameters
    ----------
    files : tuple of str
        Names in `c_source`, without suffix; a header, a source or both exist for each.  One that several
        parts name is taken once.
    numbers : callable
        Returns the constants of an estimator object.
    lacks : callable
        Says which setting of an estimator object has no counterpart in C; empty: all have.
    """

    files: tuple[str, ...]
    numbers: Callable[[Any], Numbers]
    lacks: Callable[[Any], str] = lambda estimator: ""


def _tilt_kalman(attitude: Any) -> Numbers:
    s = attitude.settings
    return (
        *_imu(attitude),
        Number("GYRO_NOISE_SD", s.gyro_noise_sd, "sd_G, rad/s per sample"),
        Number("ACCEL_NOISE_SD", s.accel_noise_sd, "sd_A, m/s²"),
        Number("ACCELERATION_MEMORY", s.acceleration_memory, "c_a"),
        Number("EXPONENTIAL", s.exponential, "1: the exponential of the turn; 0: its first two terms"),
        Number("INITIAL_TILT_SD", attitude.initial_tilt_sd, "of the alignment, rad"),
        Number("LEVELLING_SD", LEVELLING_SD, "of a tilt from one specific force, rad"),
    )


def _quaternion_ekf(attitude: Any) -> Numbers:
    s = attitude.settings
    return (
        *_imu(attitude),
        Number("GYRO_NOISE_SD", s.gyro_noise_sd, "sigma_g, rad/s per sample"),
        Number("ACCEL_NOISE_SD", s.accel_noise_sd, "sigma_a, m/s²"),
        Number("BIAS_WALK_SD", s.bias_walk_sd, "of the accelerometer bias, m/s² per root second"),
        Number("BIAS_DECAY", s.bias_decay, "alpha, 1/s"),
        Number("GATE", s.gate, "larger innovations are left out, m/s²"),
        Number("INITIAL_QUATERNION_SD", s.initial_quaternion_sd, "of the alignment"),
        Number("INITIAL_BIAS_SD", s.initial_bias_sd, "m/s²"),
    )


def _imu(attitude: Any) -> Numbers:
    return (
        Number("ATTITUDE_STATES", int(attitude.dim_x), "size of the attitude filter"),
        Number("LONGEST_HOLD", LONGEST_HOLD, "a missing gyro sample is replaced by the last one so long, s"),
    )


def _nothing(conditioner: Any) -> Numbers:
    return ()


def _average(conditioner: Any) -> Numbers:
    return (Number("AVERAGE", AVERAGE, "points of the moving average"),)


def _whitening(conditioner: Any) -> Numbers:
    w = conditioner.whitening
    (b0, b1), (_, a1) = (*w.b, 0.0)[:2], (*w.a, 0.0)[:2]
    return (
        *_average(conditioner),
        Number("B0", float(b0), f"of the whitening filter at {w.rate_hz:g} Hz"),
        Number("B1", float(b1), "likewise"),
        Number("A1", float(a1), "likewise"),
        Number("DC_GAIN", float(w.dc_gain), "what it makes of a steady height change"),
    )


def _drive(height: Any) -> Numbers:
    drive = height.drive
    return (
        Number(
            "MIDPOINT", bool(drive.midpoint), "1: integrate the mean of two accelerations; 0: the earlier"
        ),
        Number("ZUPT_STEPS", int(drive.zupt_steps), "quiet steps until there is rest; 0: never"),
        Number("ZUPT_THRESHOLD", float(drive.zupt_threshold), "largest acceleration at rest, m/s²"),
        Number("REST_SD", float(height.rest_sd), "of the velocity at rest, m/s"),
        Number("ACCELERATION_SD", float(height.acceleration_sd), "of one sample, m/s²"),
    )


def _complementary(height: Any) -> Numbers:
    # the very numbers that its own loop takes
    correlated, rate, white, drift = height._noise_parameters()
    initial = np.diag(height._initial_covariance())
    return (
        *_drive(height),
        Number("GAIN", height.gain.tolist(), "K, 1/s and 1/s²"),
        Number("LONGEST_WEIGHT", LONGEST_WEIGHT * height.time_constant, "most that a sample counts for, s"),
        Number("INITIAL_VARIANCE", initial.tolist(), "diagonal of P at the start"),
        Number("STATIONARY_VARIANCE", float(correlated), "of the Gauss-Markov noise, m²"),
        Number("DECAY_RATE", float(rate), "one over its correlation time, 1/s"),
        Number("WHITE_VARIANCE", float(white), "of one altitude, m²"),
        Number("WALK_VARIANCE", float(drift), "by which the drift grows in a second, m²/s"),
    )


def _kalman(height: Any) -> Numbers:
    return (
        *_drive(height),
        Number("STATES", len(height.states), ", ".join(height.states).replace("_", " ")),
        Number(
            "INITIAL_VARIANCE", np.diag(height.initial_covariance()).tolist(), "diagonal of P at the start"
        ),
        Number("UNRESOLVED", float(height.unresolved), "share of a change that an average may miss"),
        Number("MEASUREMENT", np.ravel(height.H).tolist(), "how the states add up to an altitude"),
        Number("R", float(np.squeeze(height.R)), "variance of an altitude's white noise, m²"),
    )


def _coloured_kalman(height: Any) -> Numbers:
    noise, names = height.noise, height.states
    walks = {"acceleration_bias": height.bias_walk**2, "offset": noise.drift_rate**2}
    variance = {"correlated": noise.correlated_sd**2}
    rate = {"correlated": 1 / noise.correlation_time} if noise.has_gauss_markov else {}
    return (
        *_kalman(height),
        Number("SD_FROM_REST", height._given[0] is None, "1: the rest tells the acceleration's sd"),
        Number("LEFT_BIAS_SD", LEFT_BIAS_SD, "what an alignment leaves of the bias, m/s²"),
        Number("DECAY_RATE", [rate.get(name, 0.0) for name in names], "1/s"),
        Number("WALK_VARIANCE", [walks.get(name, 0.0) for name in names], "growth in a second"),
        Number("STATIONARY_VARIANCE", [variance.get(name, 0.0) for name in names], "of what decays"),
    )


def _coloured_kalman_lacks(height: Any) -> str:
    if height.listens_to_rest:
        return "confirm_rest"
    if height._bank.rules.gate < math.inf:
        return "gate"
    if height.barometer_lag:
        return "barometer_lag"
    if height.level_prior_sd is not None:
        return "level_prior_sd"
    return "floors" if len(height._bank.rules.floors) else ""


def _complementary_lacks(height: Any) -> str:
    return "slow_barometer='hold'" if height.slow_barometer == "hold" else ""


ATTITUDES: Final[Mapping[str, Part]] = {
    "tilt-kalman": Part(("imu", "tilt_kalman"), _tilt_kalman),
    "quaternion-ekf": Part(("decay", "imu", "quaternion_ekf"), _quaternion_ekf),
}
"""Attitude estimators that have a counterpart in C."""
CONDITIONINGS: Final[Mapping[str, Part]] = {
    "none": Part(("no_conditioning",), _nothing),
    "average": Part(("average",), _average),
    "average+whitening": Part(("whitening",), _whitening),
}
"""Conditionings that have one."""
HEIGHTS: Final[Mapping[str, Part]] = {
    "complementary": Part(("decay", "climb", "drive", "complementary"), _complementary, _complementary_lacks),
    "kalman": Part(("climb", "drive", "kalman", "linear"), _kalman),
    "coloured-kalman": Part(
        ("decay", "climb", "drive", "coloured_kalman", "linear"), _coloured_kalman, _coloured_kalman_lacks
    ),
}
"""Height estimators that have one."""
