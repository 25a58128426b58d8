"""What to enter in other programs for one noise model, and why that number.

Filters of autopilots (PX4, ArduPilot) take every altitude's error for white.  What matters to them is the
density of the noise at the low frequencies where they listen: white noise that has the model's density at
frequency 0,

    S(0) = sigma_u²/rate + 2 sigma_c² tau,   sd per sample at the filter's rate f:  sqrt(S(0) f),

the sum of all covariances.  The samples' own sd would make them trust the barometer too much by a factor that
grows with f tau.

Simulators (Gazebo, MATLAB) make noise instead; they get the model's own terms in their parametrisation, and
what they can't make is said.  Pressures are heights divided by the ISA's metres per pascal.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from baroarma.atmosphere import SEA_LEVEL_PRESSURE, metres_per_pascal
from baroarma.noise_model import NoiseModel

FUSION_HZ: Final = 20.0
"""Rate at which PX4 (EKF2_BARO_RATE, default) and ArduPilot (one sample in 50 ms) take altitudes at most."""
LONG: Final = 3600.0
"""Correlation time in s by which Gazebo's bias passes for a random walk."""


@dataclass(frozen=True)
class Setting:
    """Hold one number to enter.

    Parameters
    ----------
    name : str
        As the program calls it.
    value : float
        In `unit`.
    unit : str
        Its unit; empty: a plain number.
    why : str
        Where it comes from.

    Examples
    --------
    >>> print(Setting("EKF2_BARO_NOISE", 1.51, "m", "white noise of the same density at 20 Hz"))
    EKF2_BARO_NOISE = 1.51 m: white noise of the same density at 20 Hz
    """

    name: str
    value: float
    unit: str
    why: str

    def __str__(self) -> str:
        return f"{self.name} = {self.value:.6g}{f' {self.unit}' if self.unit else ''}: {self.why}"


@dataclass(frozen=True)
class Hint:
    """Hold what to enter in one program.

    Parameters
    ----------
    tool : str
        The program.
    assumes : str
        What its filter or simulator takes the noise for.
    settings : tuple of Setting
        The numbers.
    limits : tuple of str
        What they don't say.
    snippet : str
        To paste; empty: there is nothing to paste.

    Examples
    --------
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> px4 = hints(noise)[0]
    >>> px4.tool, px4.settings[0].name, px4.settings[0].value  # white noise of the same density at 0 Hz
    ('PX4', 'EKF2_BARO_NOISE', 1.51)
    >>> len(px4.limits) > 0
    True
    """

    tool: str
    assumes: str
    settings: tuple[Setting, ...]
    limits: tuple[str, ...]
    snippet: str = ""

    def __str__(self) -> str:
        lines = [f"{self.tool}: {self.assumes}", *(f"  {setting}" for setting in self.settings)]
        lines += [f"  mind: {limit}" for limit in self.limits]
        return "\n".join([*lines, *(f"    {line}" for line in self.snippet.splitlines())])

    def to_dict(self) -> dict[str, Any]:
        """Return the hint as JSON has it."""
        settings = [{"name": s.name, "value": s.value, "unit": s.unit, "why": s.why} for s in self.settings]
        texts = {"tool": self.tool, "assumes": self.assumes}
        return {**texts, "settings": settings, "limits": list(self.limits), "snippet": self.snippet}


def hints(noise: NoiseModel, *, pressure: float = SEA_LEVEL_PRESSURE) -> tuple[Hint, ...]:
    """Return what to enter in PX4, ArduPilot, Gazebo and MATLAB.

    Parameters
    ----------
    noise : NoiseModel
        Noise of the raw altitude samples.
    pressure : float
        Pressure in Pa at which simulators are to make noise; a metre is fewer pascals higher up.

    Raises
    ------
    ValueError
        If the pressure is not a positive number.

    Examples
    --------
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> for hint in hints(noise)[:2]:
    ...     print(hint.tool, [(setting.name, setting.value) for setting in hint.settings])
    PX4 [('EKF2_BARO_NOISE', 1.51)]
    ArduPilot [('EK3_ALT_M_NSE', 1.5)]
    """
    if not (math.isfinite(pressure) and pressure > 0):
        raise ValueError(f"the pressure must be a positive number of Pa, but it is {pressure:g}")
    return tuple(make(noise, 1 / metres_per_pascal(pressure)) for make in _TOOLS)


def white_equivalent_sd(noise: NoiseModel, rate_hz: float) -> float:
    """Return the sd in m of white noise at a rate in Hz that has the model's density at frequency 0.

    The drift has no density there and is left out.

    Examples
    --------
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> round(white_equivalent_sd(noise, 20.0), 3)
    1.507
    """
    correlated = 2 * noise.correlated_sd**2 * noise.correlation_time
    return math.sqrt((noise.white_density + correlated) * rate_hz)


def _px4(noise: NoiseModel, pascals_per_metre: float) -> Hint:
    rate_hz = min(noise.rate_hz, FUSION_HZ)
    limits = (
        _drift_limit(noise, "EKF2 estimates the barometer's bias where it has another height source"),
        "EKF2_BARO_RATE is taken as 20 Hz (default) or the sensor's rate; the number goes with its root",
        _AT_REST,
    )
    return Hint(
        "PX4",
        "EKF2 takes altitudes for true but for white noise",
        (_floor("EKF2_BARO_NOISE", noise, rate_hz, least=0.01, most=15.0, step=0.01, default="3.5 m"),),
        tuple(filter(None, limits)),
    )


