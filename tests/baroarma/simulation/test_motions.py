"""True motions: what ideal sensors feel integrates back to the truth, and follows the papers' equations."""

import re
from math import pi, sqrt

import numpy as np
import pytest
from numba import njit
from scipy.integrate import cumulative_trapezoid
from scipy.spatial.transform import Rotation

from baroarma.rotation import angle_between, up_from_quaternion
from baroarma.simulation.motions import DURATIONS, MOTIONS, REST_BEFORE, move, options_of

G = 9.80665
THREE_MINUTES = 180.0


@njit
def strapdown(t, force, rate, up):
    """Height from force and rate: the mean of two rates, linear acceleration; second order in the step."""
    height = np.zeros(len(t))
    x, y, z = up  # the vertical in the sensor's axes is all that height needs
    velocity, before = 0.0, x * force[0, 0] + y * force[0, 1] + z * force[0, 2] - G
    for k in range(1, len(t)):
        dt = t[k] - t[k - 1]
        a, b, c = -0.5 * (rate[k] + rate[k - 1]) * dt
        angle = np.sqrt(a * a + b * b + c * c)
        if angle > 0:  # Rodrigues' formula
            one, two = np.sin(angle) / angle, (1 - np.cos(angle)) / angle**2
            u, v, w = b * z - c * y, c * x - a * z, a * y - b * x
            x += one * u + two * (b * w - c * v)
            y += one * v + two * (c * u - a * w)
            z += one * w + two * (a * v - b * u)
        now = x * force[k, 0] + y * force[k, 1] + z * force[k, 2] - G
        height[k] = height[k - 1] + velocity * dt + (2 * before + now) * dt**2 / 6
        velocity += 0.5 * (before + now) * dt
        before = now
    return height


def height_error(truth):
    up = up_from_quaternion(truth.attitude[0])
    return np.abs(strapdown(truth.t, truth.force, truth.rate, up) - truth.height).max()


def true_motion(motion, t, seed=0, **options):
    return move(motion, t, np.random.default_rng(seed), **options)


def fine_times(motion, until=THREE_MINUTES):
    """Every 2 ms; 1 ms for squats that start and stop, 0.5 ms for the sway about three axes, 0.1 ms for the
    impact that ramps up by 4000 m/s³."""
    if motion == "free-fall":
        return np.concatenate(
            (np.arange(0, 7.9, 2e-3), np.arange(7.9, 9.9, 1e-4), np.arange(9.9, until, 2e-3))
        )
    return np.arange(0, until, {"walk": 5e-4, "squat": 1e-3}.get(motion, 2e-3))


def in_body_axes(truth, vector):
    """Undo the mounting: bodies begin with the axes of the world."""
    return Rotation.from_quat(truth.attitude[0]).apply(vector)


def tilt(truth):
    up = up_from_quaternion(truth.attitude)
    return angle_between(up, up[0])


@pytest.mark.parametrize("motion", MOTIONS)
def test_integrating_perfect_sensors_returns_the_true_height_for_three_minutes(motion):
    assert height_error(true_motion(motion, fine_times(motion))) < 1e-3  # 1 mm, as promised


def test_what_the_integration_misses_is_the_integrators_second_order():
    errors = [height_error(true_motion("walk", np.arange(0, 60, step))) for step in (4e-3, 2e-3, 1e-3)]
    # halving the step quarters the error; 5 %: the next term, of fourth order, of the coarsest step
    assert np.divide(errors[:-1], errors[1:]) == pytest.approx(4, rel=0.05)


@pytest.mark.parametrize("motion", MOTIONS)
def test_height_velocity_and_acceleration_belong_together(motion):
    truth = true_motion(motion, fine_times(motion, 60))
    # the trapezoids' error is dt²/12 times the integral of the third derivative's modulus: 2 ms, 60 s,
    # 25 m/s³; less for the impact with its 0.1 ms, 0.1 s and 10 000 m/s³
    for low, high in ((truth.height, truth.velocity), (truth.velocity, truth.acceleration)):
        assert np.abs(cumulative_trapezoid(high, truth.t, initial=0) - low).max() < 5e-4


@pytest.mark.parametrize("motion", sorted(set(MOTIONS) - {"rest"}))
def test_the_acceleration_has_no_jumps(motion):
    def largest_change(step):
        return np.abs(np.diff(true_motion(motion, np.arange(0, 40, step)).force, axis=0)).max()

    # a jump would be as large at any step; what is continuous changes half as much in half the time
    assert largest_change(5e-4) == pytest.approx(0.5 * largest_change(1e-3), rel=0.05)


