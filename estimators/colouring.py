"""Coloured measurement noise as states: any filterpy Kalman filter made to know its altimeter.

A Kalman filter takes its measurement noise for white.  Correlated noise goes into the state instead:

    [x]+   [F  0 ] [x]              [x]
    [n]  = [0  F_n] [n] + ...,  z = [H  H_n] [n] + v

with n the Gauss-Markov component (F_n = exp(-dt/tau), Q_n = sigma_c^2 (1 - F_n^2), stationary at the start)
and the drift (F_n = 1, Q_n = drift_rate^2 dt), v the white component of *one raw sample*, R = sigma_u^2,
however far apart the samples are.  An ARMA(p, q) has r = max(p, q + 1) states in innovations form,

    n+ = T n + g e,  T = [-a | shifted I],  g = [1, b_1 ... b_{r-1}],  H_n = [1, 0 ...],  R = 0

[Harvey 1989, Sec. 3.3]: its current innovation is in the state, so that no white noise is left over.
"""

from __future__ import annotations

from copy import deepcopy
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baroarma.arma import ArmaModel
from baroarma.noise_model import NoiseModel

if TYPE_CHECKING:
    from filterpy.kalman import KalmanFilter

Signal = NDArray[np.float64]


class NoiseStates(NamedTuple):
    """The state space of measurement noise with m states; F and Q may be stacks, one for each interval."""

    F: Signal
    """Transition, (..., m, m)."""
    Q: Signal
    """Process noise, (..., m, m)."""
    H: Signal
    """How the states add to the measurement, (1, m)."""
    R: Signal
    """What stays white, (1, 1)."""
    P: Signal
    """Covariance at the start, (m, m)."""


def colour_measurement(kf: KalmanFilter, noise: NoiseModel | ArmaModel, dt: float) -> KalmanFilter:
    """Return a new filter whose measurement noise is the model; the given one stays as it was.

    Parameters
    ----------
    kf : filterpy.kalman.KalmanFilter
        Any linear filter with a scalar measurement.  Its R is replaced, the rest is kept; the noise states
        are appended to x.
    noise : NoiseModel or ArmaModel
        Noise of the samples passed to `update`.  A `NoiseModel` describes raw samples: R is the square of
        `white_sd`, whatever `dt` is.  When `update` gets averages instead, pass `noise.at_rate(...)`.  An
        `ArmaModel` holds at its own interval only.
    dt : float
        Time that one `predict` takes, s.

    Returns
    -------
    filterpy.kalman.KalmanFilter
        Call `predict` and `update` as before; a missing sample is a `predict` without `update`.

    Raises
    ------
    ValueError
        If the measurement is not scalar, or an ARMA model's interval is not `dt`.

    Examples
    --------
    >>> from filterpy.kalman import KalmanFilter
    >>> kf = KalmanFilter(dim_x=2, dim_z=1)
    >>> kf.F, kf.H = np.array([[1.0, 0.02], [0.0, 1.0]]), np.array([[1.0, 0.0]])
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> mine = colour_measurement(kf, noise, dt=0.02)
    >>> mine.dim_x, mine.H.tolist(), kf.dim_x
    (3, [[1.0, 0.0, 1.0]], 2)
    """
    from filterpy.kalman import KalmanFilter

    if kf.dim_z != 1:
        raise ValueError(f"the measurement has {kf.dim_z} components; a scalar one is needed")
    states = noise_states(noise, dt)
    m = len(states.P)
    new = KalmanFilter(dim_x=kf.dim_x + m, dim_z=1, dim_u=kf.dim_u)
    new.x = np.concatenate([np.array(kf.x, float), np.zeros((m, *np.shape(kf.x)[1:]))])
    new.F, new.Q, new.P = (block_diagonal(_square(kf, w), getattr(states, w)) for w in "FQP")
    new.H, new.R = np.hstack([np.reshape(kf.H, (1, -1)), states.H]), states.R
    if kf.B is not None:
        new.B = np.concatenate([kf.B, np.zeros((m, *np.shape(kf.B)[1:]))])
    new._alpha_sq, new.inv = kf._alpha_sq, deepcopy(kf.inv)
    new.x_prior, new.x_post = new.x.copy(), new.x.copy()
    new.P_prior, new.P_post = new.P.copy(), new.P.copy()
    return new


