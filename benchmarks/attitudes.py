"""Attitude estimators behind one height filter: `python benchmarks/attitudes.py [--seeds 3]`.

Two minutes of each motion, or until it ends, `coloured-kalman` without rest updates and with the noise of
SG13's barometer behind every attitude; rms over seeds of height m / velocity m/s.  Device `simple` has noise
and bias, the others also scale errors, steps, range and bandwidth.
"""

import argparse

import numpy as np

import baroarma as ba
from baroarma.simulation import BMP085, simulate
from baroarma.simulation.motions import DURATIONS

ATTITUDES = ("robust", "tilt-kalman", "quaternion-ekf", "vqf", "imufusion", "reference")
DEVICES = ("simple", "wimu", "gy-87", "bmp390-bmi270")
RIDES = {
    "rest": ("rest", {}),
    "squats": ("squat", {}),
    "stairs": ("stairs", {}),
    "walking": ("walk", {}),
    "lift": ("lift", {}),
    "free fall": ("free-fall", {}),
    **{f"circle, {f:g} Hz": ("circle", {"frequency_hz": f}) for f in (0.25, 0.5, 0.75, 1.0, 1.25)},
    **{f"Lee16, test {test.upper()}": (f"lee16-{test}", {}) for test in "abcde"},
}


def rms(attitude, motion, options, device, seeds):
    squares = []
    for seed in seeds:
        duration = min(120, DURATIONS.get(motion, 120))
        log = simulate(motion, duration=duration, seed=seed, device=device, **options)
        tracker = ba.Tracker(noise=BMP085.noise, attitude=attitude, height_settings={"confirm_rest": False})
        track = tracker.run(log)
        off = track.height - log.reference, track.velocity - log.reference_velocity
        squares.append([np.mean(e**2) for e in off])
    return np.sqrt(np.mean(squares, axis=0))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3)
    seeds = range(parser.parse_args().seeds)
    for device in DEVICES:
        print(f"\nDevice `{device}`:\n\n| motion | {' | '.join(ATTITUDES)} |\n|---|{'---|' * len(ATTITUDES)}")
        for title, (motion, options) in RIDES.items():
            cells = ["{:.2f} / {:.3f}".format(*rms(a, motion, options, device, seeds)) for a in ATTITUDES]
            print(f"| {title} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
