"""How well a rest recording can determine the noise at all: the Cramér-Rao bound.

For n regular samples of a Gaussian process with spectral density S(f; theta), no unbiased estimate of theta
can have a covariance below the inverse of the Fisher information, asymptotically (Whittle 1953)

    I_jk = D int_0^{f_s/2} (d ln S / d theta_j) (d ln S / d theta_k) df,       D: duration.

A random-walk drift is no obstacle: the samples' differences are stationary, and the factor 4 sin²(pi f/f_s)
that differencing multiplies S with drops out of d ln S.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from baroarma.noise_model import PARAMETERS, NoiseModel


def cramer_rao_bound(noise: NoiseModel, duration: float) -> dict[str, float]:
    """Return the least standard deviation of each parameter that the model has.

    Parameters
    ----------
    noise : NoiseModel
        The true noise.
    duration : float
        Length of the rest recording, s.

    Returns
    -------
    dict of str to float
        By field name, in the field's unit.

    Examples
    --------
    SG13's noise in ten minutes: the correlation time can't be known better than to 8 %.

    >>> bmp085 = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)
    >>> {name: round(sd, 4) for name, sd in cramer_rao_bound(bmp085, 600).items()}
    {'correlated_sd': 0.0077, 'correlation_time': 0.0588, 'white_sd': 0.0021, 'drift_rate': 0.0034}
    """
    present = [name for name in PARAMETERS if getattr(noise, name) > 0]
    # substitute f = (f_s/2) u^3: dense near 0, where drift and Gauss-Markov noise live
    u = (np.arange(20_000) + 0.5) / 20_000
    frequency, weight = noise.rate_hz / 2 * u**3, noise.rate_hz / 2 * 3 * u**2 / 20_000
    slopes = np.stack([_log_slope(noise, name, frequency) for name in present])
    information = duration * (slopes * weight) @ slopes.T
    sd = np.sqrt(np.diag(np.linalg.inv(information)))
    return {name: float(getattr(noise, name) * s) for name, s in zip(present, sd, strict=True)}


def _log_slope(noise: NoiseModel, name: str, frequency: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return d ln S / d ln(parameter) by central differences."""
    h = 1e-4
    up, down = (replace(noise, **{name: getattr(noise, name) * math.exp(s * h)}) for s in (+1, -1))
    return np.asarray((np.log(up.psd(frequency)) - np.log(down.psd(frequency))) / (2 * h))