@pytest.mark.parametrize("motion", MOTIONS)
def test_every_motion_begins_with_rest(motion):
    truth = true_motion(motion, np.linspace(-1, REST_BEFORE, 50))
    assert not truth.height.any()
    assert not truth.rate.any()
    assert truth.force == pytest.approx(np.tile(truth.force[0], (50, 1)), abs=1e-12)


@pytest.mark.parametrize("motion", DURATIONS)
def test_a_motion_that_ends_has_ended_by_its_duration(motion):
    truth = true_motion(motion, np.linspace(DURATIONS[motion] - 5, DURATIONS[motion], 50))
    assert np.abs(truth.velocity).max() < 1e-14  # rounding of the last quintic
    assert not truth.rate.any()


@pytest.mark.parametrize("seed", range(20))
def test_a_resting_sensor_feels_gravity_upwards_in_any_mounting(seed):
    truth = true_motion("rest", np.arange(3.0), seed)
    up = Rotation.from_quat(truth.attitude).apply(truth.force)
    assert up == pytest.approx(np.tile((0, 0, G), (3, 1)), abs=1e-12)
    assert truth.force == pytest.approx(G * up_from_quaternion(truth.attitude), abs=1e-12)


@pytest.mark.parametrize("frequency", [0.25, 0.5, 0.75, 1.0, 1.25, 1.5])
def test_the_specific_force_on_the_circle_is_that_of_the_paper(frequency):
    """SG14 Eqs. 33 and 36, with gravity's sign turned: the paper's z axis points down."""
    t, arm, w = np.linspace(10, 20, 1000), 0.3, 2 * pi * frequency
    truth = true_motion("circle", np.concatenate(([0.0], t)), frequency_hz=frequency)
    angle = w * (t - REST_BEFORE - 1.0)  # half of the two seconds of spinning up is lost
    expected = np.stack((0 * t, G * np.sin(angle) - w**2 * arm, G * np.cos(angle)), axis=1)
    assert in_body_axes(truth, truth.force)[1:] == pytest.approx(expected, abs=1e-10)
    assert in_body_axes(truth, truth.rate)[1:] == pytest.approx(np.tile((w, 0, 0), (1000, 1)), abs=1e-10)
    assert truth.height[1:] == pytest.approx(arm * np.sin(angle), abs=1e-12)


def test_a_falling_body_feels_nothing_for_as_long_as_the_paper_says():
    t = np.arange(7, 12, 1e-4)
    truth = true_motion("free-fall", t)
    feels = np.linalg.norm(truth.force, axis=1)
    start, stop = np.flatnonzero(np.diff((feels < 1e-9).astype(int)))[:2]
    # SG14 Eq. 30 counts from rest: letting go takes 20 ms, of which half is lost
    assert t[stop] - t[start] == pytest.approx(sqrt(2 * 1.53 / G) - 0.01, abs=3e-4)
    assert truth.height[stop] == pytest.approx(-1.53, abs=1e-3)
    assert truth.height[-1] == pytest.approx(-1.53, abs=1e-12)
    assert truth.velocity[(t > t[stop]) & (t < t[stop] + 0.15)].max() > 1.5  # it rebounds


def test_the_mattress_pushes_within_16_g_and_never_pulls():
    truth = true_motion("free-fall", np.arange(8, 12, 1e-4))
    assert truth.acceleration.min() > -G - 1e-9
    assert np.linalg.norm(truth.force, axis=1).max() < 16 * G


def test_squats_reach_the_depth_that_was_measured_and_stop_when_counted():
    t = np.arange(0, 40, 0.01)
    truth = true_motion("squat", t, count=3)
    minima = (np.diff(np.sign(np.diff(truth.height))) > 0) & (truth.height[1:-1] < -0.3)
    assert minima.sum() == 3
    assert truth.height.min() == pytest.approx(-0.60, abs=1e-4)  # SG14 Sec. 3.4
    assert tilt(truth).max() == pytest.approx(0.4, abs=1e-4)
    assert truth.height[-1] == pytest.approx(0, abs=1e-12)
    assert not truth.velocity[t > REST_BEFORE + 3 * (4 + 1 + 5)].any()


def test_stairs_rest_on_each_of_three_floors_of_the_papers_height():
    t = np.arange(0, 100, 0.01)
    truth = true_motion("stairs", t)
    resting = np.abs(truth.rate).max(axis=1) == 0
    for floor in range(4):
        there = resting & (np.abs(truth.height - 1.7 * floor) < 1e-9)  # SG13 Sec. 2.4
        assert there.sum() * 0.01 >= 15
    assert truth.velocity.min() > -0.05  # upwards only, but for the swing of the waist


