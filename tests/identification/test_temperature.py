"""A temperature without its reading's noise: what smoothing and the low-pass filter do to known courses."""

import numpy as np

from baroarma.identification.temperature import SMOOTHED, lagged

AT = np.arange(0.0, 300.0, 0.25)
INSIDE = np.linspace(100.0, 200.0, 77)


def test_smoothing_leaves_lines_and_parabolas_as_they_are():
    line, bend = 0.03 * AT + 20, -((AT - 150) ** 2) / 2000
    found = lagged(AT, line, 0.0, INSIDE)
    np.testing.assert_allclose(found, 0.03 * INSIDE + 20, rtol=0, atol=1e-10)
    # with f'' = 1e-3, each of two interpolations between seconds may miss f''/8, a second's mean f''/24
    found = lagged(AT, bend, 0.0, INSIDE)
    np.testing.assert_allclose(found, -((INSIDE - 150) ** 2) / 2000, rtol=0, atol=1e-3 * (2 / 8 + 1 / 24))


def test_smoothing_takes_the_readings_noise_away():
    noise = np.random.default_rng(0).normal(size=len(AT))
    # a parabola through 21 seconds of 4 readings: the sd of its middle is sqrt(9/4 / 84)
    assert np.std(lagged(AT, noise, 0.0, AT[100:-100])) < 1.5 * np.sqrt(9 / 4 / (4 * SMOOTHED))


def test_a_lagged_ramp_is_the_ramp_some_seconds_later():
    lag, slope = 15.0, 0.05
    found = lagged(AT, slope * AT, lag, INSIDE)
    # exp(-100/15) of the start is left; a filter of 1 s steps is late by lag, give or take half a step
    np.testing.assert_allclose(
        found, slope * (INSIDE - lag), rtol=0, atol=slope * (0.63 + lag * np.exp(-100 / lag))
    )


def test_a_gap_is_bridged_by_a_line():
    there = (AT < 120) | (AT > 180)
    found = lagged(AT[there], 0.03 * AT[there], 0.0, INSIDE)
    np.testing.assert_allclose(found, 0.03 * INSIDE, rtol=0, atol=1e-10)


def test_beyond_its_ends_a_temperature_stays_what_it_was():
    early, first, last, late = lagged(AT, 20 + 0.1 * AT, 0.0, np.array([-50.0, 0.0, 300.0, 350.0]))
    assert early == first
    assert late == last
