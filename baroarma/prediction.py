"""The accuracy of a preset before any experiment: sds of height and velocity over time, from the noise alone.

The covariance of the errors is propagated with the *true* noise (`error_propagation`), whatever the filter
takes for true: where that is the truth, as in `coloured-kalman`, this is its Riccati recursion; for `kalman`
and `complementary` it is what white noise leaves out.  Assumed are a device that rests during the alignment,
and motion that the accelerometer resolves: the error then does not depend on the motion, but for the tilt.

Left out is what is not linear: zero-velocity rules, rests, outliers.  With rests the errors are smaller.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from baroarma.error_propagation import Propagation, propagate
from baroarma.error_sources import SAME_RATE, Errors
from baroarma.estimators import height_estimator
from baroarma.estimators.base import Alignment
from baroarma.estimators.conditioning import AVERAGE, conditioner_of
from baroarma.estimators.height.complementary import Complementary
from baroarma.estimators.height.linear import LinearHeight
from baroarma.imu_noise import ImuNoise
from baroarma.noise_model import NoiseModel
from baroarma.predicted import Prediction
from baroarma.presets import Preset, find_preset
from baroarma.recording import Recording
from baroarma.tracker import ALIGNMENT


def predict_accuracy(
    noise: NoiseModel,
    imu: ImuNoise | Recording | str = "simple",
    preset: str = "baroarma",
    duration: float = 180.0,
    *,
    height_settings: Mapping[str, Any] | None = None,
    horizontal_acceleration: float = 0.0,
) -> Prediction:
    """Predict the errors of height and vertical velocity.

    Parameters
    ----------
    noise : NoiseModel
        The barometer's noise; it is slower than the IMU if its rate is lower.
    imu : ImuNoise, Recording or str
        The IMU's noise, a motionless recording that shows it, or the name of a simulated device.
    preset : str
        A chain with a linear height filter.
    duration : float
        Length of the run in s, its first second being the alignment.
    height_settings : mapping, optional
        Settings of the height filter that differ from the preset's, as for `Tracker`.
    horizontal_acceleration : float
        Rms of the horizontal acceleration in m/s², such as 1 when walking.  An attitude filter's tilt error
        brings its share into the vertical: the tilt of the accelerometer's and the gyro's bias and of the
        gyro's noise when levelled over 3 s, the acceleration with a correlation time of 1 s (both chosen by
        us).  0: rest or vertical motion.

    Returns
    -------
    Prediction
        Sds over time, their rms, and where they end if they do.

    Raises
    ------
    ValueError
        If it can't be predicted; the message says why.
    TypeError
        If noise or IMU are something else.

    Examples
    --------
    >>> bmp085 = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)
    >>> predict_accuracy(bmp085, "simple", "sg14-a")
    <Prediction for sg14-a: rms 0.339 m and 0.0849 m/s over 180 s>
    """
    if not isinstance(noise, NoiseModel):
        raise TypeError(
            f"noise is a NoiseModel, not {noise!r:.60}; NoiseModel.load reads one from a file, and what "
            "identify returns has it as its model"
        )
    chain = find_preset(preset)
    errors, rows = _errors(noise, _imu_noise(imu), chain, duration, horizontal_acceleration)
    height = _height_filter(chain, errors, height_settings or {})
    found = propagate(height, errors, rows)
    notes = tuple(_notes(chain, errors, height, found))
    t = np.arange(rows, dtype=np.float64) * errors.dt
    return Prediction(t, found.height_sd, found.velocity_sd, preset, noise, errors.imu, *found[2:], notes)


def _imu_noise(imu: ImuNoise | Recording | str) -> ImuNoise:
    if isinstance(imu, Recording):
        return ImuNoise.from_recording(imu)
    if isinstance(imu, str):
        return ImuNoise.of_device(imu)
    if not isinstance(imu, ImuNoise):
        raise TypeError(f"imu is an ImuNoise, a Recording or a device's name, not {imu!r:.60}")
    return imu


def _errors(
    noise: NoiseModel, imu: ImuNoise, chain: Preset, duration: float, horizontal_acceleration: float
) -> tuple[Errors, int]:
    """Return what drives the preset's height filter, and for how many rows."""
    if not (math.isfinite(horizontal_acceleration) and horizontal_acceleration >= 0):
        raise ValueError(
            f"the horizontal acceleration is an rms in m/s², 0 or more, but it is {horizontal_acceleration}"
        )
    barometer_hz = min(noise.rate_hz, imu.rate_hz)
    if barometer_hz * ALIGNMENT < 1 or not ALIGNMENT + 2 / barometer_hz <= duration < float("inf"):
        raise ValueError(
            f"a run of {duration:g} s with {barometer_hz:g} pressures in a second can't be predicted: its "
            f"first {ALIGNMENT:g} s align, with a pressure in them, and some must be left"
        )
    conditioner = conditioner_of(chain.conditioning, noise, barometer_hz)
    errors = Errors(
        noise,
        imu,
        average=1 if chain.conditioning == "none" else AVERAGE,
        whitening=conditioner.whitening,
        captured=chain.bias_capture,
        alignment=ALIGNMENT,
        horizontal_acceleration=horizontal_acceleration,
        rest=Alignment(
            accel_sd=imu.accel_sd,
            gyro_sd=imu.gyro_sd,
            gravity_sd=imu.accel_sd / math.sqrt(imu.rate_hz * ALIGNMENT),
        ),
    )
    return errors, round(duration * imu.rate_hz)


