"""The papers' methods, and others beside them: recordings in, tracks and their errors out."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.experiments.processing import (
    ENCODER_COUNTS,
    align_encoder,
    circle_reference,
    rmse,
    with_axes_of_world,
)
from baroarma.experiments.trials import Key, Measurement, Trial
from baroarma.noise_model import NoiseModel
from baroarma.recording import Recording
from baroarma.simulation import DEVICES, Device, simulate, simulate_with_encoder
from baroarma.track import Track
from baroarma.tracker import Tracker

Signal = NDArray[np.float64]
Method = Callable[[Recording], Track]

SG14_METHODS: Mapping[str, str] = {"Method A": "sg14-a", "Method B": "sg14-b"}
"""SG14's letters and the presets; SG13 calls them B and C."""
ARM: Final = 0.30
"""Length of the rod, m [SG13, Sec. 2.4; SG14, Sec. 2.3.3: printed]."""
HEIGHT: Final = "height RMSE (m)"
VELOCITY: Final = "velocity RMSE (m/s)"
NOISE_OF_PRESETS: Final = (
    "presets from --presets take the noise model that `identify` finds in ten simulated minutes of rest of "
    "the same device; the paper's own methods take nothing but the paper's constants"
)
_GY87: Final = DEVICES["gy-87"]
SENSORS: Final[Mapping[str, Device]] = {
    "SG13": DEVICES["wimu"],
    "SG14": DEVICES["wimu"],
    # BMP180 data sheet: 0.03 hPa rms in ultra-high resolution, 0.05 hPa in standard mode.  Lee16 does not
    # tell the mode; standard mode's 0.42 m is what its barometer alone shows (Table 2).
    "Lee16": replace(
        _GY87,
        barometer=replace(
            _GY87.barometer,
            noise=replace(_GY87.barometer.noise, white_sd=_GY87.barometer.noise.white_sd * 5 / 3),
        ),
    ),
}
"""The simulated sensors of each paper: one preset for all its tables."""


@lru_cache(maxsize=8)
def identified_noise(paper: str, seed: int) -> NoiseModel:
    """Identify a paper's barometer on a simulated rest of its own, ten minutes long."""
    from baroarma.identification import identify

    rng = np.random.default_rng((seed, zlib.crc32(paper.encode())))
    model = identify(simulate("rest", duration=600, device=SENSORS[paper], seed=rng)).model
    assert model is not None
    return model


def others(trial: Trial, paper: str) -> dict[str, Method]:
    """Return the trial's presets as methods by name, with the identified noise."""
    return {
        name: Tracker.preset(name, noise=identified_noise(paper, trial.seed)).run for name in trial.presets
    }


def sg14_methods(trial: Trial) -> dict[str, Method]:
    """Return Methods A and B of SG14, and the trial's presets."""
    own = {label: Tracker.preset(name).run for label, name in SG14_METHODS.items()}
    return own | others(trial, "SG14")


def turn(trial: Trial, paper: str, frequency_hz: float, seconds: float) -> tuple[Recording, Signal, Signal]:
    """Simulate the forced circular motion [SG13, Sec. 2.4; SG14, Sec. 2.3.3].

    Returns
    -------
    recording : Recording
        Of a sensor whose axes are the rod's.
    height, velocity : ndarray, shape (n,)
        The encoder's, at the recording's times, m and m/s.
    """
    recording, encoder = simulate_with_encoder(
        duration=seconds,
        frequency_hz=frequency_hz,
        arm=ARM,
        counts=ENCODER_COUNTS,
        device=SENSORS[paper],
        seed=trial.rng(paper, "circle", f"{frequency_hz:g}"),
    )
    recording = with_axes_of_world(recording)
    angle = align_encoder(recording, encoder.t, encoder.angle)
    return recording, *circle_reference(recording.t, angle, ARM)


def tracked(method: Method, recording: Recording) -> Track | None:
    """Track a recording; None when the method cannot."""
    try:
        return method(recording)
    except ValueError:
        return None


def errors(
    methods: Mapping[str, Method], recording: Recording, height: Signal, velocity: Signal, *, when: str = ""
) -> dict[Key, Measurement]:
    """Return height and velocity RMSE [SG14, Eq. 28] of every method; NaN where it could not track.

    Parameters
    ----------
    methods : mapping of str to callable
        By label.
    recording : Recording
        What they track.
    height, velocity : ndarray, shape (n,)
        Reference in m and m/s.
    when : str
        What the label adds, such as ", 0.5 Hz".
    """
    found: dict[Key, Measurement] = {}
    for label, method in methods.items():
        track = tracked(method, recording)
        h, v = (float("nan"),) * 2 if track is None else _rmses(track, height, velocity)
        found[label + when, HEIGHT] = Measurement(h)
        found[label + when, VELOCITY] = Measurement(v)
    return found


def _rmses(track: Track, height: Signal, velocity: Signal) -> tuple[float, float]:
    return rmse(track.height, height), rmse(track.velocity, velocity)


def sensor_assumption(paper: str) -> str:
    """Describe a paper's simulated sensors in a sentence."""
    d = SENSORS[paper]
    n, imu = d.barometer.noise, d.imu
    assert imu is not None
    accel, accel_bias = 1e3 * imu.accel_sd / STANDARD_GRAVITY, 1e3 * imu.accel_bias_sd / STANDARD_GRAVITY
    correlated = f", Gauss-Markov noise of {n.correlated_sd:g} m and {n.correlation_time:g} s"
    return (
        f"simulated sensors, one preset for the whole paper, every trial a new unit: barometer with "
        f"{n.white_sd:.2g} m of white noise per raw sample at {n.rate_hz:g} Hz"
        f"{correlated if n.has_gauss_markov else ''}, drift of {n.drift_rate:g} m/√s, "
        f"{d.barometer.quantum:g} Pa steps; accelerometer with {accel:.2g} mg of noise, {accel_bias:.2g} mg "
        f"of bias and {imu.accel.scale_sd:.1%} of scale error, gyro with {np.rad2deg(imu.gyro_sd):.2g} °/s, "
        f"{np.rad2deg(imu.gyro_bias_sd):.2g} °/s and {imu.gyro.scale_sd:.1%}"
    )
