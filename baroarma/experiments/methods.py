"""The papers' methods, and others beside them: recordings in, tracks and their errors out."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from baroarma.experiments.processing import rmse
from baroarma.experiments.trials import Key, Measurement, Trial
from baroarma.noise_model import NoiseModel
from baroarma.recording import Recording
from baroarma.simulation import DEVICES, simulate
from baroarma.track import Track
from baroarma.tracker import Tracker

Signal = NDArray[np.float64]
Method = Callable[[Recording], Track]

SG14_METHODS: Mapping[str, str] = {"Method A": "sg14-a", "Method B": "sg14-b"}
"""SG14's letters and the presets; SG13 calls them B and C."""
HEIGHT = "height RMSE (m)"
VELOCITY = "velocity RMSE (m/s)"
NOISE_OF_PRESETS = (
    "presets from --presets take the noise model that `identify` finds in ten simulated minutes of rest of the "
    "same device; the paper's own methods take nothing but the paper's constants"
)


@lru_cache(maxsize=8)
def identified_noise(device: str, seed: int) -> NoiseModel:
    """Identify a device's barometer on a simulated rest of its own, ten minutes long."""
    from baroarma.identification import identify

    rng = np.random.default_rng((seed, zlib.crc32(device.encode())))
    model = identify(simulate("rest", duration=600, device=device, seed=rng)).model
    assert model is not None
    return model


def others(trial: Trial, device: str) -> dict[str, Method]:
    """Return the trial's presets as methods by name, with the identified noise."""
    return {
        name: Tracker.preset(name, noise=identified_noise(device, trial.seed)).run for name in trial.presets
    }


def sg14_methods(trial: Trial) -> dict[str, Method]:
    """Return Methods A and B of SG14, and the trial's presets."""
    own = {label: Tracker.preset(name).run for label, name in SG14_METHODS.items()}
    return own | others(trial, "wimu")


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


def device_assumption(device: str) -> str:
    """Describe a simulated device in a sentence."""
    d = DEVICES[device]
    n, imu, mg = d.barometer.noise, d.imu, 9.80665e-3
    return (
        f"simulated sensors, one preset for the whole paper: barometer with {n.white_sd:g} m of white noise per "
        f"raw sample at {n.rate_hz:g} Hz, Gauss-Markov noise of {n.correlated_sd:g} m and "
        f"{n.correlation_time:g} s, drift of {n.drift_rate:g} m/√s, {d.barometer.quantum:g} Pa steps; accelerometer "
        f"noise {imu.accel_sd / mg:.2g} mg and bias {imu.accel_bias_sd / mg:.2g} mg, gyro noise "
        f"{np.rad2deg(imu.gyro_sd):.2g} °/s and bias {np.rad2deg(imu.gyro_bias_sd):.2g} °/s"
    )
