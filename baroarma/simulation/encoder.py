"""The encoder of SG14's motor: the true angle of the rod, on a clock of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from baroarma.recording import Recording
from baroarma.simulation.apparatus import rod_angle
from baroarma.simulation.motions import options_of
from baroarma.simulation.recordings import Seed, simulate

Signal = NDArray[np.float64]
LATEST_START = 2.0
"""The encoder starts at most this much after the recording, s; less than the rest before the motion."""


@dataclass(frozen=True, eq=False)
class Encoder:
    """Hold what an incremental encoder said.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Time since its own start, s.
    angle : ndarray, shape (n,)
        Angle of the rod relative to its start, rad, positive as the device at its end goes up.

    Examples
    --------
    One eighth of a turn a second, of a rod that is 0.3 m long; the height at its end is 0.3 sin(angle):

    >>> t = np.arange(0, 3, 0.5)
    >>> encoder = Encoder(t, np.pi / 4 * t)
    >>> (0.3 * np.sin(encoder.angle)).round(2).tolist()
    [0.0, 0.11, 0.21, 0.28, 0.3, 0.28]
    """

    t: Signal
    angle: Signal


def simulate_with_encoder(
    *,
    duration: float = 180.0,
    encoder_hz: float = 250.0,
    counts: int = 2048,
    seed: Seed = None,
    **options: Any,
) -> tuple[Recording, Encoder]:
    """Simulate the forced circular motion with the encoder of its motor [SG14, Sec. 2.3.3].

    The encoder starts at an unknown instant within the first 2 s of the recording (chosen by us).

    Parameters
    ----------
    duration : float
        Length of the recording, s; 3 min printed.
    encoder_hz : float
        Rate of the encoder, Hz; 250 printed.
    counts : int
        Steps per turn; 0: a perfect encoder.  2048 chosen by us.
    seed : int or numpy.random.Generator, optional
        For the same numbers again; the recording is that of `simulate` with the same seed.
    **options
        As in `simulate`, those of the motion "circle" among them.

    Returns
    -------
    tuple of Recording and Encoder

    Examples
    --------
    >>> recording, encoder = simulate_with_encoder(duration=20, frequency_hz=1.0, seed=1)
    >>> round(float(np.gradient(encoder.angle, encoder.t)[3000:4000].mean()) / (2 * np.pi), 2)
    1.0
    """
    rng = np.random.default_rng(seed)
    recording = simulate("circle", duration=duration, seed=rng, **options)
    start = rng.uniform(0.0, LATEST_START)
    t = np.arange(round((duration - start) * encoder_hz)) / encoder_hz
    rod = {**options_of("circle"), **options}
    angle = rod_angle(t + start, frequency_hz=rod["frequency_hz"], rise=rod["rise"]).value
    step = 2 * np.pi / counts if counts else 0.0
    return recording, Encoder(t, np.round(angle / step) * step if step else angle)
