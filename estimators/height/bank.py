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
`longest_odds`, for a model is never quite right and evidence must be able to turn.

A rest ends when the IMU says so, or when the velocity of the older `recent` does: a soft start is seen there.
Then this filter goes on, which rested until shortly before the start and has integrated it since; if the odds
were negative, `free` does.

A hand that rests still sways.  How fast it does is learnt from the older `recent`, too, and v = 0 holds within
that much.

An altitude that differs from the prediction by more than `gate` standard deviations is not taken, nor are
altitudes that differ less but all one way, so that their sum over about half a second does: a door slams, a
pressure steps.  If none was taken for `recovery` s, and three in a row, the height has really jumped: its
variance grows by the square of the difference, and the filter follows.

A known floor is taken as the height, once in a rest, when no other is as likely.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from baroarma.estimators.height.kernels import Rows, absorb, advance, innovate, report, settle, update

Signal = NDArray[np.float64]

RESTED: Final = 0
FREE: Final = 1
FILTERS: Final = 4
FLAGS: Final = 11
"""Length of `Filters.memory`; its entries:"""
_FORKED, _ODDS, _AGE, _SINCE, _OLDER, _ON_FLOOR, _FORK_ROW, _SILENCE = 0, 1, 2, 3, 4, 5, 6, 7
_RENEWED: Final = 6  # ... 8 and 9: the rows at which filters 2 and 3 last began anew
_SWAY: Final = 10  # variance of the velocity of what rests
AT_REST: Final = 1
REJECTED: Final = 2
"""Bits of a decision: v = 0 was taken; the altitude was not."""
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
    """Of each filter: seconds since altitudes are rejected, how many, the jump to allow, and the recent sum of
    innovations in standard deviations, (4, 4)."""
    memory: Signal
    """Flags and timers, (8,)."""


class Decisions(NamedTuple):
    """What was decided at each row; what the smoother needs."""

    bits: NDArray[np.uint8]
    """`AT_REST`, `REJECTED`, (n,)."""
    floor: Signal
    """Height of the floor that was recognised, m; NaN: none, (n,)."""
    jump: Signal
    """How far the height may have jumped since the row before, m, (n,)."""
    odds: Signal
    """Log-odds of rest; NaN: no fork, (n,)."""
    innovation: Signal
    """What the altitude differed from the prediction, in standard deviations; NaN: no altitude, (n,)."""
    innovation_sd: Signal
    """This standard deviation, m, (n,)."""

    @property
    def log_likelihood(self) -> float:
        """Log-likelihood of all altitudes that were taken."""
        taken = np.isfinite(self.innovation) & (self.bits & REJECTED == 0)
        y, s = self.innovation[taken], self.innovation_sd[taken]
        return float(-0.5 * np.sum(y**2 + np.log(2 * np.pi * s**2)))


class Bank:
    """Weigh rest against motion, from row to row.

    Parameters
    ----------
    rules : Rules
        When to believe what.
    states : int
        How many states each filter has.
    """

    def __init__(self, rules: Rules, states: int) -> None:
        self.rules = rules
        self._filters = Filters(
            np.zeros((FILTERS, states)),
            np.zeros((FILTERS, states, states)),
            np.zeros((FILTERS, 4)),
            np.zeros(FLAGS),
        )
        self._filters.memory[_SWAY] = rules.sway**2

    def run(self, rows: Rows, x: Signal, P: Signal, out: Signal) -> Decisions:
        """Take rows from the state x (m,), P (m, m) on, both changed in place; out as in `filter_rows`."""
        n, bank = len(rows.z), self._filters
        now = speaker(bank.memory)
        bank.x[now], bank.P[now] = x, P
        decisions = Decisions(np.zeros(n, np.uint8), *(np.full(n, np.nan) for _ in range(5)))
        run_bank(rows, self.rules, bank, decisions, out)
        now = speaker(bank.memory)
        x[:], P[:] = bank.x[now], bank.P[now]
        return decisions


