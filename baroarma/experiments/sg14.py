"""SG14, Tables 2 to 4 and Sec. 3.4: height and vertical velocity by Methods A and B.

Beside the paper's rows stand our probes (`probes`), which show where its claims come from.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.experiments.experiment import Experiment
from baroarma.experiments.methods import (
    HEIGHT,
    NOISE_OF_PRESETS,
    SENSORS,
    VELOCITY,
    errors,
    sensor_assumption,
    sg14_methods,
    tracked,
    turn,
)
from baroarma.experiments.probes import midpoint_methods, shrunk_methods, tilt_methods
from baroarma.experiments.processing import (
    free_fall,
    relative_altitude,
    rmse,
)
from baroarma.experiments.scene import Scene, cut
from baroarma.experiments.significance import equal_variance_p, paired_p, signed_rank_p
from baroarma.experiments.trials import Key, Measured, Measurement, Trial
from baroarma.recording import Recording
from baroarma.simulation import simulate
from baroarma.tracker import Tracker

Signal = NDArray[np.float64]
DURATION: Final = 180.0
"""Three minutes, 9000 samples [printed]."""
DROP: Final = 1.53
"""Height of the shelf, m [printed]."""
DEPTH: Final = 0.60
"""Depth of the squat, m [printed]."""
FREQUENCIES: Final = (0.25, 0.5, 0.75, 1.0, 1.25)
"""Hz [Table 4]."""
DISPLACEMENT: Final = "maximum displacement (m)"
BOURKE: Final = "velocity RMSE to Bourke (m/s)"


def lie(trial: Trial) -> Recording:
    """Simulate three minutes of rest."""
    return simulate("rest", duration=DURATION, device=SENSORS["SG14"], seed=trial.rng("sg14 rest"))


def measure_rest(trial: Trial) -> Measured:
    """Compare with no motion at all [Table 2]."""
    recording = lie(trial)
    nothing = np.zeros(len(recording))
    return errors(sg14_methods(trial) | shrunk_methods(), recording, nothing, nothing)


def fall(trial: Trial) -> Recording:
    """Simulate the free fall."""
    return simulate("free-fall", device=SENSORS["SG14"], seed=trial.rng("free-fall"))


def measure_fall(trial: Trial) -> Measured:
    """Compare with the free fall's parabola during its first phase [Table 3]."""
    recording = fall(trial)
    rows, height, velocity = free_fall(recording, DROP)
    found = {}
    for label, method in (sg14_methods(trial) | midpoint_methods()).items():
        track = tracked(method, recording)
        h = v = float("nan")
        if track is not None:
            h = rmse(track.height[rows] - track.height[rows.start - 1], height)
            v = rmse(track.velocity[rows], velocity)
        found[label, HEIGHT], found[label, VELOCITY] = Measurement(h), Measurement(v)
    return found


def measure_circle(trial: Trial) -> Measured:
    """Compare with the encoder's height and velocity [Table 4]."""
    found: dict[Key, Measurement] = {}
    share, _ = shrunk_methods().items()
    tilt = ("Method B, true attitude", Tracker.preset("sg14-b", attitude="reference").run)
    methods = sg14_methods(trial) | midpoint_methods() | dict((share, tilt))
    for frequency in FREQUENCIES:
        recording, height, velocity = turn(trial, "SG14", frequency, DURATION)
        found |= errors(methods, recording, height, velocity, when=f", {frequency:g} Hz")
    return found


def crouch(trial: Trial, count: int = 1) -> Recording:
    """Simulate squats."""
    rng = trial.rng("squat", str(count))
    return simulate(
        "squat", duration=15.0 + 4 * count, count=count, pause=0.0, device=SENSORS["SG14"], seed=rng
    )


def measure_squat(trial: Trial) -> Measured:
    """Measure depth and velocity of one squat [Sec. 3.4], and by our probes of ten."""
    recording = crouch(trial)
    bourke = tracked(Tracker.preset("bourke08").run, recording)
    assert bourke is not None
    truth, true_velocity = _truth(recording)
    found = errors(sg14_methods(trial), recording, truth, true_velocity, when=", to the truth")
    for label, method in sg14_methods(trial).items():
        track = tracked(method, recording)
        depth = velocity = float("nan")
        if track is not None:
            depth, velocity = float(-track.height.min()), rmse(track.velocity, bourke.velocity)
        found[label, DISPLACEMENT], found[label, BOURKE] = Measurement(depth), Measurement(velocity)
    ten = crouch(trial, 10)
    return found | errors(tilt_methods(), ten, *_truth(ten), when=", ten squats")


def _truth(recording: Recording) -> tuple[Signal, Signal]:
    assert recording.reference is not None
    assert recording.reference_velocity is not None
    return recording.reference, recording.reference_velocity


