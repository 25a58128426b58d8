"""Other people's recordings: `python benchmarks/real_recordings.py [FOLDER]` prints the tables of the docs.

FOLDER holds the recordings (default: ../shared/data beside the project); they are not part of the project.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import baroarma as ba
from baroarma.metrics import estimate_reference_lag
from baroarma.presets import PRESETS

RESTS = {
    "MS5611, 80 Hz, 400 s": ("ms5611_static_80hz/rest_baro", None),
    **{
        f"BMP180, oss {i}, 8.7 Hz, 300 s": (f"bmp180_stm32_rest_and_stairs/rest_oss{i}_baro", None)
        for i in range(4)
    },
    "LPS25H on the pad, 10 Hz, 960 s": ("srp_altimu10_elevator_rocket/rocket_baro", 960.0),
    "Pixracer MS5611, 60 Hz, 463 s": ("pixracer_ms5611_pendulum/pendulum_baro", None),
    "LPS25H in a lift": ("srp_altimu10_elevator_rocket/elevator_baro", None),
}
HAND_MOTIONS = ("lift30cm_a", "lift30cm_b", "setdown_c", "air_d")


def in_words(lag):
    return "can't tell" if lag is None else f"{lag:.2f} s"


def rest(folder, name, stop):
    recording = ba.read(folder / f"{name}.csv.gz")
    return recording if stop is None else recording.between(-np.inf, stop)


def with_interval(model, name):
    low, high = model.ci95[name]
    return f"{getattr(model, name):.3g} [{low:.3g}, {high:.3g}]"


def windows_cell(recording):
    found = ba.identify(recording, method="windows")
    if found.model is None:
        return "none"
    m = found.model
    return f"{m.white_sd:.3g} / {m.correlated_sd:.3g} m, {m.correlation_time:.3g} s"


def print_rests(folder):
    print("| recording | white m | Gauss-Markov m | time s | drift m/√s | p | windows: white, GM | verdict |")
    print("|---|---|---|---|---|---|---|---|")
    for title, (name, stop) in RESTS.items():
        recording = rest(folder, name, stop)
        found = ba.identify(recording)
        codes = ", ".join(f.code for f in found.verdict) or "–"
        if found.model is None:
            print(f"| {title} | – | – | – | – | – | – | **refused**: {codes} |")
            continue
        m = found.model
        gm = ["none", "–"]
        if m.has_gauss_markov:
            gm = [with_interval(m, "correlated_sd"), with_interval(m, "correlation_time")]
        cells = [with_interval(m, "white_sd"), *gm, with_interval(m, "drift_rate")]
        p = ", ".join(f"{value:.2g}" for value in m.whiteness_p.values())
        print(f"| {title} | {' | '.join(cells)} | {p} | {windows_cell(recording)} | {codes} |")


def print_hand_motions(folder):
    data = folder / "stampfly_tof_handheld"
    noise = ba.identify(ba.read(data / "rest_f.csv.gz")).model
    recordings = [ba.read(data / f"{name}.csv.gz") for name in HAND_MOTIONS]
    lags = [estimate_reference_lag(ba.Tracker(noise=noise).run(r), r) for r in recordings]
    lag = float(np.median([value for value in lags if value is not None]))
    print(f"\nNoise: {noise!r}.  The laser's lag, estimated: {', '.join(map(in_words, lags))};")
    print(f"errors against the laser shifted back by {lag:.2f} s, height m / velocity m/s rms.\n")
    print(f"| preset | {' | '.join(HAND_MOTIONS)} |\n|---|{'---|' * len(HAND_MOTIONS)}")
    tables = [ba.compare(r, noise=noise, reference_lag=lag) for r in recordings]
    for i, preset in enumerate(PRESETS):
        cells = []
        for table in tables:
            e = table.rows[i].errors
            cells.append("–" if e is None else f"{e.height_rmse:.3f} / {e.velocity_rmse:.3f}")
        print(f"| {preset} | {' | '.join(cells)} |")


def print_elevator(folder):
    data = folder / "srp_altimu10_elevator_rocket"
    noise = ba.identify(ba.read(data / "rocket_baro.csv.gz").between(-np.inf, 960)).model
    ride = ba.read(*(data / f"elevator_{s}.csv.gz" for s in ("baro", "acc", "gyr")))
    height, t = ride.height(), ride.t
    height = height - np.nanmean(height[t < 4])
    top, end = (t > 54) & (t < 61), t > t[-1] - 2.5
    print("\nElevator: lifted off the floor, up 80.8 m, down to the same floor, in the hand.  The barometer")
    print(f"itself: top {np.nanmean(height[top]):.2f} m, end {np.nanmean(height[end]):.2f} m.\n")
    print("| preset | top plateau m | end m | end against the barometer m |\n|---|---|---|---|")
    for row in ba.compare(ride, noise=noise).rows:
        if row.track is None:
            print(f"| {row.preset} | {row.refusal} | – | – |")
            continue
        h = row.track.height
        difference = np.mean(h[end]) - np.nanmean(height[end])
        print(f"| {row.preset} | {np.mean(h[top]):.2f} | {np.mean(h[end]):.2f} | {difference:+.2f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    parser.add_argument("folder", nargs="?", type=Path, default=default)
    folder = parser.parse_args().folder
    if not folder.is_dir():
        sys.exit(f"the recordings are not in {folder}; name the folder that holds them")
    print("### At rest\n")
    print_rests(folder)
    print("\n### In motion")
    print_hand_motions(folder)
    print_elevator(folder)


if __name__ == "__main__":
    main()
