"""A prediction: sds of height and velocity over time before any experiment, and what to know about them."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.imu_noise import ImuNoise
from baroarma.noise_model import NoiseModel

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

Signal = NDArray[np.float64]

_SHOWN: Final = (2.0, 5.0, 10.0, 20.0, 60.0, 180.0, 600.0, 1800.0, 3600.0)
"""Times in s of the summary's rows, as far as the run goes."""


@dataclass(frozen=True, eq=False, repr=False)
class Prediction:
    """Hold the predicted errors of a preset.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Time from the start of the alignment, s.
    height_sd, velocity_sd : ndarray, shape (n,)
        Sds of the errors, m and m/s; 0 during the alignment, where the track is 0 and the device rests.
    preset : str
        What was predicted.
    noise : NoiseModel
        Of the barometer.
    imu : ImuNoise
        Of the IMU.
    steady_height_sd, steady_velocity_sd : float or None
        Where the sds end; None where they don't, and `notes` say why.
    notes : tuple of str
        What to know before believing it, in sentences.

    Examples
    --------
    `predict_accuracy` makes one; by hand, the root mean square of 3 m and 4 m is 3.536 m:

    >>> from baroarma import ImuNoise, NoiseModel
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> imu = ImuNoise.of_device("simple")
    >>> found = Prediction([0.0, 0.02], [3.0, 4.0], [0.0, 0.0], "mine", noise, imu, None, None)
    >>> round(found.height_rms, 3), found.duration
    (3.536, 0.04)
    >>> found.rows()[1]
    ('rms over 0.04 s', 3.535..., 0.0)
    """

    t: Signal
    height_sd: Signal
    velocity_sd: Signal
    preset: str
    noise: NoiseModel
    imu: ImuNoise
    steady_height_sd: float | None
    steady_velocity_sd: float | None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in (f.name for f in fields(self)[:3]):
            array = np.array(getattr(self, name), dtype=float)
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    def __repr__(self) -> str:
        return (
            f"<Prediction for {self.preset}: rms {self.height_rms:.3g} m and {self.velocity_rms:.3g} m/s "
            f"over {self.duration:.4g} s>"
        )

    @property
    def duration(self) -> float:
        """Length of the run, s."""
        return len(self.t) / self.imu.rate_hz

    @property
    def height_rms(self) -> float:
        """Root mean square of the height's error over the run and over many runs, m."""
        return float(np.sqrt(np.mean(self.height_sd**2)))

    @property
    def velocity_rms(self) -> float:
        """Root mean square of the velocity's error likewise, m/s."""
        return float(np.sqrt(np.mean(self.velocity_sd**2)))

    def rows(self) -> list[tuple[str, float | None, float | None]]:
        """Return the summary's table: label, height in m, velocity in m/s; None: there is none."""
        times = [t for t in _SHOWN if t < self.duration] + [self.duration]
        at = [min(round(t * self.imu.rate_hz), len(self.t) - 1) for t in times]
        shown: list[tuple[str, float | None, float | None]] = [
            (f"sd after {t:g} s", float(self.height_sd[k]), float(self.velocity_sd[k]))
            for t, k in zip(times, at, strict=True)
        ]
        return [
            *shown,
            (f"rms over {self.duration:g} s", self.height_rms, self.velocity_rms),
            ("sd in the long run", self.steady_height_sd, self.steady_velocity_sd),
        ]

    def summary(self) -> str:
        """Return the prediction as a table, with what to know about it."""
        lines = [f"{self.preset}: predicted errors", f"{'':20}{'height m':>10}{'velocity m/s':>14}"]
        lines += [f"{label:20}{_cell(h):>10}{_cell(v):>14}" for label, h, v in self.rows()]
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        from baroarma.notebook import remarks, tables
        from baroarma.page import Table

        body = tuple((label, _cell(height), _cell(velocity)) for label, height, velocity in self.rows())
        head = ("", "height (m)", "velocity (m/s)")
        return tables(Table(head, body, f"{self.preset}: predicted errors"), *remarks(self.notes))

    def to_frame(self) -> pd.DataFrame:
        """Return the sds over time as a pandas DataFrame, a row per sample."""
        import pandas as pd

        columns = {"time_s": self.t, "height_sd_m": self.height_sd, "velocity_sd_m_s": self.velocity_sd}
        return pd.DataFrame(columns)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON object of `baroarma predict`."""
        return {
            "preset": self.preset,
            "duration_s": self.duration,
            "imu": self.imu.to_dict(),
            "height_rms_m": self.height_rms,
            "velocity_rms_m_s": self.velocity_rms,
            "steady_height_sd_m": self.steady_height_sd,
            "steady_velocity_sd_m_s": self.steady_velocity_sd,
            "notes": list(self.notes),
            "time_s": self.t.tolist(),
            "height_sd_m": self.height_sd.tolist(),
            "velocity_sd_m_s": self.velocity_sd.tolist(),
        }

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the sds over time; see `baroarma.plotting.plot_prediction`."""
        from baroarma.plotting import plot_prediction

        return plot_prediction(self, ax)


def _cell(value: float | None) -> str:
    return "-" if value is None else f"{value:.4f}"
