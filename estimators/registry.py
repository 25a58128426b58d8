"""Estimators by name: the built-in ones first, then what other packages bring.

Another package announces its estimators in its own `pyproject.toml`,

    [project.entry-points."baroarma.height"]
    my-filter = "my_package:MyFilter"

(or `baroarma.attitude`), and from then on `height_estimator("my-filter")` and the command line know it.  A
height estimator is called with ``noise=``, ``dt=`` and the user's settings, an attitude estimator with the
settings alone.  Classes are imported when they are asked for, not before.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any, Final, cast

if TYPE_CHECKING:
    from baroarma.estimators.base import AttitudeEstimator, HeightEstimator
    from baroarma.noise_model import NoiseModel

ATTITUDE: Final = {
    "robust": "baroarma.estimators.attitude.robust:RobustAttitude",
    "quaternion-ekf": "baroarma.estimators.attitude.quaternion_ekf:QuaternionEkf",
    "tilt-kalman": "baroarma.estimators.attitude.tilt_kalman:TiltKalman",
    "accelerometer-norm": "baroarma.estimators.attitude.accelerometer_norm:AccelerometerNorm",
    "reference": "baroarma.estimators.attitude.reference:ReferenceAttitude",
    "vqf": "baroarma.estimators.attitude.adapters:VqfAttitude",
    "imufusion": "baroarma.estimators.attitude.adapters:ImufusionAttitude",
}
"""Built-in attitude estimators: name and where the class is."""
HEIGHT: Final = {
    "complementary": "baroarma.estimators.height.complementary:Complementary",
    "kalman": "baroarma.estimators.height.kalman:Kalman",
    "coloured-kalman": "baroarma.estimators.height.coloured_kalman:ColouredKalman",
    "differenced-kalman": "baroarma.estimators.height.differenced_kalman:DifferencedKalman",
    "inertial-ekf": "baroarma.estimators.height.inertial_ekf:InertialEkf",
}
"""Built-in height estimators: name and where the class is."""


def height_estimator(
    name: str, *, noise: NoiseModel | None = None, dt: float | None = None, **settings: Any
) -> HeightEstimator:
    """Make a height estimator by name.

    Parameters
    ----------
    name : str
        One of `height_names`.
    noise : NoiseModel, optional
        Noise of the altitude samples it will get.
    dt : float, optional
        Nominal interval in s, for which a filterpy filter's matrices are set up; `step` and `run` go by the
        intervals they see.  Default: 1 / `noise.rate_hz`.
    **settings
        The estimator's own settings.

    Raises
    ------
    ValueError
        If there is no such estimator, or it has no such setting.

    Examples
    --------
    >>> height_estimator("kalman", dt=0.02).states
    ('height', 'velocity')
    """
    if dt is None and noise is not None:
        dt = 1 / noise.rate_hz
    make = _find(name, HEIGHT, "height")
    _check_settings(name, make, settings)
    return cast("HeightEstimator", make(noise=noise, dt=dt, **settings))


def attitude_estimator(name: str, **settings: Any) -> AttitudeEstimator:
    """Make an attitude estimator by name, with its own settings.

    Raises
    ------
    ValueError
        If there is no such estimator, or it has no such setting.

    Examples
    --------
    >>> import numpy as np
    >>> tilt = attitude_estimator("tilt-kalman")
    >>> state = tilt.step(dt=0.02, accel=np.array([0.0, 0.0, 9.81]), gyro=np.zeros(3))
    >>> state.up.round(6).tolist()
    [0.0, 0.0, 1.0]
    """
    make = _find(name, ATTITUDE, "attitude")
    _check_settings(name, make, settings)
    return cast("AttitudeEstimator", make(**settings))


def height_names() -> tuple[str, ...]:
    """List the height estimators; a plug-in that cannot be loaded is left out with a warning.

    Examples
    --------
    >>> height_names()[:3]
    ('complementary', 'kalman', 'coloured-kalman')
    """
    return (*HEIGHT, *_working_plugins("height", HEIGHT))


def attitude_names() -> tuple[str, ...]:
    """List the attitude estimators; a plug-in that cannot be loaded is left out with a warning.

    Examples
    --------
    >>> attitude_names()[:2]
    ('robust', 'quaternion-ekf')
    """
    return (*ATTITUDE, *_working_plugins("attitude", ATTITUDE))


def _find(name: str, built_in: Mapping[str, str], kind: str) -> Callable[..., Any]:
    if name in built_in:
        module, _, attribute = built_in[name].partition(":")
        return cast("Callable[..., Any]", getattr(import_module(module), attribute))
    plugins = _plugins(kind, built_in)
    if name not in plugins:
        names = (*built_in, *plugins)
        close = get_close_matches(name, names, n=1)
        hint = f"; did you mean {close[0]!r}?" if close else ""
        raise ValueError(f"there is no {kind} estimator {name!r}; there are {', '.join(names)}{hint}")
    try:
        return cast("Callable[..., Any]", plugins[name].load())
    except Exception as error:  # a stranger's module may raise anything
        raise ValueError(_broken(name, plugins[name], error)) from error


def _plugins(kind: str, built_in: Mapping[str, str]) -> dict[str, EntryPoint]:
    """Entry points by name; built-in names are ours."""
    found: dict[str, EntryPoint] = {}
    for point in entry_points(group=f"baroarma.{kind}"):
        if point.name in built_in:
            warnings.warn(
                f"the plug-in {point.value!r} is ignored: its name {point.name!r} is a built-in {kind} "
                "estimator's; it needs another name",
                stacklevel=4,
            )
        else:
            found.setdefault(point.name, point)
    return found


def _working_plugins(kind: str, built_in: Mapping[str, str]) -> list[str]:
    names = []
    for name, point in sorted(_plugins(kind, built_in).items()):
        try:
            point.load()
        except Exception as error:  # a stranger's module may raise anything
            warnings.warn(_broken(name, point, error), stacklevel=3)
        else:
            names.append(name)
    return names


def _broken(name: str, point: EntryPoint, error: Exception) -> str:
    return f"the plug-in {name!r} ({point.value}) cannot be loaded: {type(error).__name__}: {error}"


def _check_settings(name: str, make: Callable[..., Any], settings: Mapping[str, Any]) -> None:
    known = _settings(make)
    for setting in settings:
        if known is not None and setting not in known:
            raise ValueError(
                f"{name!r} has no setting {setting!r}; it has {', '.join(sorted(known)) or 'none'}"
            )


def _settings(make: Callable[..., Any]) -> set[str] | None:
    """Names of the settings, those passed on to a parent class included; None: it takes whatever it gets."""
    known: set[str] = set()
    for layer in inspect.getmro(make) if inspect.isclass(make) else (make,):
        function = vars(layer).get("__init__") if inspect.isclass(layer) else layer
        if function is None:
            continue
        parameters = inspect.signature(function).parameters.values()
        kinds = (inspect.Parameter.KEYWORD_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
        known |= {p.name for p in parameters if p.kind in kinds}
        if not any(p.kind is p.VAR_KEYWORD for p in parameters):
            return known - {"self", "noise", "dt"}
    return None
