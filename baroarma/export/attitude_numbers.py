"""The constants that the attitude filters' C reads, taken from the estimator objects."""

from __future__ import annotations

from typing import Any

import numpy as np

from baroarma.estimators.attitude import robust_kernels
from baroarma.estimators.attitude.robust import ACCEL_NOISE_SD, GYRO_NOISE_SD, LEAST_NOISE
from baroarma.estimators.attitude.samples import LEAST_FORCE, LEVELLING_SD
from baroarma.estimators.base import LONGEST_HOLD
from baroarma.export.c_text import Number, Numbers


def tilt_kalman(attitude: Any) -> Numbers:
    """Return what `tilt_kalman.c` reads."""
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


def robust(attitude: Any) -> Numbers:
    """Return what `robust.c` reads."""
    s = attitude.chosen
    gyro_noise_sd, accel_noise_sd = np.nan_to_num([s.gyro_noise_sd, s.accel_noise_sd]).tolist()
    return (
        Number("GYRO_NOISE_SD", gyro_noise_sd, "of one sample, rad/s; 0: what the alignment says"),
        Number("ACCEL_NOISE_SD", accel_noise_sd, "of one sample, m/s²; 0: what the alignment says"),
        Number("USUAL_GYRO_NOISE_SD", GYRO_NOISE_SD, "where it says nothing, rad/s"),
        Number("USUAL_ACCEL_NOISE_SD", ACCEL_NOISE_SD, "where it says nothing, m/s²"),
        Number("INITIAL_SD", attitude.initial_sd.tolist(), "of tilt, rad, velocity, m/s, bias, rad/s, scale"),
        Number("BIAS_FROM_ALIGNMENT", attitude.bias_sd is None, "1: the alignment adds to the bias's sd"),
        Number("BIAS_WALK", s.bias_walk, "of the gyro, rad/s per root second"),
        Number("RATE_ERROR", s.rate_error, "share of a rate that neither bias nor scale explains"),
        Number("FORCE_ERROR", s.force_error, "share of an acceleration that the sensor tells wrongly"),
        Number("PERSISTENCE", robust_kernels.PERSISTENCE, "how long these two keep their sign, s"),
        Number("TURN_BEND", robust_kernels.TURN_BEND, "by which a trapezoid misses a turn, rad/s³"),
        Number("PUSH_BEND", robust_kernels.PUSH_BEND, "by which it misses a change of velocity, m/s⁴"),
        Number("VELOCITY_SD", s.velocity_sd, "of a horizontal velocity, m/s"),
        Number("VELOCITY_TIME", s.velocity_time, "how long it remembers, s"),
        Number("UNUSUAL", robust_kernels.UNUSUAL, "sds from which a velocity is a ride"),
        Number("TOP_SPEED", s.top_speed, "nobody is faster, m/s"),
        Number("INTERVAL", s.interval, "between levellings, s"),
        Number("LATENCY", s.latency, "by which IMU samples come late, s"),
        Number("LONGEST_HOLD", LONGEST_HOLD, "a missing sample is replaced by the last one so long, s"),
        Number("LEVELLING_SD", LEVELLING_SD, "of a tilt taken anew, rad"),
        Number("LEVELLED_SD", robust_kernels.LEVELLED_SD, "of a tilt by a mean force, rad"),
        Number("BLIND_TURN", robust_kernels.BLIND_TURN, "so long without gyro the tilt is doubtful, s"),
        Number("FORCE_JUMP", robust_kernels.FORCE_JUMP, "what jumps by more is to be seen twice, m/s²"),
        Number("RATE_JUMP", robust_kernels.RATE_JUMP, "likewise, rad/s"),
        Number("PATIENCE", robust_kernels.PATIENCE, "samples that may be passed over at a stretch"),
        Number("REGAINED", robust_kernels.REGAINED, "of one more, by each that does not jump"),
        Number("LEAST_NOISE", LEAST_NOISE, "an ideal sensor has less, and may repeat itself, m/s² and rad/s"),
        Number("MOVING_FORCE", robust_kernels.MOVING_FORCE, "off gravity by more is no rest, m/s²"),
        Number("MOVING_RATE", robust_kernels.MOVING_RATE, "nor is a faster turn, rad/s"),
        Number("RIDE_SD", robust_kernels.RIDE_SD, "of a velocity of which nothing is known, m/s"),
    )


def quaternion_ekf(attitude: Any) -> Numbers:
    """Return what `quaternion_ekf.c` reads."""
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
        Number("LEAST_FORCE", LEAST_FORCE, "a smaller specific force is free fall, m/s²"),
    )
