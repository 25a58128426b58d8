"""How well is rest told from motion?  `python benchmarks/rest.py [--runs 20] [--hours 10]`.

For three barometers: the slowest climbs that are still told from rest, and what they cost, with a start that
the IMU feels (1.5 s, as a lift), with one that it doesn't feel at all, and without any: the recording begins
on the way.  Then how often a true rest is taken for motion, how fast a rest is confirmed after a stop that
left the velocity wrong, how soft starts are, and what steps and pulses of the pressure do.
"""

import argparse
from dataclasses import replace

import numpy as np

import baroarma as ba
from baroarma.atmosphere import altitude_pressure, pressure_altitude
from baroarma.simulation import BMP085, simulate, simulate_rest
from baroarma.simulation.paths import running_for
from baroarma.slowest_climb import EASE, REST, follow, simulate_rests, slowest_climb, try_climbs, watch

PAD = ba.NoiseModel(0.1431, 0.2578, 0.2113, 0.09683, rate_hz=10, sensor="LPS25H outdoors")
SPEEDS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
CLIMB = 120.0
STARTS = {
    "felt": {},
    "not felt": {"felt": False},
    "before the recording": {"felt": False, "start": -EASE},
}
SOFT_STOPS = (1.5, 3.0, 5.0, 10.0)
WITHOUT = {"attitude": "reference", "height_settings": {"confirm_rest": False}}


def on_simple(noise):
    return lambda duration, runs, seed=0: simulate_rests(
        noise, "simple", duration=duration, runs=runs, seed=seed
    )


def on_bmp390(duration, runs, seed=0):
    return [
        simulate("rest", duration=duration, device="bmp390-bmi270", seed=np.random.default_rng((seed, i)))
        for i in range(runs)
    ]


def barometers():
    """Title, noise model, and what simulates rests with it."""
    bmp390 = ba.identify(simulate_rest(600, device="bmp390-bmi270", seed=1)).model
    return [
        ("BMP085 of SG13", BMP085.noise, on_simple(BMP085.noise)),
        ("BMP390 and BMI270", bmp390, on_bmp390),
        ("LPS25H outdoors", PAD, on_simple(PAD)),
    ]


def finite(seconds):
    return "-" if np.isinf(seconds) else f"{seconds:.1f}"


