"""A climb is that of the motion, not of the noise, and its sd is honest."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import baroarma as ba
from baroarma.climbing import climb
from baroarma.simulation import BMP085, simulate
from baroarma.track import Track

SEEDS = range(12)


def exact(height, t=None, *, sd=0.0):
    """A track that knows its height up to `sd`, and nothing about its velocity's."""
    height = np.asarray(height, float)
    t = np.arange(len(height)) if t is None else t
    sds, zero = np.full(len(height), float(sd)), np.zeros(len(height))
    return Track(t, height, zero, sds, sds, zero, name="made")


@cache
def runs(motion, preset="baroarma", **options):
    """Tracks of a motion over seeds, each with the climb of the truth."""
    out = []
    for seed in SEEDS:
        log = simulate(motion, seed=seed, **{"duration": 120.0, **options})
        track = ba.Tracker.preset(preset, noise=BMP085.noise).run(log)
        out.append((track, climb(track), climb(exact(log.reference, log.t))))
    return out


def naive(track):
    return float(np.clip(np.diff(track.height), 0, None).sum())


def test_a_hand_made_walk_has_the_climb_that_one_counts():
    found = climb(exact([0, 1, 2, 1.9, 3, 1, 1.1, 0.5, 2]), threshold=0.3)
    assert found.height.tolist() == [0, 3, 0.5, 2]
    assert found.t.tolist() == [0, 4, 7, 8]
    assert (found.ascent, found.descent) == (4.5, 2.5)
    every = climb(exact([0, 1, 2, 1.9, 3, 1, 1.1, 0.5, 2]), threshold=0.05)
    assert (every.ascent, every.descent) == (pytest.approx(4.7), pytest.approx(2.7))


def test_a_descent_first_and_plateaus_make_no_difference():
    height = [5, 5, 5, 2, 2, 2, 4, 4, 4]
    found = climb(exact(height))
    assert (found.ascent, found.descent) == (2, 3)
    mirrored = climb(exact(-np.array(height)))
    assert (mirrored.ascent, mirrored.descent) == (3, 2)


@pytest.mark.parametrize("threshold", [0.3, 1.0, 3.0, None])
def test_ascent_minus_descent_is_what_lies_between_first_and_last_turn(threshold):
    for track, *_ in runs("lift", speed=0.5):
        found = climb(track, threshold=threshold)
        assert found.ascent - found.descent == pytest.approx(found.height[-1] - found.height[0])
        steps = np.diff(found.height)
        assert (np.sign(steps[1:]) == -np.sign(steps[:-1])).all()
        if threshold:
            assert np.abs(steps).min() >= threshold


def test_a_higher_threshold_never_counts_more():
    for track, *_ in runs("walk"):
        ascents = [climb(track, threshold=threshold).ascent for threshold in (0.05, 0.1, 0.2, 0.5, 1.0)]
        assert ascents == sorted(ascents, reverse=True)
        assert ascents[0] <= naive(track)


@pytest.mark.parametrize(
    ("motion", "preset"), [("rest", "baroarma"), ("rest", "sg14-a"), ("walk", "baroarma")]
)  # walking, sg14-a is off by metres and doesn't know
def test_rest_and_level_walking_climb_nothing(motion, preset):
    for track, found, truth in runs(motion, preset):
        assert truth.ascent == truth.descent == 0
        assert found.floors_up == found.floors_down == 0
        assert found.ascent == found.descent == 0
        assert naive(track) > 0


def test_squats_climb_their_depth_each():
    for track, found, truth in runs("squat", duration=65.0, count=6):
        assert truth.ascent == pytest.approx(6 * 0.6, abs=0.001)
        # each turn is that of its plateau: an sd or so, 2 to 5 cm, flatter
        assert found.ascent == pytest.approx(truth.ascent, rel=0.08)
        assert len(found.t) == 13
        assert naive(track) > found.ascent


