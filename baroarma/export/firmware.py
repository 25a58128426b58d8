"""Firmware: a preset as C99 without dependencies, with its own test.

    parts in c_source ──┐
    constants ──────────┼── baroarma.h, baroarma_config.h, baroarma.c
    golden vectors ─────┴── baroarma_selftest.c, baroarma_golden.h

One source serves floats and doubles.  Nothing is allocated, nothing is global: all state is in a structure
that the caller owns.  The self-test replays a recording that Python tracked, and samples that no sensor
should give; compiled with ``-DBAROARMA_REPLAY`` it tracks a recording's CSV instead.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any, Final, Literal

from baroarma.atmosphere import EXPONENT, SCALE_HEIGHT, SEA_LEVEL_PRESSURE, STANDARD_GRAVITY
from baroarma.atomic import replacing
from baroarma.estimators.attitude.alignment import ENOUGH, PARTS
from baroarma.estimators.attitude.samples import MOST_FORCE, MOST_RATE
from baroarma.estimators.base import ROUNDING, STALE, UNFELT, UNSEEN_WALK
from baroarma.estimators.conditioning import FARTHEST, Conditioner, conditioner_of
from baroarma.estimators.height.linear import LONGEST_STEP
from baroarma.export.c_text import Number, Numbers, comment
from baroarma.export.golden import golden_header
from baroarma.export.parts import ATTITUDES, CONDITIONINGS, HEIGHTS, Part
from baroarma.noise_model import NoiseModel
from baroarma.presets import PRESETS, Preset
from baroarma.tracker import CLOCK, Tracker

Real = Literal["float", "double"]
RATES: Final = (4.0, 2000.0)
"""Rates in Hz that firmware can be exported for: below, a second of rest says too little."""


@dataclass(frozen=True)
class Firmware:
    """Hold the exported source of a preset.

    Parameters
    ----------
    preset : str
        What it does.
    rate_hz : float
        Rate of the barometer's new samples that it was made for, Hz.
    real : {"float", "double"}
        The type it computes with, unless ``-DBAROARMA_FLOAT=0`` or ``=1`` says otherwise.
    notes : tuple of str
        What to know before flashing it.
    files : tuple of (str, str)
        Names and texts.

    Examples
    --------
    >>> import tempfile
    >>> made = firmware("sg14-a", rate_hz=50, real="double")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     made.write(folder)
    ...     sorted(os.listdir(folder)) == sorted(name for name, _ in made.files)
    True
    """

    preset: str
    rate_hz: float
    real: Real
    notes: tuple[str, ...]
    files: tuple[tuple[str, str], ...]

    def __repr__(self) -> str:
        return f"<Firmware of {self.preset} at {self.rate_hz:g} Hz, {self.real}: {len(self.files)} files>"

    def write(self, folder: str | os.PathLike[str]) -> None:
        """Write the files into a folder, which is made if need be; older ones of the same names are replaced.

        Parameters
        ----------
        folder : str or path
            Where to; its parent must exist.

        Raises
        ------
        ValueError
            If the parent doesn't exist.
        """
        target = Path(folder)
        if not target.parent.is_dir():
            raise ValueError(f"{target}: there is no folder {target.parent}; make it first")
        target.mkdir(exist_ok=True)
        for name, text in self.files:
            with replacing(target / name) as temporary:
                temporary.write_text(text, encoding="ascii")


def exportable() -> tuple[str, ...]:
    """Return the presets that firmware can be made of.

    Examples
    --------
    >>> "sg14-b" in exportable(), "bourke08" in exportable()
    (True, False)
    """
    return tuple(name for name in PRESETS if not _lack(Tracker.preset(name)))


def firmware(
    preset: str, *, noise: NoiseModel | None = None, rate_hz: float, real: Real = "float", **options: Any
) -> Firmware:
    """Make C source of a preset.

    Parameters
    ----------
    preset : str
        One of `exportable()`.
    noise : NoiseModel, optional
        Noise of the barometer's raw samples; without it the preset takes its own default.
    rate_hz : float
        Rate of the barometer's new samples, Hz: the whitening filter is made for it.  The IMU may be faster;
        each step says how long it was.
    real : {"float", "double"}
        What to compute with.  Doubles follow Python to rounding; floats are what microcontrollers are good
        at, and stay within 2 mm.
    **options
        As `Tracker` takes them: other back-ends or settings than the preset's.

    Returns
    -------
    Firmware
        Its `write` puts the files where the compiler finds them.

    Raises
    ------
    ValueError
        If the preset can't be exported, or rate or type make no sense.

    Examples
    --------
    >>> made = firmware("sg14-b", rate_hz=50)
    >>> made
    <Firmware of sg14-b at 50 Hz, float: 5 files>
    >>> [name for name, _ in made.files][:3]
    ['baroarma.h', 'baroarma_config.h', 'baroarma.c']
    """
    if real not in ("float", "double"):
        raise ValueError(f"firmware computes with 'float' or 'double', not with {real!r}")
    if not RATES[0] <= rate_hz <= RATES[1]:
        raise ValueError(
            f"the barometer's rate must be {RATES[0]:g} to {RATES[1]:g} Hz, but it is {rate_hz:g}"
        )
    tracker = Tracker.preset(preset, noise=noise, **options)
    if lack := _lack(tracker):
        names = ", ".join(exportable())
        raise ValueError(f"{tracker.settings.name} has no counterpart in C: {lack}; there are {names}")
    conditioner = conditioner_of(tracker.settings.conditioning, noise, rate_hz)
    attitude, conditioning, height = parts = _parts(tracker.settings)
    numbers = (
        *_chain_numbers(tracker.settings),
        *attitude.numbers(tracker._attitude),
        *conditioning.numbers(conditioner),
        *height.numbers(tracker._make_height(1 / rate_hz, conditioner.whitening)),
    )
    title = _title(tracker, rate_hz)
    files = (
        ("baroarma.h", title + _text("baroarma.h").replace("@types@\n", _joined(parts, ".h"))),
        ("baroarma_config.h", title + _config(numbers, real)),
        ("baroarma.c", title + _text("prelude.c") + "\n" + _joined(parts, ".c") + _text("tracker.c")),
        ("baroarma_selftest.c", title + _text("selftest.c")),
        ("baroarma_golden.h", title + golden_header(tracker, rate_hz)),
    )
    return Firmware(tracker.settings.name, float(rate_hz), real, _notes(tracker, conditioner), files)


def _lack(tracker: Tracker) -> str:
    """Say what has no counterpart in C; empty: all have."""
    preset = tracker.settings
    if preset.height is None:
        return "it works off-line"
    if preset.attitude is not None and preset.attitude not in ATTITUDES:
        return f"the attitude {preset.attitude}"
    if preset.attitude is None or preset.height not in HEIGHTS:
        return f"the height estimator {preset.height}"
    attitude, _, height = _parts(preset)
    setting = attitude.lacks(tracker._attitude) or height.lacks(tracker._make_height(0.02, None))
    return setting and f"the setting {setting}"


def _parts(preset: Preset) -> tuple[Part, Part, Part]:
    assert preset.attitude is not None
    assert preset.height is not None
    return ATTITUDES[preset.attitude], CONDITIONINGS[preset.conditioning], HEIGHTS[preset.height]


def _chain_numbers(preset: Preset) -> Numbers:
    """Return what `tracker.c` reads."""
    return (
        Number("CLOCK", CLOCK, "rounding of a clock, s"),
        Number("ROUNDING", ROUNDING, "sums of intervals that but for so much reach a time reach it, s"),
        Number("PARTS", PARTS, "of the alignment's second, whose means tell how sure its mean is"),
        Number("PART_ROUNDING", ROUNDING, "of the place in them"),
        Number("LEAST_GRAVITY", STANDARD_GRAVITY / 2, "a mean specific force below is no rest, m/s²"),
        Number("ENOUGH_SAMPLES", ENOUGH, "fewer don't tell a sensor's noise"),
        Number(
            "BIAS_CAPTURE", preset.bias_capture, "1: height counts from the rest's mean; 0: the first sample"
        ),
        Number("LONGEST_STEP", 3600.0, "a longer interval is refused, s"),
        Number("LARGEST_FORCE", 1e4, "no accelerometer reads more, m/s²"),
        Number("LARGEST_RATE", 1e3, "no gyro reads more, rad/s"),
        Number("MOST_FORCE", MOST_FORCE, "a longer specific force is no sample, m/s²"),
        Number("MOST_RATE", MOST_RATE, "nor is a longer rate, rad/s"),
        Number("FARTHEST", FARTHEST, "what is farther from the start is no altitude, m"),
        Number("STALE", STALE, "what happens in a longer interval is not felt, s"),
        Number("UNFELT", UNFELT + ROUNDING, "an older acceleration counts as 0, s"),
        Number("UNSEEN_WALK", UNSEEN_WALK, "how the velocity then wanders, m/s per root second"),
        Number("LEAST_STEP", 1e-6, "s"),
        Number("LONGEST_GAP", LONGEST_STEP, "height and velocity are unknown after such an interval, s"),
        Number("SCALE_HEIGHT", SCALE_HEIGHT, "T0/L of the ISA, m"),
        Number("EXPONENT", EXPONENT, "R L/g of the ISA"),
        Number("SEA_LEVEL_PRESSURE", SEA_LEVEL_PRESSURE, "of the ISA, Pa"),
    )


def _title(tracker: Tracker, rate_hz: float) -> str:
    """Return the comment at the head of each file; what a user wrote is made harmless."""
    noise = tracker.noise
    lines = [f"{tracker.settings.name}: {tracker.settings.title}", f"Barometer at {rate_hz:g} Hz."]
    if noise is not None:
        lines.append(f"Noise: {repr(noise)[1:-1]}{f', sensor {noise.sensor[:60]}' if noise.sensor else ''}.")
    lines.append("Made by baroarma export firmware; a change here is lost when it is made again.")
    return "/* " + "\n * ".join(comment(line) for line in lines) + " */\n\n"


def _config(numbers: Iterable[Number], real: Real) -> str:
    constants = "\n".join(str(number) for number in numbers)
    return f"""#ifndef BAROARMA_CONFIG_H
