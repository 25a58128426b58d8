"""From a rest recording to a noise model: `identify` and what it returns."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from textwrap import indent
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from baroarma.arma import Split
from baroarma.finding import Finding
from baroarma.identification.averaging import AveragingStudy, averaging_study
from baroarma.identification.homogeneity import stationarity
from baroarma.identification.intervals import intervals
from baroarma.identification.orders import OrderTable, order_table
from baroarma.identification.preprocessing import Conditioned, WindowSettings, condition, detrend, new_samples
from baroarma.identification.problem import Problem, Signal, Term
from baroarma.identification.stillness import judge_disturbance
from baroarma.identification.structural import (
    StructuralFit,
    fit_second_gauss_markov,
    fit_terms,
    select_terms,
)
from baroarma.identification.surrogates import whitened_surrogate, zero_pole_cancellation
from baroarma.identification.verdict import judge_model, judge_recording, minutes_wanting
from baroarma.identification.whiteness import Outcome, cumulative_periodogram_test, ljung_box
from baroarma.identification.windows import WindowsResult, identify_windows
from baroarma.noise_model import JSON_KEYS, TERM_NAMES, NoiseModel
from baroarma.recording import Recording

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from baroarma.identification.allan import AllanDeviation

logger = logging.getLogger(__name__)
Method = Literal["structural", "windows"]


@dataclass(frozen=True, eq=False, repr=False)
class Identification:
    """Hold what a rest recording says about its barometer's noise.

    Parameters
    ----------
    recording : Recording
        What was identified.
    model : NoiseModel or None
        The noise model with 95 % intervals; None when the recording can't support one.
    verdict : tuple of Finding
        What to know about the recording and the model.
    method : {"structural", "windows"}
        How the model was found.
    fits : tuple of StructuralFit
        Combinations of terms that were compared, the best first (structural).
    windows : WindowsResult or None
        The per-window ARMA(1,1) table (windows).
    residuals : ndarray, shape (n - 1,)
        Standardised one-step prediction errors of the model on the raw samples.
    temperature : float or None
        Air temperature in °C that heights were corrected with.

    Examples
    --------
    >>> from baroarma.simulation import simulate, simulate_rest
    >>> found = identify(simulate_rest(duration=300, seed=1))
    >>> low, high = found.model.ci95["white_sd"]
    >>> low < 0.46 < high, found.fits[0].terms
    (True, ('white', 'gm'))
    >>> found.residuals.shape, round(float(found.residuals.std()), 2)  # white, of sd 1
    ((14999,), 1.0)

    A log that can't support a model says why:

    >>> moved = identify(simulate("stairs", duration=60, seed=1))
    >>> moved.ok, moved.verdict[0].code
    (False, 'moving')
    """

    recording: Recording
    model: NoiseModel | None
    verdict: tuple[Finding, ...]
    method: Method
    fits: tuple[StructuralFit, ...] = ()
    windows: WindowsResult | None = None
    residuals: Signal | None = None
    temperature: float | None = None

    def __repr__(self) -> str:
        codes = ", ".join(finding.code for finding in self.verdict) or "nothing to object"
        return f"<Identification of {self.recording.name!r}: {self.model or 'no model'}; {codes}>"

    @property
    def ok(self) -> bool:
        """Whether there is a model."""
        return self.model is not None

    @property
    def minutes_wanting(self) -> float | None:
        """How many more minutes would bring the correlation time's half-width to 10 %; None without one."""
        return None if self.model is None else minutes_wanting(self.model, self.recording.duration)

    def samples(self) -> tuple[Signal, Signal]:
        """Return times (s) and heights (m) of the barometer's new samples.

        Returns
        -------
        t, height : ndarray, shape (m,)
            Rows without a sample are left out.

        Examples
        --------
        >>> rest = Recording(t=[0.0, 0.1, 0.2], pressure=[101325.0, float("nan"), 101325.0])
        >>> t, height = Identification(rest, None, (), "structural").samples()
        >>> t.tolist(), height.tolist()
        ([0.0, 0.2], [0.0, 0.0])
        """
        return new_samples(self.recording.t, self.recording.height(self.temperature))

    def orders(self, max_p: int = 3, max_q: int = 3) -> OrderTable:
        """Compare ARMA orders by FPE, AIC and BIC on one conditioned window [SG13, Sec. 2.5].

        Parameters
        ----------
        max_p, max_q : int
            Largest orders; (max_p + 1)(max_q + 1) fits of some tenths of a second.
        """
        conditioned = self._conditioned()
        return order_table(conditioned.windows[len(conditioned.windows) // 2], conditioned.dt, max_p, max_q)

    def stationarity(self) -> Outcome:
        """Test whether the conditioned signal keeps its spectrum from window to window."""
        conditioned = self._conditioned()
        return stationarity(conditioned.windows, conditioned.dt)

    def cancellation(self) -> Outcome:
        """Test whether zero and pole cancel behind this model's whitening filter [SG13, Sec. 2.5].

        Raises
        ------
        ValueError
            Without a Gauss-Markov component, or where no window is left.
        """
        if self.model is None or not self.model.has_gauss_markov:
            raise ValueError(f"{self.recording.name} has no Gauss-Markov noise to whiten")
        settings = WindowSettings.for_rate(self.recording.rate_hz)
        surrogate = whitened_surrogate(*self.samples(), self.model.whitening_filter(), settings)
        return zero_pole_cancellation([surrogate])

    def averaging_study(self) -> AveragingStudy:
        """Repeat the windows recipe over lengths of the moving average [SG13, Fig. 5]."""
        return averaging_study(*self.samples())

    def allan(self) -> AllanDeviation:
        """Return the Allan deviation of the height with its confidence band.

        Examples
        --------
        The model's own formula runs through the data's band:

        >>> from baroarma.simulation import simulate_rest
        >>> found = identify(simulate_rest(duration=300, seed=1))
        >>> data = found.allan()
        >>> theory = found.model.allan_deviation(data.tau)
        >>> bool(((data.low < theory) & (theory < data.high))[2:].all())  # from some intervals on
        True
        """
        from baroarma.identification.allan import allan_deviation

        return allan_deviation(*self.samples())

    def diagnostics(self) -> str:
        """Return second opinions that take seconds, as text.

        Stationarity over windows, ARMA orders, zero-pole cancellation behind the whitening filter, and the
        study over lengths of the moving average; where one can't be had, the reason.
        """
        opinions: dict[str, Callable[[], str]] = {
            "stationarity": lambda: str(self.stationarity()),
            "zero and pole behind the whitening filter": lambda: str(self.cancellation()),
            "ARMA orders of one window": lambda: self.orders().summary(),
            "length of the moving average": lambda: self.averaging_study().summary(),
        }
        parts: list[str] = []
        for title, compute in opinions.items():
            try:
                parts.append(f"{title}\n{indent(compute(), '  ')}")
            except ValueError as error:
                parts.append(f"{title}\n  not available: {error}")
        return "\n".join(parts)

    def summary(self) -> str:
        """Return the result as text: model, comparison of terms, verdict, advice."""
        lines = [f"{self.recording.name}: {len(self.recording)} rows over {self.recording.duration:.6g} s"]
        if self.model is not None:
            lines.append(replace(self.model, verdict=()).summary())
            p = self.model.whiteness_p or {}
            lines.append(
                "  whiteness of prediction errors: " + ", ".join(f"{k} p = {v:.2g}" for k, v in p.items())
            )
            if self.minutes_wanting:
                advice = "more minutes would determine the correlation time to ±10 %"
                lines.append(f"  {self.minutes_wanting:.0f} {advice}")
        if self.fits:
            least = self.fits[0].bic
            lines.append("  terms compared: BIC above the best")
            lines += [
                f"    {' + '.join(TERM_NAMES[t] for t in f.terms):40}{f.bic - least:10.1f}" for f in self.fits
            ]
        if self.windows is not None:
            lines.append(self.windows.summary())
        lines += [f"  {finding}" for finding in self.verdict]
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON object of `baroarma identify --json`: the model's keys and what else was found.

        Without a model the model's keys are null and the verdict says why.
        """
        body: dict[str, Any] = dict.fromkeys((*JSON_KEYS, "rate_hz", "ci95", "sensor", "whiteness_p"))
        body["source"] = _source(self.recording)
        if self.model is not None:
            body = self.model.to_dict()
        return {
            **body,
            "recording": self.recording.name,
            "method": self.method,
            "verdict": [finding.to_dict() for finding in self.verdict],
            "minutes_wanting": self.minutes_wanting,
            "terms": [{"terms": list(f.terms), "bic": f.bic} for f in self.fits],
            "windows": self.windows and self.windows.to_dict(),
        }

    def _repr_html_(self) -> str:
        from baroarma.notebook import styled
        from baroarma.report import identification_table

        return styled(identification_table(self))

    def plot(self) -> Figure:
        """Draw record, autocorrelation, spectrum and Allan deviation; see `baroarma.plotting`."""
        from baroarma.plotting import plot_identification

        return plot_identification(self)

    def _conditioned(self) -> Conditioned:
        found = condition(*self.samples(), WindowSettings.for_rate(self.recording.rate_hz))
        if not len(found.windows):
            raise ValueError(
                f"{self.recording.name} has no stretch long enough for a window between its gaps"
            )
        return found


def identify(
    rest: Recording,
    *,
    method: Method = "structural",
    terms: Literal["auto"] | tuple[Term, ...] = "auto",
    split: Split = "exact",
    settings: WindowSettings | None = None,
    temperature: float | None = None,
) -> Identification:
    """Learn the noise of a motionless barometer.

    Parameters
    ----------
    rest : Recording
        A recording at rest; ten minutes to an hour is a good length.
    method : {"structural", "windows"}
        ``structural``: maximum likelihood of white + Gauss-Markov + drift on the raw samples; ``windows``:
        the recipe of SG13 Sec. 2.5, one ARMA(1,1) per 30 s window of the averaged and decimated signal.
    terms : "auto" or tuple of {"white", "gm", "drift"}
        Terms of the structural model; "auto" lets BIC decide, and reports 0 for a term that the data don't
        need.
    split : {"exact", "bilinear"}
        How the windows method splits an ARMA(1,1) into its components; see `baroarma.arma`.
    settings : WindowSettings, optional
        Settings of the windows method; default: SG13's, adapted to the recording's rate.
    temperature : float, optional
        Air temperature in °C, to stretch the ISA's metres to this air's.

    Returns
    -------
    Identification
        With `model` None, and the verdict saying why, when the recording can't support a model.

    Raises
    ------
    ValueError
        For an unknown method, term or split.
    TypeError
        If `rest` is no Recording.

    Examples
    --------
    >>> from baroarma.simulation import simulate_rest
    >>> found = identify(simulate_rest(duration=300, seed=1))
    >>> found.model
    <NoiseModel at 50 Hz: white 0.4602 m, Gauss-Markov 0.2717 m / 0.8065 s, no drift>
    """
    if not isinstance(rest, Recording):
        raise TypeError(f"identify takes a Recording, not {rest!r:.60}; baroarma.read makes one from a file")
    if method not in ("structural", "windows"):
        raise ValueError(f"method {method!r} is unknown; choose 'structural' or 'windows'")
    if terms != "auto" and (not terms or not set(terms) <= {"white", "gm", "drift"}):
        raise ValueError(f"terms {terms!r} are unknown; choose 'auto' or some of 'white', 'gm', 'drift'")
    if split not in ("exact", "bilinear"):
        raise ValueError(f"split {split!r} is unknown; choose 'exact' or 'bilinear'")
    verdict = judge_recording(rest)
    logger.info(
        "judged %s: %s", rest.name, ", ".join(finding.code for finding in verdict) or "fit for a model"
    )
    if any(finding.severity == "error" for finding in verdict):
        return Identification(rest, None, verdict, method, temperature=temperature)
    if method == "windows":
        return _by_windows(rest, verdict, split, settings, temperature)
    return _structurally(rest, verdict, terms, temperature)


def _structurally(
    rest: Recording,
    verdict: tuple[Finding, ...],
    terms: Literal["auto"] | tuple[Term, ...],
    temperature: float | None,
) -> Identification:
    problem = Problem(*new_samples(rest.t, rest.height(temperature)))
    if terms == "auto":
        fit, fits = select_terms(problem)
    else:
        fit = fit_terms(problem, tuple(t for t in ("white", "drift", "gm") if t in terms))
        fits = [fit]
        if "gm" in terms:
            fits.append(fit_second_gauss_markov(problem, fit))
    logger.info("chose %s of %s", "+".join(fit.terms), ", ".join("+".join(other.terms) for other in fits))
    residuals = problem.innovations(fit.theta)
    white_sd, drift_rate, correlated_sd, correlation_time = [*map(float, fit.theta), 0.0, 0.0][:4]
    model = NoiseModel(
        correlated_sd,
        correlation_time,
        white_sd,
        drift_rate,
        rate_hz=rest.rate_hz,
        ci95=intervals(problem, fit),
        method="structural",
        whiteness_p=whiteness(residuals),
        source=_source(rest),
    )
    gain = max((fit.bic - other.bic for other in fits if "gm2" in other.terms), default=0.0)
    gm_tried = terms == "auto" or "gm" in terms
    verdict += judge_model(model, duration=rest.duration, second_gm_gain=gain, gm_tried=gm_tried)
    verdict = _each_once(verdict, judge_disturbance(problem.t[1:], residuals))
    model = replace(model, verdict=verdict)
    return Identification(
        rest, model, verdict, "structural", tuple(fits), residuals=residuals, temperature=temperature
    )


def _by_windows(
    rest: Recording,
    verdict: tuple[Finding, ...],
    split: Split,
    settings: WindowSettings | None,
    temperature: float | None,
) -> Identification:
    t, height = new_samples(rest.t, rest.height(temperature))
    settings = settings or WindowSettings.for_rate(rest.rate_hz)
    try:
        windows = identify_windows(t, height, settings, split=split)
        model = windows.to_noise_model()
        if not (model.white_sd or model.has_gauss_markov):
            raise ValueError(f"detrending over {settings.detrend_s:g} s leaves nothing; log faster than that")
    except ValueError as error:
        failed = Finding("too-short", "error", f"The windows method found no model: {error}.")
        return Identification(rest, None, (*verdict, failed), "windows", temperature=temperature)
    theta = [model.white_sd, 0.0]
    if model.has_gauss_markov:
        theta += [model.correlated_sd, model.correlation_time]
    residuals = Problem(t, detrend(t, height, settings.detrend_s)).innovations(np.array(theta))
    model = replace(model, whiteness_p=whiteness(residuals), source=_source(rest))
    judged = judge_model(model, duration=rest.duration)
    verdict = _each_once(verdict, windows.findings, judged, judge_disturbance(t[1:], residuals))
    model = replace(model, verdict=verdict)
    return Identification(rest, model, verdict, "windows", (), windows, residuals, temperature)


def _each_once(verdict: tuple[Finding, ...], *more: Iterable[Finding]) -> tuple[Finding, ...]:
    """Add findings, each code once, from whoever came first and knows most about it."""
    for findings in more:
        codes = {finding.code for finding in verdict}
        verdict += tuple(finding for finding in findings if finding.code not in codes)
    return verdict


def whiteness(residuals: Signal) -> dict[str, float]:
    """Return p-values of three tests of whiteness of standardised prediction errors.

    ``ljung_box_10`` and ``ljung_box_40`` over so many lags, and ``bartlett`` of the cumulative periodogram.
    No degrees of freedom are taken off: next to thousands of samples, four parameters weigh nothing.
    """
    return {
        "ljung_box_10": ljung_box(residuals, 10).p,
        "ljung_box_40": ljung_box(residuals, 40).p,
        "bartlett": cumulative_periodogram_test(residuals).p,
    }


def _source(rest: Recording) -> dict[str, Any]:
    source = rest.source or {"name": rest.name, "sha256": None}
    return {**source, "duration_s": rest.duration}