@pytest.mark.parametrize(
    ("motion", "preset", "options"),
    [
        ("stairs", "baroarma", {"floor_height": 3.2, "steps": 18}),
        ("lift", "baroarma", {"speed": 0.5}),
        ("squat", "baroarma", {}),
        ("stairs", "sg14-a", {"floor_height": 3.2, "steps": 18}),
        ("lift", "sg14-a", {"speed": 0.5}),
    ],
)
def test_the_sd_of_the_ascent_is_honest_where_the_naive_sum_is_not(motion, preset, options):
    z = np.array([(f.ascent - truth.ascent) / f.ascent_sd for _, f, truth in runs(motion, preset, **options)])
    # mean square of 12 errors in sds: at most chi2(0.995, 12)/12 = 2.36 if the sd is the error's
    assert np.mean(z**2) < 2.36
    bias = np.mean([f.ascent - truth.ascent for _, f, truth in runs(motion, preset, **options)])
    assert abs(bias) < np.mean([f.ascent_sd for _, f, _ in runs(motion, preset, **options)])
    too_much = np.mean([naive(track) - truth.ascent for track, _, truth in runs(motion, preset, **options)])
    assert too_much > 3 * abs(bias)


def test_floors_are_counted():
    for _, found, _ in runs("stairs", floor_height=3.2, steps=18):
        assert (found.floors_up, found.floors_down) == (3, 0)
    for track, *_ in runs("stairs", floor_height=3.2, steps=18):
        known = climb(track, floors=[9.6, 0.0, 6.4, 3.2])
        assert (known.floors_up, known.floors_down) == (3, 0)


def test_half_a_landing_is_no_floor_and_a_short_dip_breaks_no_ascent():
    assert climb(exact([0, 1.5, 0])).floors_up == 0
    assert climb(exact([0, 2.2, 0])).floors_up == 0
    assert climb(exact([0, 2.3, 0])).floors_up == 1
    assert climb(exact([0, 2.0, 1.2, 3.0, 0])).floors_up == 1
    assert climb(exact([0, 8.3, 0])).floors_up == 3
    assert climb(exact([0, 8.3, 0])).floors_down == 3
    assert climb(exact([0, 8.3, 0]), floor_height=4.0).floors_up == 2


def test_known_floors_count_by_the_nearest():
    up_and_down = exact([0, 3.4, 3.1, 9.9, 3.3])
    found = climb(up_and_down, floors=(0.0, 3.2, 6.4, 9.6))
    assert (found.floors_up, found.floors_down) == (3, 2)


def test_the_weather_does_not_climb():
    rng = np.random.default_rng(3)
    t = np.arange(0, 3600.0, 1.0)
    drift = 0.02 * np.cumsum(rng.normal(size=len(t)))
    honest = Track(t, drift, 0 * t, np.sqrt(1e-4 + 0.02**2 * t), np.full(len(t), 0.02), 0 * t)
    assert climb(honest).ascent == 0
    assert climb(honest).floors_up == 0
    assert climb(honest, threshold=0.2).ascent > 1  # which a fixed threshold believes
    hill = replace(honest, height=drift + 30 * np.sin(t / 3600 * np.pi))
    assert climb(hill).ascent == pytest.approx(30, abs=4 * climb(hill).ascent_sd)
    assert climb(hill).floors_up == 10


def test_it_is_told_in_words_json_html_and_a_plot():
    track, found, _ = runs("stairs", floor_height=3.2, steps=18)[0]
    assert f"climbs {found.ascent:.2f} m" in track.summary()
    assert found.summary().endswith("floors: 3 up, 0 down")
    document = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert document["ascent_m"] == found.ascent
    assert document["turning_points"]["height_m"] == found.height.tolist()
    assert f"<td>{found.ascent:.2f}</td>" in found._repr_html_()
    labels = [text.get_text() for text in found.plot().get_legend().get_texts()]
    assert labels[0] == f"up {found.ascent:.2f} ± {found.ascent_sd:.2f} m"


def test_nothing_moved_and_nothing_there():
    still = climb(exact(np.zeros(100), sd=0.1))
    assert (still.ascent, still.descent, still.ascent_sd, len(still.t)) == (0, 0, 0, 0)
    assert "without a swing" in still.summary()
    assert climb(exact([])).ascent == 0
    assert climb(exact([1.0])).ascent == 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"threshold": 0.0}, "threshold must be a positive number of metres, but it is 0.0"),
        ({"threshold": float("nan")}, "but it is nan"),
        ({"floor_height": -3.0}, "floor height must be a positive number of metres, but it is -3.0"),
        ({"floors": [3.0]}, r"at least two floors in m, but these are \[3.0\]"),
    ],
)
def test_what_can_not_be_is_refused(options, message):
    with pytest.raises(ValueError, match=message):
        climb(exact([0, 1, 0]), **options)


