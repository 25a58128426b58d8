"""Measurement differencing [Bryson & Henrikson 1968]: the other way to treat Gauss-Markov noise.

With z_k = s_k + c_k, s = h + offset and c_k = phi c_{k-1} + w_k, phi = exp(-gap/tau), the difference

    zeta_k = z_k - phi z_{k-1} = s_k - phi s_{k-1} + w_k,     var w = sigma_c^2 (1 - phi^2)

has white noise.  s_{k-1}, the signal at the last sample, is carried as a state, so that w is independent of
everything else and gaps need no special case; before the first sample the gap is infinite, phi = 0 and the
'difference' is the sample itself.  For pure Gauss-Markov noise this is the augmented filter in other words.

White noise u spoils it: u_k - phi u_{k-1} is MA(1) (lag-1 correlation about -1/2).  Either u is a state, too
(s then includes it, and the filter is exact again), or it is treated as white and `note` says so.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from baroarma.estimators.base import Alignment, HeightState
from baroarma.estimators.colouring import block_diagonal
from baroarma.estimators.height.coloured_kalman import (
    ACCELERATION_SD,
    BIAS_SD,
    needs_noise,
)
from baroarma.estimators.height.kernels import Rows
from baroarma.estimators.height.linear import LinearHeight, motion_transition
from baroarma.noise_model import NoiseModel

Signal = NDArray[np.float64]


class DifferencedKalman(LinearHeight):
    """Estimate height and velocity from differences of altitude samples.

    `update` takes the altitude itself and differences it; H and R follow from the time since the last sample.
    The attributes H, R and F are those of a sample at every nominal interval.

    Parameters
    ----------
    noise : NoiseModel
        Noise of the raw altitude samples.
    dt : float
        Nominal interval, s.
    carry_white : bool
        Carry the white noise as a state.  False: treat the differenced white noise as white, as is often
        done; simpler, and wrong (`note`).
    acceleration_sd, bias_sd, bias_walk, offset_sd : float
        As in `ColouredKalman`, without an alignment.
    **settings
        See `LinearHeight`; `midpoint` is on by default.

    Examples
    --------
    >>> gm = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.0, rate_hz=50)
    >>> kf = DifferencedKalman(noise=gm, dt=0.02)
    >>> kf.H.round(4).tolist(), kf.note
    ([[1.0, 0.0, 0.0, 1.0, -0.9737]], '')
    """

    def __init__(
        self,
        *,
        noise: NoiseModel | None = None,
        dt: float | None = None,
        carry_white: bool = True,
        acceleration_sd: float = ACCELERATION_SD,
        bias_sd: float = BIAS_SD,
        bias_walk: float = 3e-4,
        offset_sd: float = 100.0,
        midpoint: bool = True,
        **settings: Any,
    ) -> None:
        if noise is None:
            raise ValueError(needs_noise("differenced-kalman"))
        self.noise, self.bias_sd, self.bias_walk, self.offset_sd = noise, bias_sd, bias_walk, offset_sd
        self.carries_white = carry_white and noise.white_sd > 0
        white = ("white",) if self.carries_white else ()
        states = ("height", "velocity", "acceleration_bias", "offset", *white, "last_signal")
        self._sampled, self._gap, self._last = True, math.inf, 0.0
        super().__init__(states, dt=dt, acceleration_sd=acceleration_sd, midpoint=midpoint, **settings)
        H, R = self.differences(np.array([self.dt]))
        self.H, self.R, self.note = H, R[:, None], self._ignored()

    def transition(self, dt: float | Signal, sampled: bool | None = None) -> Signal:
        """Return F for an interval that began with a sample (s becomes the last signal) or without.

        Parameters
        ----------
        dt : float or ndarray
            Interval, s.
        sampled : bool, optional
            Default: whether there has been a sample since the last step.
        """
        F = block_diagonal(motion_transition(dt, bias=True), np.eye(self.dim_x - 3))
        if self.carries_white:
            F[..., 4, 4] = 0.0
        if self._sampled if sampled is None else sampled:
            F[..., -1, :] = self._signal()
        return F

    def wander(self, dt: float | Signal) -> Signal:
        """Return the process noise of bias, offset and white noise."""
        Q = np.zeros((*np.shape(dt), self.dim_x, self.dim_x))
        Q[..., 2, 2], Q[..., 3, 3] = self.bias_walk**2 * dt, self.noise.drift_rate**2 * dt
        if self.carries_white:
            Q[..., 4, 4] = self.noise.white_sd**2
        return Q

    def initial_covariance(self) -> Signal:
        """Return P at the start; there is no last signal yet, and its weight is 0 until there is."""
        sds = [self.initial_height_sd, self.initial_velocity_sd, self.bias_sd, self.offset_sd]
        white = [self.noise.white_sd] if self.carries_white else []
        return np.diag([*sds, *white, 0.0]) ** 2

    def differences(self, gap: Signal) -> tuple[Signal, Signal]:
        """Return H (n, m) and R (n,) of the difference to a sample `gap` s ago (n,); infinity: none.

        Examples
        --------
        After tau log 2 half of the last noise is left, after a long time none:

        >>> gm = NoiseModel(correlated_sd=0.3, correlation_time=1.0, white_sd=0.0, rate_hz=50)
        >>> H, R = DifferencedKalman(noise=gm, dt=0.02).differences(np.array([math.log(2), math.inf]))
        >>> abs(H[:, -1]).round(9).tolist(), R.round(9).tolist()  # 0.09 (1 - 1/4), 0.09
        ([0.5, 0.0], [0.0675, 0.09])
        """
        phi = self._phi(gap)
        H = np.tile(self._signal(), (len(gap), 1))
        H[:, -1] = -phi
        R = self.noise.correlated_sd**2 * (1 - phi**2)
        if not self.carries_white:
            R = R + self.noise.white_sd**2 * (1 + phi**2)
        return H, R

    def reset(self, alignment: Alignment | None = None) -> None:
        """Start anew at height 0 and velocity 0; the alignment has no effect here."""
        super().reset(alignment)
        self._sampled, self._gap, self._last = False, math.inf, 0.0

    def step(
        self,
        *,
        dt: float,
        altitude: float,
        acceleration: float = float("nan"),
        acceleration_sd: float = float("nan"),
        accel: Signal | None = None,
        gyro: Signal | None = None,
        at_rest: bool = False,
        up: Signal | None = None,
    ) -> HeightState:
        """Take one sample as a run of one row, whose H and R follow from the time since the last one."""
        steps = np.array([dt if self._started else np.nan])
        samples = (np.array([sample], float) for sample in (altitude, acceleration, acceleration_sd))
        found = self._filter(self._rows(steps, *samples, np.array([at_rest]), None))
        return HeightState(*(float(column[0]) for column in found))

    def predict(
        self,
        u: Any = None,
        B: Signal | None = None,
        F: Signal | None = None,
        Q: Signal | None = None,
    ) -> None:
        """Predict as filterpy does, over the nominal interval unless F says otherwise."""
        F = self.transition(self.dt) if F is None else F
        super().predict(u, B=B, F=F, Q=Q)
        self._sampled, self._gap = False, self._gap + self.dt

    def update(self, z: Any, R: Signal | None = None, H: Signal | None = None) -> None:
        """Update with an altitude in m (not with a difference); None: no sample.

        H and R passed in are taken, unless they are the filter's own attributes (as `batch_filter` passes
        them), which hold for a sample at every step only.  A second sample at the same instant has the same
        Gauss-Markov noise and is no new sample.
        """
        if z is None or self._gap == 0:
            super().update(None)
            return
        altitude = float(np.squeeze(z))
        own_H, own_R = self.differences(np.array([self._gap]))
        difference = altitude - float(self._phi(np.array([self._gap]))[0]) * self._last
        H = own_H if H is None or H is self.H else H
        R = own_R[:, None] if R is None or R is self.R else R
        super().update(np.array([[difference]]), R=R, H=H)
        self._sampled, self._gap, self._last = True, 0.0, altitude

    def _rows(self, steps: Signal, altitude: Signal, *rest: Any) -> Rows:
        altitude = np.array(altitude, float)
        if self._gap == 0 and len(steps) and not steps[0] > 0:
            altitude[0] = np.nan  # no time since the last sample: see `update`
        rows = super()._rows(steps, altitude, *rest)
        new, t = np.flatnonzero(np.isfinite(altitude)), np.cumsum(rows.dt)
        if len(new):
            self._sampled, self._last = bool(new[-1] == len(t) - 1), float(altitude[new[-1]])
            self._gap = float(t[-1] - t[new[-1]])
        elif len(t):
            self._sampled = self._sampled and bool(np.isnan(steps).all())
            self._gap += float(t[-1])
        return rows

    def _transitions(
        self, steps: Signal, altitude: Signal
    ) -> tuple[Signal, Signal, Signal, NDArray[np.int64]]:
        F, B, Q, which = super()._transitions(steps, altitude)
        dt = np.unique(steps[~np.isnan(steps)])
        sampled = np.isfinite(np.concatenate([[0.0 if self._sampled else np.nan], altitude[:-1]]))
        if np.isnan(steps[:1]).any():
            sampled[1:2] |= self._sampled
        F = np.concatenate([self.transition(dt, True), self.transition(dt, False)])
        which = np.where(which < 0, -1, which + len(dt) * ~sampled[: len(steps)])
        return F, np.tile(B, (2, 1)), np.tile(Q, (2, 1, 1)), which

    def _measurements(
        self, steps: Signal, altitude: Signal
    ) -> tuple[Signal, Signal, NDArray[np.int64], Signal]:
        new, t = np.flatnonzero(np.isfinite(altitude)), np.cumsum(np.nan_to_num(steps))
        gap = np.diff(t[new], prepend=-self._gap)
        before = np.concatenate([[self._last], altitude[new]])[: len(new)]
        z, index = np.full(len(t), np.nan), np.zeros(len(t), np.int64)
        z[new] = altitude[new] - self._phi(gap) * before
        gaps, index[new] = np.unique(gap, return_inverse=True)
        return *self.differences(gaps), index, z

    def _signal(self) -> Signal:
        """The row that sums what the altimeter sees apart from Gauss-Markov noise."""
        row = np.zeros(self.dim_x)
        row[[self.states.index(name) for name in ("height", "offset", "white") if name in self.states]] = 1.0
        return row

    def _phi(self, gap: Signal) -> Signal:
        if not self.noise.has_gauss_markov:
            return np.zeros_like(gap)
        return np.exp(-gap / self.noise.correlation_time)

    def _ignored(self) -> str:
        if not self.noise.has_gauss_markov:
            return "The noise model has no Gauss-Markov component: there is nothing to difference."
        if self.carries_white or self.noise.white_sd == 0:
            return ""
        phi = math.exp(-self.dt / self.noise.correlation_time)
        differenced = self.noise.correlated_sd**2 * (1 - phi**2) + self.noise.white_sd**2 * (1 + phi**2)
        return (
            f"Differencing makes the white noise of {self.noise.white_sd:.3g} m a moving average (lag-1 "
            f"correlation {-phi * self.noise.white_sd**2 / differenced:.2f}), treated as white here: the "
            "sds are wrong; `carry_white` cures it."
        )
