"""Several noise models: is one worse than another, and what do many rests say together.

Estimates of positive parameters are nearly normal on the log scale, so ratios and means are taken there, with
the standard error that the 95 % interval implies.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np

from baroarma.finding import Finding
from baroarma.identification.homogeneity import anova
from baroarma.identification.intervals import Z95
from baroarma.noise_model import PARAMETERS, Interval, NoiseModel

if TYPE_CHECKING:
    from baroarma.identification.identification import Identification


@dataclass(frozen=True)
class Ratio:
    """Hold how many times larger a parameter is in one model than in another.

    Parameters
    ----------
    parameter : str
        Field of `NoiseModel`.
    ratio : float or None
        First over second; None when one of them, or both, lack the term.
    ci95 : tuple of float or None
        95 % interval of the ratio.
    p : float or None
        Two-sided p-value of equality.

    Examples
    --------
    Twice the white noise, each known to 2 %:

    >>> def sensor(sd):
    ...     none = {"correlated_sd": (0, 0), "correlation_time": (0, 0), "drift_rate": (0, 0)}
    ...     return NoiseModel(0, 0, sd, rate_hz=50, ci95={**none, "white_sd": (sd / 1.02, sd * 1.02)})
    >>> ratios = compare_models(sensor(0.46), sensor(0.23))
    >>> print(ratios[2])
    white sd: 2 times [1.94, 2.06], p = 0
    >>> print(ratios[0])
    correlated sd: one of the two models, or both, lack it
    """

    parameter: str
    ratio: float | None
    ci95: Interval | None
    p: float | None

    def __str__(self) -> str:
        name = self.parameter.replace("_", " ")
        if self.ratio is None or self.ci95 is None:
            return f"{name}: one of the two models, or both, lack it"
        return f"{name}: {self.ratio:.3g} times [{self.ci95[0]:.3g}, {self.ci95[1]:.3g}], p = {self.p:.2g}"


def compare_models(first: NoiseModel, second: NoiseModel) -> tuple[Ratio, ...]:
    """Say for each parameter how many times larger it is in `first`, with an interval.

    Parameters
    ----------
    first, second : NoiseModel
        Models with intervals; `second` is brought to the rate of `first`, white density kept.

    Raises
    ------
    ValueError
        If a model has no intervals.

    Examples
    --------
    >>> ci = {"correlated_sd": (0.25, 0.29), "correlation_time": (0.6, 0.9), "white_sd": (0.45, 0.47)}
    >>> a = NoiseModel(0.27, 0.75, 0.46, rate_hz=50, ci95={**ci, "drift_rate": (0, 0.01)})
    >>> print(compare_models(a, a)[0])
    correlated sd: 1 times [0.9, 1.11], p = 1
    """
    second = second.at_rate(first.rate_hz)
    return tuple(_ratio(name, first, second) for name in PARAMETERS)


def pool(models: Sequence[NoiseModel]) -> NoiseModel:
    """Combine models from several rests of one sensor into one.

    Each parameter is a random-effects mean on the log scale (DerSimonian-Laird): rests that differ by more
    than their intervals allow are weighted more alike and widen the interval, with Student's t for few of
    them.  A term that half of the models or more lack is 0, with the largest upper end; otherwise the
    models that lack it don't enter the mean.

    Parameters
    ----------
    models : sequence of NoiseModel
        At least one, all with intervals; they are brought to the rate of the first.

    Returns
    -------
    NoiseModel
        With method "pooled" and a finding that says where the rests disagree.

    Raises
    ------
    ValueError
        If there is no model, or one has no intervals.

    Examples
    --------
    >>> sure = {"correlated_sd": (0.26, 0.28), "correlation_time": (0.7, 0.8), "drift_rate": (0.0, 0.01)}
    >>> nights = [
    ...     NoiseModel(0.27, 0.75, sd, rate_hz=50, ci95={**sure, "white_sd": (sd - 0.01, sd + 0.01)})
    ...     for sd in (0.45, 0.47)
    ... ]
    >>> round(pool(nights).white_sd, 2)
    0.46
    """
    if not models:
        raise ValueError("there is no model to pool; give at least one")
    models = [model.at_rate(models[0].rate_hz) for model in models]
    values: dict[str, Any] = {}
    ci95: dict[str, Interval] = {}
    disagree = []
    for name in PARAMETERS:
        # both Gauss-Markov parameters come from the same models
        key = "correlated_sd" if name == "correlation_time" else name
        with_term = [m for m in models if getattr(m, key) > 0]
        if 2 * len(with_term) <= len(models):
            values[name], ci95[name] = 0.0, (0.0, max(_interval(m, name)[1] for m in models))
            continue
        mean, half, heterogeneous = _random_effects([_log_estimate(m, name) for m in with_term])
        values[name] = math.exp(mean)
        ci95[name] = (math.exp(mean - half), math.exp(mean + half))
        if heterogeneous:
            disagree.append(name.replace("_", " "))
    verdict: tuple[Finding, ...] = ()
    if disagree:
        message = (
            f"The {len(models)} rests disagree about {', '.join(disagree)} by more than their intervals."
        )
        verdict = (Finding("heterogeneous", "warning", message),)
    return NoiseModel(
        **values,
        rate_hz=models[0].rate_hz,
        ci95=ci95,
        method="pooled",
        sensor=models[0].sensor,
        verdict=verdict,
        source=_sources(models),
    )


def _sources(models: Sequence[NoiseModel]) -> dict[str, Any]:
    sources = [model.source or {} for model in models]
    return {
        "name": ", ".join(str(source.get("name", "?")) for source in sources),
        "sha256": None,
        "duration_s": sum(float(source.get("duration_s") or 0.0) for source in sources),
    }


def _ratio(name: str, first: NoiseModel, second: NoiseModel) -> Ratio:
    if not (getattr(first, name) > 0 and getattr(second, name) > 0):
        return Ratio(name, None, None, None)
    (a, sd_a), (b, sd_b) = _log_estimate(first, name), _log_estimate(second, name)
    sd = math.hypot(sd_a, sd_b)
    p = 2 * NormalDist().cdf(-abs(a - b) / sd) if sd > 0 else float(a == b)
    interval = (math.exp(a - b - Z95 * sd), math.exp(a - b + Z95 * sd))
    return Ratio(name, math.exp(a - b), interval, p)


def _interval(model: NoiseModel, name: str) -> Interval:
    if model.ci95 is None:
        raise ValueError(f"{model!r} has no intervals; only identified models can be compared or pooled")
    return model.ci95[name]


def _log_estimate(model: NoiseModel, name: str) -> tuple[float, float]:
    """Return the logarithm of a parameter and its standard error, from the side that the interval bounds."""
    low, high = _interval(model, name)
    value = float(getattr(model, name))
    sd = math.log(high / low) / (2 * Z95) if low > 0 else math.log(high / value) / Z95
    return math.log(value), sd


def _random_effects(estimates: list[tuple[float, float]]) -> tuple[float, float, bool]:
    """Return mean, half-width of its 95 % interval, and whether Cochran's Q exceeds its 95 % quantile."""
    from scipy.stats import chi2, t

    x = np.array([value for value, _ in estimates])
    variance = np.maximum([sd**2 for _, sd in estimates], 1e-12)
    w, freedom = 1 / variance, len(x) - 1
    q = float(w @ (x - w @ x / w.sum()) ** 2)
    between = max(0.0, (q - freedom) / (w.sum() - (w @ w) / w.sum())) if freedom else 0.0
    # a spread between the rests that few rests tell is uncertain itself, hence Student's t
    quantile = float(t.ppf(0.975, freedom)) if between else Z95
    w = 1 / (variance + between)
    half_width = quantile / math.sqrt(w.sum())
    return float(w @ x / w.sum()), half_width, bool(freedom and q > chi2.ppf(0.95, freedom))


