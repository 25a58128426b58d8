"""The conditioning block: averages of new samples, then the whitening filter."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import lfilter

from baroarma.arma import ArmaModel
from baroarma.estimators.conditioning import CONDITIONINGS, Conditioner, conditioner_of, sg14_whitening
from baroarma.noise_model import NoiseModel

RNG = np.random.default_rng(1)


def test_the_average_is_taken_over_new_samples_only():
    z = RNG.normal(size=300)
    z[RNG.random(300) < 0.4] = np.nan
    out, new = Conditioner(average=4).run(z), np.isfinite(z)
    assert np.array_equal(np.isfinite(out), new)
    kept = z[new]
    expected = [kept[max(k - 3, 0) : k + 1].mean() for k in range(len(kept))]
    assert out[new] == pytest.approx(expected, abs=1e-12)


def test_method_b_is_the_average_through_scipys_filter():
    z = RNG.normal(size=400)
    whitening = sg14_whitening(None, 50.0)
    average = Conditioner(average=4).run(z)
    start = (np.array(whitening.b[1:]) - np.array(whitening.a[1:]) * whitening.dc_gain) * average[0]
    expected = lfilter(whitening.b, whitening.a, average, zi=start)[0]
    assert Conditioner(average=4, whitening=whitening).run(z) == pytest.approx(expected, abs=1e-12)


def test_step_is_run():
    z = np.where(RNG.random(200) < 0.3, np.nan, RNG.normal(size=200))
    one, other = (conditioner_of("average+whitening", None, 25.0) for _ in range(2))
    assert np.array_equal(one.run(z), [other.step(value) for value in z], equal_nan=True)


@pytest.mark.parametrize("name", CONDITIONINGS)
def test_a_second_run_goes_on_where_the_first_ended(name):
    z = np.where(RNG.random(200) < 0.3, np.nan, RNG.normal(size=200))
    whole, parts = (conditioner_of(name, None, 25.0) for _ in range(2))
    expected = whole.run(z)
    cuts = [0, 2, 3, 3, 100, 200]  # within the first average, and an empty part
    together = np.concatenate([parts.run(z[i:j]) for i, j in pairwise(cuts)])
    assert np.array_equal(together, expected, equal_nan=True)
    assert parts.step(1.0) == whole.step(1.0)


def test_the_papers_filter_has_the_papers_dc_gain():
    # SG14 Sec. 3.2 and SG13 Table 5: 0.21, at 50 Hz with unity gain at 25 Hz
    assert sg14_whitening(None, 50.0).dc_gain == pytest.approx(0.21, abs=0.005)
    assert sg14_whitening(None, 50.0).unity_gain_hz == 25


def test_the_papers_filter_has_its_zero_and_pole_where_their_coefficients_put_them():
    # tau = T/2 (1 - a)/(1 + a) with T = 0.1 s, a = -0.87 and b = -0.50 (method of SG13, Sec. 2.2)
    found = sg14_whitening(None, 50.0)
    assert found.zero_hz == pytest.approx(1 / (2 * np.pi * 0.05 * 1.87 / 0.13), rel=1e-9)
    assert found.pole_hz == pytest.approx(1 / (2 * np.pi * 0.05 * 1.50 / 0.50), rel=1e-9)


def test_the_choices_are_no_conditioning_method_a_and_method_b():
    step = np.concatenate([np.zeros(8), np.ones(8)])
    found = {name: conditioner_of(name, None, 50.0).run(step) for name in CONDITIONINGS}
    ramp = np.clip((np.arange(16) - 7) / 4, 0, 1)
    whitening = sg14_whitening(None, 50.0)
    whitened = lfilter(whitening.b, whitening.a, ramp)
    expected = {"none": step, "average": ramp, "average+whitening": whitened}
    assert found.keys() == expected.keys()
    for name, out in found.items():
        np.testing.assert_allclose(out, expected[name], atol=1e-14)


def test_an_identified_noise_gives_its_own_filter_at_the_barometers_rate():
    noise = NoiseModel(0.2, 1.0, 0.3, rate_hz=50)
    assert sg14_whitening(noise, 10.0) == noise.whitening_filter(rate_hz=10.0, unity_gain_hz=5.0)
    assert conditioner_of("average+whitening", noise, 10.0).whitening == sg14_whitening(noise, 10.0)


def test_conditioned_noise_is_white_once_decimated():
    noise = NoiseModel(0.27, 0.75, 0.46, rate_hz=50)
    z = noise.simulate(np.arange(100_000) / 50, np.random.default_rng(3))
    x = conditioner_of("average+whitening", noise, 50.0).run(z)[::5]
    r = np.corrcoef(x[1:], x[:-1])[0, 1]
    # 20 000 values: sd of a correlation 0.007; before whitening it is 0.5
    assert abs(r) < 0.03
    raw = conditioner_of("average", noise, 50.0).run(z)[::5]
    assert np.corrcoef(raw[1:], raw[:-1])[0, 1] > 0.4


def test_nothing_is_done_when_nothing_is_asked_for():
    z = np.array([1.0, np.nan, -2.0])
    conditioner = conditioner_of("none", ArmaModel, 50.0)  # the noise is not even looked at
    assert np.array_equal(conditioner.run(z), z, equal_nan=True)
    assert conditioner.whitening is None


def test_what_is_farther_than_any_barometer_works_is_no_sample():
    assert np.array_equal(Conditioner().run(np.array([0.0, -35_000.0])), [0.0, -35_000.0])
    altitude = np.array([1.0, 44_300.0, 3.0, -2e5, 4.0, 35_000.5])  # 0 Pa and 1e9 Pa from a broken transfer
    for average in (1, 2):
        whole, rows = Conditioner(average=average), Conditioner(average=average)
        out = whole.run(altitude)
        np.testing.assert_array_equal(np.isnan(out), [False, True] * 3)
        np.testing.assert_array_equal(out, [rows.step(float(z)) for z in altitude])
