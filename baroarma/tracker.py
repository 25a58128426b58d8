"""The tracker: from settings and a second of rest to a chain of estimators, in batch or one sample at a time.

The first second is taken for rest.  Its means give the tilt, the gyro bias and the altitude's zero; `run`
answers 0 there, `step` None.  From then on `step` and `run` give the same numbers (`baroarma.chain`).
"""

from __future__ import annotations

import logging
import math
import os
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.atmosphere import pressure_altitude
from baroarma.atomic import replacing
from baroarma.chain import Chain
from baroarma.estimators import attitude_estimator, height_estimator
from baroarma.estimators.attitude.alignment import align
from baroarma.estimators.base import Alignment, AttitudeEstimator, HeightEstimator
from baroarma.estimators.conditioning import CONDITIONINGS, conditioner_of
from baroarma.estimators.stillness import Stillness
from baroarma.estimators.strapdown import bourke_track
from baroarma.finding import Finding
from baroarma.fitness import Divergence, needs_imu, refuse_unfit, track_findings
from baroarma.noise_model import NoiseModel
from baroarma.presets import Preset, find_preset
from baroarma.recording import Recording
from baroarma.track import Track, TrackState
from baroarma.whitening import WhiteningFilter

logger = logging.getLogger(__name__)
Signal = NDArray[np.float64]
ALIGNMENT: Final = 1.0
"""Seconds of rest at the start [SG14, Sec. 2.4]."""
DEFAULT_NOISE: Final = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50.0, sensor="BMP085 (SG13), by default")
"""What a height estimator that lives on a noise model takes, with a warning, when none is given."""
CLOCK: Final = 5e-7
"""Half of a microsecond clock's step, and four of a double's at 1e9 s: what the alignment's end allows, s."""


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
        For an unknown name or setting, or back-ends that don't fit together; the message says what does.
    TypeError
        If `noise` is something else than a NoiseModel.

    Examples
    --------
    >>> from baroarma.simulation import simulate
    >>> Tracker.preset("sg14-a").run(simulate("squat", duration=20, seed=1))
    <Track of 'squat' by sg14-a: 1000 rows, -0.7... m>
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
        if not isinstance(noise, NoiseModel | None):
            raise TypeError(
                f"noise is a NoiseModel, not {noise!r:.60}; NoiseModel.load reads one from a file, and what "
                "identify returns has it as its model"
            )
        self.noise = noise
        self.settings = _chosen(base, attitude, height, conditioning)
        self._attitude_settings = _settings(base, self.settings, "attitude") | (attitude_settings or {})
        self._height_settings = _settings(base, self.settings, "height") | (height_settings or {})
        self._couple(explicit=attitude is not None)
        if attitude_settings or height_settings:
            self.settings = replace(self.settings, name=f"{self.settings.name} (own settings)")
        self.reset()

    @classmethod
    def preset(cls, name: str, *, noise: NoiseModel | None = None, **options: Any) -> Tracker:
        """Make a tracker by the name of a preset; options as in `Tracker`.

        Parameters
        ----------
        name : str
            Such as "sg14-a"; see `baroarma.presets`.
        noise : NoiseModel, optional
            Noise of the barometer's raw samples.
        **options
            Other arguments of `Tracker`.

        Raises
        ------
        ValueError
            As `Tracker`.

        Examples
        --------
        SG14's Method A with a two-state Kalman filter in place of its complementary one:

        >>> Tracker.preset("sg14-a", height="kalman")
        <Tracker quaternion-ekf+average+kalman: quaternion-ekf, average, kalman; noise not given>
        """
        return cls(noise=noise, preset=name, **options)

    def __repr__(self) -> str:
        s = self.settings
        chain = f"{s.attitude or '-'}, {s.conditioning}, {s.height or 'off-line'}"
        return f"<Tracker {s.name}: {chain}; noise {'identified' if self.noise else 'not given'}>"

    @property
    def estimator(self) -> HeightEstimator:
        """The height estimator as it stands, for who wants its matrices or its evidence.

        Raises
        ------
        ValueError
            Before the tracker is aligned.

        Examples
        --------
        >>> from baroarma.simulation import simulate
        >>> tracker = Tracker.preset("lee16-kf")
        >>> _ = tracker.run(simulate("squat", duration=5, seed=1))
        >>> tracker.estimator.states, tracker.estimator.x.shape
        (('height', 'velocity'), (2, 1))
        """
        if self._chain is None:
            raise ValueError("the tracker is not aligned yet; run it, or step it for a second")
        return self._chain.height

    def reset(self) -> None:
        """Forget everything but the settings."""
        self._chain: Chain | None = None
        self._with_imu = True
        self._early: list[tuple[float, Signal, Signal, float]] = []
        self._elapsed = 0.0
        self._until = math.nan

    def step(
        self,
        *,
        dt: float,
        pressure: float,
        accel: ArrayLike | None = None,
        gyro: ArrayLike | None = None,
        attitude: ArrayLike | None = None,
    ) -> TrackState | None:
        """Take one sample of all sensors.  After a `run` it goes on where that ended.

        Parameters
        ----------
        dt : float
            Time since the previous call in s; what it is on the first call has no effect.
        pressure : float
            Pa; NaN: no new sample.
        accel, gyro : array_like, shape (3,), optional
            Specific force in m/s² and angular rate in rad/s, body axes; NaN: no new sample.  Without both on
            the first call there is no IMU, and the track is one of pressure alone, as `run` would do it.
        attitude : array_like, shape (4,), optional
            Reference attitude, quaternion body to world, scalar last, for the attitude "reference".

        Returns
        -------
        TrackState or None
            The state now; None while aligning.

        Raises
        ------
        ValueError
            If the preset lacks what it needs, or works off-line only; the message says what to do.

        Examples
        --------
        A sample of each sensor every 20 ms; while aligning there is nothing to say:

        >>> tracker = Tracker.preset("sg14-a")
        >>> at_rest = {"accel": (0.0, 0.0, 9.80665), "gyro": (0.0, 0.0, 0.0), "pressure": 101325.0}
        >>> states = [tracker.step(dt=0.02, **at_rest) for _ in range(100)]
        >>> states[0] is None, round(states[-1].height, 6), round(states[-1].velocity, 6)
        (True, 0.0, 0.0)
        """
        force, rate = _vector("accel", accel), _vector("gyro", gyro)
        altitude = float(pressure_altitude(pressure))
        if self._chain is None:
            if not self._early:
                self._refuse_steps(with_imu=accel is not None and gyro is not None)
            self._elapsed += _checked(dt) if self._early else 0.0
            if self._elapsed < ALIGNMENT - CLOCK:
                self._early.append((self._elapsed, force, rate, altitude))
                return None
            columns = (np.array(column) for column in zip(*self._early, strict=True))
            self._chain = self._aligned(*columns, dt=dt)
            self._early = []
        given = None if attitude is None else np.asarray(attitude, float)
        self._until += dt
        return self._chain.step(dt=_checked(dt), altitude=altitude, accel=force, gyro=rate, attitude=given)

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
        TypeError
            If it is no Recording.

        Examples
        --------
        >>> from baroarma.simulation import BMP085, simulate
        >>> stairs = simulate("stairs", duration=30, seed=1)
        >>> track = Tracker(noise=BMP085.noise).run(stairs)
        >>> track.height.shape == stairs.t.shape
        True
        >>> bool(abs(track.height[-1] - stairs.reference[-1]) < 3 * track.height_sd[-1])
        True
        """
        if not isinstance(recording, Recording):
            raise TypeError(
                f"run takes a Recording, not {recording!r:.60}; baroarma.read makes one of a file"
            )
        return self._track(recording, None)

    def feed(self, part: Recording) -> Track:
        """Track the next part of a long recording; part by part gives the rows of one `run` over the whole.

        Parameters
        ----------
        part : Recording
            The rows that follow those of the last `feed` or `run`; the first part begins with the rest.

        Returns
        -------
        Track
            One row per row of the part.  The findings of the first part are those of `run`; of a later one,
            whether the track has left the barometer by now.

        Raises
        ------
        ValueError
            As `run`, and if the part begins before the last one ended.

        Examples
        --------
        >>> from baroarma.simulation import simulate
        >>> log, tracker = simulate("squat", duration=20, seed=1), Tracker(noise=DEFAULT_NOISE)
        >>> _, second = tracker.feed(log.between(0, 8)), tracker.feed(log.between(8, 20))
        >>> bool(second.height[-1] == tracker.run(log).height[-1])
        True
        """
        if self._chain is None:
            return self.run(part)
        dt = float(part.t[0]) - self._until
        if not dt > 0:
            raise ValueError(
                f"the part begins at {part.t[0]:.6g} s, not after {self._until:.6g} s, where the last one "
                "ended; reset the tracker before another recording"
            )
        altitude, self._until = part.height(), float(part.t[-1])
        columns = np.empty((5, len(part)))
        self._chain.run(part, altitude, dt, columns)
        findings = self._watched(part.t, columns[0], altitude)
        return _track(part, columns, self.settings.name, findings)

    def smooth(self, recording: Recording, *, lag: float = math.inf) -> Track:
        """Track a whole recording, each row with the help of what came after it.

        Parameters
        ----------
        recording : Recording
            As in `run`.
        lag : float
            Seconds of later samples that a row may know, for near-on-line use; default: all there are.  The
            time this takes grows with the lag.

        Returns
        -------
        Track
            One row per row of the recording.

        Raises
        ------
        ValueError
            As `run`, and if the preset's height estimator has no smoother.

        Examples
        --------
        >>> from baroarma.simulation import simulate
        >>> log = simulate("squat", duration=20, seed=1)
        >>> bool(Tracker(noise=DEFAULT_NOISE).smooth(log).height_sd.max() < 0.1)
        True
        """
        if not lag >= 0:
            raise ValueError(f"the lag is a time in s, 0 or more, but it is {lag}")
        return self._track(recording, float(lag))

    def _track(self, recording: Recording, lag: float | None) -> Track:
        notes = refuse_unfit(recording, self.settings)
        self.reset()
        if self.settings.height is None:
            if lag is not None:
                raise ValueError(f"the preset {self.settings.name} is off-line already, and can't smooth")
            track = bourke_track(recording)
            return replace(track, findings=(*notes, *track.findings))
        t, altitude = recording.t, recording.height()
        first = t[: np.searchsorted(t, t[0] + 2 * ALIGNMENT) + 1]
        elapsed = np.cumsum(np.diff(first, prepend=first[:1]))  # as `step` sums it
        start = int(np.searchsorted(elapsed, ALIGNMENT - CLOCK))
        if start == len(t):
            raise ValueError(
                f"{recording.name or 'the recording'} lasts {recording.duration:.3g} s, all of it needed to "
                f"align; at least {ALIGNMENT:g} s of rest and some motion are needed"
            )
        dt, early = float(t[start] - t[start - 1]), recording.rows(slice(start))
        self._with_imu = recording.accel is not None and recording.gyro is not None
        self._until = float(t[-1])
        self._chain = self._aligned(elapsed[:start], early.accel, early.gyro, altitude[:start], dt=dt)
        columns = np.zeros((5, len(t)))
        self._chain.run(recording.rows(slice(start, None)), altitude[start:], dt, columns[:, start:], lag=lag)
        columns[2:4, :start] = columns[2:4, start, None]
        logger.info("tracked %r by %r, aligned over the first %d rows", recording, self, start)
        findings = track_findings(recording, self.settings, self.noise, self._chain, aligned_over=ALIGNMENT)
        name = self.settings.name if lag is None else f"{self.settings.name}, smoothed"
        drift_rate = (self.noise or DEFAULT_NOISE).drift_rate
        self._divergence = Divergence(float(t[0]), self._chain, drift_rate=drift_rate)
        findings = (*notes, *findings, *self._watched(t, columns[0], altitude))
        return _track(recording, columns, name, findings)

    def _watched(self, t: Signal, height: Signal, altitude: Signal) -> tuple[Finding, ...]:
        """Return what is known by now about the track's distance from the barometer."""
        assert self._chain is not None
        return tuple(self._divergence.take(t, height - (altitude - self._chain.zero)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the tracker with its state, to go on with `load` exactly where it stopped (a pickle).

        Parameters
        ----------
        path : str or path
            Where to; a file that is there is replaced.

        Examples
        --------
        >>> import tempfile
        >>> from baroarma.simulation import simulate
        >>> log, tracker = simulate("squat", duration=10, seed=1), Tracker.preset("sg14-a")
        >>> _ = tracker.run(log.between(0, 6))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     tracker.save(os.path.join(folder, "tracker.pickle"))
        ...     resumed = Tracker.load(os.path.join(folder, "tracker.pickle"))
        >>> rest = log.between(6, 10)
        >>> bool((resumed.feed(rest).height == tracker.feed(rest).height).all())
        True
        """
        with replacing(path) as temporary:
            temporary.write_bytes(pickle.dumps({"format": "baroarma.tracker", "version": 1, "tracker": self}))

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Tracker:
        """Read a tracker that `save` wrote.  It is a pickle: load only files that you trust.

        Parameters
        ----------
        path : str or path
            The file.

        Raises
        ------
        ValueError
            If the file holds no tracker; the message names it.
        """
        try:
            saved = pickle.loads(Path(path).read_bytes())
        except (
            pickle.UnpicklingError,
            EOFError,
            AttributeError,
            ImportError,
            IndexError,
            ValueError,
        ) as error:
            raise ValueError(f"{path} holds no tracker that Tracker.save of this version wrote") from error
        known = isinstance(saved, dict) and saved.get("format") == "baroarma.tracker"
        if not known or saved.get("version") != 1:
            raise ValueError(f"{path} holds no tracker that Tracker.save of this version wrote")
        tracker: Tracker = saved["tracker"]
        return tracker

    def _couple(self, *, explicit: bool) -> None:
        """Make the estimators once, so that a wrong name or setting is told now; see who takes the IMU."""
        s = self.settings
        self._attitude: AttitudeEstimator | None = None
        if s.height is None:
            if explicit or self._attitude_settings or self._height_settings or s.conditioning != "none":
                raise ValueError(
                    f"the preset {s.name} has no back-ends to choose or set; take another preset"
                )
            return
        takes_imu = self._make_height(0.02, None).input == "imu"
        if takes_imu and (explicit or self._attitude_settings):
            raise ValueError(
                f"the height estimator {s.height!r} takes the IMU itself; leave the attitude estimator out"
            )
        if not takes_imu and s.attitude is None:
            raise ValueError(
                f"the height estimator {s.height!r} needs an attitude estimator before it; name one"
            )
        if takes_imu:
            self.settings = replace(s, attitude=None, needs_imu=True)
        else:
            assert s.attitude is not None
            self._attitude = attitude_estimator(s.attitude, **self._attitude_settings)

    def _make_height(self, dt: float, whitening: WhiteningFilter | None) -> HeightEstimator:
        assert self.settings.height is not None
        noise = self._conditioned_noise(whitening)
        return height_estimator(self.settings.height, noise=noise, dt=dt, **self._height_settings)

    def _conditioned_noise(self, whitening: WhiteningFilter | None) -> NoiseModel | None:
        """Return the noise of what the height estimator is fed with.

        An average leaves the density at low frequency, where the filter listens, so raw samples' noise
        describes it; whitening leaves white noise of the raw white sd, and of the drift its DC gain's share.
        """
        noise = self.noise
        if noise is None and self.settings.needs_noise:
            noise = DEFAULT_NOISE
        if noise is not None and self.settings.needs_noise:
            noise = noise.with_possible_drift()
        if noise is None or self.settings.conditioning != "average+whitening":
            return noise
        gain = whitening.dc_gain if whitening else 1.0
        return NoiseModel(0.0, 0.0, noise.white_sd, gain * noise.drift_rate, rate_hz=noise.rate_hz)

    def _aligned(
        self, t: Signal, accel: Signal | None, gyro: Signal | None, altitude: Signal, *, dt: float
    ) -> Chain:
        """Set up the estimators from the rows of the alignment, the last of them `dt` ago."""
        alignment = Alignment()
        if self._with_imu:
            assert accel is not None
            assert gyro is not None
            alignment = align(t, accel, gyro, duration=ALIGNMENT)
        new = np.isfinite(altitude)
        zero = float("nan")
        if new.any():
            zero = float(np.mean(altitude[new]) if self.settings.bias_capture else altitude[new][0])
        rate_hz = self._rate_of(t[new])
        conditioner = conditioner_of(self.settings.conditioning, self.noise, rate_hz)
        conditioner.run(altitude[new] - zero)
        height = self._make_height(float(t[-1] + dt) / len(t), conditioner.whitening)
        height.reset(alignment)
        if self._attitude is not None:
            self._attitude.reset(alignment)
        imu, stillness = self._with_imu, None
        if height.listens_to_rest and imu and self._attitude is not None:
            stillness = Stillness(alignment)
            height.look_back(t, altitude - zero, dt=dt)
        return Chain(
            self._attitude, height, conditioner, zero=zero, rate_hz=rate_hz, with_imu=imu, stillness=stillness
        )

    def _rate_of(self, t: Signal) -> float:
        """Rate of the barometer's new samples in Hz; with fewer than two, the noise model's."""
        if len(t) > 1:
            return float((len(t) - 1) / (t[-1] - t[0]))
        return (self.noise or DEFAULT_NOISE).rate_hz

    def _refuse_steps(self, *, with_imu: bool) -> None:
        if self.settings.height is None:
            raise ValueError(f"the preset {self.settings.name} works off-line, on whole recordings only")
        if not with_imu and self.settings.needs_imu:
            raise ValueError(needs_imu("the stream", self.settings))
        self._with_imu = with_imu


def _chosen(base: Preset, attitude: str | None, height: str | None, conditioning: str | None) -> Preset:
    """Return the preset with other back-ends, named after them."""
    chosen = replace(
        base,
        attitude=attitude or base.attitude,
        height=height or base.height,
        conditioning=conditioning or base.conditioning,
        bias_capture=base.bias_capture or height not in (None, base.height),  # not all have an offset
    )
    if chosen.conditioning not in CONDITIONINGS:
        raise ValueError(
            f"there is no conditioning {chosen.conditioning!r}; there are {', '.join(CONDITIONINGS)}"
        )
    if chosen == base or chosen.height is None:
        return chosen
    parts = (chosen.attitude, chosen.conditioning if chosen.conditioning != "none" else None, chosen.height)
    return replace(chosen, name="+".join(filter(None, parts)))


def _settings(base: Preset, chosen: Preset, kind: str) -> dict[str, Any]:
    """Return the preset's settings of a back-end, unless another one was chosen."""
    if getattr(base, kind) != getattr(chosen, kind):
        return {}
    return {name: constant.value for name, constant in getattr(base, f"{kind}_settings").items()}


def _track(recording: Recording, columns: Signal, preset: str, findings: tuple[Finding, ...]) -> Track:
    """Return the track of what `Chain.run` filled, (5, n), which nobody writes any more."""
    columns.flags.writeable = False
    height, velocity, height_sd, velocity_sd, acceleration = columns
    signals = height, velocity, height_sd, velocity_sd, acceleration
    return Track(recording.t, *signals, preset=preset, name=recording.name, findings=findings)


def _vector(name: str, value: ArrayLike | None) -> Signal:
    vector = np.full(3, np.nan) if value is None else np.array(value, float)
    if vector.shape != (3,):
        raise ValueError(f"{name} is a vector of three components, but has shape {vector.shape}")
    return vector


def _checked(dt: float) -> float:
    if not 0 <= dt < float("inf"):
        raise ValueError(f"dt is the time since the previous sample in s, positive, but it is {dt}")
    return dt
