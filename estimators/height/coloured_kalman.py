"""Ours: height and velocity with the altimeter's coloured noise and the accelerometer's bias in the state.

    state [h, v, accelerometer bias b, (low-passed height l), barometer offset, Gauss-Markov noise n_c]
    z = h + offset + n_c + n_u,   with a barometer of time constant tau:  z = l + ...,  l' = (h - l)/tau

The offset is unknown at the start and drifts as a random walk, so that no average has to be subtracted from
the barometer first (which would cost an error for the whole run).  With drift, height and offset can't be
told apart in the long run: the height's sd grows without end, and that is the truth.

`at_rest` is a claim: it is what the IMU feels.  A bank of filters (`baroarma.estimators.height.bank`) weighs
it against velocity and barometer, ignores outliers of the barometer and follows it where it really jumps.
filterpy's own `predict` and `update` know nothing of that: they are the single filter.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.compiled import njit
from baroarma.estimators.base import Alignment, HeightRun, HeightState
from baroarma.estimators.colouring import block_diagonal, fill_noise, noise_states
from baroarma.estimators.height.bank import (
    AT_REST,
    REJECTED,
    Bank,
    Decisions,
    Rules,
)
from baroarma.estimators.height.kernels import HEIGHT, Row, Rows, Tables
from baroarma.estimators.height.linear import (
    LinearHeight,
    fill_input,
    fill_motion,
    steps_of,
    unseen_variance,
)
from baroarma.estimators.height.smoother import smooth_rows
from baroarma.noise_model import NoiseModel

Signal = NDArray[np.float64]
ACCELERATION_SD: Final = 0.025
"""White noise of one acceleration sample where no rest tells it, m/s²: 2.5 mg, a MEMS accelerometer at 50 Hz
(chosen by us)."""
BIAS_SD: Final = 0.03
"""Bias of an accelerometer where gravity tells no larger one, m/s² (chosen by us)."""
LEFT_BIAS_SD: Final = 5e-3
"""What an alignment leaves of it, beside its noise, m/s² (chosen by us)."""
LEAST_REST_SD: Final = 1e-3
"""Velocity of what rests, m/s, however quiet (chosen by us)."""
SHAKING_TIME: Final = 0.05
"""What shakes with 1 m/s² moves with so many m/s: 3 Hz (chosen by us)."""
REST_ODDS: Final = math.log(9.0)
"""Nine of ten periods without a felt motion are rests (chosen by us)."""
CRUISE_SD: Final = 1.0
"""Spread of the speeds of lifts and escalators, m/s (chosen by us)."""
LONGEST_ODDS: Final = 10.0
"""Log-odds beyond which no more certainty is gathered: 1 in 22 000 (chosen by us)."""
ONSET: Final = 0.5
"""Within so many seconds a start is noticed (chosen by us)."""
START: Final = 5.0
"""Standard deviations of a velocity that is no rest's any more (chosen by us)."""
SWAY: Final = 0.01
"""Velocity of what shakes in the wind but stays, m/s (chosen by us)."""


