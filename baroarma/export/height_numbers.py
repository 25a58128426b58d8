"""The constants that the height filters' C reads, taken from the estimator objects."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.chain import MOST_REPEATS
from baroarma.estimators import stillness
from baroarma.estimators.height import bank
from baroarma.estimators.height.coloured_kalman import LEFT_BIAS_SD, SHAKING_TIME
from baroarma.estimators.height.complementary import LONGEST_WEIGHT
from baroarma.estimators.height.drive import BACK, WILD
from baroarma.estimators.height.kernels import JUMP_TIME
from baroarma.export.c_text import Number, Numbers


def _drive(height: Any) -> Numbers:
    drive = height.drive
    return (
        Number(
            "MIDPOINT", bool(drive.midpoint), "1: integrate the mean of two accelerations; 0: the earlier"
        ),
        Number("WILD", WILD, "a sample that jumps by more and comes back is taken out, m/s²"),
        Number("BACK", BACK, "share of the jump within which it is back"),
        Number("ZUPT_STEPS", int(drive.zupt_steps), "quiet steps until there is rest; 0: never"),
        Number("ZUPT_THRESHOLD", float(drive.zupt_threshold), "largest acceleration at rest, m/s²"),
        Number("REST_SD", float(height.rest_sd), "of the velocity at rest, m/s"),
        Number("ACCELERATION_SD", float(height.acceleration_sd), "of one sample, m/s²"),
    )


def complementary(height: Any) -> Numbers:
    """Return what `complementary.c` reads."""
    # the very numbers that its own loop takes
    correlated, rate, white, drift = height._noise_parameters()
    initial = np.diag(height._initial_covariance())
    return (
        *_drive(height),
        Number("GAIN", height.gain.tolist(), "K, 1/s and 1/s²"),
        Number("LONGEST_WEIGHT", LONGEST_WEIGHT * height.time_constant, "most that a sample counts for, s"),
        Number("INITIAL_VARIANCE", initial.tolist(), "diagonal of P at the start"),
        Number("STATIONARY_VARIANCE", float(correlated), "of the Gauss-Markov noise, m²"),
        Number("DECAY_RATE", float(rate), "one over its correlation time, 1/s"),
        Number("WHITE_VARIANCE", float(white), "of one altitude, m²"),
        Number("WALK_VARIANCE", float(drift), "by which the drift grows in a second, m²/s"),
    )


def kalman(height: Any) -> Numbers:
    """Return what `linear.c` and `kalman.c` read."""
    return (
        *_drive(height),
        Number("STATES", len(height.states), ", ".join(height.states).replace("_", " ")),
        Number(
            "INITIAL_VARIANCE", np.diag(height.initial_covariance()).tolist(), "diagonal of P at the start"
        ),
        Number("UNRESOLVED", float(height.unresolved), "share of a change that an average may miss"),
        Number("MEASUREMENT", np.ravel(height.H).tolist(), "how the states add up to an altitude"),
        Number("R", float(np.squeeze(height.R)), "variance of an altitude's white noise, m²"),
    )


def coloured_kalman(height: Any) -> Numbers:
    """Return what `coloured_kalman.c`, `bank.c` and `stillness.c` read."""
    noise, names = height.noise, height.states
    walks = {"acceleration_bias": height.bias_walk**2, "offset": noise.drift_rate**2}
    variance = {"correlated": noise.correlated_sd**2}
    rate = {"correlated": 1 / noise.correlation_time} if noise.has_gauss_markov else {}
    accel_sd, bias_sd, rest_sd = height.given()
    level = 0.0
    if height.level_prior_sd is not None:
        level = 2 * height.level_prior_sd**2 * height.level_prior_time
    lagging = names.index("low_passed") if height.barometer_lag else 0
    return (
        *kalman(height),
        Number("SD_FROM_REST", accel_sd is None, "1: the rest tells the acceleration's sd"),
        Number("BIAS_FROM_REST", bias_sd is None, "1: its gravity tells the bias's sd"),
        Number("BIAS_SD", height.bias_sd, "of the accelerometer, as far as turning reveals it, m/s²"),
        Number("STANDARD_GRAVITY", STANDARD_GRAVITY, "m/s²"),
        Number("LEFT_BIAS_SD", LEFT_BIAS_SD, "what an alignment leaves of the bias, m/s²"),
        Number(
            "REST_TIME",
            SHAKING_TIME if rest_sd is None else 0.0,
            "what shakes with 1 m/s² moves with so many m/s",
        ),
        Number("DECAY_RATE", [rate.get(name, 0.0) for name in names], "1/s"),
        Number("WALK_VARIANCE", [walks.get(name, 0.0) for name in names], "growth in a second"),
        Number("STATIONARY_VARIANCE", [variance.get(name, 0.0) for name in names], "of what decays"),
        Number("LOW_PASSED", lagging, "the state that is the low-passed height; 0: there is none"),
        Number("OFFSET", names.index("offset") if "offset" in names else 0, "the state that is the offset"),
        Number("LAG", float(height.barometer_lag), "time constant of the barometer, s"),
        Number("LEVEL_PRIOR", level, "2 sd² time of the height about the start, m² s; 0: nothing is known"),
        Number("EARLY_ALTITUDES", math.ceil(1.1 / height.dt) + 1, "kept of the alignment's second"),
        Number("CONFIRM_REST", bool(height.confirm_rest), "1: rests are believed if they prove true"),
        *_bank(height.rules()),
        *_stillness(),
    )


def _bank(rules: bank.Rules) -> Numbers:
    floors = rules.floors.tolist()
    return (
        Number("GATE", rules.gate, "sds from which an altitude is an outlier"),
        Number("RECOVERY", rules.recovery, "after so long outliers are believed, s"),
        Number("PROOF", bank.PROOF, "if there are so many"),
        Number("TOGETHER", bank.TOGETHER, "over so long innovations are summed, s"),
        Number("PRESSURE_STEP", rules.pressure_step, "largest that is the barometer's if it stays, m"),
        Number("JUMP_TIME", JUMP_TIME, "a height that jumps by 1 m may move by 1 m in so long, s"),
        Number("JUMP_ODDS", bank.JUMP_ODDS, "log-odds that a hypothesis loses by needing a jump"),
        Number("PRIOR_ODDS", rules.prior_odds, "log-odds of rest"),
        Number("LONGEST_ODDS", rules.longest_odds, "their limit"),
        Number("MOST_REPEATS", MOST_REPEATS, "of the same altitude, from which it is no news"),
        Number("MOST_NEWS", bank.MOST_NEWS, "that one altitude may change them by"),
        Number("SURE", bank.SURE, "log-odds from which something is believed at once"),
        Number("CRUISE_SD", rules.cruise_sd, "of the speeds at which things move without being felt, m/s"),
        Number("EXACT", bank.EXACT, "least variance of a velocity, (m/s)²"),
        Number("MEMORY", rules.memory, "within so long a start is noticed, s"),
        Number("ONSET", rules.onset, "sds of velocity that are a start"),
        Number("SWAY", rules.sway, "velocity of what shakes but stays, until it is known better, m/s"),
        Number("SWAY_TIME", bank.SWAY_TIME, "over so long it is learnt, s"),
        Number("FLOORS", len(floors), "known floors"),
        Number("FLOOR", floors or [0.0], "their heights, in order, m"),
        Number("FLOOR_VARIANCE", rules.floor_variance, "m²"),
    )


def _stillness() -> Numbers:
    s = stillness
    return (
        Number("SETTLED", s.SETTLED, "without a disturbance for so long the IMU is still, s"),
        Number("ALIGNED", s.ALIGNED, "so long it has been when it is aligned, s"),
        Number("LONGEST_MEAN", s.LONGEST_MEAN, "length of the reference's mean, s"),
        Number("SHORT_MEAN", s.SHORT_MEAN, "time constant of the short means, s"),
        Number("LONGEST_SILENCE", s.LONGEST_SILENCE, "without a sample for so long nothing is known, s"),
        Number("KNOCK", s.KNOCK, "sds of one sample that are no noise"),
        Number("SHIFT", s.SHIFT, "sds of a short mean that are no noise"),
        Number("LEAST_KNOCK", s.LEAST_KNOCK, "m/s² and rad/s"),
        Number("LEAST_SHIFT", s.LEAST_SHIFT, "likewise"),
        Number("GRAVITY_ERROR", s.GRAVITY_ERROR, "by which the reference may differ from gravity, m/s²"),
        Number("USUAL_NOISE", s.DEFAULT_SD, "sds of a sample where no rest tells them, m/s² and rad/s"),
        Number("LARGEST_NOISE", s.LARGEST_SD, "beyond which the rest was none"),
        Number("SHAKING_TIME", s.SHAKING_TIME, "over so long shaking is measured, s"),
        Number("SHAKEN", s.SHAKEN, "times the noise from which something shakes"),
    )
