"""Estimators: recordings and noise models in, states out.

>>> from baroarma import NoiseModel
>>> from baroarma.estimators import height_estimator
>>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
>>> kf = height_estimator("coloured-kalman", noise=noise)  # a filterpy KalmanFilter
>>> kf.predict(u=0.1)
>>> kf.update(0.3)
>>> kf.states
('height', 'velocity', 'acceleration_bias', 'offset', 'correlated')
"""

from __future__ import annotations

from baroarma.estimators.colouring import colour_measurement
from baroarma.estimators.registry import (
    attitude_estimator,
    attitude_names,
    height_estimator,
    height_names,
)

__all__ = [
    "attitude_estimator",
    "attitude_names",
    "colour_measurement",
    "height_estimator",
    "height_names",
]
