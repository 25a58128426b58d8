"""What all linear Kalman height filters share: a filterpy `KalmanFilter` that takes samples as they come.

The state begins with height and velocity.  A concrete filter says, as functions of the interval,

    x_k = F(dt) x_{k-1} + B(dt) (u_{k-1} + w_a) + w,   w_a ~ (0, sigma_a^2),   w ~ (0, wander(dt)),
    z_k = H x_k + v,   v ~ (0, R)

where u is the vertical acceleration, held over the interval together with its white noise of sd sigma_a *per
sample*: Q = wander + sigma_a^2 B B' (state which discretisation you mean; this one is filterpy's "discrete
white noise").  The plain attributes F, B, Q of filterpy are these functions at the nominal dt, and its own
`predict` and `update` work on them; `step` and `run` evaluate the functions at the intervals they see, in a
compiled loop that gives filterpy's numbers.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Any, Final

import numpy as np
from filterpy.kalman import KalmanFilter
from numpy.typing import NDArray

from baroarma.estimators.base import (
    STALE,
    UNSEEN_WALK,
    Alignment,
    HeightEstimator,
    HeightRun,
    HeightState,
)
from baroarma.estimators.height.drive import Drive, as_signal, nominal_interval
from baroarma.estimators.height.kernels import HEIGHT, Row, Rows, Tables, entries, filter_row, filter_rows
from baroarma.estimators.height.smoother import smooth_rows

Signal = NDArray[np.float64]
LONGEST_STEP: Final = 600.0
"""A longer interval counts as this, s: velocity and height are unknown by then (12 m/s, 4 km), and numbers
that are larger still would drown what is known."""


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
    unresolved : float
        Share of the change from one acceleration sample to the next that the integration may miss; default
        0: what happens between samples is as smooth as they are.

    Examples
    --------
    Three matrices make a filter that steps, runs and smooths; here one that knows of a constant bias:

    >>> class Biased(LinearHeight):
    ...     def __init__(self):
    ...         super().__init__(("height", "velocity", "bias"), dt=0.02, acceleration_sd=0.05)
    ...         self.H, self.R = np.array([[1.0, 0.0, 0.0]]), np.array([[0.01]])
    ...
    ...     def transition(self, dt):
    ...         return motion_transition(dt, bias=True)
    ...
    ...     def wander(self, dt):
    ...         return np.zeros((*np.shape(dt), 3, 3))
    ...
    ...     def initial_covariance(self):
    ...         return np.diag([1e-6, 0.01, 0.25])
    >>> t = np.arange(1000) / 50
    >>> kf = Biased()
    >>> found = kf.run(t, np.zeros(1000), np.full(1000, 0.3))  # at rest, says the barometer
    >>> round(float(kf.x[2, 0]), 2)
    0.3
    """

    x: Signal
    """State, (m, 1)."""
    P: Signal
    """Its covariance, (m, m)."""
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
        unresolved: float = 0.0,
    ) -> None:
        KalmanFilter.__init__(self, dim_x=len(states), dim_z=1, dim_u=1)
        self.states, self.dt, self._size = states, nominal_interval(dt), (0,) * len(states)
        self.acceleration_sd, self.rest_sd, self.unresolved = acceleration_sd, rest_sd, unresolved
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
        """Return B for an interval in s, (..., m, 1): a held acceleration moves height and velocity.

        Examples
        --------
        >>> from baroarma.estimators.height.kalman import Kalman
        >>> Kalman(dt=0.1).input_matrix(0.1).round(6).tolist()
        [[0.005], [0.1]]
        """
        B = np.zeros((*np.shape(dt), self.dim_x, 1))
        fill_input(B[..., 0], dt)
        return B

    def process_noise(self, dt: float, acceleration_sd: float = float("nan")) -> Signal:
        """Return Q for an interval in s; `acceleration_sd` NaN: the setting.

        Parameters
        ----------
        dt : float
            Interval, s.
        acceleration_sd : float
            Of its acceleration sample, m/s²; NaN: the setting.

        Examples
        --------
        White acceleration held over dt gives Q = sd² B Bᵀ with B = [dt²/2, dt]:

        >>> from baroarma.estimators.height.kalman import Kalman
        >>> Kalman(dt=0.1).process_noise(0.1, acceleration_sd=2.0).round(9).tolist()
        [[0.0001, 0.002], [0.002, 0.04]]
        """
        sd = self.acceleration_sd if np.isnan(acceleration_sd) else acceleration_sd
        B = self.input_matrix(dt)
        return np.asarray(self._unseen(dt) + sd**2 * B @ B.T)

    def _unseen(self, dt: float | Signal) -> Signal:
        """Return `wander`, and what the height does beside it where nothing was felt for long."""
        Q = self.wander(dt)
        Q[..., HEIGHT, HEIGHT] += unseen_variance(dt)
        return Q

    def reset(self, alignment: Alignment | None = None) -> None:
        """Start anew at height 0 and velocity 0; the alignment has no effect here."""
        self.drive.reset()
        self._started = False
        self._kept: dict[float, Tables] = {}
        self._stand(np.zeros(self.dim_x), self.initial_covariance())

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
        """Take one sample, by the same compiled loop as `run`; see `HeightEstimator.step`.

        Of filterpy's attributes x and P are those of this sample; the others, such as `x_prior` or `K`, are
        those of the last `predict`, `update` or `run`.
        """
        first, dt = not self._started, min(float(dt), LONGEST_STEP) if self._started else 0.0
        u, variance, quiet = self._driven(float(acceleration), float(acceleration_sd))
        u = u if dt <= STALE else 0.0
        row = self._row(dt, float(altitude), u, variance, quiet or bool(at_rest), up)
        H, r = np.ascontiguousarray(self.H, float), np.asarray(self.R, float).item()
        x, P = self.x[:, 0].copy(), self.P.copy()
        found = self._take(self._tables(self.dt if first else dt), H, r, first, row, x, P)
        self.x, self.P, self._started = x[:, None], P, True
        return found

    def run(
        self,
        t: Signal,
        altitude: Signal,
        acceleration: Signal | None = None,
        acceleration_sd: Signal | None = None,
        accel: Signal | None = None,
        gyro: Signal | None = None,
        at_rest: NDArray[np.bool_] | None = None,
        up: Signal | None = None,
        *,
        dt: float = 0.0,
    ) -> HeightRun:
        """Take all samples, compiled; see `HeightEstimator.run`."""
        steps = steps_of(t, dt)
        return self._filter(self._rows(steps, altitude, acceleration, acceleration_sd, at_rest, up))

    def smooth(
        self,
        t: Signal,
        altitude: Signal,
        acceleration: Signal | None = None,
        acceleration_sd: Signal | None = None,
        at_rest: NDArray[np.bool_] | None = None,
        up: Signal | None = None,
        *,
        lag: float = math.inf,
    ) -> HeightRun:
        """Like `run`, but each row knows later samples, too.

        Parameters
        ----------
        t, altitude, acceleration, acceleration_sd, at_rest, up
            As in `run`.
        lag : float
            How many seconds of later samples a row may know (fixed-lag smoother, for near-on-line use);
            default: all of them (fixed-interval).  The time this takes grows with the lag.

        Returns
        -------
        HeightRun
            Sds no larger than `run`'s.

        Raises
        ------
        ValueError
            If the lag is negative.

        Examples
        --------
        >>> from baroarma.estimators.height.kalman import Kalman
        >>> t, z = np.arange(200) / 50, np.random.default_rng(1).normal(0, 0.3, 200)
        >>> filtered, smoothed = Kalman(dt=0.02).run(t, z), Kalman(dt=0.02).smooth(t, z)
        >>> bool((smoothed.height_sd <= filtered.height_sd + 1e-12).all())
        True
        >>> bool(abs(smoothed.height_sd[-1] - filtered.height_sd[-1]) < 1e-12)  # nothing came after
        True
        """
        if not lag >= 0:
            raise ValueError(f"the lag is a time in s, 0 or more, but it is {lag}")
        return self._smooth(
            self._rows(steps_of(t), altitude, acceleration, acceleration_sd, at_rest, up), float(lag)
        )

    def _take(
        self, tables: Tables, H: Signal, r: float, first: bool, row: Row, x: Signal, P: Signal
    ) -> HeightState:
        """Take one row in place from x (m,), P (m, m)."""
        given: tuple[Any, ...] = (*tables, H, r, first, *row, self._size, x, P)
        return HeightState(*filter_row(*given))

    def _driven(self, acceleration: float, acceleration_sd: float) -> tuple[float, float, bool]:
        """Return what drives a step, its variance, and whether it is quiet: for one row what `_rows` does."""
        u, missed, quiet = self.drive.step(acceleration)
        sd = self.acceleration_sd if math.isnan(acceleration_sd) else acceleration_sd
        missed = self.unresolved * max(missed - 5 * sd, 0.0)
        return u, sd * sd + missed * missed, quiet

    def _row(
        self, dt: float, altitude: float, u: float, variance: float, at_rest: bool, up: Signal | None
    ) -> Row:
        """Do for one row what else `_rows` does."""
        return Row(altitude, dt, u, variance, at_rest, self.rest_sd**2, math.nan, math.nan, 0.0, 0)

    def _tables(self, dt: float) -> Tables:
        """Return the matrices of an interval; those of the last one are kept."""
        if dt not in self._kept:
            self._kept = {dt: self._tables_at(dt)}
        return self._kept[dt]

    def _tables_at(self, dt: float) -> Tables:
        return self._matrices(np.array([dt]))

    def _matrices(self, dt: Signal) -> Tables:
        """Return what the loops read of intervals in s, (n,)."""
        B = np.ascontiguousarray(self.input_matrix(dt)[..., 0])
        return Tables(self.transition(dt), B, self._unseen(dt))

    def _filter(self, rows: Rows) -> HeightRun:
        """Take rows, and stand where the last one leads."""
        return self._loop(filter_rows, rows)

    def _smooth(self, rows: Rows, lag: float) -> HeightRun:
        return self._loop(smooth_rows, rows, lag)

    def _loop(self, kernel: Any, rows: Rows, *options: float) -> HeightRun:
        """Run a compiled loop from the present state to the last row's."""
        n = len(rows.z)
        x, P, out = self.x.T.copy(), self.P[None].copy(), np.empty((4, n))
        kernel(rows, *options, self._size, x, P, out)
        self._stand(x[0], P[0])
        self._started = self._started or n > 0
        return HeightRun(*out)

    def _rows(
        self,
        steps: Signal,
        altitude: Signal,
        acceleration: Signal | None,
        acceleration_sd: Signal | None,
        at_rest: NDArray[np.bool_] | None,
        up: Signal | None,
    ) -> Rows:
        """Turn samples, and the time before each (NaN: none, the first), into what the loops read."""
        n, altitude, steps = len(steps), np.asarray(altitude, float), np.minimum(steps, LONGEST_STEP)
        u, missed, quiet = self.drive.rows(as_signal(acceleration, n))
        u = np.where(steps > STALE, 0.0, u)
        sd = as_signal(acceleration_sd, n)
        sd = np.where(np.isnan(sd), self.acceleration_sd, sd)
        # what changes by more than noise from sample to sample may do anything between them
        missed = self.unresolved * np.maximum(missed - 5 * sd, 0.0)
        F, B, Q, transition = self._transitions(steps, altitude)
        H, R, measurement, z = self._measurements(steps, altitude)
        rest = quiet if at_rest is None else quiet | np.asarray(at_rest, np.bool_)
        none, elapsed = np.full(n, np.nan), np.where(np.isnan(steps), 0.0, steps)
        # fmt: off
        return Rows(F, B, Q, *entries(F), transition,
                    H, R, measurement, z, elapsed,
                    u, sd**2 + missed**2, rest, np.full(n, self.rest_sd**2), none, none,
                    np.zeros(n), np.zeros(n), np.zeros(n), 0)
        # fmt: on

    def _transitions(
        self, steps: Signal, altitude: Signal
    ) -> tuple[Signal, Signal, Signal, NDArray[np.int64]]:
        """Tables of F, B and wander, and which entry leads to each row (-1: none, the first)."""
        none = np.isnan(steps)
        dt = np.unique(steps[~none])
        which = np.where(none, -1, np.searchsorted(dt, steps))
        return *self._matrices(dt), which

    def _measurements(
        self, steps: Signal, altitude: Signal
    ) -> tuple[Signal, Signal, NDArray[np.int64], Signal]:
        """Tables of H and R, which entry belongs to each row, and the measurements themselves."""
        return np.array(self.H, float), np.reshape(self.R, 1), np.zeros(len(steps), np.int64), altitude

    def _stand(self, x: Signal, P: Signal) -> None:
        """Stand at a new state (m,) and covariance (m, m), which are nobody else's."""
        self.x, self.P = x[:, None], P
        self.x_prior = self.x_post = self.x.copy()
        self.P_prior = self.P_post = self.P.copy()


