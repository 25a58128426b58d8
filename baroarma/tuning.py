"""Gains that minimise the true error: what a white-noise filter's two sds should be in coloured noise.

The gains of `complementary` and (in the steady state) of `kalman` depend on sigma_w/sigma_v alone.  Chosen by
the sds of the sensors they are wrong where the noise is not white; here the ratio is searched that minimises

    J = rms(velocity error)² + (height_weight · rms(height error))²

over the run, as `prediction` predicts it.  The altitude's sd stays, the acceleration's is what changes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from baroarma.imu_noise import ImuNoise
from baroarma.noise_model import NoiseModel
from baroarma.predicted import Prediction
from baroarma.prediction import predict_accuracy
from baroarma.presets import find_preset
from baroarma.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TIME_CONSTANTS: Final = (0.1, 100.0)
"""Shortest and longest time constant sqrt(sigma_v/sigma_w) searched, s."""
NOTHING_TO_TUNE: Final = "There is nothing to tune: the filter's gains follow from the noise model."


@dataclass(frozen=True, eq=False, repr=False)
class Tuning:
    """Hold tuned settings and what they gain.

    Parameters
    ----------
    preset : str
        What was tuned.
    height_settings : dict
        For `Tracker(preset=..., height_settings=...)`; empty when there is nothing to tune.
    before, after : Prediction
        With the preset's own settings and with these.
    notes : tuple of str
        What to know, in sentences.

    Examples
    --------
    What `tune` finds goes into a tracker:

    >>> tuned = tune("sg14-a", NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50))
    >>> tuned.after.velocity_rms < tuned.before.velocity_rms
    True
    >>> from baroarma import Tracker
    >>> Tracker(preset=tuned.preset, height_settings=tuned.height_settings)
    <Tracker sg14-a (own settings): quaternion-ekf, average, complementary; noise not given>
    """

    preset: str
    height_settings: dict[str, float]
    before: Prediction
    after: Prediction
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        before, after = self.before, self.after
        return (
            f"<Tuning of {self.preset}: velocity {before.velocity_rms:.3g} -> {after.velocity_rms:.3g} m/s, "
            f"height {before.height_rms:.3g} -> {after.height_rms:.3g} m rms over {after.duration:.4g} s>"
        )

    def summary(self) -> str:
        """Return settings and accuracy before and after as a table."""
        lines = [f"{self.preset}: tuned", f"{'':20}{'height rms m':>14}{'velocity rms m/s':>18}"]
        for label, found in (("as the preset has it", self.before), ("tuned", self.after)):
            lines.append(f"{label:20}{found.height_rms:14.4f}{found.velocity_rms:18.4f}")
        settings = [f"  {name} = {value:.6g}" for name, value in self.height_settings.items()]
        return "\n".join([*lines, *settings, *(f"  {note}" for note in (*self.notes, *self.after.notes))])

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        from baroarma.notebook import remarks, tables
        from baroarma.page import Table

        found = (("as the preset has it", self.before), ("tuned", self.after))
        body = tuple((label, f"{p.height_rms:.4f}", f"{p.velocity_rms:.4f}") for label, p in found)
        head = ("", "height rms (m)", "velocity rms (m/s)")
        settings = tuple((name, f"{value:.6g}") for name, value in self.height_settings.items())
        return tables(
            Table(head, body, f"{self.preset}: tuned"),
            *((Table(("setting", "value"), settings),) if settings else ()),
            *remarks((*self.notes, *self.after.notes)),
        )

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the sds over time, tuned and before; see `baroarma.plotting.plot_tuning`."""
        from baroarma.plotting import plot_tuning

        return plot_tuning(self, ax)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON object of `baroarma predict --tune`."""
        return {
            "preset": self.preset,
            "height_settings": dict(self.height_settings),
            "notes": list(self.notes),
            "before": self.before.to_dict(),
            "after": self.after.to_dict(),
        }


def tune(
    preset: str,
    noise: NoiseModel,
    imu: ImuNoise | Recording | str = "simple",
    *,
    duration: float = 180.0,
    height_weight: float = 0.0,
    horizontal_acceleration: float = 0.0,
) -> Tuning:
    """Find the gains of a preset's height filter that minimise the true error.

    Parameters
    ----------
    preset : str
        A preset whose height filter is `complementary` or `kalman`.
    noise, imu, duration, horizontal_acceleration
        As in `predict_accuracy`.
    height_weight : float
        What a metre of height error counts in m/s of velocity error, 1/s.  0 (default): only the velocity
        counts.  Larger: the height may cost velocity.

    Returns
    -------
    Tuning
        Settings, and the predictions before and after.

    Raises
    ------
    ValueError
        If the weight is negative; and as `predict_accuracy`.

    Examples
    --------
    >>> tuned = tune("sg14-a", NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50))
    >>> tuned
    <Tuning of sg14-a: velocity 0.0849 -> 0.0301 m/s, height 0.339 -> 0.3 m rms over 180 s>
    >>> sorted(tuned.height_settings)
    ['acceleration_sd', 'altitude_sd']
    """
    if not (math.isfinite(height_weight) and height_weight >= 0):
        raise ValueError(f"height_weight is a number of 1/s, 0 or more, but it is {height_weight}")

    def predicted(settings: dict[str, float] | None = None) -> Prediction:
        return predict_accuracy(
            noise,
            imu,
            preset,
            duration,
            height_settings=settings,
            horizontal_acceleration=horizontal_acceleration,
        )

    imu = ImuNoise.from_recording(imu) if isinstance(imu, Recording) else imu  # once, not in each trial
    before = predicted()
    if find_preset(preset).height == "coloured-kalman":
        return Tuning(preset, {}, before, before, (NOTHING_TO_TUNE,))
    altitude_sd = float(find_preset(preset).height_settings["altitude_sd"].value)

    def settings(log_time: float) -> dict[str, float]:
        return {"acceleration_sd": altitude_sd / math.exp(2 * log_time), "altitude_sd": altitude_sd}

    def cost(log_time: float) -> float:
        found = predicted(settings(log_time))
        return found.velocity_rms**2 + (height_weight * found.height_rms) ** 2

    from scipy.optimize import minimize_scalar

    ends = math.log(TIME_CONSTANTS[0]), math.log(TIME_CONSTANTS[1])
    best = float(minimize_scalar(cost, bounds=ends, method="bounded", options={"xatol": 0.01}).x)
    return Tuning(preset, settings(best), before, predicted(settings(best)), _about(best, ends))


def _about(best: float, ends: tuple[float, float]) -> tuple[str, ...]:
    time = math.exp(best)
    note = (
        f"The filter leaves the accelerometer for the barometer after {time:.3g} s (sqrt(sigma_v/sigma_w))."
    )
    if min(abs(best - end) for end in ends) < 0.05:
        note += " That is the end of what was searched: there is no best gain within it."
    return (note,)
