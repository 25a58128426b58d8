"""SG13, Tables 1 to 4 and Fig. 5: the noise of a barometer at rest, and what whitening leaves of it.

Each of two days has six tests of ten minutes.  A trial is a day; the SD in a row is the paper's, over the
windows of one test, averaged over trials.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from baroarma.arma import ArmaModel
from baroarma.estimators.conditioning import SG14_ARMA, conditioner_of
from baroarma.experiments.experiment import Experiment
from baroarma.experiments.methods import SENSORS, sensor_assumption
from baroarma.experiments.processing import relative_altitude
from baroarma.experiments.scene import Scene, cut
from baroarma.experiments.trials import Key, Measured, Measurement, Trial
from baroarma.identification.averaging import AveragingStudy, averaging_study
from baroarma.identification.homogeneity import anova
from baroarma.identification.preprocessing import Trimmed, WindowSettings
from baroarma.identification.surrogates import Surrogate, whitened_surrogate, zero_pole_cancellation
from baroarma.identification.windows import identify_windows
from baroarma.recording import Recording
from baroarma.simulation import simulate
from baroarma.whitening import WhiteningFilter

Signal = NDArray[np.float64]
TESTS: Final = ("indoors 1", "indoors 2", "indoors 3", "outdoors 1", "outdoors 2", "outdoors 3")
ALL: Final = "all six tests"
SETTINGS: Final = WindowSettings()
"""SG13's own: 1 min, M = 4, every 5th, 300 samples, 10 % [Sec. 2.5, printed]."""
PRINTED_ARMA: Final = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=1.0, dt=0.1)
"""The point estimates of Sec. 3.1, from which the paper says that it designed its filter."""
RATE_HZ: Final = 50.0


def whitening_of(model: ArmaModel) -> WhiteningFilter:
    """Return SG13's filter of a model: at 50 Hz, unity gain at 25 Hz [Sec. 3.1]."""
    return model.whitening_filter(rate_hz=RATE_HZ, unity_gain_hz=RATE_HZ / 2)


def rests(trial: Trial, day: int) -> Iterator[tuple[str, Recording]]:
    """Yield the six tests of a day by label."""
    for test in TESTS:
        rng = trial.rng(f"day {day}", test)
        yield test, simulate("rest", duration=600, device=SENSORS["SG13"], imu=None, seed=rng)


def measure_noise(trial: Trial, *, day: int) -> Measured:
    """Identify the six tests of a day as the paper does [Tables 1, 2]."""
    names = {"correlation_time": "s", "correlated_sd": "m", "white_sd": "m", "total_sd": "m"}
    found: dict[Key, Measurement] = {}
    groups: dict[str, list[Signal]] = {"a": [], "b": []}
    for test, rest in rests(trial, day):
        result = identify_windows(rest.t, rest.height(), SETTINGS, split="bilinear")
        for name, unit in names.items():
            found[test, f"{name.replace('_', ' ')} ({unit})"] = _trimmed(result.table[name])
        for name, values in groups.items():
            values.append(getattr(result.fits, name))
    for name, values in groups.items():
        pooled = np.concatenate(values)
        found[ALL, name] = Measurement(float(pooled.mean()), float(pooled.std(ddof=1)))
        found[ALL, f"ANOVA of {name} (p)"] = Measurement(anova(values, name).p)
    return found


def measure_surrogates(trial: Trial, *, day: int) -> Measured:
    """Whiten the six tests of a day and identify again [Tables 3, 4]."""
    filters = {"": whitening_of(SG14_ARMA), ", filter from the raw density": _matched_filter()}
    found: dict[Key, Measurement] = {}
    surrogates: dict[str, list[Surrogate]] = {name: [] for name in filters}
    for test, rest in rests(trial, day):
        for name, whitening in filters.items():
            surrogate = whitened_surrogate(rest.t, rest.height(), whitening, SETTINGS)
            surrogates[name].append(surrogate)
            if not name:
                found[test, "white sd (m)"] = _trimmed(surrogate.white_sd)
                found[test, "total sd (m)"] = _trimmed(surrogate.total_sd)
    for name, six in surrogates.items():
        p = zero_pole_cancellation(six).p
        found[ALL + name, "zero-pole cancellation (p)"] = Measurement(p)
    return found | _design() if day == 1 else found


def _matched_filter() -> WhiteningFilter:
    noise = SENSORS["SG13"].barometer.noise
    return noise.whitening_filter(rate_hz=RATE_HZ, unity_gain_hz=RATE_HZ / 2)


def _design() -> dict[Key, Measurement]:
    """Return what the recipe of Sec. 2.5 makes of the printed a and b, and the filter that we use."""
    found = {}
    for label, model in (("whitening filter", PRINTED_ARMA), ("whitening filter as used", SG14_ARMA)):
        w = whitening_of(model)
        assert w.pole_hz is not None
        assert w.zero_hz is not None
        found[label, "DC gain"] = Measurement(w.dc_gain)
        found[label, "pole (Hz)"] = Measurement(w.pole_hz)
        found[label, "zero below the pole (octaves)"] = Measurement(float(np.log2(w.pole_hz / w.zero_hz)))
    return found


