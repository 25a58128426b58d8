"""How late a barometer is, found by the likelihood of a log with motion."""

import numpy as np
import pytest

from baroarma.barometer_lag import HALF_CHI2, BarometerLag, estimate_barometer_lag
from baroarma.simulation import DEVICES, simulate
from baroarma.simulation.devices import BMP390, WIMU, Device
from baroarma.tracker import Tracker

NOISE = BMP390.noise
LATE = (BMP390.iir - 1) / BMP390.rate_hz
"""Group delay at frequency 0 of y += (x - y)/c: (c - 1)/rate, 0.06 s."""


def squats(seed, device="bmp390-bmi270", **options):
    return simulate("squat", duration=30, device=device, seed=seed, **options)


def estimate(log):
    return estimate_barometer_lag(log, NOISE, attitude="reference")


@pytest.fixture(scope="module")
def matched():
    """Estimates from squats without pauses, seen by an accelerometer with noise and bias only."""
    return [estimate(squats(seed, Device(BMP390, WIMU), pause=0)) for seed in range(20)]


def test_the_interval_covers_the_recursive_filters_delay_as_often_as_it_says(matched):
    covered = sum(found.ci95[0] <= LATE <= found.ci95[1] for found in matched)
    assert covered >= 17  # of 20 at 95 %; fewer happen in 1.6 % of cases


def test_the_estimate_is_that_delay_on_average(matched):
    seconds = [found.seconds for found in matched]
    # three standard errors of the mean, by the spread itself
    assert np.mean(seconds) == pytest.approx(LATE, abs=3 * np.std(seconds, ddof=1) / np.sqrt(20))
    assert all(found.ci95[0] <= found.seconds <= found.ci95[1] for found in matched)


def test_the_likelihood_falls_by_what_chi_squared_says_at_the_intervals_ends():
    log = squats(1)
    found = estimate(log)

    def evidence(lag):
        settings = {"barometer_lag": lag, "gate": np.inf}
        tracker = Tracker(noise=NOISE, attitude="reference", height_settings=settings)
        tracker.run(log)
        return tracker.estimator.evidence

    top = evidence(found.seconds)
    assert found.gain == pytest.approx(top - evidence(0.0), abs=1e-6)
    for end in found.ci95:
        # the ends are found to a millisecond, where the likelihood falls by some 0.2 in one
        assert top - evidence(end) == pytest.approx(HALF_CHI2, abs=0.3)


def test_knowing_the_lag_steadies_the_track():
    squares = []
    for seed in range(4):
        log = squats(seed, pause=0)
        squares.append(
            [
                np.mean(
                    (
                        Tracker(noise=NOISE, attitude="reference", height_settings={"barometer_lag": lag})
                        .run(log)
                        .velocity
                        - log.reference_velocity
                    )
                    ** 2
                )
                for lag in (0.0, LATE)
            ]
        )
    without, known = np.mean(squares, axis=0)
    assert known < without


def test_a_rest_cannot_tell():
    found = estimate(simulate("rest", duration=30, device="bmp390-bmi270", seed=0))
    assert found.ci95 == (0.0, found.longest)
    assert found.verdict() == "this log has too little vertical motion to tell; log some squats or stairs"


def test_a_barometer_without_filter_has_none_that_shows():
    device = Device(DEVICES["lps22hb-bmi270"].barometer, WIMU)
    log = squats(3, device, pause=0)
    found = estimate_barometer_lag(log, device.barometer.noise, attitude="reference")
    assert found.ci95[0] == 0.0
    assert found.ci95[1] < LATE
    assert found.verdict().startswith("none that this log shows; at most 0.0")


def test_without_an_imu_it_says_why_not():
    with pytest.raises(ValueError, match="rest has no IMU, against which a barometer could be late"):
        estimate(simulate("rest", duration=5, imu=None, seed=0))


def test_it_tells_its_own_story():
    found = BarometerLag(0.0612, (0.043, 0.0789), 12.3, 1.0)
    assert repr(found) == "<BarometerLag 0.061 s [0.043, 0.079]: pass barometer_lag=0.061>"
