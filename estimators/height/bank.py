"""A bank of filters that weighs 'at rest' against 'moving', so that a rest can be believed and undone.

A sensor that feels nothing may rest or ride at a constant speed.  When the IMU falls still the filter forks:

    rested   takes v = 0 at every row,
    free     never does,
    recent   two copies of `rested` that have taken no v = 0 for one to two times `memory` s.

The log-odds of `rested` against `free` begin with what the velocity says by itself,

    odds = log prior + log N(v; 0, P_vv + r) - log N(v; 0, P_vv + cruise^2),

with v and P_vv of the free filter: a lift's start was felt by the IMU, and is in v.  From then on every
altitude adds the difference of the two log-likelihoods.  The state is `rested`'s while the odds are positive,
else `free`'s: a rest that turns out wrong is undone by looking at the other filter.  The odds are held within
`longest_odds`, for a model is never quite right and evidence must be able to turn.  But what has been refuted
at 100 to 1 is believed again only at 1 to 100: otherwise a gust would now and then stop a lift for a moment.

While the rest is refuted, it is considered anew every `recovery` s, from `free`, for a soft stop is not felt.
It is believed at once if the velocity almost surely is that of a rest; else the altitudes have to show it.

The velocity's sd is that of both possibilities: p being the probability of the one that does not speak,
(1 - p) var + p (var' + difference²).  The height's is the speaker's.

A rest ends when the IMU says so, or, where a rest is sure, when the velocity of the older `recent` does: a
soft start is seen there.  Then this filter goes on, which rested until shortly before the start and has
integrated it since; if the odds were negative, `free` does.  Its velocity's variance grows by p difference²,
so that the barometer puts right soon what was wrong.

A hand that rests still sways.  How fast it does is learnt from the older `recent`, too, and v = 0 holds
within that much.

An altitude that differs from the prediction by more than `gate` standard deviations is not taken, nor are
altitudes that differ less but all one way, so that their sum over about half a second does: a door slams, a
pressure steps.  If none was taken for `recovery` s, and three in a row, something has really jumped.  A step
of a few metres that the IMU did not feel, and that has stayed as it was, is the pressure's: a cabin's door, a
fan; the barometer's offset takes it.  Anything else is the height's, whatever the IMU says: its variance
grows by the square of the difference, and the filter follows.

A known floor is taken as the height, once in a rest, when no other is as likely.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.compiled import njit
from baroarma.estimators.base import ROUNDING
from baroarma.estimators.height.kernels import (
    HEIGHT,
    VELOCITY,
    Row,
    Rows,
    Tables,
    absorb,
    innovate,
    loosen,
    one_row,
    pin,
    predict,
    predict_motion,
    report,
)

Signal = NDArray[np.float64]

PROOF: Final = 3
"""Rejected altitudes in a row from which a jump may be believed (chosen by us)."""
SINCE, COUNT, JUMP, SUM, FIRST, LATE = 0, 1, 2, 3, 4, 5
"""Columns of `Filters.doubt`."""
RESTED: Final = 0
FREE: Final = 1
FILTERS: Final = 4
FLAGS: Final = 12
"""Length of `Filters.memory`; its entries:"""
_FORKED, _ODDS, _AGE, _SINCE, _OLDER, _ON_FLOOR, _FORK_ROW, _SILENCE = 0, 1, 2, 3, 4, 5, 6, 7
_RENEWED: Final = 6  # ... 8 and 9: the rows at which filters 2 and 3 last began anew
_SWAY: Final = 10  # variance of the velocity of what rests
_REFUTED: Final = 11  # the odds were below -SURE, and have not been above SURE since
AT_REST: Final = 1
REJECTED: Final = 2
BELIEVED: Final = 4
"""Bits of a decision: v = 0 was taken, as is known by the end; the altitude was not taken; the state was that
of a rest, as was known at the row."""
TOGETHER: Final = 0.5
"""Seconds over which innovations are summed (chosen by us)."""
EXACT: Final = 1e-30
"""Variance of a velocity that is known exactly, (m/s)²."""
SWAY_TIME: Final = 5.0
"""Time constant of the mean square of a resting hand's velocity, s (chosen by us)."""
MOST_NEWS: Final = 2.0
"""No single altitude may change the log-odds by more (chosen by us): one outlier proves nothing."""
JUMP_ODDS: Final = 10.0
"""What it costs a hypothesis, in log-odds, to need a jump (chosen by us)."""
SURE: Final = 4.6
"""Log-odds of 100 to 1 (chosen by us), from which a floor is believed."""


