"""Probes of SG14's claims: its methods with one thing changed, to see where a number comes from.

Method A fed with a barometer that reports only a fifth of every change (the DC gain of Method B's filter) or
none of it; the midpoint instead of Euler's rule; the true attitude; other bias states of the attitude EKF.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from baroarma.estimators.conditioning import SG14_ARMA
from baroarma.experiments.methods import Method
from baroarma.experiments.processing import shrunk
from baroarma.experiments.sg13 import whitening_of
from baroarma.tracker import Tracker

DC_GAIN: Final = whitening_of(SG14_ARMA).dc_gain
"""Gain of the papers' whitening filter for what is slow."""


def shrunk_methods() -> dict[str, Method]:
    """Return Method A behind a barometer that reports a share of every change of altitude."""

    def fed(factor: float) -> Method:
        return lambda recording: Tracker.preset("sg14-a").run(shrunk(recording, factor))

    return {f"Method A fed with {factor:.2g} x barometer": fed(factor) for factor in (DC_GAIN, 0.0)}


def midpoint_methods() -> dict[str, Method]:
    """Return Methods A and B with the midpoint of two accelerations instead of the earlier one."""
    midpoint = {"midpoint": True}
    return {
        f"Method {letter}, midpoint": Tracker.preset(f"sg14-{letter.lower()}", height_settings=midpoint).run
        for letter in "AB"
    }


def tilt_methods() -> dict[str, Method]:
    """Return Method A as it is, with the true attitude, and with other bias states of its EKF."""
    settings: Mapping[str, dict[str, Any]] = {
        "Method A": {},
        "Method A, true attitude": {"attitude": "reference"},
        "Method A, bias frozen": _ekf(initial_bias_sd=1e-9, bias_walk_sd=0.0),
        "Method A, bias free (0.03 m/s²)": _ekf(initial_bias_sd=0.0316),
    }
    return {label: Tracker.preset("sg14-a", **options).run for label, options in settings.items()}


def _ekf(**settings: float) -> dict[str, Any]:
    return {"attitude_settings": settings}
