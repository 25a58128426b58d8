"""Whitened surrogates: does a whitening filter leave white noise?  SG13, Sec. 2.5 and Tables 3-4.

The detrended raw samples pass the whitening filter, then the same averaging, decimation, windows and
ARMA(1,1) fits as in the identification.  If the filter removed the correlation, pole and zero cancel:
a_e and b_e are equal on average (paired t-test, p > 0.1), there is no Gauss-Markov component left, and
sigma_u = H_o.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baroarma.identification.arma_fit import fit_windows
from baroarma.identification.preprocessing import Trimmed, WindowSettings, condition, trimmed_mean
from baroarma.identification.whiteness import Outcome
from baroarma.whitening import WhiteningFilter


@dataclass(frozen=True, eq=False)
class Surrogate:
    """Hold the ARMA(1,1) fits of one whitened recording.

    Parameters
    ----------
    a, b : ndarray, shape (m,)
        Coefficients per window.
    white_sd : Trimmed
        sigma_u = H_o over windows, m.
    total_sd : Trimmed
        sigma_s over windows, m.
    """

    a: NDArray[np.float64]
    b: NDArray[np.float64]
    white_sd: Trimmed
    total_sd: Trimmed


def whitened_surrogate(
    t: ArrayLike, height: ArrayLike, whitening: WhiteningFilter, settings: WindowSettings | None = None
) -> Surrogate:
    """Whiten the detrended raw samples of a recording at rest and fit an ARMA(1,1) to every window.

    Parameters
    ----------
    t, height : array_like, shape (n,)
        Times in s and heights in m of new samples; rows whose height is NaN are left out.
    whitening : WhiteningFilter
        A filter for the rate of the recording.
    settings : WindowSettings, optional
        As for `identify_windows`.

    Raises
    ------
    ValueError
        If the filter was made for another rate, or there is no gap-free window.

    Examples
    --------
    >>> from baroarma.noise_model import NoiseModel
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> w = noise.whitening_filter(unity_gain_hz=25)
    >>> surrogate = whitened_surrogate(np.arange(30000) / 50, noise.simulate(30000, 1), w)
    >>> zero_pole_cancellation([surrogate]).p > 0.1
    True
    """
    cut = condition(t, height, settings, whitening=whitening)
    if abs(whitening.rate_hz / cut.rate_hz - 1) > 0.05:
        raise ValueError(
            f"the whitening filter is for {whitening.rate_hz:g} Hz, but the recording has "
            f"{cut.rate_hz:.4g} Hz; make it for that rate"
        )
    if not len(cut.windows):
        raise ValueError("the recording has no gap-free window; record longer or choose a shorter window")
    fits = fit_windows(cut.windows, cut.dt)
    trim = (settings or WindowSettings()).trim
    return Surrogate(
        fits.a, fits.b, trimmed_mean(fits.innovation_sd, trim), trimmed_mean(fits.total_sd, trim)
    )


def zero_pole_cancellation(surrogates: Sequence[Surrogate]) -> Outcome:
    """Test by a paired t-test over all windows whether a_e and b_e are equal on average.

    Parameters
    ----------
    surrogates : sequence of Surrogate
        Recordings that were whitened by one filter: one, or the six 10-min tests of SG13's day.  More
        windows see smaller rests of correlation.

    Returns
    -------
    Outcome
        Student's t and p; SG13 accepts cancellation at p > 0.1.
    """
    from scipy.special import stdtr

    difference = np.concatenate([s.a - s.b for s in surrogates])
    difference = difference[np.isfinite(difference)]
    n = len(difference)
    if n < 2 or not np.ptp(difference) > 0:
        raise ValueError(f"{n} windows are too few for a t-test; at least 2 that differ are needed")
    t = float(difference.mean() / (difference.std(ddof=1) / np.sqrt(n)))
    p = float(2 * stdtr(n - 1, -abs(t)))
    message = (
        "Pole and zero cancel: the filter leaves white noise."
        if p > 0.1
        else f"Pole and zero don't cancel (a - b = {difference.mean():.3g} on average): correlation is left."
    )
    return Outcome(f"zero-pole cancellation, {n} windows", t, p, message)
