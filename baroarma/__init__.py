"""Barometric altimeters with honest noise: identify it, whiten it, fuse it with an IMU, judge the result.

>>> import baroarma as ba
>>> noise = ba.NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
>>> round(noise.whitening_filter(unity_gain_hz=25).dc_gain, 3)
0.193

The names below are loaded when they are first used, so that importing the package costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from baroarma.arma import ArmaModel as ArmaModel
    from baroarma.barometer_lag import estimate_barometer_lag as estimate_barometer_lag
    from baroarma.comparison import compare as compare
    from baroarma.finding import Finding as Finding
    from baroarma.formats import read as read
    from baroarma.identification import Identification as Identification
    from baroarma.identification import identify as identify
    from baroarma.imu_noise import ImuNoise as ImuNoise
    from baroarma.many import compare_many as compare_many
    from baroarma.many import identify_many as identify_many
    from baroarma.noise_model import NoiseModel as NoiseModel
    from baroarma.prediction import predict_accuracy as predict_accuracy
    from baroarma.recording import Recording as Recording
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
    "compare": "baroarma.comparison",
    "compare_many": "baroarma.many",
    "estimate_barometer_lag": "baroarma.barometer_lag",
    "identify": "baroarma.identification",
    "identify_many": "baroarma.many",
    "predict_accuracy": "baroarma.prediction",
    "read": "baroarma.formats",
    "tune": "baroarma.tuning",
}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'baroarma' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
