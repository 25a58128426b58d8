"""A table of typical barometers' noise, to compare one's own with.

Each row is one sensor in one mode with its source: a data sheet's typical rms noise, a paper's, a driver's
comment on its data sheet, or what `baroarma.identify` found in somebody's recording.  An empty field is a
number that no source at hand tells; the rate of a sensor that converts on command is one over its conversion
time.

Noises are compared by their density, rms/sqrt(rate), which neither averaging nor another rate changes.  Rows
without a rate have none, nor have those behind a sensor's own recursive filter: their rms is that of a
narrower band than the rate's.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Final, Literal

from baroarma.atmosphere import SEA_LEVEL_PRESSURE, metres_per_pascal
from baroarma.noise_model import NoiseModel

if TYPE_CHECKING:
    import pandas as pd

Kind = Literal["data sheet", "paper", "driver", "measured"]
KINDS: Final = ("data sheet", "paper", "driver", "measured")
FILTERS: Final = ("IIR", "embedded")
"""Filters, by how their names begin, behind which the rms is not that of the rate's band."""
NEAREST: Final = 3
"""How many of the sensors that resemble most a summary names."""


@dataclass(frozen=True)
class Sensor:
    """Hold what a source says about a sensor in one mode; None: nothing.

    Parameters
    ----------
    sensor, mode : str
        What it is, and how it is set.
    kind : {"data sheet", "paper", "driver", "measured"}
        What the source is; "driver": a driver's comment on the data sheet.
    rms_noise_pa : float
        Rms noise of a sample, Pa.
    rate_hz : float or None
        Rate of the samples, Hz.
    filter : str
        "off", or the filter that the noise is behind; empty: not told.
    absolute_pa, relative_pa : float or None
        Typical accuracy, ± Pa, absolute and of small differences.
    tco_pa_per_k : float or None
        Typical temperature coefficient of the offset, ± Pa/K.
    source : str
        Where it stands.

    Examples
    --------
    At sea level 1 Pa is 8.3 cm; at 25 Hz 1 Pa is 0.2 Pa/√Hz, unless a filter colours it:

    >>> mine = Sensor("mine", "as it is", "measured", 1.0, 25.0, "off", None, None, None, "a night's log")
    >>> round(mine.noise_m, 4), mine.density
    (0.0832, 0.2)
    """

    sensor: str
    mode: str
    kind: Kind
    rms_noise_pa: float
    rate_hz: float | None
    filter: str
    absolute_pa: float | None
    relative_pa: float | None
    tco_pa_per_k: float | None
    source: str

    @property
    def noise_m(self) -> float:
        """Rms noise in m of height at sea level."""
        return self.rms_noise_pa * metres_per_pascal(SEA_LEVEL_PRESSURE)

    @property
    def density(self) -> float | None:
        """Root of the two-sided spectral density, Pa/√Hz; None where there is none (module docstring)."""
        if self.rate_hz is None or self.filter.startswith(FILTERS):
            return None
        return self.rms_noise_pa / math.sqrt(self.rate_hz)


