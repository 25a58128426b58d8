"""How fast is a sample?  `python benchmarks/speed.py [--samples 90000] [--repeats 9]` prints two tables.

Every preset on the same squats at 50 Hz: `run` from recording to track, `step` one sample at a time, and the
same filter as a loop over filterpy's predict and update, where it is a filterpy filter.  Beside them other
people's filters.  The repeats of all are interleaved and the shortest of each counts, so the ratios hold on
a busy machine, too; compiling is not counted.
"""

import argparse
import math
import os
import platform
import time
from importlib import import_module
from importlib.util import find_spec

import numpy as np

import baroarma as ba
from baroarma.estimators import height_estimator
from baroarma.presets import PRESETS
from baroarma.simulation import simulate

SLOW = 2000
"""Samples of whatever is a Python loop."""
RATE = 50.0


def microseconds(work, samples):
    start = time.perf_counter()
    work()
    return (time.perf_counter() - start) / samples * 1e6


def measure(works, repeats):
    """Return the shortest time in us per sample of each (work, samples), all of them once per repeat."""
    best = dict.fromkeys(works, math.inf)
    for _ in range(repeats):
        for name, (work, samples) in works.items():
            best[name] = min(best[name], microseconds(work, samples))
    return best


def runner(preset, recording):
    """Return (work, samples); a preset that takes 20 us or more is given few samples."""
    tracker, few = ba.Tracker.preset(preset), recording.rows(slice(SLOW))
    tracker.run(few)  # compiles
    if microseconds(lambda: tracker.run(few), SLOW) > 20:
        recording = few
    return (lambda: tracker.run(recording)), len(recording)


def stepper(preset, recording):
    tracker = ba.Tracker.preset(preset)
    tracker.run(recording.rows(slice(SLOW)))
    rows = list(zip(recording.pressure[:SLOW], recording.accel[:SLOW], recording.gyro[:SLOW], strict=True))

    def steps():
        for pressure, accel, gyro in rows:
            tracker.step(dt=1 / RATE, pressure=pressure, accel=accel, gyro=gyro)

    return steps


def parts(preset, recording):
    """Return an aligned chain's attitude, conditioner and height, and the altitude they are given."""
    tracker = ba.Tracker.preset(preset)
    tracker.run(recording.rows(slice(SLOW)))
    chain = tracker._chain
    return chain.attitude, chain.conditioner, chain.height, recording.height() - chain.zero


def compiled_chain(preset, recording):
    attitude, conditioner, height, altitude = parts(preset, recording)

    def run():
        felt = attitude.run(recording.t, recording.accel, recording.gyro)
        height.run(recording.t, conditioner.run(altitude), felt.acceleration, felt.acceleration_sd)

    return run


def filterpy_loop(preset, recording):
    """Return the preset as a loop over filterpy's own predict and update; None where it has no such form.

    The complementary filter is no Kalman filter; its two lines stand here in Python.
    """
    attitude, conditioner, height, altitude = parts(preset, recording)
    kalman = PRESETS[preset].height == "kalman"
    if not hasattr(attitude, "step_by_filterpy") or not (kalman or hasattr(height, "gain")):
        return None
    forces, rates, dt = list(recording.accel[:SLOW]), list(recording.gyro[:SLOW]), 1 / RATE

    def loop():
        h = v = a = 0.0
        for k in range(SLOW):
            z = conditioner.step(float(altitude[k]))
            if kalman:
                height.predict(u=np.array([a]))
                height.update(z)
            else:
                K, y = height.gain, z - h
                h, v = (
                    h + dt * v + (K[0] + dt / 2 * K[1]) * dt * y + dt * dt / 2 * a,
                    v + K[1] * dt * y + dt * a,
                )
            a = attitude.step_by_filterpy(dt=dt, accel=forces[k], gyro=rates[k]).acceleration

    return loop


def vqf_loop(vqf, gyro, accel):
    filter_ = vqf.VQF(1 / RATE)
    for rate, force in zip(gyro, accel, strict=True):
        filter_.update(rate, force)


