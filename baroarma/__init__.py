"""Barometric altimeters with honest noise: identify it, whiten it, fuse it with an IMU, judge the result.

>>> import baroarma as ba
>>> noise = ba.NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
>>> round(noise.whitening_filter(unity_gain_hz=25).dc_gain, 3)
0.193

The names below are loaded when they are first used, so that importing the package costs nothing.
"""

from __future__ import annotations

import logging
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from baroarma.arma import ArmaModel as ArmaModel
    from baroarma.barometer_lag import estimate_barometer_lag as estimate_barometer_lag
    from baroarma.climbing import climb as climb
    from baroarma.comparison import compare as compare
    from baroarma.finding import Finding as Finding
    from baroarma.formats import read as read
    from baroarma.identification import Identification as Identification
    from baroarma.identification import identify as identify
    from baroarma.identification import warm_up as warm_up
    from baroarma.imu_noise import ImuNoise as ImuNoise
    from baroarma.local_gravity import gravity as gravity
    from baroarma.many import compare_many as compare_many
    from baroarma.many import identify_many as identify_many
    from baroarma.noise_model import NoiseModel as NoiseModel
    from baroarma.prediction import predict_accuracy as predict_accuracy
    from baroarma.recording import Recording as Recording
    from baroarma.sensor_table import compare_with_sensors as compare_with_sensors
    from baroarma.sensor_table import sensors as sensors
    from baroarma.track import Track as Track
    from baroarma.tracker import Tracker as Tracker
    from baroarma.tuning import tune as tune
    from baroarma.whitening import WhiteningFilter as WhiteningFilter

__version__ = "0.1.0"

_HOME = {
    "ArmaModel": "baroarma.arma",
    "Finding": "baroarma.finding",
    "Identification": "baroarma.identification",
    "ImuNoise": "baroarma.imu_noise",
    "NoiseModel": "baroarma.noise_model",
    "Recording": "baroarma.recording",
    "Track": "baroarma.track",
    "Tracker": "baroarma.tracker",
    "WhiteningFilter": "baroarma.whitening",
    "climb": "baroarma.climbing",
    "compare": "baroarma.comparison",
    "compare_many": "baroarma.many",
    "compare_with_sensors": "baroarma.sensor_table",
    "estimate_barometer_lag": "baroarma.barometer_lag",
    "gravity": "baroarma.local_gravity",
    "identify": "baroarma.identification",
    "identify_many": "baroarma.many",
    "predict_accuracy": "baroarma.prediction",
    "read": "baroarma.formats",
    "sensors": "baroarma.sensor_table",
    "tune": "baroarma.tuning",
    "warm_up": "baroarma.identification",
}
__all__ = sorted(_HOME)
logging.getLogger(__name__).addHandler(logging.NullHandler())  # silent, unless the program listens


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'baroarma' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
