"""SG13, Tables 5 and 6: pressure altitude in motion, raw (A), averaged (B), averaged and whitened (C).

There is no IMU in these methods; SG14 later called B and C its Methods A and B.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.estimators.conditioning import conditioner_of
from baroarma.experiments.experiment import Experiment
from baroarma.experiments.methods import NOISE_OF_PRESETS, SENSORS, others, sensor_assumption, tracked, turn
from baroarma.experiments.processing import (
    plateaus,
    relative_altitude,
    rmse,
)
from baroarma.experiments.scene import Scene, cut
from baroarma.experiments.trials import Measured, Measurement, Trial
from baroarma.recording import Recording
from baroarma.simulation import simulate

Signal = NDArray[np.float64]
METHODS: Final = {"Method A": "none", "Method B": "average", "Method C": "average+whitening"}
"""SG13's letters and our conditionings."""
FLOOR: Final = 1.7
"""Height of a floor, m [printed]."""
FLOORS: Final = range(4)
FREQUENCIES: Final = (0.5, 1.0, 1.25, 1.5)
"""Hz [Table 6; Sec. 2.4 says 0.25, 0.5, 1, 1.5]."""


def altitudes(recording: Recording) -> dict[str, Signal]:
    """Return the relative pressure altitude by every method, m, (n,)."""
    raw = relative_altitude(recording)
    return {label: conditioner_of(name, None, recording.rate_hz).run(raw) for label, name in METHODS.items()}


def _heights(recording: Recording, trial: Trial) -> Mapping[str, Signal]:
    """Return the methods' altitudes and the heights of the presets, which also use the IMU."""
    runs = {name: tracked(method, recording) for name, method in others(trial, "SG13").items()}
    nothing = np.full(len(recording), np.nan)
    return altitudes(recording) | {name: nothing if t is None else t.height for name, t in runs.items()}


def climb(trial: Trial) -> Recording:
    """Simulate three floors of stairs."""
    return simulate("stairs", duration=90, device=SENSORS["SG13"], seed=trial.rng("stairs"))


def measure_stairs(trial: Trial) -> Measured:
    """Average the altitude on every floor [Table 5]."""
    recording = climb(trial)
    assert recording.reference is not None
    found = {}
    for label, height in _heights(recording, trial).items():
        for floor in FLOORS:
            there = height[plateaus(recording.reference, floor * FLOOR)]
            mean, sd = float(np.mean(there)), float(np.std(there, ddof=1))
            found[f"{label}, floor {floor}", "mean altitude (m)"] = Measurement(mean, sd)
            found[f"{label}, floor {floor}", "SD of the altitude (m)"] = Measurement(sd)
    return found


def measure_circle(trial: Trial) -> Measured:
    """Compare the altitude with the encoder's [Table 6]."""
    found = {}
    for frequency in FREQUENCIES:
        recording, height, _ = turn(trial, "SG13", frequency, 120)
        for label, altitude in _heights(recording, trial).items():
            off = altitude - height
            for how, zero in (("", 0.0), (", zeroed over the run", float(np.mean(off)))):
                row = f"{label}{how}, {frequency:g} Hz", "altitude RMSE (m)"
                found[row] = Measurement(rmse(off, zero))
    return found


def _scene(title: str, recording: Recording, reference: Signal, rows: slice, note: str) -> Scene:
    raw, *lines = altitudes(recording).items()
    return Scene(
        title, note, "time (s)", "height (m)", recording.t[rows],
        {label: values[rows] for label, values in lines}, reference[rows], raw[1][rows],
    )  # fmt: skip


def draw_stairs(trial: Trial) -> tuple[Scene, ...]:
    """Redraw Fig. 6."""
    recording = climb(trial)
    assert recording.reference is not None
    note = "Whitened altitude (C) reports a floor of 1.7 m as 0.35 m: the filter's DC gain."
    return (_scene("SG13 Fig. 6: stairs", recording, recording.reference, slice(None), note),)


def draw_circle(trial: Trial) -> tuple[Scene, ...]:
    """Redraw Fig. 7."""
    recording, height, _ = turn(trial, "SG13", 0.5, 120)
    note = "Twenty seconds on the circle at 0.5 Hz."
    return (_scene("SG13 Fig. 7: circle", recording, height, cut(recording.t, 20, 40), note),)


def experiments() -> tuple[Experiment, ...]:
    """Return Tables 5 and 6."""
    common = (
        sensor_assumption("SG13"),
        "altitude relative to its mean over the first second; Method C whitens with a = -0.87, b = -0.50",
        NOISE_OF_PRESETS,
    )
    stairs = (
        *common,
        "the plateaus are where the true height is a floor's to within 1 cm; ± is the SD there",
    )
    circle = (
        *common,
        "two minutes with 5 s of rest first; ± is the SD over trials, the paper has one run each",
    )
    make: Callable[..., Experiment] = Experiment
    return (
        make("sg13-table-5", "pressure altitude on stairs", stairs, measure_stairs, draw=draw_stairs),
        make("sg13-table-6", "pressure altitude on the circle", circle, measure_circle, draw=draw_circle),
    )