@njit(cache=True)
def run_bank(rows: Rows, rules: Rules, bank: Filters, decisions: Decisions, out: Signal) -> None:
    """Take all rows; `rows.at_rest` is what the IMU says, not yet what is believed."""
    n, m = len(rows.z), bank.x.shape[1]
    gain, work = np.empty(m), np.empty((m + 1, m))
    flags = bank.memory
    for k in range(n):
        decisions.jump[k] = bank.doubt[speaker(flags), 2]
        for i in range(_active(flags)):
            advance(k, rows, bank.doubt[i, 2], bank.x[i], bank.P[i], work)
            bank.doubt[i, 2] = 0.0
        if flags[_FORKED] and not rows.at_rest[k]:
            _join(k, rows, bank, decisions)
        if rows.at_rest[k]:
            if flags[_FORKED] and _starts(rules, bank):
                _join(k, rows, bank, decisions)
            if not flags[_FORKED]:
                _fork(k, rows, rules, bank)
        if flags[_FORKED]:
            r = rows.rest_variance[k] + flags[_SWAY]
            update(bank.x[RESTED], bank.P[RESTED], rows.rest, r, 0.0, gain, work)
            _watch_sway(rows.dt[k], bank)
            _renew(k, rows.dt[k], rules, bank)
        for i in range(_active(flags)):
            settle(k, rows, bank.x[i], bank.P[i], gain, work)
        _take_altitude(k, rows, rules, bank, decisions, gain, work)
        if flags[_FORKED]:
            decisions.odds[k] = flags[_ODDS]
        if flags[_FORKED] and len(rules.floors):
            decisions.floor[k] = _recognise_floor(rules, bank, gain, work)
        chosen = speaker(flags)
        report(k, bank.x[chosen], bank.P[chosen], out)
        if flags[_FORKED] and chosen == RESTED:  # a start may have gone unnoticed for so long
            out[3, k] = math.sqrt(bank.P[int(flags[_OLDER]), 1, 1])
    if flags[_FORKED]:
        if flags[_ODDS] >= 0.0:
            _mark(flags, decisions)
        flags[_FORK_ROW] -= n
        flags[_RENEWED + 2] -= n
        flags[_RENEWED + 3] -= n


@njit(cache=True)
def _active(flags: Signal) -> int:
    return FILTERS if flags[_FORKED] else 1


@njit(cache=True)
def speaker(flags: Signal) -> int:
    """Return which filter speaks for the bank, given its memory."""
    return FREE if flags[_FORKED] and flags[_ODDS] < 0.0 else RESTED


@njit(cache=True)
def _copy(bank: Filters, source: int, target: int) -> None:
    bank.x[target] = bank.x[source]
    bank.P[target] = bank.P[source]
    bank.doubt[target] = bank.doubt[source]


@njit(cache=True)
def _fork(k: int, rows: Rows, rules: Rules, bank: Filters) -> None:
    """Begin to consider a rest, from the free filter, which stands in slot 0."""
    for i in range(1, FILTERS):
        _copy(bank, 0, i)
    v, variance = bank.x[0, 1], bank.P[0, 1, 1]
    still, riding = max(variance + rows.rest_variance[k], EXACT), variance + rules.cruise_sd**2
    odds = rules.prior_odds + 0.5 * (math.log(riding / still) + v * v * (1.0 / riding - 1.0 / still))
    flags = bank.memory
    flags[_FORKED], flags[_OLDER], flags[_FORK_ROW] = 1.0, 2.0, k
    flags[_ODDS] = min(max(odds, -rules.longest_odds), rules.longest_odds)
    flags[_AGE] = flags[_SINCE] = flags[_ON_FLOOR] = 0.0


@njit(cache=True)
def _renew(k: int, dt: float, rules: Rules, bank: Filters) -> None:
    """Let the older of the recent filters begin anew from the rested one, every `memory` s."""
    flags = bank.memory
    older = int(flags[_OLDER])
    if flags[_AGE] == 0.0:
        _copy(bank, RESTED, 5 - older)
        _copy(bank, RESTED, older)
        flags[_RENEWED + 2] = flags[_RENEWED + 3] = k
    flags[_AGE] += dt
    flags[_SINCE] += dt
    if flags[_SINCE] >= rules.memory:
        _copy(bank, RESTED, older)
        flags[_RENEWED + older] = k
        flags[_OLDER], flags[_SINCE] = 5 - older, 0.0


@njit(cache=True)
def _watch_sway(dt: float, bank: Filters) -> None:
    """Learn how fast what rests still moves: what the older recent filter sees beyond its own variance."""
    flags = bank.memory
    older = int(flags[_OLDER])
    if flags[_AGE] > 0.0 and flags[_ODDS] > 0.0:
        usual = bank.P[older, 1, 1] + flags[_SWAY]
        excess = min(bank.x[older, 1] ** 2, 4.0 * usual) - bank.P[older, 1, 1]  # a start is no sway
        flags[_SWAY] = max(flags[_SWAY] + min(dt / SWAY_TIME, 1.0) * (excess - flags[_SWAY]), 0.0)


