"""What does size cost?  `python benchmarks/scale.py [--longest 1e7] [--plot scale.svg]` prints the tables.

1. Time and peak memory of identifying, and of tracking from file to file, against the recording's length; the
   slope of log time against log length over the three longest (1: linear).
2. Time against the number of recordings, with one and with two processes.
3. SG13's windows recipe beside a loop over statsmodels' ARIMA.

Each length runs in a process of its own, warmed up on a minute, whose peak memory is Linux's count.  The
recordings are Parquet with an IMU, at rest, at 50 Hz: 4.32 million samples are a day.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
import warnings
from collections import deque
from functools import partial
from pathlib import Path

import numpy as np

from baroarma.formats import write_csv
from baroarma.formats.long import LongRecording
from baroarma.identification import identify
from baroarma.identification.arma_fit import fit_windows
from baroarma.identification.preprocessing import condition
from baroarma.many import identify_many
from baroarma.recording import Recording
from baroarma.simulation import BMP085, simulate_rest
from baroarma.streaming import read_rest, track_file
from baroarma.tracker import Tracker

TASKS = ("identify", "track sg14-a", "track baroarma")


def rest_with_imu(samples):
    """Rest at 50 Hz: SG13's barometer, and an IMU of white noise alone."""
    rest, rng = simulate_rest(samples / 50, seed=0), np.random.default_rng(0)
    accel, gyro = rng.normal((0, 0, 9.81), 0.025, (samples, 3)), rng.normal(0, 0.003, (samples, 3))
    return Recording(t=rest.t, pressure=rest.pressure, accel=accel, gyro=gyro)


def seconds(function, *args):
    start = time.perf_counter()
    result = function(*args)
    return time.perf_counter() - start, result


def read_parts(path):
    log = LongRecording(path)
    deque(log.parts(), maxlen=0)
    return log


def work(task, path):
    """Return the seconds of reading alone, and of all there is to do."""
    if task == "identify":
        reading, rest = seconds(read_rest, path)
        return reading, reading + seconds(identify, rest)[0]
    tracker = Tracker.preset(task.split()[1], noise=BMP085.noise)
    reading, _ = seconds(read_parts, path)
    out = Path(path).with_name("track.parquet")
    return reading, seconds(lambda: track_file(tracker, LongRecording(path), out))[0]


def measure(task, path, warm_up):
    """Do a task in this process, which does nothing else, and print seconds and peak memory."""
    work(task, warm_up)
    reading, all_of_it = work(task, path)
    status = Path("/proc/self/status").read_text(encoding="ascii")  # getrusage would count the parent's, too
    peak = int(status.split("VmHWM:")[1].split()[0]) / 1e3
    print(json.dumps({"reading_s": reading, "all_s": all_of_it, "peak_mb": peak}))


def by_length(longest, folder):
    warm_up = folder / "minute.parquet"
    write_csv(rest_with_imu(3000), warm_up)
    lengths = [10**k for k in range(3, int(np.log10(longest)) + 1)]
    found = {task: [] for task in TASKS}
    print(f"{'samples':>10}  {'task':<16}{'reading s':>11}{'all s':>9}{'us/sample':>11}{'peak MB':>9}")
    for n in lengths:
        write_csv(rest_with_imu(n), path := folder / "rest.parquet")
        for task in TASKS:
            command = [sys.executable, __file__, "--one", task, str(path), str(warm_up)]
            row = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
            found[task].append(row)
            each = 1e6 * row["all_s"] / n
            times = f"{row['reading_s']:11.3f}{row['all_s']:9.3f}{each:11.2f}"
            print(f"{n:10d}  {task:<16}{times}{row['peak_mb']:9.0f}", flush=True)
    for task, rows in found.items():
        times = [row["all_s"] for row in rows]
        slope = np.polyfit(np.log(lengths[-3:]), np.log(times[-3:]), 1)[0]
        print(f"slope of {task}: {slope:.2f} from {lengths[-3]:g} to {lengths[-1]:g} samples")
    return lengths, found


def draw(lengths, found, path):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 3.6), layout="constrained")
    axes = figure.subplots(1, 2)
    for ax, key, label in zip(axes, ("all_s", "peak_mb"), ("time s", "memory MB"), strict=True):
        for task, rows in found.items():
            ax.loglog(lengths, [row[key] for row in rows], "o-", label=task)
        ax.set_xlabel("samples")
        ax.set_ylabel(label)
        ax.grid(alpha=0.3)
    time_ax = figure.axes[0]
    last = max(rows[-1]["all_s"] for rows in found.values())
    time_ax.loglog(lengths, [last * n / lengths[-1] for n in lengths], "k:", label="linear")
    time_ax.legend()
    figure.savefig(path, metadata={"Date": None} if str(path).endswith(".svg") else None)


def by_number(folder, most=8):
    paths = [folder / f"rest{k}.parquet" for k in range(most)]
    for k, path in enumerate(paths):
        write_csv(simulate_rest(3600, seed=k), path)
    print("\nrecordings of 1 hour   1 process s   2 processes s")
    for n in (2, 4, most):
        one, two = (seconds(partial(identify_many, paths[:n], jobs=jobs)) for jobs in (1, 2))
        assert [f.model for f in one[1]] == [f.model for f in two[1]]
        print(f"{n:20d}{one[0]:14.2f}{two[0]:16.2f}")


def against_statsmodels(windows=60):
    from statsmodels.tsa.arima.model import ARIMA

    rest = simulate_rest(windows * 30 + 1, seed=1)
    cut = condition(rest.t, rest.height())
    fit_windows(cut.windows, cut.dt)
    ours, fits = min((seconds(fit_windows, cut.windows, cut.dt) for _ in range(5)), key=lambda s: s[0])
    models = [ARIMA(w, order=(1, 0, 1), trend="n", concentrate_scale=True) for w in cut.windows]
    precise = {"pgtol": 1e-10, "factr": 10, "maxiter": 500}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        plain, _ = seconds(lambda: [model.fit() for model in models])
        exact, theirs = seconds(lambda: [model.fit(method_kwargs=dict(precise)) for model in models])
    a, b = np.array([[-fit.params[0], fit.params[1]] for fit in theirs]).T
    apart = np.maximum(abs(fits.a - a), abs(fits.b - b))
    n, per_window = len(models), 1e3 / len(models)
    print(f"\nARMA(1,1) of {n} windows of {cut.windows.shape[1]}, per window")
    print(f"  baroarma: {per_window * ours:.3f} ms")
    for what, time_s in (("as it is", plain), ("with a tight tolerance", exact)):
        print(f"  statsmodels {what}: {per_window * time_s:.1f} ms, {time_s / ours:.0f} times as long")
    print(f"  coefficients apart: {np.median(apart):.1e} in the median, {apart.max():.1e} at most")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--longest", type=float, default=1e7, help="samples of the longest recording")
    parser.add_argument("--plot", help="save the plot of part 1 here")
    parser.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        measure(*options.one)
        return
    print(f"{os.cpu_count()} cores, Python {sys.version.split()[0]}, NumPy {np.__version__}")
    with tempfile.TemporaryDirectory() as folder:
        lengths, found = by_length(options.longest, Path(folder))
        by_number(Path(folder))
    against_statsmodels()
    if options.plot:
        draw(lengths, found, options.plot)


if __name__ == "__main__":
    main()
