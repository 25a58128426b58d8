"""The whitening filter, batch and sample by sample."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy import signal

from baroarma import NoiseModel
from baroarma.whitening import WhiteningFilter, WhiteningStream, no_whitening, synthesise

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


def test_the_response_is_computed_in_double_precision():
    w, f = NOISE.whitening_filter(), np.float32([0.3, 4.7])
    assert np.array_equal(w.response(f), w.response(f.astype(float)))
    assert np.array_equal(w(f), w(f.astype(float)))
    assert NoiseModel(0, 0, 0.4, rate_hz=50).whitening_filter()(f).dtype == float


def test_a_signal_has_one_dimension_and_may_lack_every_sample():
    w = NOISE.whitening_filter()
    with pytest.raises(ValueError, match=r"the signal has shape \(2, 3\); a one-dimensional one is needed"):
        w(np.zeros((2, 3)))
    assert np.isnan(w([np.nan, np.nan])).all()
    assert len(w([])) == 0


def test_a_stream_of_any_order_is_lfilter_from_its_steady_state():
    # SciPy's own steady state is lfilter_zi
    b, a = signal.butter(3, 0.2)
    for numerator, denominator in ((b, a), (b, (1.0,)), ((0.4,), a)):
        x = np.random.default_rng(1).normal(size=40) + 5
        start = signal.lfilter_zi(numerator, denominator) * x[0]
        expected = signal.lfilter(numerator, denominator, x, zi=start)[0]
        stream = WhiteningStream(tuple(numerator), tuple(denominator))
        assert [stream.step(v) for v in x] == pytest.approx(expected, abs=1e-12)  # rounding


def test_settings_that_can_not_be_are_named():
    for rate in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(ValueError, match=f"the rate must be a positive number of Hz, but it is {rate:g}"):
            synthesise(tau_p=0.7, tau_o=0.1, rate_hz=rate, unity_gain_hz=0.0)
    for frequency in (-0.1, 10.5, np.nan):
        with pytest.raises(ValueError, match=f"unity gain at {frequency:g} Hz is impossible at a rate of 20"):
            synthesise(tau_p=0.7, tau_o=0.1, rate_hz=20, unity_gain_hz=frequency)
        with pytest.raises(ValueError, match="choose a frequency from 0 to 10 Hz"):
            no_whitening(rate_hz=20, unity_gain_hz=frequency, note="")
    half = synthesise(tau_p=0.7, tau_o=0.1, rate_hz=0.5, unity_gain_hz=0.25)
    assert abs(half.response(0.25)) == pytest.approx(1)


def test_a_note_makes_no_other_filter():
    w = synthesise(tau_p=0.7, tau_o=0.1, rate_hz=20, unity_gain_hz=10, note="By hand.")
    assert w.note == "By hand."
    assert w == synthesise(tau_p=0.7, tau_o=0.1, rate_hz=20, unity_gain_hz=10)
    assert synthesise(tau_p=0.7, tau_o=0.1, rate_hz=20, unity_gain_hz=10).note == ""
    assert WhiteningFilter((1.0,), (1.0,), 20.0, 10.0).note == ""


def test_a_filter_of_whole_numbers_holds_floats():
    w = no_whitening(rate_hz=20, unity_gain_hz=10, note="Nothing.")
    assert [type(v) for v in (w.rate_hz, w.unity_gain_hz, *w.b, *w.a)] == [float] * 4
    assert (w.rate_hz, w.unity_gain_hz, w.note) == (20.0, 10.0, "Nothing.")
    assert repr(w) == "<WhiteningFilter at 20 Hz: 1 (nothing to whiten)>"
    w = synthesise(tau_p=0.7, tau_o=0.1, rate_hz=20, unity_gain_hz=3)
    assert [type(v) for v in (w.rate_hz, w.unity_gain_hz)] == [float] * 2


def test_the_dictionary_is_the_documented_object():
    w = NOISE.whitening_filter(unity_gain_hz=10)
    assert w.to_dict() == {
        "b": list(w.b),
        "a": list(w.a),
        "rate_hz": 50.0,
        "unity_gain_hz": 10.0,
        "dc_gain": pytest.approx(abs(w.response(0.0))),
        "zero_hz": pytest.approx(1 / (2 * np.pi * 0.75)),
        "pole_hz": w.pole_hz,
    }


def told(w):
    return {line[:18].strip(): line[18:] for line in w.summary().splitlines()[1:]}


def test_the_summary_tells_coefficients_and_price():
    w = NOISE.whitening_filter(unity_gain_hz=10)
    assert w.summary().startswith(f"{w!r}\n  b ")
    assert told(w) == {
        "b": f"{w.b[0]:.6g}, {w.b[1]:.6g}",
        "a": f"1, {w.a[1]:.6g}",
        "gain 1 at": "10 Hz",
        "gain at DC": f"{w.dc_gain:.4g}: of a climb by 10 m, {10 * w.dc_gain:.3g} m are left",
        "zero": f"{w.zero_hz:.4g} Hz",
        "pole": f"{w.pole_hz:.4g} Hz",
    }
    white = NoiseModel(0, 0, 0.4, rate_hz=50).whitening_filter()
    assert told(white) == {
        "b": "1",
        "a": "1",
        "gain 1 at": "25 Hz",
        "gain at DC": "1: of a climb by 10 m, 10 m are left",
        "note": white.note,
    }
    html = w._repr_html_()
    for cell in ("Whitening filter at 50 Hz", ">what<", ">value<", ">gain 1 at<", ">10 Hz<"):
        assert cell in html


def test_it_is_drawn_where_it_is_told():
    ax = Figure().subplots()
    assert NOISE.whitening_filter().plot(ax) is ax
    assert ax.lines
