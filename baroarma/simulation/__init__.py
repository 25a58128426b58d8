"""Simulated recordings with truth: a motion, seen by the sensors of a device."""

from __future__ import annotations

from baroarma.simulation.devices import BMP085, DEVICES, WIMU, Device
from baroarma.simulation.encoder import Encoder, simulate_with_encoder
from baroarma.simulation.motions import (
    DURATIONS,
    MOTIONS,
    REST_BEFORE,
    Truth,
    check_options,
    move,
    options_of,
)
from baroarma.simulation.recordings import simulate, simulate_rest
from baroarma.simulation.sensors import Barometer, Imu, Triad
from baroarma.simulation.streams import Clock

__all__ = [
    "BMP085",
    "DEVICES",
    "DURATIONS",
    "MOTIONS",
    "REST_BEFORE",
    "WIMU",
    "Barometer",
    "Clock",
    "Device",
    "Encoder",
    "Imu",
    "Triad",
    "Truth",
    "check_options",
    "move",
    "options_of",
    "simulate",
    "simulate_rest",
    "simulate_with_encoder",
]
