"""Soak: days of mixed motions without a fault, and a day full of faults; what grows, and what recovers.

    python benchmarks/soak.py [--days 10] [--step-days 10] [--faults-hours 24] [--preset baroarma ...]

Part 1 feeds hour after hour to one tracker, and row by row to another (`step`): per hour the errors, the
errors over their own sds, the covariance, the process's memory, and how far the two are apart.

Part 2 feeds the same hours with and without faults (`soak_world.FAULTS`).  A row is *bad* if its velocity is
off by more than 0.2 m/s and by more than 0.1 m/s beyond the error of the same preset without faults; an event
has recovered at its last bad row.  The criterion, fixed before the first run: within 5 s after each fault.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

import numpy as np

from baroarma import Tracker
from baroarma.presets import PRESETS
from baroarma.simulation import BMP085

sys.path.insert(0, str(Path(__file__).parent))
from soak_world import HOUR, QUIET, RATE_HZ, SPACING, World, faults

OFF, BEYOND, RECOVERED = 0.2, 0.1, 5.0
"""m/s, m/s and s of the criterion."""
COLUMNS = ("height", "velocity", "height_sd", "velocity_sd", "acceleration")
SLOW = ("sonoh15", "zhang12")
"""Presets whose height filter is not compiled: a hundred times as long."""


def memory_mb():
    """Resident memory of this process; NaN where the system doesn't tell."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return float("nan")
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def steps(tracker, part, before):
    """Columns of `Tracker.step` over a part; NaN while aligning."""
    none = (np.nan,) * len(COLUMNS)
    dt = np.diff(part.t, prepend=before)
    samples = zip(dt.tolist(), part.pressure.tolist(), part.accel, part.gyro, strict=True)
    rows = [tracker.step(dt=d, pressure=p, accel=a, gyro=g) or none for d, p, a, g in samples]
    return np.array(rows).T


def apart(found, track):
    """Return the largest difference of step's columns and the track's, over 1 + size, where step answers."""
    there = np.isfinite(found[0])
    pairs = ((row[there], getattr(track, name)[there]) for row, name in zip(found, COLUMNS, strict=True))
    return max(float(np.max(np.abs(one - other) / (1 + np.abs(other)), initial=0.0)) for one, other in pairs)


def covariance(tracker):
    """Symmetry and least eigenvalue of the height filter's P, both relative to its sds; None without P."""
    P = getattr(tracker.estimator, "P", None)
    if P is None:
        return None
    sds = np.sqrt(np.diag(P))
    sds = np.where(sds > 0, sds, 1.0)
    correlation = P / np.outer(sds, sds)
    return [float(np.abs(correlation - correlation.T).max()), float(np.linalg.eigvalsh(correlation).min())]


def endure(preset, parts, *, stepped_parts=0, weather="model", seed=1, say=print, rows=HOUR):
    """Return one dict per hour (or so many rows) of part 1; the first `stepped_parts` go row by row, too."""
    world, noise = World(seed, weather), BMP085.noise
    fed, stepped = (Tracker.preset(preset, noise=noise) for _ in range(2))
    found, before, last = [], 0.0, 0.0
    for hour in range(parts):
        part, began = world.hour(rows), time.perf_counter()
        track, fed_s = fed.feed(part), time.perf_counter() - began
        off = track.height - part.reference
        v_off = track.velocity - part.reference_velocity
        row = {
            "hour": hour,
            "velocity_rms": float(np.sqrt(np.mean(v_off**2))),
            "velocity_nees": float(np.mean((v_off / track.velocity_sd) ** 2)),
            "velocity_sd": float(np.mean(track.velocity_sd)),
            "worst_velocity": float(np.abs(v_off).max()),
            "height_error": float(off[-1]),
            "height_sd": float(track.height_sd[-1]),
            "height_nees": float(np.mean((off / track.height_sd) ** 2)),
            "height_walk": float((off[-1] - last) / (noise.drift_rate * np.sqrt(part.duration))),
            "covariance": covariance(fed),
            "fed_us": 1e6 * fed_s / rows,
            "findings": sorted({finding.code for finding in track.findings}),
        }
        if hour < stepped_parts:
            began = time.perf_counter()
            row["apart"] = apart(steps(stepped, part, before), track)
            row["step_us"] = 1e6 * (time.perf_counter() - began) / rows
        row["memory_mb"] = memory_mb()
        found.append(row)
        before, last = part.t[-1], off[-1]
        if hour % 24 == 0 or hour < 3:
            say(f"  {preset} hour {hour}: " + ", ".join(f"{k} {v:.4g}" for k, v in row.items()
                                                         if isinstance(v, float)))  # fmt: skip
    return found


def per_day(rows):
    """Print a table of a day a line."""
    print(f"{'day':>4}{'v rms':>9}{'v sd':>9}{'v NEES':>8}{'worst v':>9}{'h error':>9}{'h sd':>8}"
          f"{'h NEES':>8}{'h walk':>8}{'memory':>8}{'apart':>9}")  # fmt: skip
    for start in range(0, len(rows), 24):
        day = rows[start : start + 24]
        mean = {k: np.mean([r[k] for r in day]) for k in ("velocity_nees", "velocity_sd", "height_nees")}
        rms = {k: np.sqrt(np.mean([r[k] ** 2 for r in day])) for k in ("velocity_rms", "height_walk")}
        print(f"{start // 24 + 1:4d}{rms['velocity_rms']:9.4f}{mean['velocity_sd']:9.4f}"
              f"{mean['velocity_nees']:8.2f}{max(r['worst_velocity'] for r in day):9.3f}"
              f"{day[-1]['height_error']:9.2f}{day[-1]['height_sd']:8.2f}{mean['height_nees']:8.2f}"
              f"{rms['height_walk']:8.2f}{day[-1]['memory_mb']:8.1f}"
              f"{max(r.get('apart', np.nan) for r in day):9.1e}")  # fmt: skip
    print(f"  growth per day after the first quarter: {growth(rows)}")


