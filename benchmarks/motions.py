"""Every preset on every motion: `python benchmarks/motions.py [--seeds 10] [--presets a,b]`.

Three minutes at 50 Hz that begin with 5 s of rest, any mounting, SG13's and SG14's sensors (device `simple`);
each seed has its own rest recording of ten minutes, from which the noise is identified.  Root mean square
over seeds of height m / velocity m/s.  Then what the table doesn't show: free fall at and after the impact,
known level, smoothing.
"""

import argparse
import functools
from concurrent.futures import ProcessPoolExecutor

import numpy as np

import baroarma as ba
from baroarma.presets import PRESETS
from baroarma.simulation import simulate, simulate_rest

MOTIONS = {
    "rest": ("rest", {}),
    "squats, 0.4 rad tilt": ("squat", {}),
    "squats without pause": ("squat", {"pause": 0.0}),
    "three flights of stairs": ("stairs", {}),
    "walking": ("walk", {}),
    "lift, 0.1 m/s": ("lift", {"speed": 0.1}),
    "lift, 0.2 m/s": ("lift", {"speed": 0.2}),
    "lift, 0.5 m/s": ("lift", {"speed": 0.5}),
    "lift, 1 m/s": ("lift", {"speed": 1.0}),
    "circle, 0.25 Hz": ("circle", {"frequency_hz": 0.25}),
    "circle, 0.5 Hz": ("circle", {"frequency_hz": 0.5}),
    "circle, 0.75 Hz": ("circle", {"frequency_hz": 0.75}),
    "circle, 1 Hz": ("circle", {"frequency_hz": 1.0}),
    "circle, 1.25 Hz": ("circle", {"frequency_hz": 1.25}),
    "free fall, 20 s": ("free-fall", {"duration": 20.0}),
}
LEVEL = {"height_settings": {"level_prior_sd": 0.2}}


@functools.cache
def noise(seed):
    return ba.identify(simulate_rest(600, seed=1000 + seed)).model


def recording(title, seed):
    motion, options = MOTIONS[title]
    return simulate(motion, seed=seed, **{"duration": 180.0, **options})


def squares(track, log):
    """Mean squares of height's and velocity's errors."""
    return [
        float(np.mean((track.height - log.reference) ** 2)),
        float(np.mean((track.velocity - log.reference_velocity) ** 2)),
    ]


def trial(title, presets, seed):
    log, found = recording(title, seed), {}
    for preset in presets:
        try:
            found[preset] = squares(ba.Tracker.preset(preset, noise=noise(seed)).run(log), log)
        except ValueError:  # bourke08 refuses a motion without rests
            continue
    return found


def knowing(title, seed):
    """Ours without rest updates, as it is, with a known level where there is one, and smoothed."""
    log, model = recording(title, seed), noise(seed)
    ways = {
        "no rest updates": ba.Tracker(noise=model, height_settings={"confirm_rest": False}).run(log),
        "on-line": ba.Tracker(noise=model).run(log),
        "2 s later": ba.Tracker(noise=model).smooth(log, lag=2.0),
        "afterwards": ba.Tracker(noise=model).smooth(log),
    }
    if title.startswith("circle"):
        ways["known level"] = ba.Tracker(noise=model, **LEVEL).run(log)
    return {way: squares(track, log) for way, track in ways.items()}


def fall(seed):
    """Error of velocity at the impact, and of height 5 s after the last."""
    log = recording("free fall, 20 s", seed)
    track = ba.Tracker(noise=noise(seed)).run(log)
    impact = int(np.argmin(log.reference_velocity))
    moving = np.flatnonzero(np.abs(log.reference_velocity) > 1e-6)
    later = int(np.searchsorted(log.t, log.t[moving[-1]] + 5.0))
    return (
        abs(track.velocity[impact] - log.reference_velocity[impact]),
        abs(track.height[later] - log.reference[later]),
    )


def rms(trials, name):
    found = [trial[name] for trial in trials if name in trial]
    return "{:.3f} / {:.3f}".format(*np.sqrt(np.mean(found, axis=0))) if found else "–"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--presets", default=",".join(PRESETS))
    options = parser.parse_args()
    presets, seeds = options.presets.split(","), range(options.seeds)
    ways = ("no rest updates", "on-line", "2 s later", "afterwards", "known level")
    with ProcessPoolExecutor() as pool:
        print(f"| motion | {' | '.join(presets)} |\n|---|{'---|' * len(presets)}")
        for title in MOTIONS:
            trials = list(pool.map(functools.partial(trial, title, presets), seeds))
            print(f"| {title} | {' | '.join(rms(trials, p) for p in presets)} |", flush=True)
        print(f"\n`baroarma`:\n\n| motion | {' | '.join(ways)} |\n|---|{'---|' * len(ways)}")
        for title in MOTIONS:
            trials = list(pool.map(functools.partial(knowing, title), seeds))
            print(f"| {title} | {' | '.join(rms(trials, w) for w in ways)} |", flush=True)
        falls = np.array(list(pool.map(fall, seeds)))
    print(
        "\nFree fall: velocity at the impact off by {:.3f} m/s, height 5 s later by {:.3f} m at most.".format(
            *falls.max(axis=0)
        )
    )


if __name__ == "__main__":
    main()