def unseen_variance(dt: float | Signal) -> float | NDArray[np.floating[Any]]:
    """Return how far the height wanders, m², in an interval (s) too long for an acceleration to be held.

    White acceleration of density q moves the velocity by q dt and the height by q dt³/3; an acceleration that
    is held over dt, with the variance q/dt, explains q dt³/4 of it.

    Examples
    --------
    >>> unseen_variance(np.array([0.02, 2.0])).round(3).tolist()
    [0.0, 0.167]
    """
    return (dt > STALE) * (UNSEEN_WALK**2 * dt * dt * dt / 12)


def steps_of(t: Signal, dt: float = 0.0) -> Signal:
    """Return the time before each row: `dt` before the first, and NaN instead of 0, for nothing was."""
    t = np.asarray(t, float)
    return np.diff(t, prepend=t[:1] - (dt or np.nan))


def motion_transition(dt: float | Signal, *, bias: bool = False) -> Signal:
    """Return F of height and velocity, and of the bias that the accelerometer adds, (..., 2 or 3, same).

    Examples
    --------
    >>> motion_transition(0.1, bias=True).round(3).tolist()
    [[1.0, 0.1, -0.005], [0.0, 1.0, -0.1], [0.0, 0.0, 1.0]]
    """
    m = 3 if bias else 2
    F = np.zeros((*np.shape(dt), m, m)) + np.eye(m)
    fill_motion(F, dt)
    return F


def fill_motion(F: Signal, dt: float | Signal) -> None:
    """Write what depends on the interval, in s, into the F of height, velocity and, if it has one, bias."""
    F[..., 0, 1] = dt
    if F.shape[-1] > 2:
        F[..., 0, 2], F[..., 1, 2] = -(dt**2) / 2, -dt


def fill_input(B: Signal, dt: float | Signal) -> None:
    """Write what an acceleration that is held over dt s does to height and velocity, (..., m)."""
    B[..., 0], B[..., 1] = dt**2 / 2, dt