class Rules(NamedTuple):
    """When to believe what."""

    gate: float
    """Standard deviations from which an altitude is an outlier; infinity: none is."""
    recovery: float
    """Seconds of outliers after which they are believed."""
    prior_odds: float
    """Log-odds of rest against constant speed, before anything else is known."""
    cruise_sd: float
    """Spread of the speeds at which things move without being felt, m/s."""
    longest_odds: float
    """Limit of the log-odds."""
    memory: float
    """How long the IMU may take to notice a start, s."""
    sway: float
    """Velocity of what shakes but stays, m/s, until it is known better."""
    onset: float
    """Standard deviations of velocity that are a start."""
    pressure_step: float
    """Largest step, m, that is the barometer's and not the height's; 0: none is."""
    floors: Signal
    """Heights of known floors, m, in order; may be empty."""
    floor_variance: float
    """How exactly, m²."""


class Filters(NamedTuple):
    """The filters, and what is remembered from row to row."""

    x: Signal
    """States, (4, m): the first is the filter while there is no fork."""
    P: Signal
    """Covariances, (4, m, m)."""
    doubt: Signal
    """Of each filter, (4, 6): seconds since altitudes are rejected, how many, the jump to allow (m; negative:
    of the offset), the recent sum of innovations in standard deviations, the mean of those rejected in the
    first half of `recovery` and of late (m)."""
    memory: Signal
    """Flags and timers, (12,)."""


class Decisions(NamedTuple):
    """What was decided at each row; what the smoother needs."""

    bits: NDArray[np.uint8]
    """`AT_REST`, `REJECTED`, `BELIEVED`, (n,)."""
    floor: Signal
    """Height of the floor that was recognised, m; NaN: none, (n,)."""
    jump: Signal
    """How far the height may have jumped since the row before, m; negative: the offset, (n,)."""
    odds: Signal
    """Log-odds of rest; NaN: no fork, (n,)."""
    innovation: Signal
    """What the altitude differed from the prediction, in standard deviations; NaN: no altitude, (n,)."""
    innovation_sd: Signal
    """This standard deviation, m, (n,)."""
    rest_variance: Signal
    """Variance with which v = 0 was taken; NaN: it was not, (n,)."""
    startled: Signal
    """Variance of the velocity that was wrong if this is where a rest begins, (m/s)², (n,)."""
    released: Signal
    """Variance that the velocity gained where a rest was over, (m/s)², (n,)."""

    @property
    def believed(self) -> NDArray[np.bool_]:
        """Whether each row's state is that of a rest, (n,): more than odds above 0 after a refutation."""
        return self.bits & BELIEVED > 0

    @property
    def log_likelihood(self) -> float:
        """Log-likelihood of all altitudes that were taken."""
        return float(_log_likelihood(self.bits, self.innovation, self.innovation_sd))


class Bank:
    """Weigh rest against motion, from row to row.

    Parameters
    ----------
    rules : Rules
        When to believe what.
    states : int
        How many states each filter has.
    lagged : bool
        Whether one of them is a low-passed height.
    """

    def __init__(self, rules: Rules, states: int, *, lagged: bool = False) -> None:
        self.rules, self._size, self._lagged = rules, (0,) * states, lagged or None
        self._filters = Filters(
            np.zeros((FILTERS, states)),
            np.zeros((FILTERS, states, states)),
            np.zeros((FILTERS, 6)),
            np.zeros(FLAGS),
        )
        self._filters.memory[_SWAY] = rules.sway**2

    def run(self, rows: Rows, x: Signal, P: Signal, out: Signal) -> Decisions:
        """Take rows from the state x (m,), P (m, m) on, both changed in place; out as in `filter_rows`."""
        n, bank = len(rows.z), self._filters
        now = speaker(bank.memory)
        bank.x[now], bank.P[now] = x, P
        decisions = Decisions(np.zeros(n, np.uint8), *(np.full(n, np.nan) for _ in range(8)))
        run_bank(rows, self.rules, bank, self._size, self._lagged, decisions, out)
        now = speaker(bank.memory)
        x[:], P[:] = bank.x[now], bank.P[now]
        return decisions

    def step(
        self, tables: Tables, H: Signal, r: float, first: bool, row: Row, x: Signal, P: Signal
    ) -> tuple[float, float, float, float, float]:
        """Take one row; return height, velocity, their sds, and the altitude's log-likelihood if taken."""
        given: tuple[Any, ...] = (
            *tables,
            H,
            r,
            first,
            *row,
            *self.rules,
            *self._filters,
            self._size,
            self._lagged,
            x,
            P,
        )
        found: tuple[float, float, float, float, float] = weigh_row(*given)
        return found


