"""Clocks, rates, low-pass filters and loggers do what their formulas say."""

import numpy as np
import pytest
from scipy import signal

from baroarma.simulation.streams import Clock, low_passed, poll, sample_times

LOG = np.arange(500) / 50


def test_a_sensor_at_the_logs_rate_is_logged_as_it_is():
    assert sample_times(LOG, None) is LOG
    assert np.array_equal(poll(LOG, LOG, LOG**2, held=False), LOG**2)


@pytest.mark.parametrize("rate", [3.0, 6.8, 10.0, 12.5, 33.0])
def test_a_slower_sensor_is_held_or_left_out_between_its_samples(rate):
    stamps = sample_times(LOG, rate)
    assert np.diff(stamps) == pytest.approx(1 / rate)
    held, blank = (poll(LOG, stamps, stamps, held) for held in (True, False))
    new = np.isfinite(blank)
    assert new.sum() == len(stamps)  # no sample is lost, none comes twice
    assert np.array_equal(held[new], blank[new])
    age = LOG - held
    assert age.min() > -1e-9
    assert age.max() < 1 / rate
    assert (LOG - blank)[new].max() < 1 / 50  # a new sample is logged in the next row


def test_a_faster_sensor_loses_the_samples_in_between():
    stamps = sample_times(LOG, 200.0)
    assert poll(LOG, stamps, stamps, held=False) == pytest.approx(LOG)


def test_vectors_are_polled_row_by_row():
    logged = poll(LOG, LOG[::2], np.stack((LOG[::2], -LOG[::2]), axis=1), held=False)
    assert np.array_equal(logged[::2, 1], -LOG[::2])
    assert np.isnan(logged[1::2]).all()


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan")])
def test_a_rate_that_cannot_be_is_refused(rate):
    with pytest.raises(ValueError, match="a sensor's rate_hz must be above 0"):
        sample_times(LOG, rate)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("frequency", [1.0, 5.0, 20.0])
def test_the_low_pass_filter_has_the_response_of_butterworths(order, frequency):
    w, cutoff = 2 * np.pi * frequency, 8.0
    # 2 s are 16 cycles of the cut-off: what is left of the start is below e^-16 of it for the slowest pole
    steady = LOG > 2
    basis = np.exp(1j * w * LOG[steady])
    out = low_passed(lambda t: np.sin(w * t), LOG, Clock(), cutoff, order)[steady]
    b, a = signal.butter(order, 2 * np.pi * cutoff, analog=True)
    response = signal.freqs(b, a, [w])[1][0]
    # the bilinear transform bends frequencies by (pi f / fs)²/3 of themselves: 0.5 % at 20 of 500 Hz, less
    # its bend at the cut-off, where it is exact; two orders make 1 % of it
    assert out == pytest.approx((response * basis).imag, abs=0.01 * abs(response))


def test_the_low_pass_filter_begins_settled_and_leaves_a_constant_alone():
    out = low_passed(lambda t: np.full((len(t), 3), 9.8), LOG, Clock(), 8.0, 2)
    assert out == pytest.approx(np.full((500, 3), 9.8), abs=1e-12)


def test_a_cut_off_far_above_the_rate_changes_nothing():
    out = low_passed(lambda t: np.sin(t), LOG, Clock(), 5000.0, 2)
    # a second-order Butterworth filter delays by sqrt(2) / (2 pi f), which is 45 us; the bilinear transform
    # at ten times the cut-off shortens that by (pi / 10)²/3, which is 3 % or 1.5 us; the start is settled
    assert out[1:] == pytest.approx(np.sin(LOG[1:] - np.sqrt(2) / (2 * np.pi * 5000)), abs=2e-6)


def test_the_clock_says_when_a_stamp_really_was():
    at = np.polynomial.Polynomial([1, 2, 3])
    clock = Clock(offset=0.25, skew=1e-3)
    assert low_passed(at, LOG, clock, None, 2) == pytest.approx(at(1.001 * LOG + 0.25))
