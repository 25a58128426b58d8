"""Devices by name: the sensors of the papers, and today's.

Where nothing else is said the numbers are typical values of the data sheets, quoted from memory and therefore
approximate.  What no data sheet says is chosen by us: the drift of the pressure (the weather indoors), slow
drifts of the biases, what a calibration leaves of bias and scale, and the bandwidths, set for logs of 50 Hz.

White noise is given as a density d; behind a second-order low-pass filter of bandwidth B its sd per sample is
d sqrt(1.11 B).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians, sqrt
from typing import Final

from baroarma.atmosphere import STANDARD_GRAVITY, metres_per_pascal
from baroarma.noise_model import NoiseModel
from baroarma.simulation.sensors import Barometer, Imu, Triad

BANDWIDTH: Final = 20.0
"""Of accelerometers and gyros in Hz, unless said otherwise: logs at 50 Hz are then hardly aliased."""
INDOOR_DRIFT: Final = 0.01
"""Drift of the pressure altitude in a room, m/sqrt(s)."""
METRES: Final = metres_per_pascal(100_000.0)
"""Metres of height per Pa near the ground."""


@dataclass(frozen=True)
class Device:
    """Hold the sensors of a device; `imu` None: only a barometer.

    Examples
    --------
    A barometer of one's own, with twelve samples a second:

    >>> from baroarma.simulation import simulate
    >>> noise = NoiseModel(correlated_sd=0.1, correlation_time=2.0, white_sd=0.2, rate_hz=12.5)
    >>> mine = Device(Barometer(noise, quantum=0.5, rate_hz=12.5, held=False))
    >>> simulate("rest", duration=10, device=mine, seed=1)
    <Recording 'rest': 500 rows, 9.98 s, pressure 125 samples at 12.5 Hz, reference>
    """

    barometer: Barometer
    imu: Imu | None = None


def _white(sensor: str, noise_pa: float, rate_hz: float) -> NoiseModel:
    return NoiseModel(0.0, 0.0, noise_pa * METRES, INDOOR_DRIFT, rate_hz=rate_hz, sensor=sensor)


def _triad(counts_per_unit: float, limit: float, scale_sd: float, drift_sd: float, to_si: float) -> Triad:
    """Return three axes from data-sheet units, of which one is `to_si` in SI."""
    return Triad(
        scale_sd=scale_sd,
        drift_sd=drift_sd * to_si,
        limit=limit * to_si,
        quantum=to_si / counts_per_unit,
        bandwidth_hz=BANDWIDTH,
    )


def _imu(
    accel_density: float, gyro_density: float, bias: tuple[float, float], triads: tuple[Triad, Triad]
) -> Imu:
    """Return an IMU from noise densities (g and degrees/s per sqrt(Hz)) and bias spreads (g, degrees/s)."""
    noise_bandwidth = sqrt(1.11 * BANDWIDTH)
    return Imu(
        accel_sd=accel_density * noise_bandwidth * STANDARD_GRAVITY,
        gyro_sd=radians(gyro_density * noise_bandwidth),
        accel_bias_sd=bias[0] * STANDARD_GRAVITY,
        gyro_bias_sd=radians(bias[1]),
        accel=triads[0],
        gyro=triads[1],
    )


BMP085: Final = Barometer(
    NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50.0, sensor="BMP085, ultra-low power"), quantum=1.0
)
"""SG13: conditioned sigma_c, tau and 1 Pa printed (Tables 1-2, Sec. 2.3); raw white sd and drift chosen by us
so that those tables come out."""
WIMU: Final = Imu(
    accel_sd=2.5e-3 * STANDARD_GRAVITY,
    gyro_sd=radians(0.15),
    accel_bias_sd=2e-3 * STANDARD_GRAVITY,
    gyro_bias_sd=radians(0.5),
)
"""BMA180 and ITG-3200 of SG13 and SG14, noise and bias only; all chosen by us."""

BMA180_ITG3200: Final = _imu(
    # BMA180: 150 ug/sqrt(Hz), 14 bit on +-16 g; calibrated in the field (SG14 Sec. 2.4), 2 mg and 0.3 % left.
    # ITG-3200: 0.03 degrees/s/sqrt(Hz), +-2000 degrees/s, 14.375 counts per degree/s.
    150e-6,
    0.03,
    (2e-3, 0.5),
    (_triad(512, 16, 3e-3, 3e-4, STANDARD_GRAVITY), _triad(14.375, 2000, 0.01, 0.02, radians(1))),
)
BMP180: Final = Barometer(
    # 0.06 hPa rms in ultra-low power, 0.03 in ultra-high resolution, +-1 hPa absolute, steps of 1 Pa; Lee16's
    # Table 1 prints its ranges and 128 Hz.  The mode is not told; here ultra-high resolution, about 25 Hz.
    _white("BMP180, ultra-high resolution", 3.0, 25.0),
    quantum=1.0,
    offset_sd=100.0,
    lowest=30_000.0,
    highest=110_000.0,
    rate_hz=25.0,
)
MPU6050: Final = _imu(
    # 400 ug/sqrt(Hz), 0.005 degrees/s/sqrt(Hz), +-3 % scale, +-50 mg, +-20 degrees/s before any calibration;
    # here as levelled once on a table (10 mg, 1 %), gyro as switched on.  +-4 g and +-500 degrees/s, 16 bit.
    400e-6,
    0.005,
    (10e-3, 2.0),
    (_triad(8192, 4, 0.01, 5e-4, STANDARD_GRAVITY), _triad(65.5, 500, 0.01, 0.02, radians(1))),
)
BMP390: Final = Barometer(
    # 300 to 1250 hPa, +-50 Pa absolute, steps of 0.016 Pa, 0.02 Pa rms at best (looked up); without filter
    # about 0.9 Pa at 50 Hz.  The recursive filter's 4 is that of its settings for handheld devices.
    _white("BMP390, standard resolution", 0.9, 50.0),
    quantum=1 / 64,
    offset_sd=50.0,
    lowest=30_000.0,
    highest=125_000.0,
    iir=4.0,
    rate_hz=50.0,
)
LPS22HB: Final = Barometer(
    # 260 to 1260 hPa, at most 75 Hz (looked up); 0.75 Pa rms, 4096 counts per hPa, +-100 Pa absolute.
    _white("LPS22HB, low noise", 0.75, 75.0),
    quantum=100 / 4096,
    offset_sd=100.0,
    lowest=26_000.0,
    highest=126_000.0,
    rate_hz=75.0,
)
MS5611: Final = Barometer(
    # 0.012 mbar rms at an oversampling of 4096, which takes 9 ms, as long as the temperature between two
    # pressures; +-1.5 mbar absolute; 10 to 1200 mbar; the compensated output has steps of 0.01 mbar.
    _white("MS5611, oversampling 4096", 1.2, 50.0),
    quantum=1.0,
    offset_sd=150.0,
    lowest=1_000.0,
    highest=120_000.0,
    rate_hz=50.0,
)
BMI270: Final = _imu(
    # 160 ug/sqrt(Hz), 0.007 degrees/s/sqrt(Hz) (looked up), +-20 mg, +-0.5 degrees/s; set to +-8 g and
    # +-1000 degrees/s.
    160e-6,
    0.007,
    (20e-3, 0.5),
    (_triad(4096, 8, 4e-3, 2e-4, STANDARD_GRAVITY), _triad(32.8, 1000, 4e-3, 5e-3, radians(1))),
)
ICM42688: Final = _imu(
    # 70 ug/sqrt(Hz), 0.0028 degrees/s/sqrt(Hz), 0.5 % scale, +-20 mg, +-0.5 degrees/s; set to +-16 g and
    # +-1000 degrees/s.
    70e-6,
    0.0028,
    (20e-3, 0.5),
    (_triad(2048, 16, 5e-3, 1e-4, STANDARD_GRAVITY), _triad(32.8, 1000, 5e-3, 3e-3, radians(1))),
)

DEVICES: Final = {
    "simple": Device(BMP085, WIMU),
    "wimu": Device(BMP085, BMA180_ITG3200),
    "gy-87": Device(BMP180, MPU6050),
    "bmp390-bmi270": Device(BMP390, BMI270),
    "bmp390-icm42688": Device(BMP390, ICM42688),
    "lps22hb-bmi270": Device(LPS22HB, BMI270),
    "lps22hb-icm42688": Device(LPS22HB, ICM42688),
    "ms5611-icm42688": Device(MS5611, ICM42688),
}
"""Devices by the name that users type: "simple" has noise and bias only, "wimu" is SG13's and SG14's, "gy-87"
Lee16's, the others are named after their chips."""
