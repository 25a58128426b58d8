"""Ours: height and velocity with the altimeter's coloured noise and the accelerometer's bias in the state.

    state [h, v, accelerometer bias, barometer offset, Gauss-Markov noise],   z = h + offset + n_c + n_u

The offset is unknown at the start and drifts as a random walk, so that no average has to be subtracted from
the barometer first (which would cost an error for the whole run).  With drift, height and offset can't be
told apart in the long run: the height's sd grows without end, and that is the truth.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from baroarma.estimators.colouring import block_diagonal, noise_states
from baroarma.estimators.height.linear import LinearHeight, motion_transition
from baroarma.noise_model import NoiseModel

Signal = NDArray[np.float64]


class ColouredKalman(LinearHeight):
    """Estimate height and velocity with the altimeter's noise model in the state.

    Parameters
    ----------
    noise : NoiseModel
        Noise of the raw altitude samples that are passed in; for averages pass `noise.at_rate(...)`.
        Without a Gauss-Markov component its state is left out, and `note` says so.
    dt : float
        Nominal interval, s.
    acceleration_sd : float
        White noise of one acceleration sample, m/s²; default 2.5 mg, a MEMS accelerometer at 50 Hz.
    bias_sd : float
        Prior sd of the accelerometer bias, m/s²; default 5 mg.  Larger: found by the barometer alone.
    bias_walk : float
        Its random walk, m/s²/sqrt(s); default 1 mm/s² in a second, 1 mg in 100 s.
    offset_sd : float
        Prior sd of the barometer's offset, m.  Wide by default; small when the level is known; 0 without
        drift: no such state.
    **settings
        See `LinearHeight`; `midpoint` is on by default.

    Examples
    --------
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> ColouredKalman(noise=noise, dt=0.02).states
    ('height', 'velocity', 'acceleration_bias', 'offset', 'correlated')
    """

    def __init__(
        self,
        *,
        noise: NoiseModel | None = None,
        dt: float | None = None,
        acceleration_sd: float = 0.025,
        bias_sd: float = 0.05,
        bias_walk: float = 1e-3,
        offset_sd: float = 100.0,
        midpoint: bool = True,
        **settings: Any,
    ) -> None:
        if noise is None:
            raise ValueError(needs_noise("coloured-kalman"))
        self.noise, self.bias_sd, self.bias_walk, self.offset_sd = noise, bias_sd, bias_walk, offset_sd
        states = ["height", "velocity", "acceleration_bias"]
        states += ["offset"] * bool(noise.drift_rate or offset_sd) + ["correlated"] * noise.has_gauss_markov
        if not noise.has_gauss_markov:
            self.note = "The noise model has no Gauss-Markov component: there is no state for it."
        super().__init__(tuple(states), dt=dt, acceleration_sd=acceleration_sd, midpoint=midpoint, **settings)
        altimeter = noise_states(noise, self.dt, offset_sd=offset_sd)
        self.H, self.R = np.hstack([[[1.0, 0.0, 0.0]], altimeter.H]), altimeter.R

    def transition(self, dt: float | Signal) -> Signal:
        """Return F for an interval in s."""
        altimeter = noise_states(self.noise, dt, offset_sd=self.offset_sd)
        return block_diagonal(motion_transition(dt, bias=True), altimeter.F)

    def wander(self, dt: float | Signal) -> Signal:
        """Return the process noise of bias, offset and Gauss-Markov noise."""
        altimeter = noise_states(self.noise, dt, offset_sd=self.offset_sd)
        return block_diagonal(bias_wander(dt, self.bias_walk), altimeter.Q)

    def initial_covariance(self) -> Signal:
        """Return P at the start."""
        motion = np.diag([self.initial_height_sd, self.initial_velocity_sd, self.bias_sd]) ** 2
        return block_diagonal(motion, noise_states(self.noise, self.dt, offset_sd=self.offset_sd).P)


def bias_wander(dt: float | Signal, bias_walk: float) -> Signal:
    """Return the process noise of [height, velocity, bias] when the bias walks, (..., 3, 3).

    Examples
    --------
    >>> bias_wander(0.25, 2.0)[2].tolist()
    [0.0, 0.0, 1.0]
    """
    dt = np.asarray(dt, float)
    Q = np.zeros((*dt.shape, 3, 3))
    Q[..., 2, 2] = bias_walk**2 * dt
    return Q


def needs_noise(name: str) -> str:
    """Return the sentence for a filter that cannot do without a noise model."""
    return (
        f"{name!r} needs a noise model: identify one from a rest recording, or say it by hand, such as "
        "NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)"
    )