def climbs(noise, simulated, runs):
    rests = simulated(REST + CLIMB, runs)
    print(
        "| start | speed m/s | recognised | s, median | worst | lost m, median | worst | end error m, rms |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for start, how in STARTS.items():
        for speed in SPEEDS:
            c = try_climbs(rests, noise, speed, **how)
            print(
                f"| {start} | {speed:g} | {c.recognised:.0%} | {finite(np.median(c.seconds))} | "
                f"{finite(max(c.seconds))} | {np.median(c.lost):.2f} | {max(c.lost):.2f} | "
                f"{np.sqrt(np.mean(np.square(c.left))):.2f} |",
                flush=True,
            )
    bare = [ba.Tracker(noise=noise, **WITHOUT).run(rest).height for rest in rests]
    print(
        f"| without rest updates | any | | | | {np.median([-h.min() for h in bare]):.2f} | "
        f"{max(-h.min() for h in bare):.2f} | {np.sqrt(np.mean([h[-1] ** 2 for h in bare])):.2f} |\n"
    )


def rests_mistaken(noise, simulated, hours):
    """Alarms per hour of rest, the longest one in s, how many seconds of an hour, and the worst height."""
    alarms, longest, doubted, height = 0, 0.0, 0.0, 0.0
    for hour in range(hours):
        seen = watch(simulated(3600.0, 1, seed=1000 + hour)[0], noise)
        edges = np.flatnonzero(np.diff(seen.believed.astype(int), prepend=1, append=1))
        lasts = np.append(seen.t, 3600.0)[edges[1::2]] - seen.t[edges[::2]]
        alarms, doubted = alarms + len(lasts), doubted + lasts.sum()
        longest, height = max(longest, lasts.max(initial=0.0)), max(height, np.abs(seen.height).max())
    return alarms / hours, longest, doubted / hours, height


def clumsy_stop(noise, simulated, runs, error=0.0, *, ease=EASE, speed=0.5, travel=10.0):
    """Seconds from a stop until rest is believed for good, and the height's error then, m."""
    seconds, off = [], []
    for rest in simulated(REST + travel + 90.0, runs, seed=2000):
        course = speed * running_for(rest.t, REST, ease, travel)
        share = np.where(rest.t < REST + travel, 1.0, 1.0 - error / speed)
        stop = REST + travel + ease
        log = follow(rest, course, share_felt=share)
        seen = watch(log, noise)
        doubted = seen.t[~seen.believed]
        seconds.append(max(doubted[-1] - stop, 0.0) if seen.believed[-1] else np.inf)
        off.append(seen.height[-1] - log.reference[-1])
    return np.median(seconds), max(seconds), np.sqrt(np.mean(np.square(off)))


def disturbed(rest, metres, start, duration=np.inf):
    blown = metres * ((rest.t >= start) & (rest.t < start + duration))
    return replace(rest, pressure=altitude_pressure(pressure_altitude(rest.pressure) + blown))


def pressure_event(noise, simulated, runs, metres, duration):
    """Mean height 1, 5 and 60 s after the pressure has changed, and its greatest, m."""
    found = []
    for rest in simulated(REST + 65.0, runs, seed=3000):
        seen = watch(disturbed(rest, metres, REST, duration), noise)
        after = [seen.height[np.searchsorted(seen.t, REST + later)] for later in (1.0, 5.0, 60.0)]
        found.append([*after, seen.height[seen.t >= REST].max()])
    return np.mean(found, axis=0)


def others(noise, simulated, runs, hours):
    print("| velocity error at a stop from 0.5 m/s | s until rest, median | worst | end error m, rms |")
    print("|---|---|---|---|")
    for error in (0.0, 0.02, 0.05, 0.1, 0.2, 0.4):
        median, worst, off = clumsy_stop(noise, simulated, runs, error)
        print(f"| {error:g} m/s | {finite(median)} | {finite(worst)} | {off:.2f} |", flush=True)
    print("\n| a stop from 0.5 m/s, all felt, takes | s until rest, median | worst | end error m, rms |")
    print("|---|---|---|---|")
    for ease in SOFT_STOPS:
        median, worst, off = clumsy_stop(noise, simulated, runs, ease=ease)
        print(f"| {ease:g} s | {finite(median)} | {finite(worst)} | {off:.2f} |", flush=True)
    print("\n| climb at 0.1 m/s reached in | recognised | s, median | worst | lost m, median | worst |")
    print("|---|---|---|---|---|---|")
    rests = simulated(REST + CLIMB, runs)
    for ease in (0.5, 1.5, 5.0, 15.0, 60.0):
        c = try_climbs(rests, noise, 0.1, ease=ease)
        print(
            f"| {ease:g} s | {c.recognised:.0%} | {finite(np.median(c.seconds))} | "
            f"{finite(max(c.seconds))} | {np.median(c.lost):.2f} | {max(c.lost):.2f} |",
            flush=True,
        )
    print(
        "\n| at rest the pressure altitude | height 1 s later | 5 s | 60 s | at most |\n|---|---|---|---|---|"
    )
    for metres in (0.5, 1.0, 3.0, 10.0):
        for duration, what in ((np.inf, "steps by"), (0.3, "is off for 0.3 s by")):
            cells = pressure_event(noise, simulated, runs, metres, duration)
            print(
                f"| {what} {metres:g} m | {' | '.join(f'{round(c, 2) + 0.0:.2f}' for c in cells)} |",
                flush=True,
            )
    alarms, longest, doubted, height = rests_mistaken(noise, simulated, hours)
    print(
        f"\n{hours} h of rest: {alarms:.1f} times an hour taken for motion, {longest:.1f} s at most, "
        f"{doubted:.1f} s of an hour; height off by at most {height:.2f} m.\n",
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--hours", type=int, default=10)
    options = parser.parse_args()
    for title, noise, simulated in barometers():
        print(f"### {title}\n\n{noise}\n", flush=True)
        climbs(noise, simulated, options.runs)
        others(noise, simulated, options.runs, options.hours)
    print("### The slowest climb (`slowest_climb`)\n")
    for title, noise, _ in barometers():
        for within in (10.0, 60.0):
            for felt in (True, False):
                found = slowest_climb(noise, felt=felt, within=within, runs=options.runs)
                print(f"* {title}, within {within:g} s, start {'' if felt else 'not '}felt: {found!r}")


if __name__ == "__main__":
    main()
