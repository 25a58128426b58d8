"""The tracker: alignment, conditioning, attitude and height, chained; in batch or one sample at a time.

    accel, gyro ── attitude ── vertical acceleration ──┐
                                                       ├── height ── Track
    pressure ── altitude ── conditioning ──────────────┘

The first second is taken for rest.  Its means give the tilt, the gyro bias and the altitude's zero; `run`
answers 0 there, `step` None.  From then on `step` and `run` give the same numbers.
"""

from __future__ import annotations

import os
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.atmosphere import pressure_altitude
from baroarma.estimators import attitude_estimator, height_estimator
from baroarma.estimators.attitude.alignment import align
from baroarma.estimators.base import Alignment, AttitudeEstimator, HeightEstimator
from baroarma.estimators.conditioning import AVERAGE, CONDITIONINGS, Conditioner, sg14_whitening
from baroarma.estimators.strapdown import bourke_track
from baroarma.finding import Finding
from baroarma.noise_model import NoiseModel
from baroarma.presets import Preset, find_preset
from baroarma.recording import Recording
from baroarma.track import Track

Signal = NDArray[np.float64]
ALIGNMENT = 1.0
"""Seconds of rest at the start [SG14, Sec. 2.4]."""
DEFAULT_NOISE = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50.0, sensor="BMP085 (SG13), by default")
"""What a preset that lives on a noise model takes, with a warning, when none is given."""
PRESSURE_ONLY_SD = 0.5
"""Sd in m/s² of the motion that a pressure-only track allows for: people, stairs, lifts."""
_ROUNDING = 1e-6  # s; sums of intervals and differences of times disagree by less


class TrackState(NamedTuple):
    """What `Tracker.step` returns: height (m) and velocity (m/s), up, with sds; acceleration (m/s²)."""

    height: float
    velocity: float
    height_sd: float
    velocity_sd: float
    acceleration: float