@njit(cache=True)
def _starts(rules: Rules, bank: Filters) -> bool:
    """Return whether the velocity that has come up since shortly before is none of a rest."""
    flags = bank.memory
    older = int(flags[_OLDER])
    v, variance = bank.x[older, 1], bank.P[older, 1, 1] + max(flags[_SWAY], rules.sway**2)
    return flags[_ODDS] >= 0.0 and v * v > rules.onset**2 * variance


@njit(cache=True)
def _join(k: int, rows: Rows, bank: Filters, decisions: Decisions) -> None:
    """Go on with one filter: the IMU feels something."""
    flags = bank.memory
    if flags[_ODDS] >= 0.0:
        _copy(bank, int(flags[_OLDER]), 0)
        _mark(flags, decisions)
    else:
        _copy(bank, FREE, 0)
    flags[_FORKED] = 0.0


@njit(cache=True)
def _mark(flags: Signal, decisions: Decisions) -> None:
    """Mark the rows of the rest, as far as the filter that goes on has taken it."""
    stop = int(flags[_RENEWED + int(flags[_OLDER])])
    for k in range(max(int(flags[_FORK_ROW]), 0), stop + 1):
        decisions.bits[k] |= AT_REST


@njit(cache=True)
def _take_altitude(
    k: int, rows: Rows, rules: Rules, bank: Filters, decisions: Decisions, gain: Signal, work: Signal
) -> None:
    """Update all filters with the altitude of row k, or say that it is an outlier."""
    flags = bank.memory
    decisions.bits[k] = 0
    active = _active(flags)
    for i in range(active):
        bank.doubt[i, 0] += rows.dt[k] if bank.doubt[i, 1] > 0.0 else 0.0
    flags[_SILENCE] += rows.dt[k]
    if math.isnan(rows.z[k]):
        return
    share = math.exp(-flags[_SILENCE] / TOGETHER)
    flags[_SILENCE] = 0.0
    where = rows.measurement[k]
    h, r = rows.H[where], rows.R[where]
    chosen = speaker(flags)
    news = 0.0
    for i in range(active):
        x, P, doubt = bank.x[i], bank.P[i], bank.doubt[i]
        y, s = innovate(x, P, h, r, rows.z[k], gain)
        if s <= 0.0:  # a second sample at the same instant
            continue
        off = y / math.sqrt(s)
        doubt[3] = share * doubt[3] + math.sqrt(1.0 - share * share) * min(max(off, -rules.gate), rules.gate)
        taken = abs(off) <= rules.gate and abs(doubt[3]) <= rules.gate
        sign = 1.0 if i == RESTED else -1.0
        if i < 2 and active > 1:
            news -= sign * 0.5 * (off * off + math.log(s))
        if i == chosen:
            decisions.innovation[k], decisions.innovation_sd[k] = off, math.sqrt(s)
            decisions.bits[k] |= 0 if taken else REJECTED
        if taken:
            absorb(x, P, h, r, y, s, gain, work)
            doubt[:2] = 0.0
            continue
        doubt[1] += 1.0
        if doubt[1] >= 3.0 and doubt[0] >= rules.recovery:
            doubt[0], doubt[1], doubt[2], doubt[3] = 0.0, 0.0, abs(y), 0.0
            if i < 2 and active > 1:
                flags[_ODDS] -= sign * JUMP_ODDS
    odds = flags[_ODDS] + min(max(news, -MOST_NEWS), MOST_NEWS)
    flags[_ODDS] = min(max(odds, -rules.longest_odds), rules.longest_odds)


@njit(cache=True)
def _recognise_floor(rules: Rules, bank: Filters, gain: Signal, work: Signal) -> float:
    """Take the floor that the rested filter stands on, once a rest, if it is sure; return it or NaN."""
    flags = bank.memory
    if flags[_ON_FLOOR] or flags[_ODDS] < SURE or flags[_AGE] < rules.memory:
        return math.nan
    h, variance = bank.x[RESTED, 0], bank.P[RESTED, 0, 0] + rules.floor_variance
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
    work[2, :] = 0.0
    work[2, 0] = 1.0
    update(bank.x[RESTED], bank.P[RESTED], work[2], rules.floor_variance, floor, gain, work)
    return float(floor)
