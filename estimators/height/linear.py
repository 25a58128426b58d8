"""What all linear Kalman height filters share: a filterpy `KalmanFilter` that takes samples as they come.

The state begins with height and velocity.  A concrete filter says, as functions of the interval,

    x_k = F(dt) x_{k-1} + B(dt) (u_{k-1} + w_a) + w,   w_a ~ (0, sigma_a^2),   w ~ (0, wander(dt)),
    z_k = H x_k + v,   v ~ (0, R)

where u is the vertical acceleration, held over the interval together with its white noise of sd sigma_a *per
sample*: Q = wander + sigma_a^2 B B' (state which discretisation you mean; this one is filterpy's "discrete
white noise").  The plain attributes F, B, Q of filterpy are these functions at the nominal dt; `step` and
`run` evaluate them at the intervals they see, and `run` is a compiled loop over the very same matrices.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np
from filterpy.kalman import KalmanFilter
from numpy.typing import NDArray

from baroarma.estimators.base import Alignment, HeightEstimator, HeightRun, HeightState
from baroarma.estimators.height.drive import Drive, as_signal, nominal_interval
from baroarma.estimators.height.kernels import Rows, filter_rows
from baroarma.estimators.height.smoother import smooth_rows

Signal = NDArray[np.float64]


class LinearHeight(KalmanFilter, HeightEstimator):
    """Run a linear Kalman filter for height and velocity.

    Concrete filters take these settings along with their own.

    Parameters
    ----------
    states : tuple of str
        What the state holds, height and velocity first.
    dt : float or None
        Nominal interval in s, for filterpy's own `predict`.
    acceleration_sd : float
        White noise of one acceleration sample, m/s², wherever `step` or `run` isn't told.  Larger: the
        barometer is followed faster.
    initial_height_sd, initial_velocity_sd : float
        Sds at the start, m and m/s: height counts from there, and one starts at rest, more or less.
    midpoint : bool
        Integrate the mean of two acceleration samples instead of the earlier one.
    zupt_steps, zupt_threshold : int, float
        Lee16's zero-velocity rule: |a| < threshold (m/s²) for so many steps; 0 steps: no rule.
    rest_sd : float
        Sd of 'the velocity is 0' at rest, m/s.
    """

    note: str = ""
    """What this filter leaves out of the noise it was given, in a sentence; empty: nothing."""

    def __init__(
        self,
        states: tuple[str, ...],
        /,
        *,
        dt: float | None,
        acceleration_sd: float,
        initial_height_sd: float = 1e-3,
        initial_velocity_sd: float = 0.1,
        midpoint: bool = False,
        zupt_steps: int = 0,
        zupt_threshold: float = 0.1,
        rest_sd: float = 0.01,
    ) -> None:
        KalmanFilter.__init__(self, dim_x=len(states), dim_z=1, dim_u=1)
        self.states, self.dt = states, nominal_interval(dt)
        self.acceleration_sd, self.rest_sd = acceleration_sd, rest_sd
        self.initial_height_sd, self.initial_velocity_sd = initial_height_sd, initial_velocity_sd
        self.drive = Drive(midpoint=midpoint, zupt_steps=zupt_steps, zupt_threshold=zupt_threshold)
        self.F, self.B = self.transition(self.dt), self.input_matrix(self.dt)
        self.Q = self.process_noise(self.dt)
        self.reset()

    @abstractmethod
    def transition(self, dt: float | Signal) -> Signal:
        """Return F for an interval in s, (m, m), or a stack of them for an array of intervals."""

    @abstractmethod
    def wander(self, dt: float | Signal) -> Signal:
        """Return the process noise of an interval without the acceleration's, (..., m, m)."""

    @abstractmethod
    def initial_covariance(self) -> Signal:
        """Return P at the start, (m, m)."""

    def input_matrix(self, dt: float | Signal) -> Signal:
        """Return B for an interval in s, (..., m, 1): a held acceleration moves height and velocity."""
        dt = np.asarray(dt, float)
        B = np.zeros((*dt.shape, self.dim_x, 1))
        B[..., 0, 0], B[..., 1, 0] = dt**2 / 2, dt
        return B

    def process_noise(self, dt: float, acceleration_sd: float = float("nan")) -> Signal:
        """Return Q for an interval in s; `acceleration_sd` NaN: the setting."""
        sd = self.acceleration_sd if np.isnan(acceleration_sd) else acceleration_sd
        B = self.input_matrix(dt)
        return np.asarray(self.wander(dt) + sd**2 * B @ B.T)

    def reset(self, alignment: Alignment | None = None) -> None:
        """Start anew at height 0 and velocity 0; the alignment has no effect here."""
        self.drive.reset()
        self._started = False
        self._restore(np.zeros(self.dim_x), self.initial_covariance())

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
    ) -> HeightState:
        """Take one sample by filterpy's `predict` and `update`; see `HeightEstimator.step`."""
        u, quiet = self.drive.step(acceleration)
        if self._started:
            self._advance(dt, u, acceleration_sd)
        self._started = True
        if at_rest or quiet:
            KalmanFilter.update(self, np.zeros((1, 1)), R=self.rest_sd**2, H=self._rest()[None])
        if not np.isnan(altitude):
            self.update(altitude)
        sds = np.sqrt(np.diag(self.P)[:2])
        return HeightState(float(self.x[0, 0]), float(self.x[1, 0]), float(sds[0]), float(sds[1]))

    def run(
        self,
        t: Signal,
        altitude: Signal,
        acceleration: Signal | None = None,
        acceleration_sd: Signal | None = None,
        accel: Signal | None = None,
        gyro: Signal | None = None,
        at_rest: NDArray[np.bool_] | None = None,
    ) -> HeightRun:
        """Take all samples, compiled; see `HeightEstimator.run`."""
        return self._batch(filter_rows, t, altitude, acceleration, acceleration_sd, at_rest)

    def smooth(
        self,
        t: Signal,
        altitude: Signal,
        acceleration: Signal | None = None,
        acceleration_sd: Signal | None = None,
        at_rest: NDArray[np.bool_] | None = None,
    ) -> HeightRun:
        """Like `run`, but each row knows all samples, the later ones too (fixed-interval smoother)."""
        return self._batch(smooth_rows, t, altitude, acceleration, acceleration_sd, at_rest)

    def _advance(self, dt: float, u: float, acceleration_sd: float) -> None:
        Q = self.process_noise(dt, acceleration_sd)
        self.predict(u, B=self.input_matrix(dt), F=self.transition(dt), Q=Q)

    def _batch(
        self,
        kernel: Any,
        t: Signal,
        altitude: Signal,
        acceleration: Signal | None,
        acceleration_sd: Signal | None,
        at_rest: NDArray[np.bool_] | None,
    ) -> HeightRun:
        n = len(t)
        t, altitude = np.asarray(t, float), np.asarray(altitude, float)
        u, quiet = self.drive.rows(as_signal(acceleration, n))
        sd = as_signal(acceleration_sd, n)
        F, B, Q, transition = self._transitions(t, altitude)
        H, R, measurement, z = self._measurements(t, altitude)
        variance = np.where(np.isnan(sd), self.acceleration_sd, sd) ** 2
        rest = quiet if at_rest is None else quiet | np.asarray(at_rest, np.bool_)
        # fmt: off
        rows = Rows(F, np.ascontiguousarray(B[..., 0]), Q, transition, H, R, measurement, z,
                    u, variance, rest, self._rest(), float(self.rest_sd**2))
        # fmt: on
        x, P, out = self.x[:, 0].copy(), self.P.copy(), np.empty((4, n))
        kernel(rows, x, P, out)
        self._restore(x, P)
        self._started = self._started or n > 0
        return HeightRun(*out)

    def _transitions(self, t: Signal, altitude: Signal) -> tuple[Signal, Signal, Signal, NDArray[np.int64]]:
        """Tables of F, B and wander, and which entry leads to each row (-1: none, the first)."""
        dt, which = np.unique(np.diff(t), return_inverse=True)
        index = np.concatenate([np.full(min(len(t), 1), -1), which])
        return self.transition(dt), self.input_matrix(dt), self.wander(dt), index

    def _measurements(self, t: Signal, altitude: Signal) -> tuple[Signal, Signal, NDArray[np.int64], Signal]:
        """Tables of H and R, which entry belongs to each row, and the measurements themselves."""
        return np.array(self.H, float), np.reshape(self.R, 1), np.zeros(len(t), np.int64), altitude

    def _rest(self) -> Signal:
        return np.asarray(np.eye(self.dim_x)[1])

    def _restore(self, x: Signal, P: Signal) -> None:
        self.x, self.P = x[:, None].copy(), P.copy()
        self.x_prior = self.x_post = self.x.copy()
        self.P_prior = self.P_post = self.P.copy()


def motion_transition(dt: float | Signal, *, bias: bool = False) -> Signal:
    """Return F of height and velocity, and of the bias that the accelerometer adds, (..., 2 or 3, same).

    Examples
    --------
    >>> motion_transition(0.1, bias=True).round(3).tolist()
    [[1.0, 0.1, -0.005], [0.0, 1.0, -0.1], [0.0, 0.0, 1.0]]
    """
    dt = np.asarray(dt, float)
    F = np.zeros((*dt.shape, 3, 3))
    F[..., [0, 1, 2], [0, 1, 2]] = 1.0
    F[..., 0, 1], F[..., 0, 2], F[..., 1, 2] = dt, -(dt**2) / 2, -dt
    return F if bias else np.ascontiguousarray(F[..., :2, :2])
