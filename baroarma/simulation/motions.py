"""True motions by name, and what a sensor mounted at random on the moving body would ideally feel.

Every motion begins with `REST_BEFORE` seconds of rest, is exact at any instant (`baroarma.simulation.jet`)
and has a continuous acceleration.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.simulation.apparatus import REST_BEFORE, circle, free_fall, lift, rest
from baroarma.simulation.human import squat, stairs, walk
from baroarma.simulation.lee16 import lee16_a, lee16_b, lee16_c, lee16_d, lee16_e
from baroarma.simulation.pose import Pose, Truth, observe

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = [
    "DURATIONS",
    "MOTIONS",
    "REST_BEFORE",
    "MountedMotion",
    "Truth",
    "check_options",
    "mount",
    "move",
    "options_of",
]

Signal = NDArray[np.float64]
MOTIONS: Final[dict[str, Callable[..., Pose]]] = {
    "rest": rest,
    "free-fall": free_fall,
    "circle": circle,
    "squat": squat,
    "stairs": stairs,
    "lift": lift,
    "walk": walk,
    "lee16-a": lee16_a,
    "lee16-b": lee16_b,
    "lee16-c": lee16_c,
    "lee16-d": lee16_d,
    "lee16-e": lee16_e,
}
"""Motions by the name that users type."""
DURATIONS: Final = {
    "free-fall": 20.0,
    "lee16-a": 50.0,
    "lee16-b": 50.0,
    "lee16-c": 45.0,
    "lee16-d": 45.0,
    "lee16-e": 45.0,
}
"""How long a recording of a motion that ends is by default, s; of the others: 180."""
MAY_BE_ZERO: Final = ("tilt", "swings", "sway", "lean", "bounce", "tumble", "pause")
"""Options without which there is still a motion."""


@dataclass(frozen=True, eq=False)
class MountedMotion:
    """Hold a motion with its options and the way the sensor sits on the body; call it with times.

    Parameters
    ----------
    motion : str
        One of `MOTIONS`.
    mounting : scipy.spatial.transform.Rotation
        Turns the sensor's axes into the body's.
    options : mapping
        Of the motion.
    """

    motion: str
    mounting: Rotation
    options: Mapping[str, Any] = field(default_factory=dict)

    def __call__(self, t: Signal) -> Truth:
        """Return the truth at times t (n,) in s, in any order; before 0 there is rest."""
        return observe(t, MOTIONS[self.motion](t, **self.options), self.mounting)


def mount(motion: str, rng: np.random.Generator, **options: Any) -> MountedMotion:
    """Mount a sensor at random on a moving body.

    Parameters
    ----------
    motion : str
        One of `MOTIONS`.
    rng : numpy.random.Generator
        For the mounting.
    **options
        Of the motion; see `options_of`.

    Raises
    ------
    ValueError
        If the motion or an option is unknown, or a value can't be; the message lists those there are.
    """
    from scipy.spatial.transform import Rotation

    check_options(motion, options)
    return MountedMotion(motion, Rotation.random(rng=rng), options)


def move(motion: str, t: Signal, rng: np.random.Generator, **options: Any) -> Truth:
    """Return the true motion, at times t (n,) in s, of a sensor mounted at random; see `mount`.

    Parameters
    ----------
    motion : str
        One of `MOTIONS`.
    t : ndarray, shape (n,)
        s.
    rng : numpy.random.Generator
        For the mounting.
    **options
        Of the motion; see `options_of`.

    Raises
    ------
    ValueError
        As `check_options`.

    Examples
    --------
    >>> truth = move("circle", np.array([0.0, 100.0]), np.random.default_rng(1), frequency_hz=1.25)
    >>> round(float(np.linalg.norm(truth.rate[1])) / (2 * np.pi), 6)
    1.25
    """
    return mount(motion, rng, **options)(t)


def options_of(motion: str) -> dict[str, Any]:
    """Return the options of a motion with their defaults.

    Raises
    ------
    ValueError
        If the motion is unknown.

    Examples
    --------
    >>> options_of("circle")
    {'frequency_hz': 0.5, 'arm': 0.3, 'rise': 2.0}
    """
    if motion not in MOTIONS:
        raise ValueError(f"motion {motion!r} is unknown; choose one of {', '.join(sorted(MOTIONS))}")
    parameters = inspect.signature(MOTIONS[motion]).parameters.values()
    return {p.name: p.default for p in parameters if p.kind is p.KEYWORD_ONLY}


def check_options(motion: str, options: Mapping[str, Any]) -> None:
    """Check the options of a motion.

    Raises
    ------
    ValueError
        If the motion or an option is unknown, or a value can't be; the message lists those there are.

    Parameters
    ----------
    motion : str
        One of `MOTIONS`.
    options : mapping of str to object
        What the user gave.

    Examples
    --------
    >>> check_options("circle", {"frequency_hz": 1.25})
    >>> check_options("circle", {"hertz": 1.25})
    Traceback (most recent call last):
        ...
    ValueError: motion 'circle' has no option 'hertz'; ...
    """
    known = options_of(motion)
    for name, value in options.items():
        if name not in known:
            raise ValueError(f"motion {motion!r} has no option {name!r}; {_listed(known)}")
        _check(motion, name, value, known[name])


def _listed(options: Mapping[str, Any]) -> str:
    return f"it has {', '.join(options)}" if options else "it has none"


def _check(motion: str, name: str, value: Any, default: Any) -> None:
    """Refuse what is no number, or makes no motion."""
    if isinstance(default, tuple):
        wanted, good = "a list of numbers", _are_numbers(value)
    else:
        whole, zero = default is None or isinstance(default, int), name in MAY_BE_ZERO
        wanted = f"a {'whole ' if whole else ''}number {'that is not negative' if zero else 'above 0'}"
        good = value is default or (_is_number(value, whole) and (value > 0 or (zero and value == 0)))
    if not good:
        raise ValueError(f"{name} of the motion {motion!r} must be {wanted}, but it is {value!r}")


def _is_number(value: Any, whole: bool = False) -> bool:
    kind = Integral if whole else Real
    return not isinstance(value, bool) and isinstance(value, kind) and bool(np.isfinite(float(value)))


def _are_numbers(values: Any) -> bool:
    return isinstance(values, Sequence | np.ndarray) and len(values) > 0 and all(map(_is_number, values))