#define BAROARMA_CONFIG_H

#include <math.h>

#ifndef BAROARMA_FLOAT
#define BAROARMA_FLOAT {int(real == "float")} /* 1: float; 0: double */
#endif
#if BAROARMA_FLOAT
typedef float baroarma_real;
#else
typedef double baroarma_real;
#endif

{constants}

#endif
"""


def _joined(parts: Iterable[Part], suffix: str) -> str:
    """Return the parts' texts of one kind, one after the other, each once."""
    names = dict.fromkeys(f"{name}{suffix}" for part in parts for name in part.files)
    folder = resources.files("baroarma.export") / "c_source"
    return "".join(_text(name) + "\n" for name in names if (folder / name).is_file())


def _text(name: str) -> str:
    return (resources.files("baroarma.export") / "c_source" / name).read_text(encoding="ascii")


def _notes(tracker: Tracker, conditioner: Conditioner) -> tuple[str, ...]:
    notes = []
    if tracker.noise is None and tracker.settings.needs_noise:
        notes.append("No noise model was given: the firmware has a BMP085's, from a paper; identify yours.")
    w = conditioner.whitening
    if w is not None and w.note:
        notes.append(w.note)
    elif w is not None and abs(w.dc_gain - 1) > 1e-9:
        notes.append(f"A steady height change is reported {w.dc_gain:.4g} times its size (DC gain).")
    return tuple(notes)
