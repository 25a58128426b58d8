"""The whitening filter, batch and sample by sample."""

import numpy as np
import pytest
from scipy import signal

from baroarma import NoiseModel
from baroarma.whitening import synthesise

NOISE = NoiseModel(0.27, 0.75, 0.46, rate_hz=50)


@pytest.mark.parametrize("unity_gain_hz", [0, 0.3, 5, 25])
def test_gain_is_one_where_it_was_asked_for(unity_gain_hz):
    w = NOISE.whitening_filter(unity_gain_hz=unity_gain_hz)
    assert abs(w.response(unity_gain_hz)) == pytest.approx(1, abs=1e-12)


def test_unity_gain_beyond_nyquist_is_refused_with_the_range():
    with pytest.raises(ValueError, match="choose a frequency from 0 to 25 Hz"):
        NOISE.whitening_filter(unity_gain_hz=25.1)


def test_response_is_scipys():
    w = NOISE.whitening_filter()
    frequency, gain = signal.freqz(w.b, w.a, 64, fs=50)
    assert w.response(frequency) == pytest.approx(gain)


def test_zero_and_pole_come_back_from_the_coefficients():
    w = synthesise(tau_p=0.7, tau_o=0.1, rate_hz=20, unity_gain_hz=3)
    assert (w.zero_hz, w.pole_hz) == pytest.approx((1 / (2 * np.pi * 0.7), 1 / (2 * np.pi * 0.1)))


@pytest.mark.parametrize(
    "noise", [NOISE, NoiseModel(0.27, 0.75, 0.0, rate_hz=50), NoiseModel(0, 0, 0.4, rate_hz=50)]
)
def test_stream_is_the_batch(noise):
    w = noise.whitening_filter(unity_gain_hz=10)
    x = np.random.default_rng(0).normal(size=500)
    x[[0, 3, 4, 200]] = np.nan
    stream = w.stream()
    assert np.allclose(w(x), [stream.step(v) for v in x], rtol=0, atol=1e-13, equal_nan=True)


def test_a_constant_gives_its_steady_state_from_the_first_sample():
    w = NOISE.whitening_filter()
    assert w(np.full(50, 7.0)) == pytest.approx(7 * w.dc_gain)


def test_white_noise_needs_no_whitening_and_says_so():
    w = NoiseModel(0, 0, 0.4, 0.01, rate_hz=50).whitening_filter()
    assert (w.b, w.a, w.zero_hz) == ((1.0,), (1.0,), None)
    assert "no Gauss-Markov" in w.note
    x = np.arange(5.0)
    assert w(x).tolist() == x.tolist()


def test_pure_gauss_markov_noise_becomes_exactly_white():
    noise = NoiseModel(0.3, 0.5, 0.0, rate_hz=50)
    w = noise.whitening_filter(unity_gain_hz=25)
    spectrum = noise.psd(np.linspace(0.1, 25, 30)) * np.abs(w.response(np.linspace(0.1, 25, 30))) ** 2
    assert spectrum == pytest.approx(spectrum[0])


def test_whitened_noise_is_white():
    # the bilinear transform bends frequencies near Nyquist, where the noise is white already: 1 % is its size
    frequency = np.linspace(0.01, 25, 400)
    spectrum = NOISE.psd(frequency) * np.abs(NOISE.whitening_filter().response(frequency)) ** 2
    assert spectrum == pytest.approx(spectrum.mean(), rel=0.01)


@pytest.mark.parametrize("white_sd", [1e-9, 0.005, 0.02, 0.05])
@pytest.mark.parametrize(("correlation_time", "rate_hz"), [(0.1, 10), (0.75, 50), (0.3, 15)])
def test_next_to_no_white_noise_does_not_make_the_filter_ring(white_sd, correlation_time, rate_hz):
    noise = NoiseModel(0.27, correlation_time, white_sd, rate_hz=rate_hz)
    w = noise.whitening_filter()
    frequency = np.linspace(0.01, rate_hz / 2, 400)
    spectrum = noise.psd(frequency) * np.abs(w.response(frequency)) ** 2
    assert -w.a[1] > -1e-9  # the pole is at a positive place: a step dies out without changing sign
    # the sampled process undone is white to rounding; the density's formula is off by a third where it takes
    # over, at tau_o of half an interval
    assert spectrum == pytest.approx(spectrum.mean(), rel=1 / 3)


def test_a_correlation_far_shorter_than_the_interval_leaves_nothing_to_whiten():
    w = NoiseModel(0.07, 0.0127, 0.19, rate_hz=60).whitening_filter(rate_hz=0.1)
    assert w([1.0, -2.0, 5.0]) == pytest.approx([1.0, -2.0, 5.0])