class ColouredKalman(LinearHeight):
    """Estimate height and velocity with the altimeter's noise model in the state.

    Parameters
    ----------
    noise : NoiseModel
        Noise of the raw altitude samples that are passed in; for averages pass `noise.at_rate(...)`.
        Without a Gauss-Markov component its state is left out, and `note` says so.
    dt : float
        Nominal interval, s.
    acceleration_sd : float, optional
        White noise of one acceleration sample, m/s².  Default: what the alignment's rest says, else 2.5 mg.
    bias_sd : float, optional
        Sd of the accelerometer's bias, m/s²: the prior where there is no alignment; and how much a turn by
        60 degrees brings to light of what an alignment has hidden in gravity.  Default: 3 mg, or what the
        alignment's gravity exceeds the standard one by, if that is more.  Larger: found by the barometer.
    bias_walk : float
        Its random walk, m/s²/sqrt(s); default 0.3 mm/s² in a second, 0.3 mg in 100 s.
    offset_sd : float
        Prior sd of the barometer's offset, m.  Wide by default; small when the level is known; 0 without
        drift: no such state.
    barometer_lag : float
        Time constant of the barometer's own low-pass filter, or its latency, s: about 0.2 in a BMP280 with
        its filter on.  `estimate_barometer_lag` finds it in a log with motion.  Default 0: none, no state.
    level_prior_sd : float, optional
        How far the height wanders about the start, m, if you know: 0.2 on an arm, 0.3 in squats.  It steadies
        the height and pulls true changes of level back; default: nothing is known.
    level_prior_time : float
        How long one such excursion lasts, s.  Longer: the level counts less.
    floors : sequence of float
        Heights of known floors above the start, m; at rest, the one that is sure is taken.
    floor_sd : float
        How exactly they are known, m.
    confirm_rest : bool
        Whether to weigh what `at_rest` claims; False: it is ignored.
    gate : float
        An altitude so many standard deviations off is an outlier; infinity: none is.
    recovery : float
        Outliers that go on for so many seconds are believed: something has jumped.
    pressure_step : float
        A step up to so many metres that nothing felt, and that stays, is the pressure's (a door, a fan): the
        offset takes it.  Larger steps are the height's, and so are smaller ones with 0.
    unresolved : float
        Share of the change from one acceleration sample to the next that the midpoint may miss.
    rest_sd : float, optional
        Velocity of what rests, m/s; default: what the noise of the acceleration samples is over 1/20 s.
    decided : callable, optional
        Called after each `run` with the `Decisions` on its rows: rests, outliers, floors, jumps, the odds.
        A tracker runs a long recording in parts; a list's `append` collects them.
    **settings
        See `LinearHeight`; `midpoint` is on by default.

    Examples
    --------
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> ColouredKalman(noise=noise, dt=0.02).states
    ('height', 'velocity', 'acceleration_bias', 'offset', 'correlated')
    """

    listens_to_rest = True
    bias_sd: float
    """Sd of the accelerometer's bias, m/s²: as given, else as the alignment says."""
    evidence: float
    """Log-likelihood of the altitudes that were taken since `reset`."""

    def __init__(
        self,
        *,
        noise: NoiseModel | None = None,
        dt: float | None = None,
        acceleration_sd: float | None = None,
        bias_sd: float | None = None,
        bias_walk: float = 3e-4,
        offset_sd: float = 100.0,
        barometer_lag: float = 0.0,
        level_prior_sd: float | None = None,
        level_prior_time: float = 1.0,
        floors: Sequence[float] = (),
        floor_sd: float = 0.05,
        confirm_rest: bool = True,
        gate: float = 6.0,
        recovery: float = 2.0,
        pressure_step: float = 5.0,
        unresolved: float = 0.1,
        midpoint: bool = True,
        rest_sd: float | None = None,
        decided: Callable[[Decisions], object] | None = None,
        **settings: Any,
    ) -> None:
        if noise is None:
            raise ValueError(needs_noise("coloured-kalman"))
        self.noise, self.bias_walk, self.offset_sd = noise, bias_walk, offset_sd
        self.barometer_lag, self.confirm_rest = barometer_lag, confirm_rest
        self.level_prior_sd, self.level_prior_time = level_prior_sd, level_prior_time
        self._given, self._decided = (acceleration_sd, bias_sd, rest_sd), decided
        has_offset = bool(noise.drift_rate or offset_sd)
        rules = Rules(
            gate=gate,
            recovery=recovery,
            prior_odds=REST_ODDS,
            cruise_sd=CRUISE_SD,
            longest_odds=LONGEST_ODDS,
            memory=ONSET,
            sway=SWAY,
            onset=START,
            pressure_step=pressure_step if has_offset else 0.0,
            floors=np.sort(np.array(floors, float)),
            floor_variance=float(floor_sd**2),
        )
        self._bank = Bank(rules, 0)
        states = ["height", "velocity", "acceleration_bias"] + ["low_passed"] * bool(barometer_lag)
        states += ["offset"] * has_offset + ["correlated"] * noise.has_gauss_markov
        self._offset = states.index("offset") if has_offset else 0
        if not noise.has_gauss_markov:
            self.note = "The noise model has no Gauss-Markov component: there is no state for it."
        super().__init__(
            tuple(states),
            dt=dt,
            acceleration_sd=ACCELERATION_SD if acceleration_sd is None else acceleration_sd,
            midpoint=midpoint,
            rest_sd=LEAST_REST_SD if rest_sd is None else rest_sd,
            unresolved=unresolved,
            **settings,
        )
        altimeter = noise_states(noise, self.dt, offset_sd=offset_sd)
        seen = [[0.0, 0.0, 0.0, 1.0]] if barometer_lag else [[1.0, 0.0, 0.0]]
        self.H, self.R = np.hstack([seen, altimeter.H]), altimeter.R

    def rules(self) -> Rules:
        """Return when the bank believes what."""
        return self._bank.rules

    def given(self) -> tuple[float | None, float | None, float | None]:
        """Return `acceleration_sd`, `bias_sd`, `rest_sd` as they were given; None: the alignment is asked."""
        return self._given

    def transition(self, dt: float | Signal) -> Signal:
        """Return F for an interval in s.

        Examples
        --------
        Height and velocity move, less the accelerometer's bias; Gauss-Markov noise is forgotten:

        >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
        >>> F = ColouredKalman(noise=noise, dt=0.02).transition(0.75)
        >>> np.diag(F).round(4).tolist(), F[0, :3].round(5).tolist()
        ([1.0, 1.0, 1.0, 1.0, 0.3679], [1.0, 0.75, -0.28125])
        """
        return self._filled(dt)[0]

    def input_matrix(self, dt: float | Signal) -> Signal:
        """Return B for an interval in s, (..., m, 1)."""
        return self._filled(dt)[1][..., None]

    def wander(self, dt: float | Signal) -> Signal:
        """Return the process noise of bias, offset and Gauss-Markov noise."""
        return self._filled(dt)[2]

    def _filled(self, dt: float | Signal) -> Tables:
        """Return F, B and wander, (..., m, m), (..., m), (..., m, m)."""
        B = np.zeros((*np.shape(dt), self.dim_x))
        Q = np.zeros((*B.shape, self.dim_x))
        F = Q + np.eye(self.dim_x)
        self._fill(F, B, Q, dt)
        return Tables(F, B, Q)

    def _fill(self, F: Signal, B: Signal, Q: Signal, dt: float | Signal) -> None:
        """Write all that depends on the interval."""
        fill_motion(F, dt)
        fill_input(B, dt)
        Q[..., 2, 2] = self.bias_walk**2 * dt
        if self.barometer_lag:
            _fill_lagged(F, B, dt, self.barometer_lag)
        own = slice(4 if self.barometer_lag else 3, None)
        fill_noise(F[..., own, own], Q[..., own, own], self.noise, dt)

    def initial_covariance(self) -> Signal:
        """Return P at the start: height and low-passed height are the same."""
        bias_sd = self.bias_sd if self._aligned_sd is None else self._aligned_sd
        motion = np.diag([self.initial_height_sd, self.initial_velocity_sd, bias_sd]) ** 2
        if self.barometer_lag:
            same = [0, 1, 2, 0]
            motion = motion[np.ix_(same, same)]
        return block_diagonal(motion, noise_states(self.noise, self.dt, offset_sd=self.offset_sd).P)

    def reset(self, alignment: Alignment | None = None) -> None:
        """Start anew at height 0 and velocity 0, with the accelerometer noise that the alignment saw."""
        accel_sd, bias_sd, self._aligned_sd = ACCELERATION_SD, BIAS_SD, None
        if alignment is not None and math.isfinite(alignment.accel_sd):
            accel_sd = alignment.accel_sd
            bias_sd = math.hypot(BIAS_SD, alignment.gravity - STANDARD_GRAVITY)
            self._aligned_sd = math.hypot(np.nan_to_num(alignment.gravity_sd), LEFT_BIAS_SD)
        self.acceleration_sd, self.bias_sd = (
            usual if given is None else given
            for given, usual in zip(self._given[:2], (accel_sd, bias_sd), strict=True)
        )
        self.Q = self.process_noise(self.dt)
        self.evidence = 0.0
        self._anchor = np.array([*(alignment or Alignment()).up, 0.0])
        self._bank = Bank(self._bank.rules, self.dim_x, lagged=bool(self.barometer_lag))
        super().reset(alignment)

    def look_back(self, t: Signal, altitude: Signal, *, dt: float) -> None:
        """Learn the barometer's offset from the rest before the first row, if rests are believed.

        Parameters
        ----------
        t, altitude, dt
            As in `HeightEstimator.look_back`.
        """
        if not self.confirm_rest:
            return
        t, altitude = np.append(t, t[-1] + dt), np.append(altitude, np.nan)
        self.decide(t, altitude, np.zeros(len(t)), at_rest=np.ones(len(t), np.bool_))
        self._started = False

    def decide(
        self,
        t: Signal,
        altitude: Signal,
        acceleration: Signal | None = None,
        acceleration_sd: Signal | None = None,
        at_rest: NDArray[np.bool_] | None = None,
        up: Signal | None = None,
    ) -> Decisions:
        """Like `run`, but return what is decided at each row: rests, outliers, floors, jumps, the odds.

        Parameters
        ----------
        t, altitude, acceleration, acceleration_sd, at_rest, up
            As in `run`.

        Returns
        -------
        Decisions
            By row, (n,), and the log-likelihood of the altitudes.

        Examples
        --------
        One altitude of two hundred is wild:

        >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
        >>> altitude = noise.simulate(200, 1)
        >>> altitude[150] += 50.0
        >>> kf = ColouredKalman(noise=noise, dt=0.02)
        >>> np.flatnonzero(kf.decide(np.arange(200) / 50, altitude, np.zeros(200)).bits & REJECTED).tolist()
        [150]
        """
        rows = self._rows(steps_of(t), altitude, acceleration, acceleration_sd, at_rest, up)
        return self._weigh(rows)[1]

    def _filter(self, rows: Rows) -> HeightRun:
        found, decisions = self._weigh(rows)
        if self._decided is not None:
            self._decided(decisions)
        return found

    def _smooth(self, rows: Rows, lag: float) -> HeightRun:
        """Decide on the way forward, go back over what was decided, and stand where the way forward led."""
        x, P = self.x.T.copy(), self.P[None].copy()
        _, decisions = self._weigh(rows)
        at_rest, rejected = decisions.bits & AT_REST > 0, decisions.bits & REJECTED > 0
        on_floor = np.isfinite(decisions.floor)
        decided = rows._replace(
            z=np.where(rejected, np.nan, rows.z),
            at_rest=at_rest,
            startled=np.where(at_rest, decisions.startled, 0.0) + decisions.released,
            rest_variance=decisions.rest_variance,
            level=np.where(on_floor, decisions.floor, rows.level),
            level_variance=np.where(on_floor, self._bank.rules.floor_variance, rows.level_variance),
            jump=decisions.jump,
        )
        out = np.empty((4, len(rows.z)))
        smooth_rows(decided, lag, self._size, x, P, out)
        return HeightRun(*out)

    def _rows(self, steps: Signal, *samples: Any) -> Rows:
        rows = super()._rows(steps, *samples)
        rows = rows._replace(offset=self._offset)
        if self._given[2] is None:
            shaken = SHAKING_TIME**2 * rows.acceleration_variance
            rows = rows._replace(rest_variance=np.maximum(shaken, LEAST_REST_SD**2))
        if not self.confirm_rest:
            rows = rows._replace(at_rest=np.zeros(len(steps), np.bool_))
        if (up := samples[-1]) is not None:
            _turn(np.asarray(up, float), rows.at_rest, self._anchor, rows.turned)
            rows.turned[:] *= self.bias_sd**2
        if self.level_prior_sd is None:
            return rows
        with np.errstate(divide="ignore"):  # no time, no information
            variance = 2 * self.level_prior_sd**2 * self.level_prior_time / rows.dt
        return rows._replace(level=np.where(rows.dt > 0, 0.0, np.nan), level_variance=variance)

    def _row(
        self, dt: float, altitude: float, u: float, variance: float, at_rest: bool, up: Signal | None
    ) -> Row:
        level, level_variance, turned, rest_variance = math.nan, math.nan, 0.0, self.rest_sd**2
        at_rest = at_rest and self.confirm_rest
        if up is not None:
            turned = self.bias_sd**2 * _turn_once(up, at_rest, self._anchor)
        if self._given[2] is None:
            rest_variance = max(SHAKING_TIME**2 * variance, LEAST_REST_SD**2)
        if self.level_prior_sd is not None and dt > 0:
            level, level_variance = 0.0, 2 * self.level_prior_sd**2 * self.level_prior_time / dt
        # fmt: off
        return Row(altitude, dt, u, variance, at_rest, rest_variance, level, level_variance, turned,
                   self._offset)
        # fmt: on

    def _tables_at(self, dt: float) -> Tables:
        """Change what depends on the interval: with a jittering clock all differ."""
        if not self._kept:
            return super()._tables_at(dt)
        (tables,) = self._kept.values()
        F, B, Q = tables
        self._fill(F[0], B[0], Q[0], dt)
        Q[0, HEIGHT, HEIGHT] = unseen_variance(dt)
        return tables

    def _matrices(self, dt: Signal) -> Tables:
        """Return what the loops read, filled at once."""
        tables = self._filled(dt)
        tables.Q[:, HEIGHT, HEIGHT] = unseen_variance(dt)
        return tables

    def _take(
        self, tables: Tables, H: Signal, r: float, first: bool, row: Row, x: Signal, P: Signal
    ) -> HeightState:
        *found, evidence = self._bank.step(tables, H, r, first, row, x, P)
        self.evidence += evidence
        return HeightState(*found)

    def _weigh(self, rows: Rows) -> tuple[HeightRun, Decisions]:
        """Run the bank from the present state to the last row's."""
        n = len(rows.z)
        x, P, out = self.x[:, 0].copy(), self.P.copy(), np.empty((4, n))
        decisions = self._bank.run(rows, x, P, out)
        self._stand(x, P)
        self._started = self._started or n > 0
        self.evidence += decisions.log_likelihood
        return HeightRun(*out), decisions