def _ardupilot(noise: NoiseModel, pascals_per_metre: float) -> Hint:
    rate_hz = min(noise.rate_hz, FUSION_HZ)
    limits = (
        _drift_limit(noise, "EKF3 has no state for it: the height follows the weather"),
        "EKF3 takes one sample in 50 ms at most; below, the number goes with the root of the rate",
        "the same number serves the synthetic height of EK3_SRCx_POSZ = 0",
        _AT_REST,
    )
    default = "2 m for copters, 3 m for planes"
    return Hint(
        "ArduPilot",
        "EKF3 takes altitudes for true but for white noise",
        (_floor("EK3_ALT_M_NSE", noise, rate_hz, least=0.1, most=100.0, step=0.1, default=default),),
        tuple(filter(None, limits)),
    )


_AT_REST: Final = (
    "this is the sensor at rest; rotors, wind and speed add to it, so that it is the least to enter"
)


def _floor(
    name: str, noise: NoiseModel, rate_hz: float, *, least: float, most: float, step: float, default: str
) -> Setting:
    sd = white_equivalent_sd(noise, rate_hz)
    value = round(min(max(sd, least), most) / step) * step
    kept = "" if least <= sd <= most else f", kept within {least:g} to {most:g} m"
    why = f"white noise at {rate_hz:g} Hz as dense at low frequency has {sd:.4g} m{kept} (default {default})"
    return Setting(name, round(value, 9), "m", why)


def _drift_limit(noise: NoiseModel, what: str) -> str:
    if not noise.drift_rate:
        return ""
    second, minute = noise.drift_rate, 60**0.5 * noise.drift_rate
    return f"the drift, {second:.2g} m in a second and {minute:.2g} m in a minute, is in no parameter; {what}"


def _gazebo(noise: NoiseModel, pascals_per_metre: float) -> Hint:
    pascals = pascals_per_metre
    limits = ["versions that don't know dynamic_bias_* leave the slow noise out, without a word"]
    if noise.has_gauss_markov:
        start, walk = noise.correlated_sd, noise.correlated_sd * math.sqrt(2 / noise.correlation_time)
        time, what = noise.correlation_time, "Gauss-Markov sd times sqrt(2/tau): it drives the process"
        limits.append(_drift_limit(noise, "the one slow process is the Gauss-Markov noise"))
    else:
        start, walk, time = 0.0, noise.drift_rate, LONG
        what = "the drift, as a process that forgets in an hour"
    settings = (
        Setting("update_rate", noise.rate_hz, "Hz", "the rate at which the white sd holds"),
        Setting("stddev", noise.white_sd * pascals, "Pa", "white sd of one sample"),
        Setting("bias_stddev", start * pascals, "Pa", "of where the slow noise starts"),
        Setting("dynamic_bias_stddev", walk * pascals, "Pa/sqrt(s)", what),
        Setting("dynamic_bias_correlation_time", time, "s", "how long the slow noise remembers"),
    )
    return Hint(
        "Gazebo",
        f"the air-pressure sensor adds white noise and one slow bias, in Pa ({pascals:.4g} Pa/m here)",
        settings,
        tuple(filter(None, limits)),
        _sdf(settings),
    )


def _sdf(settings: tuple[Setting, ...]) -> str:
    rate, *inner = settings
    lines = "\n".join(f"        <{s.name}>{s.value:.6g}</{s.name}>" for s in inner)
    return f"""<sensor name="air_pressure" type="air_pressure">
  <update_rate>{rate.value:.6g}</update_rate>
  <air_pressure>
    <pressure>
      <noise type="gaussian">
        <mean>0</mean>
        <bias_mean>0</bias_mean>
{lines}
      </noise>
    </pressure>
  </air_pressure>
</sensor>"""


def _matlab(noise: NoiseModel, pascals_per_metre: float) -> Hint:
    d = math.exp(-1 / (noise.rate_hz * noise.correlation_time)) if noise.has_gauss_markov else 0.0
    density = noise.white_sd * math.sqrt(2 / noise.rate_hz)
    instability = noise.correlated_sd * math.sqrt((1 + d) / 2)
    settings = (
        Setting("SampleRate", noise.rate_hz, "Hz", "the rate at which the white sd holds"),
        Setting("NoiseDensity", density, "m/sqrt(Hz)", "one-sided: white sd times sqrt(2/rate)"),
        Setting("BiasInstability", instability, "m", "Gauss-Markov sd times sqrt((1 + d)/2)"),
        Setting("DecayFactor", d, "", "d = exp(-1/(rate tau))"),
    )
    limits = (
        _drift_limit(noise, "add it to the output as a cumulative sum of randn"),
        "the numbers are altimeterSensor's; barometerSensor (since R2025a) takes them in Pa, but whether it "
        "scales its correlated noise in the same way was not checked: compare its sd with the model's",
        "the slow noise starts at 0, and is complete after a few correlation times",
    )
    metres = ", ".join(f"{s.name}={s.value:.6g}" for s in settings)
    pascal = (1.0, pascals_per_metre, pascals_per_metre, 1.0)
    pascals = ", ".join(f"{s.name}={s.value * k:.6g}" for s, k in zip(settings, pascal, strict=True))
    return Hint(
        "MATLAB",
        "altimeterSensor and barometerSensor add white noise and first-order correlated noise",
        settings,
        tuple(filter(None, limits)),
        f"altimeter = altimeterSensor({metres});\nbarometer = barometerSensor({pascals});",
    )


_TOOLS: Final[tuple[Callable[[NoiseModel, float], Hint], ...]] = (_px4, _ardupilot, _gazebo, _matlab)
