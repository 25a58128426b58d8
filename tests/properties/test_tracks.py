"""What must not matter to a track, and what must matter in proportion."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from baroarma import NoiseModel, Recording, Tracker, identify
from baroarma.atmosphere import altitude_pressure
from baroarma.estimators import attitude_estimator, height_estimator
from baroarma.simulation import BMP085, simulate
from baroarma.testing import attitude_samples, height_samples

spec = importlib.util.spec_from_file_location("strategies", Path(__file__).with_name("strategies.py"))
drawn = importlib.util.module_from_spec(spec)
spec.loader.exec_module(drawn)

GATE = 5
seeds = st.integers(0, 10_000)
motions = st.builds(
    lambda motion, seed: simulate(motion, duration=8, seed=seed),
    st.sampled_from(["rest", "squat", "walk", "lift", "circle"]),
    seeds,
)
HEIGHTS = ["complementary", "kalman", "coloured-kalman", "differenced-kalman"]


def tracked(preset, recording, **options):
    return Tracker.preset(preset, noise=BMP085.noise, **options).run(recording)


def apart(one, other):
    """Largest difference of heights (m) and velocities (m/s)."""
    return max(np.abs(one.height - other.height).max(), np.abs(one.velocity - other.velocity).max())


@pytest.mark.parametrize("preset", drawn.ONLINE)
def test_the_origin_of_time_does_not_matter(preset):
    @drawn.examples(GATE)
    @given(motions, st.floats(-1e6, 1e6))
    def holds(recording, origin):
        later = replace(recording, t=recording.t + origin)
        # a double near 1e6 s knows an interval to 1e-10 s; speeds and accelerations are of the order of 10
        assert apart(tracked(preset, later), tracked(preset, recording)) < 1e-7

    holds()


INVARIANT = {
    # Lee's filter has no preferred axis, nor has ours without the gyro's scale: rounding, times 400 rows.
    **dict.fromkeys(["lee16", "lee16-kf", "zihajehzadeh15", "tanigawa08"], ({}, 1e-9)),
    "baroarma": ({"attitude_settings": {"scale_sd": 0.0}}, 1e-9),
    # The gyro's scale is an error of each axis, 1 %; what a turn of 10 rad tells of it depends on the axes:
    # 6e-5 measured on the rod, 4e-8 in a walk.
    "baroarma with scale": ({}, 1e-3),
    # Biases of all axes alike; the EKF linearises in body axes: (1 degree)² of its prior, at 1 m/s.
    "zhang12": ({}, 1e-3),
}


@pytest.mark.parametrize("name", INVARIANT)
def test_the_mounting_does_not_matter(name):
    options, tolerance = INVARIANT[name]

    @drawn.examples(GATE)
    @given(motions, drawn.rotations)
    def holds(recording, turn):
        preset = name.split()[0]
        turned = turned_by(recording, turn)
        assert apart(tracked(preset, turned, **options), tracked(preset, recording, **options)) < tolerance

    holds()


def turned_by(recording, turn):
    accel, gyro = (turn.apply(np.array(values)) for values in (recording.accel, recording.gyro))
    return replace(recording, accel=accel, gyro=gyro)


@pytest.mark.parametrize(
    ("preset", "motion"), [("sg14-a", "circle"), ("sg14-b", "circle"), ("sonoh15", "rest")]
)
def test_where_the_paper_prefers_axes_the_mounting_matters(preset, motion):
    """SG14's gate takes or rejects components (Eq. 17); Son and Oh's scale errors belong to axes."""
    recording = simulate(motion, duration=8, seed=1)
    worst = max(
        apart(tracked(preset, turned_by(recording, turn)), tracked(preset, recording))
        for turn in drawn.Rotation.random(3, rng=1)
    )
    assert worst > 1e-3


@drawn.examples()
@given(seeds, drawn.angles)
def test_the_heading_of_a_reference_does_not_matter(seed, heading):
    samples = attitude_samples(seed, n=50)
    north = drawn.Rotation.from_rotvec([0.0, 0.0, heading])
    turned = (north * drawn.Rotation.from_quat(samples["attitude"])).as_quat()
    one = attitude_estimator("reference").run(**samples)
    other = attitude_estimator("reference").run(**{**samples, "attitude": turned})
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12)


OVERSHOOT = 2.0
"""Sum of the sizes of a height filter's response to one altitude; 1.1 for Higgins' gains."""


@pytest.mark.parametrize("preset", drawn.COMPILED)
def test_weather_only_changes_the_scale(preset):
    """30 hPa more or less: what a pascal is worth changes by 0.81 times 3 %, and so does all that follows."""

    @drawn.examples(GATE)
    @given(motions, st.floats(-3000.0, 3000.0))
    def holds(recording, weather):
        other = replace(recording, pressure=recording.pressure + weather)
        seen = np.ptp(recording.height())
        share = 0.81 * abs(weather) / (recording.pressure.min() + min(weather, 0.0))
        # 1 % of the share: the ISA's own bend over the metres of a climb
        limit = OVERSHOOT * 1.01 * share * seen + 1e-9
        track, there = tracked(preset, recording), tracked(preset, other)
        assert np.abs(there.height - track.height).max() <= limit
        # a velocity follows the altitude no faster than the filter's rate, 1/s at most here
        assert np.abs(there.velocity - track.velocity).max() <= 2 * limit

    holds()


@pytest.mark.parametrize("name", HEIGHTS)
def test_going_down_is_going_up_upside_down(name):
    @drawn.examples()
    @given(seeds, st.booleans())
    def holds(seed, rests):
        samples = height_samples(seed)
        n = len(samples["t"])
        at_rest = np.arange(n) > n // 2 if rests else None
        flipped = {k: -v if k in ("altitude", "acceleration") else v for k, v in samples.items()}
        one, other = (
            height_estimator(name, noise=BMP085.noise, dt=0.02).run(**s, at_rest=at_rest)
            for s in (samples, flipped)
        )
        # not a bit of difference: every operation is odd in the samples
        np.testing.assert_array_equal(other.height, -one.height)
        np.testing.assert_array_equal(other.velocity, -one.velocity)
        np.testing.assert_array_equal(other.height_sd, one.height_sd)

    holds()


def split(samples):
    """Rows in the middle of every interval: the IMU's sample again, no altitude, half of the time."""
    n = len(samples["t"])
    out = {name: np.repeat(values, 2, axis=0)[:-1] for name, values in samples.items()}
    t = samples["t"]
    out["t"][1::2] = (t[1:] + t[:-1]) / 2
    out["altitude"][1::2] = np.nan
    assert len(out["t"]) == 2 * n - 1
    return out