def study(trial: Trial) -> AveragingStudy:
    """Average the first test of the first day over M = 1, 2, ... 256 samples [Fig. 5]."""
    _, rest = next(rests(trial, 1))
    return averaging_study(rest.t, rest.height(), settings=SETTINGS, split="bilinear")


def measure_averaging(trial: Trial) -> Measured:
    """Read from the study over M what the paper's text reads from Fig. 5."""
    rows = {row.average: row for row in study(trial).rows}
    raw_white = rows[4].white_sd.mean * np.sqrt(4)  # where the paper's own model fits
    alone = {m: raw_white / np.sqrt(m) for m in rows}
    unfit = [m for m, row in rows.items() if row.bartlett_failures > 0.5]
    eight = {"Bartlett rejects": rows[8].bartlett_failures, "Ljung-Box rejects": rows[8].ljung_box_failures}
    return {
        ("M = 256", "total sd (m)"): _trimmed(rows[256].total_sd),
        ("M = 32", "white sd alone (m)"): Measurement(alone[32]),
        ("all M", "smallest M with a total sd of 0.15"): _least(
            m for m in rows if rows[m].total_sd.mean < 0.155
        ),
        ("all M", "smallest M with a white sd of 0.1"): _least(m for m in rows if alone[m] < 0.1),
        ("all M", "smallest M that ARMA(1,1) does not fit"): _least(unfit),
        **{("M = 8", f"windows that {who} (%)"): Measurement(100 * share) for who, share in eight.items()},
        **{(f"M = {m}", "total sd, our study (m)"): _trimmed(row.total_sd) for m, row in rows.items()},
    }


def _least(averages: Iterable[int]) -> Measurement:
    return Measurement(float(min(averages, default=np.nan)))


def _trimmed(value: Trimmed) -> Measurement:
    return Measurement(value.mean, value.sd)


def draw_rest(trial: Trial) -> tuple[Scene, ...]:
    """Redraw Fig. 4, with the conditioned signals over the raw one."""
    _, rest = next(rests(trial, 1))
    raw = relative_altitude(rest)
    rows = cut(rest.t, 0, 120)
    lines = {
        label: conditioner_of(name, None, RATE_HZ).run(raw)[rows] for label, name in _CONDITIONED.items()
    }
    note = "Two of the ten minutes; raw altitude behind."
    title = "SG13 Fig. 4: pressure altitude at rest"
    return (Scene(title, note, "time (s)", "height (m)", rest.t[rows], lines, raw=raw[rows]),)


_CONDITIONED: Final = {"averaged": "average", "and whitened": "average+whitening"}


def draw_averaging(trial: Trial) -> tuple[Scene, ...]:
    """Redraw Fig. 5."""
    rows = study(trial).rows
    m = np.array([float(row.average) for row in rows])
    fits = np.array([row.bartlett_failures < 0.5 for row in rows])
    total, correlated, white = (
        np.array([getattr(row, name).mean for row in rows])
        for name in ("total_sd", "correlated_sd", "white_sd")
    )
    lines = {
        "total": total,
        "correlated": np.where(fits, correlated, np.nan),
        "white": np.where(fits, white, np.nan),
    }
    theory = white[2] * np.sqrt(4 / m)
    title, note = (
        "SG13 Fig. 5: averages of M samples",
        "Components only where Bartlett's test lets the model pass.",
    )
    law = "white, 1/√M"
    return (Scene(title, note, "M", "sd (m)", m, lines, theory, points=True, against=law),)


_SPREAD = (
    "± is the SD over the 20 windows of one test, trimmed as the paper's, averaged over trials; p-values are "
    "medians over trials"
)
_DAY = "one sensor preset stands for all six tests: day, weather and room do not differ here"


def experiments() -> tuple[Experiment, ...]:
    """Return Tables 1 to 4 and Fig. 5."""
    device = sensor_assumption("SG13")
    noise = (device, _DAY, _SPREAD, "the bilinear split, which is the paper's")
    white = (device, _DAY, _SPREAD, "the filter used has a = -0.87 and b = -0.50, DC gain 0.21")
    five = (device, "one test of ten minutes; 'does not fit' is: Bartlett's test rejects most windows")
    titles = {1: "first day", 2: "second day"}
    return (
        *(
            Experiment(f"sg13-table-{day}", f"noise at rest, {titles[day]}", noise,
                       partial(measure_noise, day=day), draw=draw_rest if day == 1 else None, tracks=False)
            for day in (1, 2)
        ),
        *(
            Experiment(f"sg13-table-{day + 2}", f"whitened noise, {titles[day]}", white,
                       partial(measure_surrogates, day=day), tracks=False)
            for day in (1, 2)
        ),
        Experiment("sg13-figure-5", "averages of M samples", five, measure_averaging, draw=draw_averaging,
                   tracks=False),
    )  # fmt: skip
