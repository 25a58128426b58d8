"""Presets: what each paper's estimator consists of, and ours.

Every constant is marked *printed* (it stands in the paper) or *chosen* (by us, with the reason).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final, Literal

from baroarma.atmosphere import STANDARD_GRAVITY

MG: Final = 1e-3 * STANDARD_GRAVITY
"""A thousandth of standard gravity, m/s²."""
Origin = Literal["printed", "chosen"]


@dataclass(frozen=True)
class Constant:
    """Hold a preset's constant with its origin.

    Parameters
    ----------
    value : object
        In SI units.
    origin : {"printed", "chosen"}
        Whether the paper prints it or we chose it.
    why : str
        Where it is printed, or why we chose it.

    Examples
    --------
    >>> find_preset("sg14-a").height_settings["altitude_sd"]
    Constant(value=0.3, origin='printed', why='SG14 Table 1, sigma_v (Method A)')
    """

    value: Any
    origin: Origin
    why: str


@dataclass(frozen=True)
class Preset:
    """Describe one chain of attitude, conditioning and height.

    Parameters
    ----------
    name : str
        What users type.
    title : str
        One line about it.
    attitude : str or None
        Name of the attitude estimator; None when the height estimator takes the IMU itself.
    height : str or None
        Name of the height estimator; None for the off-line method.
    conditioning : {"none", "average", "average+whitening"}
        What happens to the altitude before.
    bias_capture : bool
        Whether the altitude's mean over the alignment is subtracted; else the first sample.
    attitude_settings, height_settings : mapping of str to Constant
        Settings of the two.
    needs_imu : bool
        Whether a recording without IMU is refused.

    Examples
    --------
    What SG14 does not print, and we had to choose:

    >>> preset = find_preset("sg14-a")
    >>> [name for name, constant in preset.constants().items() if constant.origin == "chosen"]
    ['initial_quaternion_sd', 'initial_bias_sd']
    """

    name: str
    title: str
    attitude: str | None
    height: str | None
    conditioning: str = "none"
    bias_capture: bool = True
    attitude_settings: Mapping[str, Constant] = field(default_factory=dict, hash=False)
    height_settings: Mapping[str, Constant] = field(default_factory=dict, hash=False)
    needs_imu: bool = True

    @property
    def needs_noise(self) -> bool:
        """Whether its height estimator lives on a noise model."""
        return self.height in ("coloured-kalman", "differenced-kalman")

    def constants(self) -> dict[str, Constant]:
        """Return all constants by setting."""
        return {**self.attitude_settings, **self.height_settings}


def _sg14(altitude_sd: float, method: str) -> dict[str, Constant]:
    return {
        "acceleration_sd": Constant(15 * MG, "printed", "SG14 Table 1, sigma_w"),
        "altitude_sd": Constant(altitude_sd, "printed", f"SG14 Table 1, sigma_v (Method {method})"),
    }


_QUATERNION_EKF = {
    "gyro_noise_sd": Constant(math.radians(1.0), "printed", "SG14 Table 1, sigma_g = 1 deg/s"),
    "accel_noise_sd": Constant(10 * MG, "printed", "SG14 Table 1, sigma_a"),
    "bias_walk_sd": Constant(5e-4, "printed", "SG14 Table 1, accelerometer-bias noise, m/s³"),
    "bias_decay": Constant(0.0, "printed", "SG14 Table 1, alpha"),
    "gate": Constant(150 * MG, "printed", "SG14 Table 1, threshold of the vector selection"),
    "initial_quaternion_sd": Constant(1e-2, "chosen", "P0 is not printed; a second's levelling"),
    "initial_bias_sd": Constant(1e-3, "chosen", "P0 is not printed; larger ones lose the tilt in squats"),
}
_LEE16_TILT = {
    "acceleration_memory": Constant(0.1, "chosen", "c_a is not printed"),
    "transition": Constant("exponential", "chosen", "Lee16's first-order F drifts (omega dt)³/3 a step"),
}
_LEE16_HEIGHT = {
    "acceleration_sd": Constant(0.1, "chosen", "MPU-6050's 4 mg, and 6 mg for the tilt's error"),
    "altitude_sd": Constant(0.25, "chosen", "BMP180 data sheet: 0.03 hPa rms in ultra-high resolution"),
}
_LEE16_ZUPT = {
    "zupt_steps": Constant(12, "printed", "Lee16 Eq. 14, n"),
    "zupt_threshold": Constant(0.1, "printed", "Lee16 Eq. 14, m/s²"),
}

_ALL = (
    Preset(
        "baroarma",
        "ours: the identified noise, offset, drift and accelerometer bias in the Kalman filter's state",
        attitude="robust",
        height="coloured-kalman",
        bias_capture=False,
        height_settings={"midpoint": Constant(True, "chosen", "Euler's half-sample lag is an error")},
        needs_imu=False,
    ),
    Preset(
        "sg14-a",
        "Sabatini & Genovese 2014, Method A: 4-point average, complementary filter",
        attitude="quaternion-ekf",
        height="complementary",
        conditioning="average",
        attitude_settings=_QUATERNION_EKF,
        height_settings=_sg14(0.30, "A"),
    ),
    Preset(
        "sg14-b",
        "Sabatini & Genovese 2014, Method B: average and whitening filter, complementary filter",
        attitude="quaternion-ekf",
        height="complementary",
        conditioning="average+whitening",
        attitude_settings=_QUATERNION_EKF,
        height_settings=_sg14(0.15, "B"),
    ),
    Preset(
        "lee16",
        "Lee 2016: tilt Kalman filter, complementary filter with zero-velocity updates",
        attitude="tilt-kalman",
        height="complementary",
        attitude_settings=_LEE16_TILT,
        height_settings={**_LEE16_HEIGHT, **_LEE16_ZUPT},
    ),
    Preset(
        "lee16-kf",
        "Lee 2016: tilt Kalman filter, two-state Kalman filter with zero-velocity updates",
        attitude="tilt-kalman",
        height="kalman",
        attitude_settings=_LEE16_TILT,
        height_settings={**_LEE16_HEIGHT, **_LEE16_ZUPT},
    ),
    Preset(
        "zihajehzadeh15",
        "Zihajehzadeh et al. 2015: tilt Kalman filter, two-state Kalman filter",
        attitude="tilt-kalman",
        height="kalman",
        attitude_settings=_LEE16_TILT,
        height_settings=_LEE16_HEIGHT,
    ),
    Preset(
        "tanigawa08",
        "Tanigawa et al. 2008: two-state Kalman filter (tilt filter in place of their proprietary one)",
        attitude="tilt-kalman",
        height="kalman",
        attitude_settings=_LEE16_TILT,
        height_settings={
            "acceleration_sd": Constant(0.8 * MG, "printed", "SG14 Sec. 4 quotes sigma_w"),
            "altitude_sd": Constant(1.0, "printed", "SG14 Sec. 4 quotes sigma_v"),
        },
    ),
    Preset(
        "sonoh15",
        "Son & Oh 2015: tightly coupled, accelerometer bias and scale",
        attitude=None,
        height="inertial-ekf",
        height_settings={
            "accel_bias_sd": Constant(0.1, "chosen", "10 mg: a consumer accelerometer's offset"),
            "accel_scale_sd": Constant(0.01, "chosen", "1 %: a consumer accelerometer's scale"),
        },
    ),
    Preset(
        "zhang12",
        "Zhang et al. 2012: tightly coupled, gyro and accelerometer bias, barometer baseline (no UWB radio)",
        attitude=None,
        height="inertial-ekf",
        height_settings={
            "accel_bias_sd": Constant(0.1, "chosen", "10 mg: a consumer accelerometer's offset"),
            "gyro_bias_sd": Constant(0.005, "chosen", "0.3 deg/s left after bias capture"),
            "baseline_sd": Constant(0.3, "chosen", "error of a second's mean of coloured noise"),
        },
    ),
    Preset(
        "bourke08",
        "Bourke et al. 2008, off-line: strapdown between quasi-static periods, de-drifted",
        attitude=None,
        height=None,
    ),
)

PRESETS: Final[Mapping[str, Preset]] = MappingProxyType({preset.name: preset for preset in _ALL})
"""All presets by name, ours first."""


def find_preset(name: str) -> Preset:
    """Return a preset by name.

    Raises
    ------
    ValueError
        If there is none; the message lists them.

    Examples
    --------
    >>> preset = find_preset("sg14-a")
    >>> preset.attitude, preset.conditioning, preset.height
    ('quaternion-ekf', 'average', 'complementary')
    """
    if name not in PRESETS:
        raise ValueError(f"there is no preset {name!r}; there are {', '.join(PRESETS)}")
    return PRESETS[name]
