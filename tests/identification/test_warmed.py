"""The result of a warm-up, by hand: what it is called, what is said of it, what is taken out."""

import json

import numpy as np
import pytest

from baroarma import Recording
from baroarma.atmosphere import altitude_pressure, metres_per_pascal
from baroarma.identification.warmed import WarmUp

T = np.arange(0.0, 300.0, 0.5)
EFFECT = 2.0 * np.exp(-T / 60) - 2.0 * np.exp(-T[-1] / 60)
REST = Recording(T, altitude_pressure(100.0 + EFFECT), temperature=40 - 10 * np.exp(-T / 60), name="warmed")


def by_hand(**changed):
    usual = {
        "recording": REST,
        "cause": "temperature",
        "slope": -0.2,
        "ci95": (-0.25, -0.15),
        "ci95_beside_trend": (-0.3, -0.1),
        "lag": 0.0,
        "span": 10.0,
        "gain": 30.0,
        "jitter": 0.0,
        "jitter_sd": 0.0,
        "drift_rates": (0.05, 0.01),
        "effect": EFFECT,
    }
    return WarmUp(**{**usual, **changed})


@pytest.mark.parametrize(
    ("changed", "status", "words"),
    [
        ({}, "effect", "compensate()"),
        ({"ci95": (-0.25, 0.01)}, "none", "how large one could hide"),
        ({"span": 0.9}, "hardly-warmed", "changes by 0.9 K only"),
        ({"cause": "settling", "span": 0.9}, "effect", "compensate()"),  # its unit is no kelvin
        ({"ci95_beside_trend": (-0.3, 0.1)}, "not-separable", "relative_to"),
        ({"ci95_beside_trend": (-0.15, -0.1)}, "not-separable", "relative_to"),  # leaves the slope out
    ],
)
def test_the_status_follows_from_the_intervals_and_says_what_to_do(changed, status, words):
    run = by_hand(**changed)
    assert run.status == status
    assert words in run.verdict()
    assert run.summary().endswith(f"{status}: {run.verdict()}")


def test_the_slope_is_told_as_data_sheets_do():
    run = by_hand()
    metres = metres_per_pascal(float(np.median(REST.pressure)))
    assert run.pascal_per_kelvin == pytest.approx(0.2 / metres)
    assert f"{run.pascal_per_kelvin:+.3g} Pa/K" in run.summary()
    assert repr(run) == "<WarmUp of 'warmed': -0.2 m/K [-0.25, -0.15], +1.99 m at the start; effect>"
    settling = by_hand(cause="settling")
    assert settling.unit == "m"
    assert np.isnan(settling.pascal_per_kelvin)
    assert "Pa/K" not in settling.summary()


def test_lag_and_jitter_are_told_where_there_are_any():
    assert "time constant" not in by_hand().summary()
    assert "reading's own noise" not in by_hand().summary()
    run = by_hand(lag=12.5, jitter=-20.0, jitter_sd=0.2)
    assert "time constant 12.5 s" in run.summary()
    assert "0.2 m of the white noise" in run.summary()


def test_json_has_null_where_there_is_no_temperature():
    document = json.loads(json.dumps(by_hand(span=float("nan")).to_dict(), allow_nan=False))
    assert document["span_k"] is None
    assert document["slope"] == -0.2
    assert document["ci95"] == [-0.25, -0.15]
    assert document["status"] == "effect"


def test_what_is_taken_out_is_the_effect_and_a_note_says_so():
    compensated = by_hand().compensate()
    # altitude -> pressure -> altitude rounds in the 12th digit of 10^5 Pa
    np.testing.assert_allclose(compensated.height(), 100.0, rtol=0, atol=1e-6)
    assert [note.code for note in compensated.notes] == ["warm-up-compensated"]
    assert REST.notes == ()


def test_its_plot_shows_height_effect_and_temperature():
    ax = by_hand().plot()
    assert ax.get_legend().get_texts()[0].get_text() == "barometer"
    assert ax.get_title(loc="left").startswith("warmed: starts ")
    assert ax.figure.axes[1].get_ylabel() == "temperature (°C), dashed"