@njit(cache=True, error_model="numpy")
def run_bank(
    rows: Rows,
    rules: Rules,
    bank: Filters,
    size: tuple[int, ...],
    lagged: bool | None,
    decisions: Decisions,
    out: Signal,
) -> None:
    """Take all rows; `rows.at_rest` is what the IMU says, not yet what is believed.

    `size` is as in `filter_rows`.  `lagged` None: there is no low-passed height among the states; the
    compiler leaves out what would be needed for it.
    """
    x, P, doubt, flags = bank
    m = len(size)
    assert x.shape[1] == m and P.shape[1] == m and P.shape[2] == m  # noqa: PT018 - compiled
    gain, work = np.empty(m), np.empty((m + 1, m))
    F, B, Q, ends, columns, transition, H, R, measurement, z = rows[:10]
    dt, u, variance, at_rest, rest_variance, level, level_variance, _, turned, _, _ = rows[10:]
    bits, floor, jump, odds, innovation, innovation_sd, rested, startled, released = decisions
    n = len(z)
    for k in range(n):
        jump[k], bits[k], startled[k], released[k] = doubt[speaker(flags), JUMP], 0, 0.0, 0.0
        for i in range(_active(flags)):
            if transition[k] >= 0:
                if lagged is None:
                    predict_motion(i, x, P, F, B, Q, transition[k], u[k], variance[k], work, size)
                else:
                    predict(i, x, P, F, B, Q, transition[k], ends, columns, u[k], variance[k], work, size)
            loosen(i, P, turned[k], doubt[i, JUMP], 0.0, rows.offset)
            doubt[i, JUMP] = 0.0
            doubt[i, SINCE] += dt[k] if doubt[i, COUNT] > 0.0 else 0.0
        flags[_SILENCE] += dt[k]
        if flags[_FORKED] and (not at_rest[k] or _starts(rules.sway, rules.onset, x, P, flags)):
            released[k] = _join(x, P, doubt, flags, bits)
        if flags[_FORKED] and flags[_ODDS] < -SURE and flags[_AGE] >= rules.recovery - ROUNDING:
            startled[k] = _fork(k, rest_variance[k], rules, FREE, x, P, doubt, flags)
        if at_rest[k] and not flags[_FORKED]:
            startled[k] = _fork(k, rest_variance[k], rules, RESTED, x, P, doubt, flags)
        if flags[_FORKED]:
            rested[k] = rest_variance[k] + flags[_SWAY]
            pin(RESTED, x, P, VELOCITY, 0.0, rested[k], gain, work, size)
            _watch_sway(dt[k], x, P, flags)
            _renew(k, dt[k], rules.memory, x, P, doubt, flags)
        if not math.isnan(level[k]):
            for i in range(_active(flags)):
                pin(i, x, P, HEIGHT, level[k], level_variance[k], gain, work, size)
        if not math.isnan(z[k]):
            j, chosen, active = measurement[k], speaker(flags), _active(flags)
            share, news, believed = math.exp(-flags[_SILENCE] / TOGETHER), 0.0, False
            fresh, flags[_SILENCE] = math.sqrt(1.0 - share * share), 0.0
            for i in range(active):
                y, s = innovate(i, x, P, H, j, R[j], z[k], gain, size)
                if s <= 0.0:  # a second sample at the same instant
                    continue
                sd = math.sqrt(s)
                off = y / sd
                capped = min(max(off, -rules.gate), rules.gate)
                doubt[i, SUM] = share * doubt[i, SUM] + fresh * capped
                taken = capped == off and abs(doubt[i, SUM]) <= rules.gate
                if taken:
                    doubt[i, COUNT] = doubt[i, SINCE] = 0.0
                    absorb(i, x, P, H, j, R[j], y, s, gain, work, size)
                else:
                    _doubt(i, y, sd, share, rules, doubt)
                if i == chosen:
                    innovation[k], innovation_sd[k] = off, sd
                    bits[k] = 0 if taken else REJECTED
                if i < 2 and active > 1:
                    sign = 1.0 if i == RESTED else -1.0
                    news -= sign * (0.5 * capped * capped + math.log(sd))
                    believed = believed or taken
                    flags[_ODDS] -= sign * JUMP_ODDS if doubt[i, JUMP] != 0.0 else 0.0
            if active > 1:
                _hear(news if believed else 0.0, rules.longest_odds, flags)
        if flags[_FORKED]:
            odds[k] = flags[_ODDS]
            if len(rules.floors):
                floor[k] = _recognise_floor(rules, x, P, flags, gain, work, size)
        report(k, speaker(flags), x, P, out)
        if flags[_FORKED]:
            if speaker(flags) == RESTED:
                bits[k] |= BELIEVED
            out[3, k] = _sd_of_both(x, P, flags)
    if flags[_FORKED]:
        if speaker(flags) == RESTED:
            _mark(flags, bits)
        flags[_FORK_ROW] -= n
        flags[_RENEWED + 2] -= n
        flags[_RENEWED + 3] -= n