def compare_methods(found: Sequence[Measured]) -> Mapping[Key, float]:
    """Compare Methods A and B by Wilcoxon's and Bartlett's tests, for every condition that both met."""
    p: dict[Key, float] = {}
    for label, quantity in found[0]:
        if label.partition(", ")[0] == "Method A" and quantity in (HEIGHT, VELOCITY) and _plain(label):
            row = label.replace("Method A", "A against B")
            a, b = (_values(found, label.replace("Method A", m), quantity) for m in ("Method A", "Method B"))
            name = quantity.partition(" (")[0]
            p[row, f"{name}, Wilcoxon (p)"] = paired_p(a, b)
            p[row, f"{name}, Bartlett (p)"] = equal_variance_p(a, b)
    return p


def _plain(label: str) -> bool:
    """Whether a row is the paper's own, not a probe."""
    when = label.partition(", ")[2]
    return not when or re.fullmatch(r"[\d.]+ Hz", when) is not None


def compare_squats(found: Sequence[Measured]) -> Mapping[Key, float]:
    """Compare the depths with each other and with the measured one [Sec. 3.4]."""
    a, b = (_values(found, label, DISPLACEMENT) for label in ("Method A", "Method B"))
    against = f"maximum displacement, Wilcoxon against {DEPTH:.2f} m (p)"
    return {
        ("A against B", "maximum displacement, Bartlett (p)"): equal_variance_p(a, b),
        ("Method A", against): signed_rank_p(a, DEPTH),
        ("Method B", against): signed_rank_p(b, DEPTH),
    }


def _values(found: Sequence[Measured], label: str, quantity: str) -> list[float]:
    return [measured[label, quantity].value for measured in found]


def draw_rest(trial: Trial) -> tuple[Scene, ...]:
    """Redraw Fig. 3."""
    return _scenes("SG14 Fig. 3: no motion", trial, lie(trial), None, None, "Three minutes on a table.")


def draw_fall(trial: Trial) -> tuple[Scene, ...]:
    """Redraw Fig. 4."""
    recording = fall(trial)
    note = "Method B settles at a fifth of the fall: the whitening filter's DC gain."
    return _scenes("SG14 Fig. 4: free fall", trial, recording, *_truth(recording), note)


def draw_circle(trial: Trial) -> tuple[Scene, ...]:
    """Redraw Fig. 5."""
    recording, height, velocity = turn(trial, "SG14", 0.5, DURATION)
    note = "Ten of the sixty seconds that the paper shows."
    rows = cut(recording.t, 20, 30)
    return _scenes("SG14 Fig. 5: circle, 0.5 Hz", trial, recording, height, velocity, note, rows)


def draw_squat(trial: Trial) -> tuple[Scene, ...]:
    """Redraw Fig. 6."""
    recording = crouch(trial)
    return _scenes("SG14 Fig. 6: squat", trial, recording, *_truth(recording), "One squat of 0.60 m.")


def _scenes(
    title: str,
    trial: Trial,
    recording: Recording,
    height: Signal | None,
    velocity: Signal | None,
    note: str,
    rows: slice = slice(None),
) -> tuple[Scene, ...]:
    """Return height over the raw altitude, and velocity, by every method."""
    runs = {label: tracked(method, recording) for label, method in sg14_methods(trial).items()}
    t = recording.t[rows]
    raw = relative_altitude(recording)[rows]

    def scene(quantity: str, unit: str, reference: Signal | None, behind: Signal | None) -> Scene:
        lines = {label: getattr(run, quantity)[rows] for label, run in runs.items() if run is not None}
        truth = None if reference is None else reference[rows]
        return Scene(
            f"{title}, {quantity}", note, "time (s)", f"{quantity} ({unit})", t, lines, truth, behind
        )

    return scene("height", "m", height, raw), scene("velocity", "m/s", velocity, None)


def experiments() -> tuple[Experiment, ...]:
    """Return Tables 2 to 4 and the squats."""
    common = (
        sensor_assumption("SG14"),
        "Methods A and B are the presets sg14-a and sg14-b: constants of Table 1, whitening filter a = -0.87 "
        "and b = -0.50 (DC gain 0.21), level and gyro bias from the first second",
        "± is the SD over trials; rows without a published number are ours",
        NOISE_OF_PRESETS,
    )
    fall = (
        "heights are taken relative to the release: with the barometer's error of some 0.3 m in them "
        "the published 0.07 m could not come out",
    )
    circle = (
        "the rod rests for 5 s and reaches its speed in 2 s; all 9000 samples enter the RMSE",
        "the sensor's axes are the rod's, as printed: mounted askew the EKF loses the tilt from 0.75 Hz on",
        "encoder and gyro are aligned where the rate passes 5 °/s, linearly between samples",
    )
    squat = (
        "one squat of 0.60 m with 0.4 rad of lean, after 5 s of rest",
        "the displacement is minus the least height",
    )
    make: Callable[..., Experiment] = Experiment
    return (
        make("sg14-table-2", "no motion", common, measure_rest, compare_methods, draw_rest),
        make("sg14-table-3", "free fall", (*common, *fall), measure_fall, compare_methods, draw_fall),
        make("sg14-table-4", "forced circular motion", (*common, *circle), measure_circle, compare_methods,
             draw_circle),
        make("sg14-squat", "squats", (*common, *squat), measure_squat, compare_squats, draw_squat),
    )  # fmt: skip
