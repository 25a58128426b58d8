"""Does what is predicted come true: `python benchmarks/prediction.py [--seeds 400]`.

Simulated rests of 180 s and (four times as many) of 20 s, device "simple" and its own noise model, through
the whole tracker with the attitude "reference"; zero-velocity rules and rests are switched off, for a
prediction knows none.  Rms over runs and time, height m / velocity m/s; ratio: Monte Carlo over predicted,
with its standard error.  Then what `tune` finds.
"""

import argparse

import numpy as np

import baroarma as ba
from baroarma.simulation import BMP085, simulate

PRESETS = ("sg14-a", "sg14-b", "lee16", "lee16-kf", "zihajehzadeh15", "tanigawa08", "baroarma")
RESTLESS = {"lee16": {"zupt_steps": 0}, "lee16-kf": {"zupt_steps": 0}, "baroarma": {"confirm_rest": False}}
TUNED = ("sg14-a", "lee16", "zihajehzadeh15", "tanigawa08")


def monte_carlo(duration, seeds):
    """Mean squared errors of each run, (seeds, 2), by preset."""
    trackers = {
        name: ba.Tracker(
            preset=name, noise=BMP085.noise, attitude="reference", height_settings=RESTLESS.get(name)
        )
        for name in PRESETS
    }
    squares = {name: [] for name in PRESETS}
    for seed in range(seeds):
        recording = simulate("rest", duration=duration, seed=seed)
        for name, tracker in trackers.items():
            track = tracker.run(recording)
            squares[name].append([np.mean(track.height**2), np.mean(track.velocity**2)])
    return {name: np.array(found) for name, found in squares.items()}


def pair(values, form=".4f"):
    return " / ".join(format(value, form) for value in values)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=400)
    seeds = parser.parse_args().seeds
    for duration, runs in ((180.0, seeds), (20.0, 4 * seeds)):
        print(f"\n### Rest of {duration:g} s, {runs} runs\n")
        print("| preset | predicted | Monte Carlo | ratio | standard error |\n|---|---|---|---|---|")
        for name, squares in monte_carlo(duration, runs).items():
            found = ba.predict_accuracy(BMP085.noise, "simple", name, duration)
            predicted = np.array([found.height_rms, found.velocity_rms])
            rms = np.sqrt(squares.mean(axis=0))
            error = squares.std(axis=0) / np.sqrt(runs) / (2 * rms * predicted)
            cells = pair(predicted), pair(rms), pair(rms / predicted, ".3f"), pair(error, ".3f")
            print(f"| {name} | {' | '.join(cells)} |")
    print("\n### Tuned for 180 s\n")
    print("| preset | before | after | √(σ_v/σ_w) s |\n|---|---|---|---|")
    for name in TUNED:
        tuned = ba.tune(name, BMP085.noise, "simple")
        before, after = ((p.height_rms, p.velocity_rms) for p in (tuned.before, tuned.after))
        settings = tuned.height_settings
        time = np.sqrt(settings["altitude_sd"] / settings["acceleration_sd"])
        print(f"| {name} | {pair(before)} | {pair(after)} | {time:.2f} |")


if __name__ == "__main__":
    main()
