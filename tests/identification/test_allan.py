import numpy as np
import pytest

from baroarma.identification.allan import allan_deviation
from baroarma.noise_model import NoiseModel

T = np.arange(30000) / 50
NOISE = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)


def test_the_band_contains_the_models_deviation_in_95_percent_or_a_little_more():
    inside = []
    for seed in range(30):
        found = allan_deviation(T, NOISE.simulate(T, seed))
        model = NOISE.allan_deviation(found.tau)
        inside.append((found.low < model) & (model < found.high))
    # Neighbouring averaging times share data: some 12 * 30 / 2 independent draws, 3 sds are 5 %.  The band is
    # meant to be rather wide, for the smaller of two degrees of freedom was taken.
    assert 0.90 <= np.mean(inside) <= 0.995
    assert found.tau[0] == pytest.approx(0.02)
    assert found.tau[-1] <= 600 / 8


def test_the_deviation_is_half_the_mean_square_of_adjacent_differences():
    x = np.random.default_rng(1).normal(size=500)
    found = allan_deviation(np.arange(500) / 10, x)
    averages = np.convolve(x, np.full(4, 0.25), mode="valid")
    by_hand = np.sqrt(np.mean((averages[4:] - averages[:-4]) ** 2) / 2)
    assert found.tau[2] == pytest.approx(0.4)
    assert found.deviation[2] == pytest.approx(by_hand, rel=1e-9)


def test_white_noise_falls_with_the_root_of_the_averaging_time():
    found = allan_deviation(T, 0.46 * np.random.default_rng(2).normal(size=30000))
    expected = 0.46 / np.sqrt(found.tau * 50)
    assert np.mean((found.low < expected) & (expected < found.high)) >= 10 / 12


def test_only_the_longest_stretch_without_a_gap_is_used():
    keep = (T < 100) | (T > 105)
    x = NOISE.simulate(T, 3)
    found = allan_deviation(T[keep], x[keep])
    alone = allan_deviation(T[T > 105], x[T > 105])
    assert found.duration == pytest.approx(494.96)
    np.testing.assert_array_equal(found.deviation, alone.deviation)


def test_a_large_offset_does_not_matter():
    x = NOISE.simulate(T, 4)
    # allantools sums heights up: 3e4 sums of 3e4 m would cost digits, which starting from 0 saves.
    np.testing.assert_allclose(
        allan_deviation(T, x + 3e4).deviation, allan_deviation(T, x).deviation, rtol=1e-8
    )


def test_a_short_record_is_refused():
    with pytest.raises(ValueError, match="has 10 samples; an Allan deviation needs 16"):
        allan_deviation(np.arange(10.0), np.arange(10.0))
