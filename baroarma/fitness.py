"""Whether a recording is fit for a tracker, and what to know before believing the track."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.chain import Chain
from baroarma.estimators.strapdown import QUIET_ACCELERATION, QUIET_RATE
from baroarma.finding import Finding
from baroarma.formats.units import unit_findings
from baroarma.glance import usual_interval
from baroarma.noise_model import NoiseModel
from baroarma.presets import Preset
from baroarma.recording import Recording

Signal = NDArray[np.float64]
DIVERGENCE: Final = 5.0
"""Metres between the means of track and barometer that no noise explains (chosen by us)."""
DIVERGENCE_OVER: Final = 5.0
"""Seconds over which these means are taken."""
LONGEST_IMU_GAP: Final = 1.0
"""Seconds without IMU, and ten usual intervals, that are told: on stairs they move a track by 7 sds."""


def refuse_unfit(recording: Recording, preset: Preset) -> tuple[Finding, ...]:
    """Raise if a recording lacks what a chain needs; return what `reading_notes` does.

    Raises
    ------
    ValueError
        The message says what is missing and what to do.
    """
    name, notes = recording.name or "the recording", reading_notes(recording)
    wrong = [note.message for note in notes if note.severity == "error"]
    if wrong:
        raise ValueError(f"{name}: {wrong[0]}")
    if not recording.is_new.any():
        raise ValueError(f"{name}: there is no pressure sample to track")
    if preset.needs_imu and (recording.accel is None or recording.gyro is None):
        raise ValueError(needs_imu(name, preset))
    if preset.attitude == "reference" and recording.reference_attitude is None:
        raise ValueError(
            f"{name} has no reference attitude, which the attitude 'reference' passes on; choose another one"
        )
    return notes


def needs_imu(what: str, preset: Preset) -> str:
    """Return the sentence for what has no IMU."""
    return (
        f"{what} has no accelerometer and gyro, which the preset {preset.name} needs; take the preset "
        "baroarma for a track from pressure alone"
    )


def reading_notes(recording: Recording) -> tuple[Finding, ...]:
    """Return what reading noticed and a track should repeat; a recording built by hand is looked at now."""
    looked_at = recording.source is not None or any(note.code == "units" for note in recording.notes)
    own = () if looked_at else unit_findings(recording)
    return tuple(note for note in (*recording.notes, *own) if note.severity != "info")


def track_findings(
    recording: Recording, preset: Preset, noise: NoiseModel | None, chain: Chain, *, aligned_over: float
) -> tuple[Finding, ...]:
    """Return what to know about the track that a chain made of a recording.

    Parameters
    ----------
    recording, preset, chain
        What was tracked, and by what.
    noise : NoiseModel or None
        What the user gave.
    aligned_over : float
        Seconds at the start that were taken for rest.
    """
    return (
        *_about_whitening(chain),
        *_about_noise(preset, noise, chain),
        *_about_sensors(recording, chain, aligned_over),
        *_about_rest(recording, aligned_over),
    )


class Divergence:
    """Watch, part by part, whether a track leaves the barometer, which it should follow in the long run.

    Parameters
    ----------
    start : float
        Time of the track's first row, s.
    chain : Chain
        Behind a whitening filter height differs from the barometer by design, and nothing is said.
    drift_rate : float
        Drift of the barometer, m/sqrt(s): in a night it leaves a track that rests.
    """

    def __init__(self, start: float, chain: Chain, *, drift_rate: float = 0.0) -> None:
        self._start, self._by_design = start, chain.conditioner.whitening is not None
        self._drift_rate = drift_rate
        self._block: NDArray[Any] = np.zeros(0)  # only those with samples: times in us would make billions
        self._sum: NDArray[Any] = self._block
        self._count: NDArray[Any] = self._block

    def take(self, t: Signal, apart: Signal) -> list[Finding]:
        """Take the next rows, and return what is known by now.

        Parameters
        ----------
        t, apart : ndarray, shape (n,)
            Times in s, and height minus barometric height, m; NaN: no sample.
        """
        new = np.isfinite(apart)
        block = np.floor((t[new] - self._start) / DIVERGENCE_OVER)
        starts = np.flatnonzero(np.diff(block, prepend=-1.0))
        sums = np.add.reduceat(apart[new], starts) if len(starts) else np.zeros(0)
        self._block, which = np.unique(np.concatenate((self._block, block[starts])), return_inverse=True)
        self._sum = np.bincount(which, np.concatenate((self._sum, sums)))
        self._count = np.bincount(which, np.concatenate((self._count, np.diff(starts, append=len(block)))))
        return [] if self._by_design or not len(self._block) else self._findings()

    def _findings(self) -> list[Finding]:
        apart = np.abs(self._sum / self._count)
        drift = self._drift_rate * np.sqrt(DIVERGENCE_OVER * (self._block + 1))
        lost = apart >= DIVERGENCE + 4 * drift
        if not lost.any():
            return []
        worst, first = int(np.argmax(apart)), int(np.argmax(lost))
        message = (
            f"The track leaves the barometer by up to {apart[worst]:.3g} m, first after "
            f"{self._block[first] * DIVERGENCE_OVER:g} s: the tilt was lost or a sensor saturated, so don't "
            "believe height and velocity from there on."
        )
        return [Finding("diverged", "warning", message)]


def _about_whitening(chain: Chain) -> list[Finding]:
    whitening = chain.conditioner.whitening
    if whitening is None or abs(whitening.dc_gain - 1) < 1e-6:
        return []
    message = (
        f"The whitening filter reports a steady height change only {whitening.dc_gain:.3g} times its size "
        "(its DC gain); floors and lifts come out too small."
    )
    return [Finding("dc-gain", "warning", message)]


def _about_noise(preset: Preset, noise: NoiseModel | None, chain: Chain) -> list[Finding]:
    found = []
    if noise is None and preset.needs_noise:
        message = (
            "No noise model was given, so that of a BMP085 was taken; identify your barometer's from a "
            "recording at rest and pass it as noise."
        )
        found.append(Finding("default-noise", "warning", message))
    if noise is not None and not 0.75 < chain.rate_hz / noise.rate_hz < 1.33:
        message = (
            f"The noise model describes samples at {noise.rate_hz:.3g} Hz, but these come at "
            f"{chain.rate_hz:.3g} Hz; its white sd was taken as it is, so if the sensor averages over its "
            "interval, pass noise.at_rate(...)."
        )
        found.append(Finding("noise-rate", "warning", message))
    if note := getattr(chain.height, "note", ""):
        found.append(Finding("left-out", "info", note))
    return found


def _about_sensors(recording: Recording, chain: Chain, aligned_over: float) -> list[Finding]:
    found = []
    if not chain.with_imu:
        message = "There is no IMU: this is the barometer alone, smoothed, and late in fast motion."
        found.append(Finding("no-imu", "warning", message))
    first = float(recording.t[np.argmax(recording.is_new)] - recording.t[0])
    if first >= aligned_over:
        message = f"The first pressure came after {first:.3g} s and counts as height 0 there."
        found.append(Finding("late-barometer", "warning", message))
    return found + imu_gaps(recording)


def imu_gaps(recording: Recording) -> list[Finding]:
    """Name the times without IMU, from its first to its last sample."""
    if recording.accel is None or recording.gyro is None:
        return []
    whole = np.isfinite(recording.accel[:, 0])
    for signal, axis in (
        (recording.accel, 1),
        (recording.accel, 2),
        *((recording.gyro, i) for i in range(3)),
    ):
        whole &= np.isfinite(signal[:, axis])  # three times as fast as `all` along the axis
    t = recording.t if whole.all() else recording.t[whole]
    steps = np.diff(t)
    gaps = np.flatnonzero(steps > max(LONGEST_IMU_GAP, 10 * usual_interval(t)))
    if not len(gaps):
        return []
    longest = int(gaps[np.argmax(steps[gaps])])
    message = (
        f"The IMU is silent {len(gaps)} time{'s' if len(gaps) > 1 else ''}, longest for "
        f"{steps[longest]:.3g} s from {t[longest]:.4g} s on: what moved meanwhile only the barometer saw, so "
        "velocity and tilt are less sure than they look."
    )
    return [Finding("gaps", "warning", message)]


def _about_rest(recording: Recording, aligned_over: float) -> list[Finding]:
    if recording.accel is None or recording.gyro is None:
        return []
    early = slice(int(np.searchsorted(recording.t, recording.t[0] + aligned_over)))
    spread = float(np.nanstd(np.linalg.norm(recording.accel[early], axis=1)))
    rate = float(np.sqrt(np.sum(np.nanvar(recording.gyro[early], axis=0))))
    if spread < QUIET_ACCELERATION and rate < QUIET_RATE:
        return []
    message = (
        f"The first {aligned_over:g} s were not at rest (the specific force varies by {spread:.2g} m/s², the "
        f"angular rate by {rate:.2g} rad/s), so tilt, gyro bias and zero are off from the start; begin where "
        "the device rests."
    )
    return [Finding("not-at-rest", "warning", message)]