def table(found: Sequence[Identification], pooled: NoiseModel | None = None) -> str:
    """Return a text table: a line per recording, the pooled model, how the others differ from the first.

    Parameters
    ----------
    found : sequence of Identification
        What `identify` returned for each recording.
    pooled : NoiseModel, optional
        Shown below them.
    """
    models = [(f.recording.name, f.model, f) for f in found]
    width = max(len(name) for name in ("recording", *(name for name, *_ in models)))
    lines = [f"{'recording':{width}}  {'white m':>9} {'GM m':>9} {'GM s':>9} {'drift':>9}  verdict"]
    for name, model, one in models:
        codes = dict.fromkeys(finding.code for finding in one.verdict)
        lines.append(f"{name:{width}}  {_cells(model)}  {', '.join(codes) or 'ok'}")
    if pooled is not None:
        lines.append(f"{'pooled':{width}}  {_cells(pooled)}")
        low, high = zip(*(pooled.ci95[name] for name in _COLUMNS), strict=True) if pooled.ci95 else ((), ())
        lines.append(f"{'  95 % from':{width}}  " + " ".join(f"{v:9.4g}" for v in low))
        lines.append(f"{'  to':{width}}  " + " ".join(f"{v:9.4g}" for v in high))
        lines += [f"  {finding}" for finding in pooled.verdict]
    first = models[0][1]
    for name, model, _ in models[1:]:
        if first is not None and model is not None:
            lines.append(f"{name} against {models[0][0]}:")
            lines += [f"  {ratio}" for ratio in compare_models(model, first) if ratio.ratio is not None]
    tables = [f.windows for f in found if f.windows is not None]
    if len(tables) == len(found):
        lines += [
            f"  {anova([w.fits.a for w in tables], 'a')}",
            f"  {anova([w.fits.b for w in tables], 'b')}",
        ]
    return "\n".join(lines)


_COLUMNS = ("white_sd", "correlated_sd", "correlation_time", "drift_rate")


def _cells(model: NoiseModel | None) -> str:
    if model is None:
        return " ".join(["-".rjust(9)] * 4)
    return " ".join(f"{getattr(model, name):9.4g}" for name in _COLUMNS)
