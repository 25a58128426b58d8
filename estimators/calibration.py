"""In-field calibration: the accelerometer's scale and offset from rests in several orientations.

At rest the specific force has the modulus g, whatever the orientation.  With f = scale * reading - offset per
axis, the six parameters follow from rests in at least six orientations by least squares on |f| - g [Lötters
et al. 1998, which SG14 uses, Sec. 2.4].  Each rest is weighted by the sd of its mean; when the rests disagree
by more than that (axes that are not square, a hand that trembles), all sds grow accordingly.  g is standard
gravity, unless it is given: a place with 0.3 % less makes all scales 0.3 % larger.  The gyro's bias is its
mean over the rests.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.estimators.strapdown import periods, quasi_static
from baroarma.recording import Recording

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Signal = NDArray[np.float64]
PARAMETERS: Final = 6
"""Three scales, three offsets."""
SHORTEST_REST: Final = 1.0
"""Seconds that a rest must last to count."""
LARGEST_SD: Final = 0.02
"""Sd of a scale beyond which the orientations are too alike."""
LARGEST_SCALE: Final = 1.25
"""Specific force at rest over standard gravity, or the inverse, beyond which no calibration is wanted."""
LARGEST_BIAS: Final = 0.6
"""rad/s: 34 deg/s, beyond the 20 deg/s of the worst data sheets."""
SMALLEST_SD: Final = 1e-4
"""Least noise of a sample that is believed, m/s²: a coarse sensor at rest may repeat one number."""


@dataclass(frozen=True, repr=False)
class Calibration:
    """Hold what turns readings into specific force and angular rate: f = scale * reading - offset.

    Parameters
    ----------
    accel_scale, accel_offset : tuple of float
        Per axis; 1 and m/s².
    accel_scale_sd, accel_offset_sd : tuple of float
        Their standard deviations.
    gyro_bias, gyro_bias_sd : tuple of float
        And its sd, rad/s.
    rests : int
        Number of rests.
    residual_sd : float
        Rms of |f| - g over the rests after calibration, m/s².

    Examples
    --------
    A calibration undoes reading = (f + offset)/scale, so that at rest |f| is g again:

    >>> found = Calibration(
    ...     accel_scale=(1.02, 1.0, 1.0), accel_offset=(0.1, 0.0, 0.0), gyro_bias=(0.01, 0.0, 0.0),
    ...     accel_scale_sd=(0.001,) * 3, accel_offset_sd=(0.01,) * 3, gyro_bias_sd=(1e-4,) * 3,
    ...     rests=6, residual_sd=0.01,
    ... )
    >>> still = np.array([[(STANDARD_GRAVITY + 0.1) / 1.02, 0.0, 0.0]])
    >>> raw = Recording(t=[0.0], pressure=[101325.0], accel=still, gyro=[[0.01, 0.0, 0.0]])
    >>> found.apply(raw).accel.round(5).tolist(), found.apply(raw).gyro.tolist()
    ([[9.80665, 0.0, 0.0]], [[0.0, 0.0, 0.0]])
    """

    accel_scale: tuple[float, ...]
    accel_offset: tuple[float, ...]
    accel_scale_sd: tuple[float, ...]
    accel_offset_sd: tuple[float, ...]
    gyro_bias: tuple[float, ...]
    gyro_bias_sd: tuple[float, ...]
    rests: int
    residual_sd: float

    def __repr__(self) -> str:
        scale, offset = (", ".join(f"{v:.4g}" for v in t) for t in (self.accel_scale, self.accel_offset))
        bias = ", ".join(f"{v:.3g}" for v in self.gyro_bias)
        return (
            f"<Calibration from {self.rests} rests: scale {scale}; offset {offset} m/s²; gyro {bias} rad/s>"
        )

    def apply(self, recording: Recording) -> Recording:
        """Return the recording with calibrated accelerometer and gyro.

        Parameters
        ----------
        recording : Recording
            With accelerometer and gyro.

        Raises
        ------
        ValueError
            If it lacks one of them.
        """
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
            "gyro_bias_sd_rad_s": list(self.gyro_bias_sd),
            "rests": self.rests,
            "residual_sd_m_s2": self.residual_sd,
        }

    def summary(self) -> str:
        """Return the calibration as text."""
        lines = [f"{self.rests} rests, residual {self.residual_sd:.3g} m/s²"]
        for i, axis in enumerate("xyz"):
            lines.append(
                f"  {axis}: scale {self.accel_scale[i]:.5f} ± {self.accel_scale_sd[i]:.5f}, "
                f"offset {self.accel_offset[i]:+.4f} ± {self.accel_offset_sd[i]:.4f} m/s², gyro bias "
                f"{np.rad2deg(self.gyro_bias[i]):+.4f} ± {np.rad2deg(self.gyro_bias_sd[i]):.4f} °/s"
            )
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from baroarma.notebook import tables
        from baroarma.page import Table

        rows = tuple(
            (
                axis,
                f"{self.accel_scale[i]:.5f} ± {self.accel_scale_sd[i]:.5f}",
                f"{self.accel_offset[i]:+.4f} ± {self.accel_offset_sd[i]:.4f}",
                f"{np.rad2deg(self.gyro_bias[i]):+.4f} ± {np.rad2deg(self.gyro_bias_sd[i]):.4f}",
            )
            for i, axis in enumerate("xyz")
        )
        head = ("axis", "accelerometer scale", "accelerometer offset (m/s²)", "gyro bias (°/s)")
        caption = f"Calibration from {self.rests} rests, residual {self.residual_sd:.3g} m/s²; ± 1 sd"
        return tables(Table(head, rows, caption))

    def plot(self) -> Figure:
        """Draw scale, offset and bias of each axis; see `baroarma.plotting.plot_calibration`."""
        from baroarma.plotting import plot_calibration

        return plot_calibration(self)


def calibrate(recording: Recording, *, gravity: float = STANDARD_GRAVITY) -> Calibration:
    """Calibrate from a recording with rests in at least six orientations.

    Parameters
    ----------
    recording : Recording
        With accelerometer and gyro.
    gravity : float
        g of the place in m/s², such as ``baroarma.gravity(latitude, height)``; all scales and offsets are
        proportional to it.

    Returns
    -------
    Calibration
        Scale, offset, gyro bias with sds from the residuals.

    Raises
    ------
    ValueError
        If the rests are too few or too alike; the message says what to do.

    Examples
    --------
    Each axis up and down for three seconds, then a turn; the first axis reads 2 % too little:

    >>> rng = np.random.default_rng(1)
    >>> up = np.repeat(np.vstack([np.eye(3), -np.eye(3)]), 200, axis=0)
    >>> accel = STANDARD_GRAVITY * up * [0.98, 1.0, 1.0] + rng.normal(0, 0.01, up.shape)
    >>> gyro = rng.normal(0, 0.001, up.shape)
    >>> gyro[np.arange(1200) % 200 >= 150] += 2.0
    >>> log = Recording(t=np.arange(1200) / 50, pressure=np.full(1200, 101325.0), accel=accel, gyro=gyro)
    >>> found = calibrate(log)
    >>> found.rests, [round(scale, 3) for scale in found.accel_scale]  # 1/0.98
    (6, [1.02, 1.0, 1.0])
    """
    from scipy.optimize import least_squares

    rests = _rests(recording)
    if len(rests) < PARAMETERS:
        raise ValueError(
            f"{recording.name or 'the recording'} has too few rests of {SHORTEST_REST:g} s or more, "
            f"{len(rests)}; scale and offset need at least {PARAMETERS}, in different orientations"
        )
    means = np.array([rest.accel for rest in rests])
    _refuse_other_units(means, np.array([rest.gyro for rest in rests]))
    weights = 1 / np.array([rest.modulus_sd for rest in rests])

    def misfit(parameters: Signal) -> Signal:
        force = means * parameters[:3] - parameters[3:]
        return np.asarray(weights * (np.linalg.norm(force, axis=1) - gravity))

    found = least_squares(misfit, np.array([1.0, 1, 1, 0, 0, 0]), x_scale=np.array([0.01] * 3 + [0.1] * 3))
    sd = _sds(np.asarray(found.jac, float), found.fun)
    if not np.all(sd[:3] < LARGEST_SD):
        raise ValueError(
            f"the {len(rests)} rests are too alike to tell scale from offset; turn the device so that each "
            "axis points up once and down once"
        )
    gyro_bias, gyro_bias_sd = _gyro_bias(rests)
    return Calibration(
        _tuple(found.x[:3]),
        _tuple(found.x[3:]),
        _tuple(sd[:3]),
        _tuple(sd[3:]),
        _tuple(gyro_bias),
        _tuple(gyro_bias_sd),
        len(rests),
        float(np.sqrt(np.mean((found.fun / weights) ** 2))),
    )


def _refuse_other_units(force: Signal, rate: Signal) -> None:
    """Refuse rests that no scale or bias of a working sensor explains."""
    modulus, turning = float(np.median(np.linalg.norm(force, axis=1))), float(np.abs(rate).max())
    if not LARGEST_SCALE**-1 < modulus / STANDARD_GRAVITY < LARGEST_SCALE:
        raise ValueError(
            f"the specific force at rest is {modulus:.4g} m/s², not about 9.8: the accelerometer's unit is "
            "wrong, or gravity was taken out; correct that first"
        )
    if turning > LARGEST_BIAS:
        raise ValueError(
            f"the gyro reads {turning:.3g} rad/s at rest, more than any gyro's bias: it looks like deg/s "
            "under the label rad/s; correct that first"
        )


class _Rest(NamedTuple):
    """A rest: mean specific force and rate, sd of the mean modulus, sds of the mean rate, samples."""

    accel: Signal
    gyro: Signal
    modulus_sd: float
    gyro_sd: Signal
    size: int


def _rests(recording: Recording) -> list[_Rest]:
    if recording.accel is None or recording.gyro is None:
        raise ValueError(f"{recording.name or 'the recording'} has no accelerometer and gyro to calibrate")
    good = np.isfinite(recording.accel).all(axis=1) & np.isfinite(recording.gyro).all(axis=1)
    t, accel, gyro = recording.t[good], recording.accel[good], recording.gyro[good]
    if len(t) < 2:
        raise ValueError(f"{recording.name or 'the recording'} has no complete IMU sample to calibrate with")
    static = quasi_static(t, accel, gyro)
    return [_rest(accel[a:b], gyro[a:b]) for a, b in periods(static) if t[b - 1] - t[a] >= SHORTEST_REST]


def _rest(accel: Signal, gyro: Signal) -> _Rest:
    root = np.sqrt(len(accel))
    modulus_sd = max(float(np.linalg.norm(accel, axis=1).std(ddof=1)), SMALLEST_SD) / root
    return _Rest(
        accel.mean(axis=0), gyro.mean(axis=0), modulus_sd, gyro.std(axis=0, ddof=1) / root, len(accel)
    )


def _gyro_bias(rests: list[_Rest]) -> tuple[Signal, Signal]:
    """Mean over all rests, with the sd of its noise or of the rests' disagreement, whichever is larger."""
    share = np.array([rest.size for rest in rests], float)
    share /= share.sum()
    rates = np.array([rest.gyro for rest in rests])
    noise = np.sqrt(share**2 @ np.array([rest.gyro_sd for rest in rests]) ** 2)
    return share @ rates, np.maximum(noise, rates.std(axis=0, ddof=1) * np.sqrt(share @ share))


def _sds(jacobian: Signal, residuals: Signal) -> Signal:
    """Standard deviations of the parameters (residuals in sds), larger where the residuals say so."""
    freedom = len(residuals) - PARAMETERS
    excess = float(residuals @ residuals) / freedom if freedom else 1.0
    if np.linalg.matrix_rank(jacobian) < PARAMETERS:
        return np.full(PARAMETERS, np.inf)
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    return np.asarray(np.sqrt(max(excess, 1.0) * np.diag(covariance)))


def _tuple(values: Signal) -> tuple[float, ...]:
    return tuple(float(v) for v in values)