def noise_states(noise: NoiseModel | ArmaModel, dt: float | Signal, *, offset_sd: float = 0.0) -> NoiseStates:
    """Return the state space of measurement noise: the drift (if any), then Gauss-Markov (if any) or ARMA.

    Parameters
    ----------
    noise : NoiseModel or ArmaModel
        The noise.
    dt : float or ndarray
        Interval in s; an array gives stacks of F and Q.  An ARMA model takes its own interval only.
    offset_sd : float
        Prior sd of an unknown constant offset in m, the drift's start.  0: the drift starts at 0.
    """
    if isinstance(noise, ArmaModel):
        return _arma_states(noise, dt)
    dt, drifts = np.asarray(dt, float), bool(noise.drift_rate or offset_sd)
    P = np.diag([offset_sd**2] * drifts + [noise.correlated_sd**2] * noise.has_gauss_markov)
    none = np.zeros((*np.shape(dt), *P.shape))
    F, Q = none + np.eye(len(P)), none
    fill_noise(F, Q, noise, dt)
    return NoiseStates(F, Q, H=np.ones((1, len(P))), R=np.array([[noise.white_sd**2]]), P=P)


def fill_noise(F: Signal, Q: Signal, noise: NoiseModel, dt: float | Signal) -> None:
    """Write what depends on the interval, in s, into the F and Q of `noise_states`."""
    if F.shape[-1] > noise.has_gauss_markov:
        Q[..., 0, 0] = noise.drift_rate**2 * dt
    if noise.has_gauss_markov:
        phi = np.exp(-dt / noise.correlation_time)
        F[..., -1, -1], Q[..., -1, -1] = phi, noise.correlated_sd**2 * (1 - phi**2)


def block_diagonal(first: Signal, second: Signal) -> Signal:
    """Put two (stacks of) square matrices on the diagonal of a larger one."""
    n, m = first.shape[-1], second.shape[-1]
    out = np.zeros((*np.broadcast_shapes(first.shape[:-2], second.shape[:-2]), n + m, n + m))
    out[..., :n, :n] = first
    out[..., n:, n:] = second
    return out


def _arma_states(model: ArmaModel, dt: float | Signal) -> NoiseStates:
    if not np.allclose(dt, model.dt, rtol=1e-6, atol=0):
        raise ValueError(
            f"the ARMA model holds for samples every {model.dt:g} s, but the filter steps every {dt} s; "
            "identify it at the filter's interval or use a NoiseModel"
        )
    p, q = len(model.ar), len(model.ma)
    if p == q == 0:
        empty = np.zeros((0, 0))
        return NoiseStates(empty, empty, np.zeros((1, 0)), np.array([[model.sd**2]]), empty)
    r = max(p, q + 1)
    F, g = np.eye(r, k=1), np.zeros((r, 1))
    F[:p, 0] = -np.array(model.ar)
    g[: q + 1, 0] = 1.0, *model.ma
    Q = model.sd**2 * g @ g.T
    return NoiseStates(F, Q, np.eye(1, r), np.zeros((1, 1)), _stationary(F, Q))


def _stationary(F: Signal, Q: Signal) -> Signal:
    """Solve P = F P F' + Q."""
    n = len(F)
    P = np.linalg.solve(np.eye(n * n) - np.kron(F, F), Q.ravel()).reshape(n, n)
    return (P + P.T) / 2


def _square(kf: Any, name: str) -> Signal:
    """A matrix of the filter; filterpy also takes a number for a multiple of the identity."""
    value = np.asarray(getattr(kf, name), float)
    return value * np.eye(kf.dim_x) if value.ndim == 0 else value