@pytest.mark.parametrize("speed", [0.1, 0.2, 1.0])
def test_a_lift_goes_at_its_speed_between_its_floors(speed):
    t = np.arange(0, 300, 0.05)
    truth = true_motion("lift", t, speed=speed)
    assert (truth.height.min(), truth.height.max()) == (0, pytest.approx(12))
    up = np.isclose(truth.velocity, speed, rtol=1e-12)
    # 12 m, of which starting and stopping take half of 1.5 s each at that speed
    first = up & (t < REST_BEFORE + 12 / speed + 2)
    assert first.sum() * 0.05 == pytest.approx(12 / speed - 1.5, abs=0.1)


def test_a_walker_bounces_with_the_step_and_turns_the_corner():
    t = np.arange(0, 22, 0.01)
    truth = true_motion("walk", t)
    steady = t > REST_BEFORE + 1
    # amplitude 2.5 cm at 2 Hz; the waist in front of the trunk's axis adds 10 cm times the nodding of 25 mrad
    assert np.ptp(truth.height[steady]) == pytest.approx(0.05, abs=0.005)
    heading = Rotation.from_quat(truth.attitude) * Rotation.from_quat(truth.attitude[0]).inv()
    yaw = np.unwrap(heading.as_euler("ZYX")[:, 0])
    assert yaw[(t > 17) & (t < 21)].mean() - yaw[(t > 7) & (t < 15)].mean() == pytest.approx(pi / 2, abs=0.01)


@pytest.mark.parametrize(("test", "top"), [("a", 3.5), ("b", 3.0), ("c", 3.0), ("d", 1.5), ("e", 0.6)])
def test_lees_movements_have_the_printed_extent(test, top):
    truth = true_motion(f"lee16-{test}", np.arange(0, 50, 0.01))
    assert (truth.height.min(), truth.height.max()) == (pytest.approx(0), pytest.approx(top))
    assert truth.height[-1] == pytest.approx(0, abs=1e-12)


def test_lees_first_movement_tilts_by_45_degrees_on_the_way_only():
    truth = true_motion("lee16-a", np.arange(0, 50, 0.01))
    assert np.degrees(tilt(truth).max()) > 45
    top = truth.height > 3.5 - 1e-9
    assert top.sum() * 0.01 == pytest.approx(10, abs=0.5)  # "about 10 seconds"; the last mm take a while
    assert tilt(truth)[top].max() < 0.01


def test_lees_third_movement_is_faster_than_the_second():
    b, c = (np.abs(true_motion(f"lee16-{k}", np.arange(0, 50, 0.01)).velocity).max() for k in "bc")
    assert c > 1.5 * b


@pytest.mark.parametrize(
    ("motion", "options", "sentence"),
    [
        ("hover", {}, "motion 'hover' is unknown; choose one of circle, free-fall"),
        ("rest", {"depth": 1}, "motion 'rest' has no option 'depth'; it has none"),
        ("squat", {"deep": 1}, "no option 'deep'; it has depth, period, tilt, pause, count"),
        ("squat", {"period": 0}, "period of the motion 'squat' must be a number above 0, but it is 0"),
        ("squat", {"count": 1.5}, "must be a whole number above 0, but it is 1.5"),
        ("squat", {"tilt": -0.1}, "must be a number that is not negative, but it is -0.1"),
        ("lift", {"speed": float("nan")}, "speed of the motion 'lift' must be a number above 0"),
        ("lift", {"speed": "fast"}, "must be a number above 0, but it is 'fast'"),
        ("lee16-a", {"levels": 3}, "must be a list of numbers, but it is 3"),
        ("lee16-a", {"levels": [1, "high"]}, "must be a list of numbers, but it is [1, 'high']"),
        ("free-fall", {"rebound": 0.1}, "doesn't leave the mattress"),
        ("free-fall", {"height": 0.001}, "needs a height of at least 0.01 m"),
    ],
)
def test_what_is_no_motion_is_refused_with_what_there_is(motion, options, sentence):
    with pytest.raises(ValueError, match=re.escape(sentence)):
        true_motion(motion, np.arange(3.0), **options)


@pytest.mark.parametrize("motion", MOTIONS)
def test_every_option_changes_the_motion(motion):
    t = np.arange(0, 120, 0.1)
    plain = true_motion(motion, t)
    for name, value in options_of(motion).items():
        other = 2 if value is None else value[:1] if isinstance(value, tuple) else value * 2
        if name == "rebound":
            other = 0.5
        changed = true_motion(motion, t, **{name: other})
        assert not np.array_equal(plain.force, changed.force), name