class Tracker:
    """Turn IMU and barometer into height and vertical velocity.

    Parameters
    ----------
    noise : NoiseModel, optional
        Noise of the barometer's raw samples.
    attitude, height, conditioning : str, optional
        Names of back-ends; default: those of the preset.
    preset : str
        The chain to start from; "baroarma" is ours.
    attitude_settings, height_settings : dict, optional
        Settings that shall differ from the preset's.

    Raises
    ------
    ValueError
        For an unknown name or setting; the message lists what there is.

    Examples
    --------
    >>> from baroarma.simulation import simulate
    >>> Tracker.preset("sg14-a").run(simulate("squat", duration=20, seed=1))
    <Track of 'squat' by sg14-a: 1000 rows, -0.9... m>
    """

    def __init__(
        self,
        *,
        noise: NoiseModel | None = None,
        attitude: str | None = None,
        height: str | None = None,
        conditioning: str | None = None,
        preset: str = "baroarma",
        attitude_settings: dict[str, Any] | None = None,
        height_settings: dict[str, Any] | None = None,
    ) -> None:
        base = find_preset(preset)
        chosen = replace(
            base,
            attitude=attitude or base.attitude,
            height=height or base.height,
            conditioning=conditioning or base.conditioning,
        )
        if chosen.conditioning not in CONDITIONINGS:
            raise ValueError(
                f"there is no conditioning {chosen.conditioning!r}; there are {', '.join(CONDITIONINGS)}"
            )
        if chosen != base:
            chosen = replace(chosen, name="+".join(filter(None, (chosen.attitude, chosen.height))))
        self.settings: Preset = chosen
        self.noise = noise
        same_attitude, same_height = chosen.attitude == base.attitude, chosen.height == base.height
        self._attitude_settings = {
            **{k: c.value for k, c in base.attitude_settings.items() if same_attitude},
            **(attitude_settings or {}),
        }
        self._height_settings = {
            **{k: c.value for k, c in base.height_settings.items() if same_height},
            **(height_settings or {}),
        }
        self._attitude: AttitudeEstimator | None = None
        if chosen.attitude is not None and chosen.height is not None:
            self._attitude = attitude_estimator(chosen.attitude, **self._attitude_settings)
        if chosen.height is not None:
            self._make_height(0.02)  # a wrong name or setting is told now, not at the first sample
        self.reset()

    @classmethod
    def preset(cls, name: str, *, noise: NoiseModel | None = None, **options: Any) -> Tracker:
        """Make a tracker by the name of a preset; options as in `Tracker`."""
        return cls(noise=noise, preset=name, **options)

    def __repr__(self) -> str:
        s = self.settings
        chain = f"{s.attitude or '-'}, {s.conditioning}, {s.height or 'off-line'}"
        return f"<Tracker {s.name}: {chain}; noise {'identified' if self.noise else 'not given'}>"

    def reset(self) -> None:
        """Forget everything but the settings."""
        self._early: list[tuple[float, Signal, Signal, float]] | None = []
        self._elapsed = 0.0
        self._zero = 0.0
        self._height: HeightEstimator | None = None
        self._conditioner: Conditioner | None = None
        self._last_acceleration = 0.0
        self._last_velocity = 0.0

    def step(self, *, dt: float, accel: ArrayLike, gyro: ArrayLike, pressure: float) -> TrackState | None:
        """Take one sample of all sensors.

        Parameters
        ----------
        dt : float
            Time since the previous call in s; what it is on the first call has no effect.
        accel, gyro : array_like, shape (3,)
            Specific force in m/s² and angular rate in rad/s, body axes; NaN: no new sample.
        pressure : float
            Pa; NaN: no new sample.

        Returns
        -------
        TrackState or None
            The state now; None while aligning.
        """
        if self.settings.height is None:
            raise ValueError(f"the preset {self.settings.name} works off-line only; use run")
        accel, gyro = np.asarray(accel, float), np.asarray(gyro, float)
        altitude = float(pressure_altitude(pressure))
        if self._early is not None:
            self._elapsed += dt if self._early else 0.0
            if self._elapsed < ALIGNMENT - _ROUNDING:
                self._early.append((self._elapsed, accel, gyro, altitude))
                return None
            self._align_from_memory(dt)
        assert self._height is not None
        assert self._conditioner is not None
        conditioned = self._conditioner.step(self._relative(altitude))
        if self._attitude is None:
            state = self._height.step(dt=dt, altitude=conditioned, accel=accel, gyro=gyro)
            acceleration = (state.velocity - self._last_velocity) / dt if dt > 0 else 0.0
        else:
            a = self._attitude.step(dt=dt, accel=accel, gyro=gyro).acceleration
            state = self._height.step(dt=dt, altitude=conditioned, acceleration=a)
            acceleration = self._last_acceleration if np.isnan(a) else a
        self._last_acceleration, self._last_velocity = acceleration, state.velocity
        return TrackState(*state, acceleration)

    def run(self, recording: Recording) -> Track:
        """Track a whole recording.

        Parameters
        ----------
        recording : Recording
            With accelerometer and gyro, unless the preset can do without.

        Returns
        -------
        Track
            One row per row of the recording.

        Raises
        ------
        ValueError
            If the recording lacks what the preset needs; the message says what.
        """
        self._check(recording)
        self.reset()
        if self.settings.height is None:
            return bourke_track(recording)
        t = recording.t
        altitude = recording.height()
        early = t - t[0] < ALIGNMENT - _ROUNDING
        if early.all():
            raise ValueError(
                f"{recording.name or 'the recording'} lasts {recording.duration:.3g} s, all of it needed to "
                f"align; at least {ALIGNMENT:g} s of rest and some motion are needed"
            )
        start = int(early.sum())
        alignment = self._align(
            t[early] - t[0],
            None if recording.accel is None else recording.accel[early],
            None if recording.gyro is None else recording.gyro[early],
            altitude[early],
            float(t[start] - t[start - 1]),
        )
        assert self._height is not None
        assert self._conditioner is not None
        relative = altitude - self._zero
        if np.isnan(self._zero):
            relative = altitude - _first(altitude)
        conditioned = self._conditioner.run(relative[start:])
        later = recording.rows(slice(start, None))
        acceleration, height = self._run_chain(later, conditioned, alignment)
        return self._track(recording, start, acceleration, height)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the tracker with its state, to go on with `load` exactly where it stopped (a pickle)."""
        target = Path(path)
        temporary = target.with_name(f".{target.name}.{os.getpid()}.tmp")
        try:
            temporary.write_bytes(pickle.dumps({"format": "baroarma.tracker", "version": 1, "tracker": self}))
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Tracker:
        """Read a tracker that `save` wrote.  It is a pickle: load only files that you trust."""
        saved = pickle.loads(Path(path).read_bytes())
        if not isinstance(saved, dict) or saved.get("format") != "baroarma.tracker":
            raise ValueError(f"{path} holds no tracker that Tracker.save wrote")
        tracker: Tracker = saved["tracker"]
        return tracker

    def _make_height(self, dt: float) -> HeightEstimator:
        assert self.settings.height is not None
        noise = self._noise_for_height()
        return height_estimator(self.settings.height, noise=noise, dt=dt, **self._height_settings)

    def _noise_for_height(self) -> NoiseModel | None:
        """Return the noise of what the height estimator is fed with.

        An average leaves the density at low frequency, where the filter listens, so raw samples' noise
        describes it; whitening leaves white noise of the raw white sd.
        """
        noise = self.noise
        if noise is None and self._needs_noise:
            noise = DEFAULT_NOISE
        if noise is not None and self.settings.conditioning == "average+whitening":
            return NoiseModel(0.0, 0.0, noise.white_sd, rate_hz=noise.rate_hz)
        return noise

    @property
    def _needs_noise(self) -> bool:
        return self.settings.height in ("coloured-kalman", "differenced-kalman")

    def _align_from_memory(self, dt: float) -> None:
        """End the alignment of `step`: the rows so far become tilt, biases, zero and the filters' past."""
        assert self._early is not None
        rows, self._early = self._early, None
        t, accel, gyro, altitude = (np.array(column) for column in zip(*rows, strict=True))
        self._align(t, accel, gyro, altitude, dt)

    def _align(
        self, t: Signal, accel: Signal | None, gyro: Signal | None, altitude: Signal, dt: float
    ) -> Alignment:
        """Set up the estimators from the rows of the alignment, the last of them `dt` ago."""
        alignment = Alignment()
        if accel is not None and gyro is not None:
            alignment = align(t, accel, gyro, duration=np.inf)
        new = np.isfinite(altitude)
        self._zero = float("nan")
        if new.any():
            self._zero = float(np.mean(altitude[new]) if self.settings.bias_capture else altitude[new][0])
        count = int(new.sum())
        rate = (count - 1) / np.ptp(t[new]) if count > 1 else self.noise.rate_hz if self.noise else 50.0
        whiten = self.settings.conditioning == "average+whitening"
        self._whitening = sg14_whitening(self.noise, float(rate)) if whiten else None
        average = 1 if self.settings.conditioning == "none" else AVERAGE
        self._conditioner = Conditioner(average=average, whitening=self._whitening)
        for value in altitude[new]:
            self._conditioner.step(value - self._zero)
        nominal = float(t[-1] + dt) / len(t)
        self._height = self._make_height(nominal)
        self._height.reset(alignment)
        if self._attitude is not None:
            self._attitude.reset(alignment)
        return alignment

    def _relative(self, altitude: float) -> float:
        if np.isnan(self._zero) and not np.isnan(altitude):
            self._zero = altitude  # no sample while aligning: the first one is the zero
        return altitude - self._zero

    def _run_chain(
        self, later: Recording, altitude: Signal, alignment: Alignment
    ) -> tuple[Signal, tuple[Signal, ...]]:
        """Run attitude and height over the rows after the alignment."""
        assert self._height is not None
        if self._attitude is None:
            run = self._height.run(later.t, altitude, accel=later.accel, gyro=later.gyro)
            steps = np.diff(later.t, prepend=later.t[:1])
            change = np.diff(run.velocity, prepend=run.velocity[:1])
            acceleration = np.divide(change, steps, out=np.zeros_like(change), where=steps > 0)
            return acceleration, run
        if later.accel is None or later.gyro is None:
            still = np.zeros(len(later))
            sd = np.full(len(later), PRESSURE_ONLY_SD)
            return still, self._height.run(later.t, altitude, still, sd)
        found = self._attitude.run(later.t, later.accel, later.gyro, later.reference_attitude)
        return _held(found.acceleration), self._height.run(later.t, altitude, found.acceleration)

    def _track(
        self, recording: Recording, start: int, acceleration: Signal, height: tuple[Signal, ...]
    ) -> Track:
        def padded(values: Signal, first: float) -> Signal:
            return np.concatenate([np.full(start, first), values])

        return Track(
            recording.t,
            padded(height[0], 0.0),
            padded(height[1], 0.0),
            padded(height[2], float(height[2][0])),
            padded(height[3], float(height[3][0])),
            padded(acceleration, 0.0),
            preset=self.settings.name,
            name=recording.name,
            findings=self._findings(recording),
        )

    def _findings(self, recording: Recording) -> tuple[Finding, ...]:
        found = [note for note in recording.notes if note.severity != "info"]
        if self._whitening is not None and abs(self._whitening.dc_gain - 1) > 1e-6:
            message = (
                f"The whitening filter reports a steady height change only {self._whitening.dc_gain:.3g} "
                "times its size (its DC gain); floors and lifts come out too small."
            )
            found.append(Finding("dc-gain", "warning", message))
        if self.noise is None and self._needs_noise:
            message = (
                "No noise model was given, so that of a BMP085 was taken; identify your barometer's from a "
                "recording at rest and pass it as noise."
            )
            found.append(Finding("default-noise", "warning", message))
        if recording.accel is None or recording.gyro is None:
            message = (
                "The recording has no IMU: this is the barometer alone, smoothed, and late in fast motion."
            )
            found.append(Finding("no-imu", "warning", message))
        note = getattr(self._height, "note", "")
        if note:
            found.append(Finding("left-out", "info", note))
        return tuple(found)

    def _check(self, recording: Recording) -> None:
        wrong = [note.message for note in recording.notes if note.severity == "error"]
        if wrong:
            raise ValueError(f"{recording.name}: {wrong[0]}")
        if not recording.is_new.any():
            raise ValueError(f"{recording.name}: there is no pressure sample to track")
        no_imu = recording.accel is None or recording.gyro is None
        if no_imu and (self.settings.needs_imu or self._attitude is None):
            raise ValueError(
                f"{recording.name or 'the recording'} has no accelerometer and gyro, which the preset "
                f"{self.settings.name} needs; take the preset baroarma for a track from pressure alone"
            )
        if self.settings.attitude == "reference" and recording.reference_attitude is None:
            raise ValueError(
                f"{recording.name or 'the recording'} has no reference attitude, which the attitude "
                "'reference' passes on; choose another attitude"
            )


def _held(values: Signal) -> Signal:
    """Repeat the last number where there is none; 0 before the first."""
    last = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(values)), -1))
    return np.where(last >= 0, values[np.maximum(last, 0)], 0.0)


def _first(values: Signal) -> float:
    return float(values[np.isfinite(values)][0])