@njit(cache=True)
def _turn(up: Signal, still: NDArray[np.bool_], anchor: Signal, turned: Signal) -> None:
    """Fill `turned`: what the turn away from the last rest adds to the bias's variance, in units of its own.

    Between verticals that enclose an angle the bias differs with a variance of 2 (1 - cos angle).  `anchor`
    is the vertical of the last rest and the greatest 1 - cos since.
    """
    for k in range(len(up)):
        turned[k] = _turn_once(up[k], still[k], anchor)


@njit(cache=True)
def _turn_once(up: Signal, still: bool, anchor: Signal) -> float:
    away = 1.0 - (anchor[0] * up[0] + anchor[1] * up[1] + anchor[2] * up[2])
    if still:
        for i in range(3):
            anchor[i] = up[i]
        anchor[3] = 0.0
        return 0.0
    turned = 2.0 * max(away - anchor[3], 0.0)
    anchor[3] = max(away, anchor[3])
    return float(turned)


def _fill_lagged(F: Signal, B: Signal, dt: float | Signal, lag: float) -> None:
    """Write how the low-passed height follows height, velocity and acceleration over dt.

    The solution of l' = (h + v t + a t²/2 - l)/lag at t = dt; the bias is an acceleration that isn't there.
    """
    risen = -np.expm1(-dt / lag)
    B[..., 3] = dt**2 / 2 - lag * dt + lag**2 * risen
    F[..., 3, 0], F[..., 3, 1], F[..., 3, 2] = risen, dt - lag * risen, -B[..., 3]
    F[..., 3, 3] = np.exp(-dt / lag)


def needs_noise(name: str) -> str:
    """Return the sentence for a filter that cannot do without a noise model."""
    return (
        f"{name!r} needs a noise model: identify one from a rest recording, or say it by hand, such as "
        "NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)"
    )
