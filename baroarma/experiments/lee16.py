"""Lee16, Table 2: the height's error by three vertical accelerations and two height filters, five movements.

a_OPT has the reference attitude, a_KF the tilt Kalman filter, a_app the accelerometer's modulus alone; CF is
the complementary filter, KF the two-state Kalman filter, both with zero-velocity updates.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from baroarma.experiments.cost import cost_ratio
from baroarma.experiments.experiment import Experiment
from baroarma.experiments.methods import NOISE_OF_PRESETS, SENSORS, Method, others, sensor_assumption, tracked
from baroarma.experiments.processing import relative_altitude, rmse
from baroarma.experiments.scene import Scene
from baroarma.experiments.trials import Key, Measured, Measurement, Trial
from baroarma.recording import Recording
from baroarma.simulation import simulate
from baroarma.tracker import Tracker

TESTS: Final = "ABCDE"
ACCELERATIONS: Final = {"a_OPT": "reference", "a_KF": "tilt-kalman", "a_app": "accelerometer-norm"}
FILTERS: Final = {"CF": "lee16", "KF": "lee16-kf"}
WITH_ATTITUDE: Final = "DE"
"""The tests in which the paper's reference saw the sensor's attitude."""
RMSE: Final = "height RMSE (cm)"
RAW: Final = "barometer alone"
ZIHAJEHZADEH: Final = "Zihajehzadeh 2015"


def movement(trial: Trial, test: str) -> Recording:
    """Simulate one of the five tests."""
    return simulate(f"lee16-{test.lower()}", device=SENSORS["Lee16"], seed=trial.rng("lee16", test))


def methods(trial: Trial) -> dict[str, Method]:
    """Return the paper's six combinations, two without zero-velocity updates, and the trial's presets."""
    six = {
        f"{a} + {f}": Tracker.preset(preset, attitude=attitude).run
        for f, preset in FILTERS.items()
        for a, attitude in ACCELERATIONS.items()
    }
    more = {
        ZIHAJEHZADEH: Tracker.preset("zihajehzadeh15").run,
        "a_KF + CF, never at rest": Tracker.preset("lee16", height_settings={"zupt_steps": 0}).run,
    }
    return six | more | others(trial, "Lee16")


def measure(trial: Trial) -> Measured:
    """Compare heights with the truth, test by test and on average."""
    by_method: dict[str, dict[str, float]] = {}
    for test in TESTS:
        recording = movement(trial, test)
        assert recording.reference is not None
        raw = relative_altitude(recording)
        new = np.isfinite(raw)
        by_method.setdefault(RAW, {})[test] = 100 * rmse(raw[new], recording.reference[new])
        for label, method in methods(trial).items():
            track = tracked(method, recording)
            error = float("nan") if track is None else 100 * rmse(track.height, recording.reference)
            by_method.setdefault(label, {})[test] = error
    found = {
        (f"{label}, Test {test}", RMSE): Measurement(error)
        for label, errors in by_method.items()
        for test, error in errors.items()
    }
    return found | _averages(by_method) | _filters_compared(by_method)


def _averages(by_method: dict[str, dict[str, float]]) -> dict[Key, Measurement]:
    """Average over tests: a_OPT over the two that the paper has it for, the others over all."""
    found = {}
    for label, errors in by_method.items():
        tests = WITH_ATTITUDE if label.startswith("a_OPT") else TESTS
        mean = Measurement(float(np.mean([errors[test] for test in tests])))
        key = (ZIHAJEHZADEH, f"average {RMSE}") if label == ZIHAJEHZADEH else (f"{label}, average", RMSE)
        found[key] = mean
    return found


def _filters_compared(by_method: dict[str, dict[str, float]]) -> dict[Key, Measurement]:
    """Return what CF and KF differ in: errors of the 12 cases of Table 2, and the operations of a step."""
    differences = [
        abs(by_method[f"{a} + CF"][test] - by_method[f"{a} + KF"][test])
        for a in ACCELERATIONS
        for test in (WITH_ATTITUDE if a == "a_OPT" else TESTS)
    ]
    return {
        ("CF against KF", "mean difference of the RMSEs (cm)"): Measurement(float(np.mean(differences))),
        ("CF against KF", "cost ratio (%)"): Measurement(cost_ratio()),
    }


def draw(trial: Trial) -> tuple[Scene, ...]:
    """Redraw Fig. 4: the complementary filter in the five tests."""
    scenes = []
    for test in TESTS:
        recording = movement(trial, test)
        runs = {
            label.removesuffix(" + CF"): tracked(method, recording)
            for label, method in methods(trial).items()
            if not label.endswith((" + KF", "never at rest")) and label != ZIHAJEHZADEH
        }
        lines = {label: run.height for label, run in runs.items() if run is not None}
        raw = relative_altitude(recording)
        title, note = (
            f"Lee16 Fig. 4: Test {test}",
            "Complementary filter; the motion is drawn after the text.",
        )
        scenes.append(
            Scene(title, note, "time (s)", "height (m)", recording.t, lines, recording.reference, raw)
        )
    return tuple(scenes)


def experiments() -> tuple[Experiment, ...]:
    """Return Table 2."""
    assumptions = (
        sensor_assumption("Lee16"),
        "the paper prints the extent of its movements, not their course; pace, pauses and tilt are ours",
        "the BMP180's mode is not printed; standard mode (0.05 hPa) is what its raw errors look like",
        "c_a, sigma_acc, sigma_B are not printed either and come from data sheets (presets lee16, lee16-kf)",
        "± is the SD over trials; the paper has one run each, so that our SD is the yardstick",
        "the cost is counted in operations of one step, matrices dense",
        NOISE_OF_PRESETS,
    )
    return (Experiment("lee16-table-2", "five movements by hand", assumptions, measure, draw=draw),)
