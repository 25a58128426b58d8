"""Attitude estimators behind one height filter: `python benchmarks/attitudes.py [--seeds 5]`.

Two minutes of each motion, `coloured-kalman` with the true noise model behind every attitude; rms over seeds
of height m / velocity m/s.  Device `simple` has noise and bias; `wimu` also scale errors, steps, bandwidth.
"""

import argparse

import numpy as np

import baroarma as ba
from baroarma.simulation import BMP085, simulate

ATTITUDES = ("tilt-kalman", "quaternion-ekf", "vqf", "imufusion", "reference")
RIDES = {
    "rest": ("rest", {}),
    "squats": ("squat", {}),
    "stairs": ("stairs", {}),
    "walking": ("walk", {}),
    "circle, 0.5 Hz": ("circle", {"frequency_hz": 0.5}),
    "circle, 1 Hz": ("circle", {"frequency_hz": 1.0}),
    "circle, 1.25 Hz": ("circle", {"frequency_hz": 1.25}),
}


def rms(attitude, motion, options, device, seeds):
    squares = []
    for seed in seeds:
        log = simulate(motion, duration=120, seed=seed, device=device, **options)
        track = ba.Tracker(noise=BMP085.noise, attitude=attitude).run(log)
        off = track.height - log.reference, track.velocity - log.reference_velocity
        squares.append([np.mean(e**2) for e in off])
    return np.sqrt(np.mean(squares, axis=0))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=5)
    seeds = range(parser.parse_args().seeds)
    for device in ("simple", "wimu"):
        print(f"\nDevice `{device}`:\n\n| motion | {' | '.join(ATTITUDES)} |\n|---|{'---|' * len(ATTITUDES)}")
        for title, (motion, options) in RIDES.items():
            cells = ["{:.2f} / {:.3f}".format(*rms(a, motion, options, device, seeds)) for a in ATTITUDES]
            print(f"| {title} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
