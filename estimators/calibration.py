"""In-field calibration: the accelerometer's scale and offset from rests in several orientations.

At rest the specific force has the modulus g, whatever the orientation.  With f = scale * reading - offset per
axis, the six parameters follow from rests in at least six orientations by least squares on |f| - g [Lötters
et al. 1998, which SG14 uses, Sec. 2.4].  The gyro's bias is its mean over the rests.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.estimators.strapdown import quasi_static
from baroarma.recording import Recording

Signal = NDArray[np.float64]
SHORTEST_REST = 1.0
"""Seconds that a rest must last to count."""
LARGEST_SD = 0.02
"""Sd of a scale beyond which the orientations are too alike."""


@dataclass(frozen=True)
class Calibration:
    """Hold what turns readings into specific force and angular rate: f = scale * reading - offset.

    Parameters
    ----------
    accel_scale, accel_offset : tuple of float
        Per axis; 1 and m/s².
    accel_scale_sd, accel_offset_sd : tuple of float
        Their standard deviations.
    gyro_bias : tuple of float
        rad/s.
    rests : int
        Number of rests.
    residual_sd : float
        Rms of |f| - g over the rests after calibration, m/s².
    """

    accel_scale: tuple[float, ...]
    accel_offset: tuple[float, ...]
    accel_scale_sd: tuple[float, ...]
    accel_offset_sd: tuple[float, ...]
    gyro_bias: tuple[float, ...]
    rests: int
    residual_sd: float

    def apply(self, recording: Recording) -> Recording:
        """Return the recording with calibrated accelerometer and gyro."""
        if recording.accel is None or recording.gyro is None:
            raise ValueError(f"{recording.name or 'the recording'} has no accelerometer and gyro")
        return replace(
            recording,
            accel=recording.accel * np.array(self.accel_scale) - np.array(self.accel_offset),
            gyro=recording.gyro - np.array(self.gyro_bias),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON object of `baroarma calibrate`."""
        return {
            "accel_scale": list(self.accel_scale),
            "accel_offset_m_s2": list(self.accel_offset),
            "accel_scale_sd": list(self.accel_scale_sd),
            "accel_offset_sd_m_s2": list(self.accel_offset_sd),
            "gyro_bias_rad_s": list(self.gyro_bias),
            "rests": self.rests,
            "residual_sd_m_s2": self.residual_sd,
        }

    def summary(self) -> str:
        """Return the calibration as text."""
        lines = [f"{self.rests} rests, residual {self.residual_sd:.3g} m/s²"]
        rows = zip(
            "xyz",
            self.accel_scale,
            self.accel_scale_sd,
            self.accel_offset,
            self.accel_offset_sd,
            self.gyro_bias,
            strict=True,
        )
        for axis, scale, scale_sd, offset, offset_sd, bias in rows:
            lines.append(
                f"  {axis}: scale {scale:.5f} ± {scale_sd:.5f}, offset {offset:+.4f} ± {offset_sd:.4f} m/s², "
                f"gyro bias {np.rad2deg(bias):+.4f} °/s"
            )
        return "\n".join(lines)


def calibrate(recording: Recording) -> Calibration:
    """Calibrate from a recording with rests in at least six orientations.

    Parameters
    ----------
    recording : Recording
        With accelerometer and gyro.

    Returns
    -------
    Calibration
        Scale, offset, gyro bias with sds from the residuals.

    Raises
    ------
    ValueError
        If the rests are too few or too alike; the message says what to do.
    """
    from scipy.optimize import least_squares

    means, sizes, gyro_bias = _rests(recording)
    if len(means) < 6:
        raise ValueError(
            f"{recording.name or 'the recording'} has {len(means)} rests of {SHORTEST_REST:g} s; scale and "
            "offset need at least 6, in different orientations"
        )

    def misfit(parameters: Signal) -> Signal:
        force = means * parameters[:3] - parameters[3:]
        return np.sqrt(sizes) * (np.linalg.norm(force, axis=1) - STANDARD_GRAVITY)

    found = least_squares(misfit, np.array([1.0, 1, 1, 0, 0, 0]), x_scale=np.array([0.01] * 3 + [0.1] * 3))
    sd = _sds(found.jac, found.fun)
    if not np.all(sd[:3] < LARGEST_SD):
        raise ValueError(
            f"the {len(means)} rests are too alike to tell scale from offset; turn the device so that each "
            "axis points up once and down once"
        )
    return Calibration(
        _tuple(found.x[:3]),
        _tuple(found.x[3:]),
        _tuple(sd[:3]),
        _tuple(sd[3:]),
        _tuple(gyro_bias),
        len(means),
        float(np.sqrt(np.mean(found.fun**2 / sizes))),
    )


def _rests(recording: Recording) -> tuple[Signal, Signal, Signal]:
    """Return mean reading and number of samples of each rest, and the gyro's mean over all of them."""
    if recording.accel is None or recording.gyro is None:
        raise ValueError(f"{recording.name or 'the recording'} has no accelerometer and gyro to calibrate")
    good = np.isfinite(recording.accel).all(axis=1) & np.isfinite(recording.gyro).all(axis=1)
    t, accel, gyro = recording.t[good], recording.accel[good], recording.gyro[good]
    if len(t) < 2:
        raise ValueError(f"{recording.name or 'the recording'} has no complete IMU sample to calibrate with")
    static = quasi_static(t, accel, gyro)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], static, [False])).astype(int)))
    spans = [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if t[b - 1] - t[a] >= SHORTEST_REST]
    means = np.array([accel[a:b].mean(axis=0) for a, b in spans]).reshape(-1, 3)
    sizes = np.array([b - a for a, b in spans], float)
    rates = np.concatenate([gyro[a:b] for a, b in spans]) if spans else np.zeros((1, 3))
    return means, sizes, rates.mean(axis=0)


def _sds(jacobian: Signal, residuals: Signal) -> Signal:
    """Standard deviations of the parameters; with no residuals to spare, those of 5 mm/s² a rest."""
    freedom = len(residuals) - jacobian.shape[1]
    variance = (
        float(residuals @ residuals) / freedom if freedom > 0 else 25e-6 * float(np.mean(residuals != 0) + 1)
    )
    with np.errstate(divide="ignore", over="ignore"):
        covariance = np.linalg.pinv(jacobian.T @ jacobian)
    if np.linalg.matrix_rank(jacobian) < jacobian.shape[1]:
        return np.full(jacobian.shape[1], np.inf)
    return np.asarray(np.sqrt(variance * np.diag(covariance)))


def _tuple(values: Signal) -> tuple[float, ...]:
    return tuple(float(v) for v in values)