@njit(cache=True, error_model="numpy")
def weigh_row(
    F: Signal,
    B: Signal,
    Q: Signal,
    H: Signal,
    r: float,
    first: bool,
    z: float,
    dt: float,
    u: float,
    variance: float,
    at_rest: bool,
    rest_variance: float,
    level: float,
    level_variance: float,
    turned: float,
    offset: int,
    gate: float,
    recovery: float,
    prior_odds: float,
    cruise_sd: float,
    longest_odds: float,
    memory: float,
    sway: float,
    onset: float,
    pressure_step: float,
    floors: Signal,
    floor_variance: float,
    states: Signal,
    covariances: Signal,
    doubt: Signal,
    flags: Signal,
    size: tuple[int, ...],
    lagged: bool | None,
    x: Signal,
    P: Signal,
) -> tuple[float, float, float, float, float]:
    """Do what `Bank.step` says; all comes one by one, since Python passes named tuples slowly."""
    row = Row(z, dt, u, variance, at_rest, rest_variance, level, level_variance, turned, offset)
    # fmt: off
    rules = Rules(gate, recovery, prior_odds, cruise_sd, longest_odds, memory, sway, onset, pressure_step,
                  floors, floor_variance)
    # fmt: on
    bank = Filters(states, covariances, doubt, flags)
    bits, cells, out = np.zeros(1, np.uint8), np.full((8, 1), np.nan), np.empty((4, 1))
    decisions = Decisions(
        bits, cells[0], cells[1], cells[2], cells[3], cells[4], cells[5], cells[6], cells[7]
    )
    now = speaker(bank.memory)
    bank.x[now], bank.P[now] = x, P
    run_bank(one_row(Tables(F, B, Q), H, r, first, row), rules, bank, size, lagged, decisions, out)
    now = speaker(bank.memory)
    x[:], P[:] = bank.x[now], bank.P[now]
    evidence = _log_likelihood(bits, cells[3], cells[4])
    return out[0, 0], out[1, 0], out[2, 0], out[3, 0], evidence


@njit(cache=True, error_model="numpy")
def _log_likelihood(bits: NDArray[np.uint8], innovation: Signal, innovation_sd: Signal) -> float:
    total = 0.0
    for k in range(len(bits)):
        if not (math.isnan(innovation[k]) or bits[k] & REJECTED):
            total -= 0.5 * (innovation[k] ** 2 + math.log(2.0 * math.pi * innovation_sd[k] ** 2))
    return total


@njit(cache=True, error_model="numpy", inline="always")
def _active(flags: Signal) -> int:
    return FILTERS if flags[_FORKED] else 1


@njit(cache=True, error_model="numpy", inline="always")
def speaker(flags: Signal) -> int:
    """Return which filter speaks for the bank, given its memory."""
    return FREE if flags[_FORKED] and (flags[_ODDS] < 0.0 or flags[_REFUTED]) else RESTED