def _height_filter(
    chain: Preset, errors: Errors, settings: Mapping[str, Any]
) -> Complementary | LinearHeight:
    """Return the preset's height filter without its zero-velocity rule, or say why it can't be predicted."""
    if chain.height not in ("complementary", "kalman", "coloured-kalman"):
        raise ValueError(
            f"the errors of {chain.name!r} depend on the motion, for it is not a linear filter of the "
            "barometer; run it on simulated recordings instead"
        )
    beyond = [name for name in ("level_prior_sd", "floors") if settings.get(name)]
    if beyond:
        raise ValueError(
            f"what {beyond[0]} knows about the motion can't be predicted from the noise; leave it out"
        )
    own = {name: constant.value for name, constant in chain.height_settings.items()} | {"zupt_steps": 0}
    made = height_estimator(chain.height, noise=errors.noise, dt=errors.dt, **{**own, **settings})
    assert isinstance(made, Complementary | LinearHeight)
    return made


def _notes(
    chain: Preset, errors: Errors, height: Complementary | LinearHeight, found: Propagation
) -> list[str]:
    notes = []
    if found.steady_height_sd is None and errors.noise.drift_rate > 0:
        notes.append(
            "The height has no steady state: the altimeter's drift can't be told from height, and its sd "
            "grows without end."
        )
    if found.steady_velocity_sd is None:
        whole = errors.rows_per_sample % 1 == 0
        why = (
            "the filter's gains still change by the end of the run"
            if whole
            else "the rates have no whole ratio"
        )
        notes.append(f"No steady state is told: {why}.")
    if "zupt_steps" in chain.height_settings or chain.height == "coloured-kalman":
        notes.append(
            "Rests are left out, the alignment's own, too; where the device rests the errors are smaller."
        )
    if abs(errors.dc_gain - 1) > 1e-6:
        notes.append(
            f"The whitening filter reports a steady height change only {errors.dc_gain:.3g} times its size; "
            "what it takes from a motion comes on top of these errors."
        )
    if errors.noise.rate_hz > errors.imu.rate_hz * (1 + SAME_RATE):
        notes.append(
            f"The noise model describes pressures at {errors.noise.rate_hz:.4g} Hz, of which the rows at "
            f"{errors.imu.rate_hz:.4g} Hz take as many as they can."
        )
    if note := getattr(height, "note", ""):
        notes.append(note)
    return notes
