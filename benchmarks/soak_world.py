"""Days of mixed motions seen by one device, and the faults that field logs have; used by `soak.py`.

A `World` goes on hour by hour: rests, walks, stairs, lifts, squats and turns of the device in random order,
each from rest to rest; one mounting, one unit's biases that wander slowly, one weather.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from baroarma import Recording
from baroarma.atmosphere import altitude_pressure
from baroarma.simulation import BMP085, WIMU
from baroarma.simulation.apparatus import REST_BEFORE, lift, rest
from baroarma.simulation.human import FAST, WAIST, squat, stairs
from baroarma.simulation.jet import cos, sin
from baroarma.simulation.paths import eased, running_for
from baroarma.simulation.pose import FORWARD, LEFT, UP, Pose, observe

RATE_HZ = 50
HOUR = 3600 * RATE_HZ
LEVEL = 100.0
QUIET = 60.0
"""Rest at the start, s."""
GYRO_WANDER, ACCEL_WANDER, WANDER_TIME = np.radians(0.1), 5e-3, 3600.0
"""Sd (rad/s, m/s²) and time constant (s) of the Gauss-Markov biases that come on top of the constant ones."""
TIDE = (8.4, 12 * 3600.0)
SYNOPTIC = (84.0, 4 * 86400.0)
"""Amplitude (m) and period (s) of weather: a tide of 1 hPa in 12 h, highs and lows of 10 hPa in four days."""


class World:
    """Simulate a device's life, one hour after the other.

    `weather` "model": a random walk as the noise model's drift says; "synoptic": tide, highs, lows besides.
    """

    def __init__(self, seed, weather="model"):
        self.rng = np.random.default_rng(seed)
        self.noise, self.weather = BMP085.noise, weather
        self.mounting = Rotation.random(rng=self.rng)
        self.bias = np.array([[WIMU.accel_bias_sd], [WIMU.gyro_bias_sd]]) * self.rng.normal(size=(2, 3))
        self.wander = self.rng.normal(size=(2, 3))
        self.phases = self.rng.uniform(0, 2 * np.pi, 2)
        self.rows, self.height, self.drift = 0, 0.0, 0.0

    def hour(self, rows=HOUR):
        """Return the next hour, or so many rows."""
        t = (self.rows + np.arange(rows)) / RATE_HZ
        parts, done = [], 0
        while done < rows:
            part = self._segment(rows - done, quiet=self.rows + done == 0)
            parts.append(part)
            done += len(part[0])
        force, rate, height, velocity = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        self.rows += rows
        bias = self._bias(rows)
        noise = self.rng.normal(size=(2, rows, 3))
        return Recording(
            t=t,
            pressure=np.round(altitude_pressure(LEVEL + height + self._barometer(t))),
            accel=force + bias[0] + WIMU.accel_sd * noise[0],
            gyro=rate + bias[1] + WIMU.gyro_sd * noise[1],
            reference=height,
            reference_velocity=velocity,
            name="soak",
        )

    def _segment(self, room, quiet):
        """Specific force, rate, height, velocity of the next motion that fits into so many rows."""
        pose, duration, turn = (Pose, QUIET, None) if quiet else self._motion()
        n = round(duration * RATE_HZ)
        if quiet or n > room:
            pose, n, turn = rest, min(room, round(QUIET * RATE_HZ)), None
        truth = observe(np.arange(n) / RATE_HZ, pose(np.arange(n) / RATE_HZ), self.mounting)
        height, self.height = self.height + truth.height, self.height + truth.height[-1]
        if turn is not None:
            self.mounting = turn * self.mounting
        return truth.force, truth.rate, height, truth.velocity

    def _motion(self):
        """Choose a motion: a function of time, how long it lasts, and how it leaves the device."""
        rng = self.rng
        kind = rng.choice(["rest", "walk", "stairs", "lift", "squat", "turn"])
        pause = rng.uniform(2, 20)
        if kind == "rest":
            return rest, rng.uniform(10, 120), None
        if kind == "walk":
            steps = int(rng.integers(20, 200))
            return lambda t: walk(t, steps), REST_BEFORE + steps / 2 + FAST + pause, None
        if kind == "squat":
            count, tilt = int(rng.integers(1, 6)), rng.uniform(0, 0.5)
            times = REST_BEFORE + count * (4 + FAST + pause)
            return lambda t: squat(t, count=count, tilt=tilt, pause=pause), times, None
        if kind == "turn":
            angle, heading = rng.uniform(0, np.pi), rng.uniform(0, 2 * np.pi)
            axis = (np.cos(heading), np.sin(heading), 0.0)
            turn = Rotation.from_rotvec(angle * np.array(axis))
            return lambda t: Pose(0.0 * eased(t, 5, 2), ((axis, angle * eased(t, 5, 2)),)), 7 + pause, turn
        down = rng.random() < 0.5 + np.clip(self.height / 40, -0.5, 0.5)
        if kind == "stairs":
            floors = int(rng.integers(1, 5))
            climb = lambda t: stairs(t, floors=floors, pause=pause)  # noqa: E731
            duration = max(REST_BEFORE, pause) + floors * (10 / 1.5 + FAST + pause)
        else:
            metres, speed = rng.uniform(3, 30), rng.uniform(0.2, 2.0)
            climb = lambda t: lift(t, climb=metres, speed=speed, pause=pause)  # noqa: E731
            duration = REST_BEFORE + metres / speed + 1.5 + pause
        return (lambda t: upside_down(climb(t))) if down else climb, duration, None

    def _bias(self, rows):
        """Biases of accelerometer and gyro, (2, rows, 3): constant, and a slow Gauss-Markov wander."""
        minutes = np.arange(0, rows + 3000, 3000)
        path, keep = [self.wander], np.exp(-60 / WANDER_TIME)
        for _ in minutes[1:]:
            path.append(keep * path[-1] + np.sqrt(1 - keep**2) * self.rng.normal(size=(2, 3)))
        self.wander = path[-1]
        sds = np.array([ACCEL_WANDER, GYRO_WANDER])
        curves = [[np.interp(np.arange(rows), minutes, column) for column in axis.T] for axis in
                  np.moveaxis(np.array(path), 1, 0)]  # fmt: skip
        return self.bias[:, None] + sds[:, None, None] * np.moveaxis(np.array(curves), 1, 2)

    def _barometer(self, t):
        """Noise of the altitude, weather included, m."""
        walk = self.noise.drift_rate / np.sqrt(RATE_HZ) * np.cumsum(self.rng.normal(size=len(t)))
        drift, self.drift = self.drift + walk, self.drift + walk[-1]
        if self.weather == "synoptic":
            waves = zip((TIDE, SYNOPTIC), self.phases, strict=True)
            drift = drift + sum(a * (np.sin(2 * np.pi * t / T + p) - np.sin(p)) for (a, T), p in waves)
        return drift + replace(self.noise, drift_rate=0.0).simulate(t, self.rng)


def walk(t, steps):
    """Walk straight ahead by so many steps at 2 Hz and stop."""
    pace = running_for(t, REST_BEFORE, FAST, steps / 2)
    beat, side = sin(4 * np.pi * pace), sin(2 * np.pi * pace)
    return Pose(
        -0.025 * (1.0 - cos(4 * np.pi * pace)),
        turns=((UP, 0.05 * side), (LEFT, 0.025 * beat), (FORWARD, 0.05 * side)),
        lever=WAIST,
        forward=(1.3 * pace + 0.01 * beat).second,
        left=(0.02 * side).second,
    )


def upside_down(pose):
    """Go down where the pose goes up."""
    return replace(pose, height=-pose.height)


@dataclass
class Event:
    """A fault: its kind, the first row, and the first row after it, of the faulty recording."""

    kind: str
    start: int
    stop: int


SPACING = 30.0, 45.0
"""Seconds without a fault after each one."""


def faults(recording, rng, *, after=QUIET, shift=0.0):
    """Return the recording with faults, which of its rows are left, the events, and the clock's new shift.

    The first `after` s stay as they are; `shift` s have been added to the clock before.
    """
    columns = {name: np.array(getattr(recording, name)) for name in ("t", "pressure", "accel", "gyro")}
    keep, events, start = np.ones(len(recording), bool), [], round(after * RATE_HZ)
    kinds = rng.permutation(list(FAULTS))
    columns["t"] += shift
    while True:
        kind = str(kinds[len(events) % len(kinds)])
        longest = LONGEST.get(kind, 10.0)
        n = max(round(np.exp(rng.uniform(np.log(0.1), np.log(longest))) * RATE_HZ), 1)
        if start + n + round(SPACING[1] * RATE_HZ) > len(recording):
            break
        FAULTS[kind](columns, keep, slice(start, start + n), rng)
        events.append(Event(kind, start, start + n))
        start += n + round(rng.uniform(*SPACING) * RATE_HZ)
    place = np.cumsum(keep) - keep
    events = [Event(e.kind, int(place[e.start]), int(place[e.stop])) for e in events]
    rows = np.flatnonzero(keep)
    shift = columns["t"][-1] - recording.t[-1]
    columns["pressure"] = np.abs(columns["pressure"])  # nothing says a negative one
    return Recording(**{name: values[rows] for name, values in columns.items()}), rows, events, shift


def gap(columns, keep, rows, rng):
    """No rows at all; the clock goes on."""
    keep[rows] = False


def nothing_new(*names):
    """Rows without samples of these sensors."""

    def fault(columns, keep, rows, rng):
        for name in names:
            columns[name][rows] = np.nan

    return fault


def stuck(*names):
    """The same samples again and again, none of them new."""

    def fault(columns, keep, rows, rng):
        for name in names:
            columns[name][rows] = columns[name][rows.start]

    return fault


def zeros(*names):
    """A sensor that restarts and reads 0."""

    def fault(columns, keep, rows, rng):
        for name in names:
            columns[name][rows] = 0.0

    return fault


def spikes(size, *names):
    """A few samples in the span are off by up to `size`."""

    def fault(columns, keep, rows, rng):
        for name in names:
            hit = rng.integers(rows.start, rows.stop, 1 + (rows.stop - rows.start) // 25)
            columns[name][hit] += rng.uniform(-size[name], size[name], columns[name][hit].shape)

    return fault


def pressure_step(columns, keep, rows, rng):
    """A door: the pressure is another one from now on."""
    columns["pressure"][rows.start :] += rng.uniform(-60, 60)


def clock_jump(columns, keep, rows, rng):
    """The clock is set forward, and nothing else happens."""
    columns["t"][rows.start :] += np.exp(rng.uniform(np.log(0.5), np.log(100)))


RANGE = {"pressure": 3000.0, "accel": 16 * 9.80665, "gyro": np.radians(2000)}
ABSURD = {"pressure": 1e9, "accel": 1e6, "gyro": 1e4}
IMU = ("accel", "gyro")
FAULTS = {
    "gap": gap,
    "all NaN": nothing_new("pressure", *IMU),
    "barometer gone": nothing_new("pressure"),
    "IMU gone": nothing_new(*IMU),
    "accelerometer gone": nothing_new("accel"),
    "gyro gone": nothing_new("gyro"),
    "barometer stuck": stuck("pressure"),
    "IMU stuck": stuck(*IMU),
    "barometer zeros": zeros("pressure"),
    "IMU zeros": zeros(*IMU),
    "barometer spikes": spikes(RANGE, "pressure"),
    "IMU spikes": spikes(RANGE, *IMU),
    "absurd values": spikes(ABSURD, "pressure", *IMU),
    "pressure step": pressure_step,
    "clock jump": clock_jump,
}
"""Faults by name: functions that change columns or which rows to keep."""
LONGEST = {"gap": 120.0, "all NaN": 120.0, "barometer gone": 120.0, "IMU gone": 120.0, "IMU stuck": 2.0,
           "IMU zeros": 2.0, "barometer zeros": 5.0, "pressure step": 0.2, "clock jump": 0.2}  # fmt: skip
"""Longest of a kind, s; of the others 10.  How long one lasts is log-uniform from 0.1 s."""