def growth(rows):
    """Slopes per day of what must not grow, with standard errors, after the first quarter as a warm-up."""
    late = rows[len(rows) // 4 :]
    if len(late) < 4:
        return {}
    x, slopes = np.array([row["hour"] for row in late]) / 24, {}
    for name in ("memory_mb", "velocity_rms", "velocity_sd"):
        (slope, _), V = np.polyfit(x, [row[name] for row in late], 1, cov="unscaled")
        rest = np.array([row[name] for row in late])
        residual = rest - np.polyval(np.polyfit(x, rest, 1), x)
        slopes[name] = [float(slope), float(np.sqrt(V[0, 0] * residual.var(ddof=2)))]
    return slopes


def recover(preset, hours, *, seed=2, say=print, rows=HOUR):
    """Return one dict per event of part 2."""
    world, rng, noise = World(seed), np.random.default_rng(seed), BMP085.noise
    plain, tried = (Tracker.preset(preset, noise=noise) for _ in range(2))
    found, shift = [], 0.0
    for hour in range(hours):
        part = world.hour(rows)
        faulty, kept, events, shift = faults(part, rng, after=QUIET if hour == 0 else 10.0, shift=shift)
        one, other = plain.feed(part), tried.feed(faulty)
        off = np.abs(other.velocity - part.reference_velocity[kept])
        usual = np.abs(one.velocity - part.reference_velocity)[kept]
        bad = off > np.maximum(OFF, usual + BEYOND)
        h_off = np.abs(other.height - one.height[kept])
        for event in events:
            stop = event.stop + round(SPACING[0] * RATE_HZ)
            rows_bad = np.flatnonzero(bad[event.stop : stop])
            found.append({
                "kind": event.kind, "hour": hour, "at_s": float(faulty.t[event.start]),
                "lasted_s": float(part.t[kept[event.stop]] - part.t[kept[event.start - 1]]),
                "recovery_s": float((rows_bad[-1] + 1) / RATE_HZ) if len(rows_bad) else 0.0,
                "velocity_nees": float(np.mean((off / other.velocity_sd)[event.stop : stop] ** 2)),
                "worst_velocity_5s": float(off[event.stop + round(RECOVERED * RATE_HZ) : stop].max()),
                "height_off_after": float(h_off[stop - 1] - h_off[event.start - 1]),
            })  # fmt: skip
        if hour % 4 == 0:
            say(f"  {preset} hour {hour}: {len(events)} faults")
    return found


def per_kind(events):
    """Print recovery times per kind of fault."""
    print(f"{'fault':<20}{'n':>5}{'median s':>10}{'95 % s':>8}{'worst s':>9}{'within 5 s':>12}"
          f"{'NEES 0-30 s':>13}{'worst v 5-30 s':>16}{'height off m':>14}")  # fmt: skip
    kinds = sorted({event["kind"] for event in events})
    for kind in [*kinds, "all"]:
        some = [event for event in events if kind in (event["kind"], "all")]
        s = np.array([event["recovery_s"] for event in some])
        h = np.abs([event["height_off_after"] for event in some])
        print(f"{kind:<20}{len(s):5d}{np.median(s):10.2f}{np.quantile(s, 0.95):8.2f}{s.max():9.2f}"
              f"{100 * np.mean(s <= RECOVERED):10.1f} %{np.mean([e['velocity_nees'] for e in some]):13.1f}"
              f"{max(e['worst_velocity_5s'] for e in some):16.3f}{np.quantile(h, 0.95):14.2f}",
              flush=True)  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--days", type=float, default=10.0, help="simulated days of part 1; 0: skip it")
    parser.add_argument("--faults-hours", type=int, default=24, help="simulated hours of part 2; 0: skip it")
    parser.add_argument(
        "--preset", nargs="+", default=["baroarma"], help="names, or 'all': the compiled ones"
    )
    parser.add_argument("--weather", choices=("model", "synoptic"), default="model", help="of part 1")
    parser.add_argument("--step-days", type=float, default=10.0, help="of these, also row by row")
    parser.add_argument("--json", help="write all figures here")
    options = parser.parse_args()
    compiled = [name for name, p in PRESETS.items() if p.height and name not in SLOW]
    found = {}
    for preset in compiled if options.preset == ["all"] else options.preset:
        found[preset] = {}
        if options.days:
            print(f"{preset}: {options.days:g} days", flush=True)
            hours, stepped = (max(round(24 * days), 1) for days in (options.days, options.step_days))
            rows = endure(preset, hours, stepped_parts=stepped, weather=options.weather)
            per_day(rows)
            found[preset]["hours"] = rows
        if options.faults_hours:
            print(f"{preset}: {options.faults_hours} hours of faults", flush=True)
            found[preset]["events"] = recover(preset, options.faults_hours)
            per_kind(found[preset]["events"])
        if options.json:
            Path(options.json).write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