@pytest.mark.parametrize("name", HEIGHTS)
def test_without_altitudes_one_step_is_two_half_steps(name):
    """A held acceleration is integrated exactly; the midpoint's first half step holds the old one.

    Midpoint: (a + b)/2 dt becomes a dt/2 + (a + b)/2 dt/2, less by (b - a) dt/4; over equal steps these sum
    up to (a_n - a_0) dt/4.
    """

    @drawn.examples()
    @given(seeds)
    def holds(seed):
        rng = np.random.default_rng(seed)
        n, dt = 100, 0.02
        a = rng.normal(size=n)
        samples = {"t": dt * np.arange(n), "altitude": np.full(n, np.nan), "acceleration": a}
        settings = {} if name in ("complementary", "kalman") else {"unresolved": 0.0}
        one, two = (height_estimator(name, noise=BMP085.noise, dt=dt, **settings) for _ in range(2))
        whole, halves = one.run(**samples), two.run(**split(samples))
        off = halves.velocity[::2] - whole.velocity
        expected = np.zeros(n) if name in ("complementary", "kalman") else -(a - a[0]) * dt / 4
        np.testing.assert_allclose(off, expected, atol=1e-12)
        # its integral: half a step's share of the sum, and of the row itself
        limit = 1e-12 + dt * np.abs(expected).sum() + dt * np.abs(expected).max()
        assert np.abs(halves.height[::2] - whole.height).max() <= limit

    holds()


@pytest.mark.parametrize("name", ["kalman", "coloured-kalman"])
def test_with_altitudes_two_half_steps_of_the_same_density_are_nearly_one(name):
    """Noise of sd s a sample over dt is noise of s sqrt(2) a sample over dt/2; what is left is second order.

    The gains follow from P, whose terms differ by (dt/tau)² = (0.02/1.4)² = 2e-4 of themselves.
    """

    @drawn.examples()
    @given(seeds)
    def holds(seed):
        rng = np.random.default_rng(seed)
        n, dt, sd = 200, 0.02, 0.15
        samples = {
            "t": dt * np.arange(n),
            "altitude": rng.normal(scale=0.5, size=n),
            "acceleration": np.repeat(rng.normal(), n),
            "acceleration_sd": np.full(n, sd),
        }
        halves = split(samples)
        halves["acceleration_sd"][:] *= np.sqrt(2)
        one, two = (height_estimator(name, noise=BMP085.noise, dt=dt) for _ in range(2))
        whole, parts = one.run(**samples), two.run(**halves)
        size = np.abs(whole.height).max() + np.abs(whole.velocity).max()
        np.testing.assert_allclose(parts.height[::2], whole.height, atol=1e-3 * size)
        np.testing.assert_allclose(parts.velocity[::2], whole.velocity, atol=1e-3 * size)
        np.testing.assert_allclose(parts.velocity_sd[::2], whole.velocity_sd, rtol=1e-3)

    holds()


@drawn.examples(3)
@given(seeds, st.sampled_from([0.25, 0.5, 2.0, 4.0]))
def test_a_noise_k_times_as_large_has_a_model_k_times_as_large(seed, k):
    t = np.arange(6000) / 50
    noise = NoiseModel(0.27, 0.75, 0.46, 0.02, rate_hz=50).simulate(t, seed)
    one, other = (
        identify(
            Recording(t=t, pressure=altitude_pressure(scale * noise)), terms=("white", "gm", "drift")
        ).model
        for scale in (1.0, k)
    )
    for name in ("correlated_sd", "white_sd", "drift_rate"):
        # the optimiser stops where the likelihood is flat: a thousandth of a standard error, 10 % or so
        low, high = one.ci95[name]
        tolerance = 1e-3 * k * (high - low) + 1e-9
        assert getattr(other, name) == pytest.approx(k * getattr(one, name), abs=tolerance)
    low, high = one.ci95["correlation_time"]
    assert other.correlation_time == pytest.approx(one.correlation_time, abs=1e-3 * (high - low))
