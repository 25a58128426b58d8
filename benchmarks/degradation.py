"""What worse logs cost: `python benchmarks/degradation.py [--seeds 5]`.

A minute of simulated squats with SG13's sensors: all samples; the barometer at a fifth of the rate; 20 % of
each sensor's samples missing; 3 s without any sensor.  Rms over seeds, height m / velocity m/s.
"""

import argparse
from dataclasses import replace

import numpy as np

import baroarma as ba
from baroarma.simulation import BMP085, simulate

PRESETS = ("sg14-a", "lee16", "baroarma", "zhang12")


def slow_barometer(recording, rng):
    new = np.arange(len(recording)) % 5 == 0
    return replace(recording, pressure=np.where(new, recording.pressure, np.nan))


def missing(recording, rng):
    lost = rng.random((3, len(recording))) < 0.2
    lost[:, recording.t < 1] = False  # the alignment is not what is looked at
    return replace(
        recording,
        pressure=np.where(lost[0], np.nan, recording.pressure),
        accel=np.where(lost[1][:, None], np.nan, recording.accel),
        gyro=np.where(lost[2][:, None], np.nan, recording.gyro),
    )


def gap(recording, rng):
    return recording.rows((recording.t < 30) | (recording.t >= 33))


LOGS = {
    "all samples": lambda recording, rng: recording,
    "barometer at a fifth": slow_barometer,
    "20 % missing": missing,
    "3 s without any": gap,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=5)
    seeds = range(parser.parse_args().seeds)
    print(f"| preset | {' | '.join(LOGS)} |\n|---|{'---|' * len(LOGS)}")
    for preset in PRESETS:
        cells = []
        for worsen in LOGS.values():
            squares = []
            for seed in seeds:
                log = worsen(simulate("squat", duration=60, seed=seed), np.random.default_rng(seed))
                track = ba.Tracker.preset(preset, noise=BMP085.noise).run(log)
                off = track.height - log.reference, track.velocity - log.reference_velocity
                squares.append([np.mean(e**2) for e in off])
            height, velocity = np.sqrt(np.mean(squares, axis=0))
            cells.append(f"{height:.3f} / {velocity:.3f}")
        print(f"| {preset} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