@njit(cache=True, error_model="numpy")
def _copy(source: int, target: int, x: Signal, P: Signal, doubt: Signal) -> None:
    x[target] = x[source]
    P[target] = P[source]
    doubt[target] = doubt[source]


@njit(cache=True, error_model="numpy")
def _fork(
    k: int,
    rest_variance: float,
    rules: Rules,
    source: int,
    x: Signal,
    P: Signal,
    doubt: Signal,
    flags: Signal,
) -> float:
    """Begin to consider a rest, from the filter `source`; again, if that is the free one of a fork.

    A velocity that no rest explains is an error of its own, and tells nothing about height and bias: return
    the variance that it adds.
    """
    _copy(source, 0, x, P, doubt)
    for i in range(1, FILTERS):
        _copy(0, i, x, P, doubt)
    v, variance = x[0, VELOCITY], P[0, VELOCITY, VELOCITY]
    still, riding = max(variance + rest_variance, EXACT), variance + rules.cruise_sd**2
    odds = rules.prior_odds + 0.5 * (math.log(riding / still) + v * v * (1.0 / riding - 1.0 / still))
    if source == FREE and odds < SURE:
        odds = min(odds, -SURE)
    startled = max(v * v - 4.0 * still, 0.0)
    P[RESTED, VELOCITY, VELOCITY] += startled
    flags[_FORKED], flags[_OLDER], flags[_FORK_ROW] = 1.0, 2.0, k
    flags[_ODDS] = min(max(odds, -rules.longest_odds), rules.longest_odds)
    flags[_REFUTED] = 1.0 if odds <= -SURE else 0.0
    flags[_AGE] = flags[_SINCE] = flags[_ON_FLOOR] = 0.0
    return float(startled)


@njit(cache=True, error_model="numpy", inline="always")
def _renew(k: int, dt: float, memory: float, x: Signal, P: Signal, doubt: Signal, flags: Signal) -> None:
    """Let the older of the recent filters begin anew from the rested one, every `memory` s."""
    if flags[_AGE] == 0.0:
        _copy(RESTED, 2, x, P, doubt)
        _copy(RESTED, 3, x, P, doubt)
        flags[_RENEWED + 2] = flags[_RENEWED + 3] = k
    flags[_AGE] += dt
    flags[_SINCE] += dt
    if flags[_SINCE] >= memory - ROUNDING:
        older = int(flags[_OLDER])
        _copy(RESTED, older, x, P, doubt)
        flags[_RENEWED + older] = k
        flags[_OLDER], flags[_SINCE] = 5 - older, 0.0


@njit(cache=True, error_model="numpy", inline="always")
def _watch_sway(dt: float, x: Signal, P: Signal, flags: Signal) -> None:
    """Learn how fast what rests still moves: what the older recent filter sees beyond its own variance."""
    if flags[_AGE] > 0.0 and speaker(flags) == RESTED:
        older = int(flags[_OLDER])
        own = P[older, VELOCITY, VELOCITY]
        excess = min(x[older, VELOCITY] ** 2, 4.0 * (own + flags[_SWAY])) - own  # a start is no sway
        flags[_SWAY] = max(flags[_SWAY] + min(dt / SWAY_TIME, 1.0) * (excess - flags[_SWAY]), 0.0)


@njit(cache=True, error_model="numpy", inline="always")
def _starts(sway: float, onset: float, x: Signal, P: Signal, flags: Signal) -> bool:
    """Return whether what surely rested has shortly come to a velocity that is none of a rest."""
    older = int(flags[_OLDER])
    variance = P[older, VELOCITY, VELOCITY] + max(flags[_SWAY], sway**2)
    return bool(flags[_ODDS] > SURE and x[older, VELOCITY] ** 2 > onset**2 * variance)


@njit(cache=True, error_model="numpy", inline="always")
def _chance(flags: Signal) -> float:
    """Return how probable it is that the filter that doesn't speak is right."""
    return 1.0 / (1.0 + math.exp(abs(flags[_ODDS] - (SURE if flags[_REFUTED] else 0.0))))