@dataclass(frozen=True)
class SensorTable:
    """Hold rows of the table; iterates over them.

    Parameters
    ----------
    rows : tuple of Sensor
        In the order of the file, or the most alike first.
    factors : tuple of float
        By how much a given noise is larger than each row's; empty without one.
    title : str
        What was compared.

    Examples
    --------
    >>> table = sensors("BMP085")
    >>> table
    <SensorTable: 5 rows of 1 sensors>
    >>> [row.rms_noise_pa for row in table if row.kind == "data sheet"]  # Pa, from oss 0 to oss 3
    [6.0, 5.0, 4.0, 3.0]
    """

    rows: tuple[Sensor, ...]
    factors: tuple[float, ...] = ()
    title: str = "Typical barometers"

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Sensor]:
        return iter(self.rows)

    def __repr__(self) -> str:
        names = {row.sensor for row in self.rows}
        return f"<SensorTable: {len(self)} rows of {len(names)} sensors>"

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas DataFrame: the fields, `noise_m` and, for a comparison, `times_as_noisy`."""
        import pandas as pd

        frame = pd.DataFrame([{**asdict(row), "noise_m": row.noise_m} for row in self.rows])
        if self.factors:
            frame["times_as_noisy"] = self.factors
        return frame

    def summary(self) -> str:
        """Return the title, and which sensors are most alike."""
        alike = [
            f"  {factor:5.2f} times {row.sensor}, {row.mode} ({row.kind})"
            for row, factor in list(zip(self.rows, self.factors, strict=False))[:NEAREST]
        ]
        return "\n".join([self.title, *alike])

    def _repr_html_(self) -> str:
        from baroarma.notebook import tables
        from baroarma.page import Table

        head: tuple[str, ...] = (
            "sensor",
            "mode",
            "noise Pa",
            "m",
            "rate Hz",
            "filter",
            "± Pa",
            "TCO Pa/K",
            "kind",
            "source",
        )
        body: tuple[tuple[str, ...], ...] = tuple(
            (
                row.sensor,
                row.mode,
                f"{row.rms_noise_pa:g}",
                f"{row.noise_m:.2g}",
                _number(row.rate_hz),
                row.filter,
                _number(row.absolute_pa),
                _number(row.tco_pa_per_k),
                row.kind,
                row.source,
            )
            for row in self.rows
        )
        if self.factors:
            head = ("this noise is", *head)
            body = tuple((f"× {f:.2g}", *cells) for f, cells in zip(self.factors, body, strict=True))
        return tables(Table(head, body, caption=self.title))


def sensors(name: str = "") -> SensorTable:
    """Return the table of typical barometers' noise.

    Parameters
    ----------
    name : str
        Only sensors whose name begins so, in upper or lower case; default: all.

    Returns
    -------
    SensorTable
        Sensor, mode, noise in Pa and m, rate, filter, accuracy, temperature coefficient, source.

    Raises
    ------
    ValueError
        If there is no such sensor; the message lists those there are.

    Examples
    --------
    >>> [(row.mode, row.rms_noise_pa, round(row.noise_m, 2)) for row in sensors("BMP085")][0]
    ('ultra low power (oss 0)', 6.0, 0.5)
    """
    rows = tuple(row for row in _rows() if row.sensor.lower().startswith(name.lower()))
    if not rows:
        known = ", ".join(dict.fromkeys(row.sensor for row in _rows()))
        raise ValueError(f"there is no sensor {name!r} in the table; there are {known}")
    return SensorTable(rows)


def compare_with_sensors(noise: NoiseModel, *, pressure: float = SEA_LEVEL_PRESSURE) -> SensorTable:
    """Compare a noise model's white noise with that of typical sensors, the most alike first.

    Parameters
    ----------
    noise : NoiseModel
        Such as `identify` found; its Gauss-Markov noise and drift (wind, weather, warming) are left out.
    pressure : float
        Pressure in Pa at which it was found, to turn its metres into pascals; the effect is 1 % per km.

    Returns
    -------
    SensorTable
        With `factors`: the root of the ratio of the two densities, by how much the noise is larger than the
        sensor's would be at the same rate.

    Raises
    ------
    ValueError
        If the model has no white noise to compare.

    Examples
    --------
    >>> table = compare_with_sensors(NoiseModel(0, 0, 0.125, rate_hz=80))
    >>> print(table.summary())
    White noise of 0.168 Pa/√Hz (0.125 m at 80 Hz) is
       1.00 times MS5611, on an Arduino (measured)
       ...
    """
    if not noise.white_sd:
        raise ValueError("the model has no white noise to compare; identify a log of a higher rate")
    pascal = math.sqrt(noise.white_density) / metres_per_pascal(pressure)
    found = [(row, pascal / row.density) for row in _rows() if row.density]
    found.sort(key=lambda pair: abs(math.log(pair[1])))
    rows, factors = zip(*found, strict=True)
    title = f"White noise of {pascal:.3g} Pa/√Hz ({noise.white_sd:.3g} m at {noise.rate_hz:.4g} Hz) is"
    return SensorTable(rows, factors, title)


@cache
def _rows() -> tuple[Sensor, ...]:
    text = files("baroarma").joinpath("sensors.csv").read_text(encoding="utf-8")
    words = {"sensor", "mode", "kind", "filter", "source"}
    rows: list[dict[str, Any]] = [
        {f.name: _field(row[f.name], f.name in words) for f in fields(Sensor)}
        for row in csv.DictReader(text.splitlines())
    ]
    return tuple(Sensor(**row) for row in rows)


def _field(text: str, is_word: bool) -> str | float | None:
    if is_word:
        return text
    return float(text) if text else None


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"
