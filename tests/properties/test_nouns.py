"""Properties of the values that flow: what holds for all of them, not for three examples."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from baroarma import NoiseModel, Recording, Track
from baroarma.arma import gauss_markov_arma
from baroarma.atmosphere import altitude_pressure, metres_per_pascal, pressure_altitude
from baroarma.metrics import errors
from baroarma.rotation import angle_between, skew, up_from_quaternion

spec = importlib.util.spec_from_file_location("strategies", Path(__file__).with_name("strategies.py"))
drawn = importlib.util.module_from_spec(spec)
spec.loader.exec_module(drawn)

EPS = np.finfo(float).eps
signals = arrays(float, st.integers(2, 50), elements=st.floats(-1e4, 1e4))


@drawn.examples()
@given(drawn.noise_models())
def test_a_noise_model_survives_json_exactly(noise):
    again = NoiseModel.from_dict(json.loads(json.dumps(noise.to_dict(), allow_nan=False)))
    assert again == noise
    assert again.to_dict() == noise.to_dict()


@drawn.examples()
@given(drawn.noise_models(), drawn.rates)
def test_a_change_of_rate_keeps_the_density_and_can_be_undone(noise, rate_hz):
    other = noise.at_rate(rate_hz)
    # a square root, a square and two products: some units in the last place
    assert other.white_density == pytest.approx(noise.white_density, rel=8 * EPS)
    assert other.at_rate(noise.rate_hz).white_sd == pytest.approx(noise.white_sd, rel=8 * EPS)
    assert (other.correlated_sd, other.drift_rate) == (noise.correlated_sd, noise.drift_rate)


@drawn.examples()
@given(drawn.arma11())
def test_an_arma_model_is_what_its_components_make(model):
    parts = model.split("exact")
    assert parts.correlated_sd**2 + parts.white_sd**2 == pytest.approx(model.autocovariance(0)[0], rel=1e-9)
    again = gauss_markov_arma(**parts._asdict(), dt=model.dt)
    # near a = -1 the variance is (1 - a²) of what the terms are: three digits of sixteen go there
    assert again.ar == pytest.approx(model.ar, rel=1e-12)
    assert again.ma == pytest.approx(model.ma, rel=1e-9)
    assert again.sd == pytest.approx(model.sd, rel=1e-9)


@drawn.examples()
@given(drawn.arma11())
def test_time_constants_lead_back_to_the_coefficients(model):
    tau_p, tau_o = model.time_constants()
    assert tau_p > tau_o > 0
    coefficients = [(1 - 2 * tau / model.dt) / (1 + 2 * tau / model.dt) for tau in (tau_p, tau_o)]
    assert coefficients == pytest.approx([*model.ar, *model.ma], rel=1e-9)


@drawn.examples()
@given(drawn.arma11(), signals, st.floats(0.0, 1.0))
def test_whitening_undoes_shaping(model, x, share):
    w = model.whitening_filter(rate_hz=1 / model.dt, unity_gain_hz=share / 2 / model.dt)
    from scipy.signal import lfilter

    shaped = lfilter(w.a, w.b, x)  # the inverse, from rest; a leading zero is the whitening's own rest
    there = w(np.concatenate([[0.0], shaped]))[1:]
    # the inverse's sum of up to 1000 terms loses three digits
    np.testing.assert_allclose(there, x, atol=1e-9 * (1 + np.abs(x).max()) * max(1.0, np.abs(shaped).max()))


@drawn.examples()
@given(drawn.arma11(), signals)
def test_a_whitening_stream_is_the_filter(model, x):
    w = model.whitening_filter(rate_hz=1 / model.dt, unity_gain_hz=0)
    stream = w.stream()
    np.testing.assert_allclose([stream.step(v) for v in x], w(x), rtol=1e-9, atol=1e-9 * np.abs(x).max())


@drawn.examples()
@given(st.floats(-1000.0, 30_000.0))
def test_pressure_is_the_altitude_s_inverse(height):
    # what a double keeps of (1 - h/H)^5.26, times the scale height
    assert float(pressure_altitude(altitude_pressure(height))) == pytest.approx(height, abs=44_331 * 16 * EPS)


@drawn.examples()
@given(st.floats(30_000.0, 110_000.0), st.floats(-3000.0, 3000.0), st.floats(-30.0, 30.0))
def test_weather_only_changes_the_scale_of_a_climb(pressure, weather, climb):
    """30 hPa of weather make a climb longer or shorter by the ratio of what a pascal is worth."""
    assume(30_000 < pressure + weather < 110_000)
    top = float(altitude_pressure(float(pressure_altitude(pressure)) + climb))
    other = float(pressure_altitude(top + weather) - pressure_altitude(pressure + weather))
    ratio = metres_per_pascal(pressure + weather) / metres_per_pascal(pressure)
    # the second derivative of the ISA: 0.81/p times the difference of the pressures, of both climbs
    bend = 2 * abs(climb) * abs(top - pressure) / min(pressure, pressure + weather)
    assert other == pytest.approx(climb * ratio, abs=bend + 1e-9)
    # near the ground -0.81 x 3 %
    if pressure > 95_000:
        assert abs(ratio - 1) < 0.81 * abs(weather) / min(pressure, pressure + weather) + 1e-12


@drawn.examples()
@given(drawn.rotations, drawn.angles)
def test_the_vertical_knows_no_heading(rotation, heading):
    from scipy.spatial.transform import Rotation

    turned = Rotation.from_rotvec([0.0, 0.0, heading]) * rotation
    up = up_from_quaternion(rotation.as_quat())
    assert np.linalg.norm(up) == pytest.approx(1.0, abs=8 * EPS)
    np.testing.assert_allclose(up_from_quaternion(turned.as_quat()), up, atol=8 * EPS)
    np.testing.assert_allclose(rotation.apply(up), [0, 0, 1], atol=16 * EPS)


@drawn.examples()
@given(drawn.rotations, st.floats(1e-8, np.pi - 1e-3))
def test_the_angle_between_is_the_angle_of_the_turn(rotation, angle):
    from scipy.spatial.transform import Rotation

    a = rotation.apply([0.0, 0.0, 1.0])
    across = np.cross(a, rotation.apply([1.0, 0.0, 0.0]))
    b = Rotation.from_rotvec(angle * across).apply(a)
    assert float(angle_between(a, 3.0 * b)) == pytest.approx(angle, abs=16 * EPS)
    np.testing.assert_allclose(skew(a) @ b, np.cross(a, b), atol=4 * EPS)


@drawn.examples()
@given(drawn.streams(), st.integers(0, 92), st.floats(0.0, 1.0))
def test_parts_of_a_recording_are_the_recording(recording, cut, share):
    cut = min(cut, len(recording))
    middle = float(recording.t[0] + share * recording.duration)
    for parts in (
        [recording.rows(slice(cut)), recording.rows(slice(cut, None))],
        [recording.between(-np.inf, middle), recording.between(middle, np.inf)],
    ):
        assert sum(map(len, parts)) == len(recording)
        for name in ("t", "pressure", "accel", "gyro"):
            whole = np.concatenate([getattr(part, name) for part in parts])
            np.testing.assert_array_equal(whole, getattr(recording, name))


@drawn.examples()
@given(signals, st.floats(-100.0, 100.0), st.floats(-1e3, 1e3))
def test_errors_are_blind_to_the_zero_and_see_all_else(off, zero, velocity_off):
    n = len(off)
    t, height = np.arange(n) / 50 + 1.0, np.cumsum(np.ones(n))
    t = np.concatenate([np.arange(50) / 50, t])
    true = np.concatenate([np.zeros(50), height])
    rec = Recording(t=t, pressure=np.full(n + 50, 1e5), reference=true, reference_velocity=0 * true)
    track = Track(
        t, true + zero + np.concatenate([np.zeros(50), off]), 0 * t + velocity_off, *np.ones((3, n + 50))
    )
    found = errors(track, rec)
    # subtracting the mean of 50 zeros costs their rounding
    assert found.height_rmse == pytest.approx(
        np.sqrt(np.sum(off**2) / (n + 50)), abs=1e-9 * (1 + np.abs(off).max())
    )
    assert found.height_bias == pytest.approx(np.sum(off) / (n + 50), abs=1e-9 * (1 + np.abs(off).max()))
    assert found.velocity_rmse == pytest.approx(abs(velocity_off), rel=1e-9)