@njit(cache=True, error_model="numpy", inline="always")
def _sd_of_both(x: Signal, P: Signal, flags: Signal) -> float:
    """Return the rms error of the speaker's velocity: it may be right, or the other one.

    Of a rest's the older recent filter's variance is meant: a start may have gone unnoticed for so long.
    """
    one, other, own = FREE, RESTED, FREE
    if speaker(flags) == RESTED:
        one, other, own = RESTED, FREE, int(flags[_OLDER])
    p, off = _chance(flags), x[other, VELOCITY] - x[one, VELOCITY]
    variance = (1.0 - p) * P[own, VELOCITY, VELOCITY] + p * (P[other, VELOCITY, VELOCITY] + off * off)
    return math.sqrt(max(variance, 0.0))


@njit(cache=True, error_model="numpy")
def _join(x: Signal, P: Signal, doubt: Signal, flags: Signal, bits: NDArray[np.uint8]) -> float:
    """Go on with one filter: the rest is over.

    The velocity may have been the other one's; return the variance that this adds.
    """
    rested = int(flags[_OLDER])
    one, other = (rested, FREE) if speaker(flags) == RESTED else (FREE, rested)
    if one == rested:
        _mark(flags, bits)
    _copy(one, 0, x, P, doubt)
    released = _chance(flags) * (x[other, VELOCITY] - x[one, VELOCITY]) ** 2
    P[0, VELOCITY, VELOCITY] += released
    flags[_FORKED] = 0.0
    return float(released)


@njit(cache=True, error_model="numpy")
def _mark(flags: Signal, bits: NDArray[np.uint8]) -> None:
    """Mark the rows of the rest, as far as the filter that goes on has taken it."""
    stop = int(flags[_RENEWED + int(flags[_OLDER])])
    for k in range(max(int(flags[_FORK_ROW]), 0), stop + 1):
        bits[k] |= AT_REST


@njit(cache=True, error_model="numpy")
def _doubt(i: int, y: float, sd: float, share: float, rules: Rules, doubt: Signal) -> None:
    """Keep the doubts of filter i, which did not take an altitude that is off by y m."""
    if doubt[i, COUNT] == 0.0:
        doubt[i, FIRST] = doubt[i, LATE] = y
    doubt[i, COUNT] += 1.0
    doubt[i, LATE] += (1.0 - share) * (y - doubt[i, LATE])
    if doubt[i, SINCE] <= 0.5 * rules.recovery:
        doubt[i, FIRST] += (y - doubt[i, FIRST]) / doubt[i, COUNT]
    if doubt[i, COUNT] >= PROOF and doubt[i, SINCE] >= rules.recovery - ROUNDING:
        stays = abs(doubt[i, LATE] - doubt[i, FIRST]) < 0.3 * abs(doubt[i, LATE]) + 0.25 * sd
        doubt[i, JUMP] = -abs(y) if stays and abs(y) <= rules.pressure_step else abs(y)
        doubt[i, SINCE] = doubt[i, COUNT] = doubt[i, SUM] = 0.0


@njit(cache=True, error_model="numpy", inline="always")
def _hear(news: float, longest: float, flags: Signal) -> None:
    """Change the log-odds, no further than one altitude may, nor beyond where they can turn."""
    odds = flags[_ODDS] + min(max(news, -MOST_NEWS), MOST_NEWS)
    flags[_ODDS] = min(max(odds, -longest), longest)
    if abs(odds) > SURE:
        flags[_REFUTED] = 1.0 if odds < 0.0 else 0.0


@njit(cache=True, error_model="numpy")
def _recognise_floor(
    rules: Rules, x: Signal, P: Signal, flags: Signal, gain: Signal, work: Signal, size: tuple[int, ...]
) -> float:
    """Take the floor that the rested filter stands on, once a rest, if it is sure; return it or NaN."""
    if flags[_ON_FLOOR] or flags[_ODDS] < SURE or flags[_AGE] < rules.memory - ROUNDING:
        return math.nan
    h, variance = x[RESTED, HEIGHT], P[RESTED, HEIGHT, HEIGHT] + rules.floor_variance
    best, second, floor = math.inf, math.inf, math.nan
    for candidate in rules.floors:
        distance = (h - candidate) ** 2 / variance
        if distance < best:
            best, second, floor = distance, best, candidate
        elif distance < second:
            second = distance
    if best > 9.0 or second - best < 2.0 * SURE:
        return math.nan
    flags[_ON_FLOOR] = 1.0
    pin(RESTED, x, P, HEIGHT, floor, rules.floor_variance, gain, work, size)
    return float(floor)