def imufusion_loop(fusion, gyro, accel):
    filter_ = fusion.Ahrs()
    filter_.set_sample_period(1 / RATE)
    for rate, force in zip(gyro, accel, strict=True):
        filter_.update_no_magnetometer(rate, force)


def statsmodels_filter(altitude, samples):
    """Return statsmodels' (Cython) Kalman filter with the two states of the height filter `kalman`."""
    from statsmodels.tsa.statespace.kalman_filter import KalmanFilter

    dt = 1 / RATE
    G = np.array([[dt**2 / 2], [dt]])
    model = KalmanFilter(
        k_endog=1,
        k_states=2,
        design=[[1.0, 0.0]],
        obs_cov=[[0.3**2]],
        transition=[[1.0, dt], [0.0, 1.0]],
        selection=np.eye(2),
        state_cov=0.15**2 * G @ G.T,
    )
    model.bind(altitude[:samples].copy())
    model.initialize_known(np.zeros(2), 1e-4 * np.eye(2))
    return model.filter


def peers(recording):
    """Return what other packages do, if they are installed: name -> (work, samples)."""
    gyro, accel, n = np.array(recording.gyro), np.array(recording.accel), len(recording)
    few = gyro[:SLOW], accel[:SLOW]
    degrees = np.degrees(few[0]), few[1] / 9.80665
    works = {}
    if find_spec("vqf"):
        vqf = import_module("vqf")
        works["VQF updateBatch"] = (lambda: vqf.VQF(1 / RATE).updateBatch(gyro, accel), n)
        works["VQF update"] = (lambda: vqf_loop(vqf, *few), SLOW)
    if find_spec("imufusion"):
        fusion = import_module("imufusion")
        works["imufusion update"] = (lambda: imufusion_loop(fusion, *degrees), SLOW)
    if find_spec("ahrs"):
        madgwick = import_module("ahrs").filters.Madgwick
        works["ahrs Madgwick"] = (lambda: madgwick(gyr=few[0], acc=few[1], frequency=RATE), SLOW)
    altitude = recording.height() - recording.height()[0]
    kalman = height_estimator("kalman", dt=1 / RATE)
    a, t = np.zeros(n), np.array(recording.t)
    kalman.run(t[:SLOW], altitude[:SLOW], a[:SLOW])
    works["height `kalman` alone"] = (lambda: kalman.run(t, altitude, a), n)
    works["statsmodels KalmanFilter of its two states"] = (statsmodels_filter(altitude, n), n)
    return works


def number(value):
    return "–" if value is None else f"{value:.3g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=90_000)
    parser.add_argument("--repeats", type=int, default=9)
    options = parser.parse_args()
    recording = simulate("squat", duration=options.samples / RATE, seed=1)
    n = len(recording)
    works = peers(recording)
    presets = [name for name, preset in PRESETS.items() if preset.height]
    for name in presets:
        works["run", name] = runner(name, recording)
        works["step", name] = (stepper(name, recording), SLOW)
        if PRESETS[name].attitude and (loop := filterpy_loop(name, recording)):
            works["filterpy", name] = (loop, SLOW)
    works["sg14-a: attitude, conditioning and height alone"] = (compiled_chain("sg14-a", recording), n)
    found = measure(works, options.repeats)
    vqf = found.get("VQF updateBatch")
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, {platform.platform()},")
    print(f"Python {platform.python_version()}, numpy {np.__version__}; {n} samples,")
    print(f"us per sample, shortest of {options.repeats}\n")
    print("| preset | run | run / VQF | step | filterpy loop | loop / run |\n|---|---|---|---|---|---|")
    for name in presets:
        run, step, loop = found["run", name], found["step", name], found.get(("filterpy", name))
        cells = run, vqf and run / vqf, step, loop, loop and loop / run
        print(f"| {name} | {' | '.join(map(number, cells))} |")
    print("\n| others | us | / VQF |\n|---|---|---|")
    for name in (key for key in works if isinstance(key, str)):
        print(f"| {name} | {number(found[name])} | {number(vqf and found[name] / vqf)} |")


if __name__ == "__main__":
    main()