def known(height, t=None, *, height_sd=0.1, velocity_sd=0.0):
    """A track with sds of its own."""
    height = np.asarray(height, float)
    t = np.arange(float(len(height))) if t is None else t
    full = np.ones(len(height))
    return Track(t, height, 0 * full, height_sd * full, velocity_sd * full, 0 * full, name="made")


def test_a_swing_as_high_as_the_threshold_counts():
    for threshold, ascent in ((1.0, 1.0), (1.01, 0.0)):
        assert climb(exact([0, 1, 0]), threshold=threshold).ascent == ascent
    assert climb(exact([0, 0.2, 0])).ascent == 0.2  # at least 20 cm where nothing is uncertain
    assert climb(exact([0, 0.19, 0])).ascent == 0.0


def test_a_turns_height_is_the_mean_of_what_can_not_be_told_from_its_extreme():
    rng = np.random.default_rng(4)
    wiggle = 0.02 * rng.uniform(-1, 1, 50)
    height = np.concatenate((np.zeros(50), 5 + wiggle, np.zeros(50)))
    # independent from row to row: sd of a change 0.14 m, far more than the wiggle and less than the 5 m
    found = climb(known(height, height_sd=0.1, velocity_sd=100.0))
    assert found.height == pytest.approx([0.0, 5 + wiggle.mean(), 0.0])
    # known exactly, the extreme itself is the turn
    assert climb(exact(height)).height.max() == height.max()
    # a threshold of one's own goes from extreme to extreme
    assert climb(known(height, height_sd=0.1, velocity_sd=100.0), threshold=1.0).ascent == height.max()


def test_a_climb_keeps_the_name_and_its_own_times():
    found = climb(known([0, 5, 0, 7], t=np.array([10.0, 11.0, 13.0, 17.0]), height_sd=0.0))
    assert found.name == "made"
    assert found.t.tolist() == [10, 11, 13, 17]
    assert (found.ascent, found.descent) == (12, 5)
    empty = climb(exact([]))
    assert empty.name == "made"
    assert empty.to_dict() == {
        **dict.fromkeys(("ascent_m", "ascent_sd_m", "descent_m", "descent_sd_m"), 0.0),
        **dict.fromkeys(("floors_up", "floors_down"), 0),
        "turning_points": {"time_s": [], "height_m": []},
    }


@pytest.mark.parametrize("floors", [[3.0], [3.0, 3.0], [0.0, float("nan")], [0.0, float("inf")], []])
def test_floors_that_are_none_are_refused(floors):
    with pytest.raises(ValueError, match="floors are the heights of at least two floors in m"):
        climb(exact([0, 1, 0]), floors=floors)


def test_known_floors_need_not_be_as_high_as_one_another():
    tall = exact([0, 5.8, 0])
    assert climb(tall, floors=[0, 6, 9]).floors_up == 1
    assert climb(tall, floors=[0, 3, 6, 9]).floors_up == 2
    assert climb(tall, floors=[0, 3, 6, 9], floor_height=100.0).floors_up == 2
    assert climb(exact([0, 2.9, 2.0, 5.8, 0]), floors=[0, 3, 6]).floors_down == 2


def test_a_swing_of_five_sds_of_the_change_is_believed():
    # independent from row to row: the sd of a change is 0.1 sqrt(2) m, five of them 0.71 m
    for height, believed in ((0.65, False), (0.75, True)):
        found = climb(known([0, height, 0], height_sd=0.1, velocity_sd=100.0))
        assert (found.ascent > 0) == believed


def test_a_dip_of_less_than_half_a_floor_breaks_no_ascent():
    assert climb(exact([0, 2.0, 0.8, 3.0, 0])).floors_up == 1
    assert climb(exact([0, 2.0, 0.4, 3.0, 0])).floors_up == 1  # of the second part, 2.6 m
    assert climb(exact([0, 2.0, 0.4, 2.5, 0])).floors_up == 0
    assert climb(exact([0, 3, 0]), floors=[0, 3]).floors_up == 1


def test_before_the_first_swing_the_extreme_so_far_is_where_it_starts():
    down, up = (climb(exact(sign * np.array([0, 0.1, -1, -0.95])), threshold=0.2) for sign in (1, -1))
    assert (down.descent, down.ascent) == (pytest.approx(1.1), 0.0)
    assert (up.ascent, up.descent) == (pytest.approx(1.1), 0.0)
