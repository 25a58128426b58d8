import numpy as np
import pytest

from baroarma.estimators.height.drive import Drive, as_signal, nominal_interval

NAN = float("nan")


def test_euler_integrates_the_previous_sample_and_midpoint_the_mean_of_two():
    a = np.array([1.0, 3.0, -1.0])
    assert Drive().rows(a)[0].tolist() == [0, 1, 3]
    assert Drive(midpoint=True).rows(a)[0].tolist() == [0.5, 2, 1]


def test_a_missing_sample_repeats_the_last_one_and_before_the_first_there_is_none():
    assert Drive().rows(np.array([NAN, 2.0, NAN, NAN, 1.0]))[0].tolist() == [0, 0, 2, 2, 2]


@pytest.mark.parametrize("steps", [1, 3, 12])
def test_rest_needs_a_closed_interval_of_n_quiet_steps(steps):
    a = np.full(40, 0.05)
    a[20] = 0.1  # not below 0.1 m/s² [Lee16, Eq. 14]
    at_rest = Drive(zupt_steps=steps, zupt_threshold=0.1).rows(a)[2]
    expected = [k >= steps and abs(a[max(k - steps, 0) : k + 1]).max() < 0.1 for k in range(40)]
    assert at_rest.tolist() == expected


def test_without_a_rule_nothing_is_ever_at_rest():
    assert not Drive().rows(np.zeros(100))[2].any()


def test_rows_go_on_where_steps_ended():
    a = np.random.default_rng(0).normal(scale=0.06, size=60)
    whole, parts = (Drive(midpoint=True, zupt_steps=3) for _ in range(2))
    inputs, change, at_rest = whole.rows(a)
    stepped = [parts.step(value) for value in a[:30]]
    late = parts.rows(a[30:])
    for column, whole_run in enumerate((inputs, change, at_rest)):
        assert np.array_equal(whole_run, [*[step[column] for step in stepped], *late[column]])
    assert np.array_equal(change, np.abs(np.diff(a, prepend=0.0)))
    assert 0 < at_rest.sum() < 60


def test_a_wild_sample_between_two_that_agree_is_taken_out_again():
    a = np.array([0.0, 0.1, 0.2, 150.0, 0.3, 0.4])
    for midpoint in (False, True):
        calm, wild = (Drive(midpoint=midpoint).rows(x) for x in (np.where(a > 1, 0.2, a), a))
        # Euler never integrates it, the midpoint takes back what it had; the change is told, for the sd
        assert wild[0][:5].sum() == pytest.approx(calm[0][:5].sum(), abs=0.1)
        assert wild[1][4] > 100


def test_a_shock_of_two_samples_is_no_wild_one():
    a = np.array([0.0, 0.0, 150.0, 140.0, 0.0, 0.0])
    assert Drive(midpoint=True).rows(a)[0].sum() == pytest.approx(a.sum())
    assert Drive().rows(a)[0].sum() == pytest.approx(a.sum())


@pytest.mark.parametrize(("height", "out"), [(50.5, True), (49.5, False), (-50.5, True)])
def test_wild_is_more_than_5_g_and_back_within_a_fifth(height, out):
    for back in (0.19, -0.19):
        a = 3.0 + np.array([0.0, 0.0, height, back * height, 0.0])
        euler, midpoint = Drive().rows(a)[0], Drive(midpoint=True).rows(a)[0]
        # row 3 integrates the sample before it: the wild one, or the one before that
        assert euler[3] == pytest.approx(a[1] if out else a[2])
        # the midpoint has had half of the wild one in row 2, and gives it back
        assert midpoint[2] + midpoint[3] == pytest.approx(
            a[1] + a[3] / 2 + (a[1] / 2 if out else a[2] - a[1] / 2)
        )
    stays = 3.0 + np.array([0.0, 0.0, height, 0.21 * height, 0.0])
    assert Drive().rows(stays)[0][3] == stays[2]


def test_a_reset_forgets_all_samples():
    used, new = Drive(midpoint=True, zupt_steps=2), Drive(midpoint=True, zupt_steps=2)
    used.rows(np.array([0.01, 120.0, 0.02, 0.01, 0.01]))
    used.reset()
    a = np.array([0.05, 0.06, 90.0, 0.05])
    for one, other in zip(used.rows(a), new.rows(a), strict=True):
        assert np.array_equal(one, other)
        assert one.dtype == other.dtype
    assert Drive().rows(a)[2].dtype == bool
    assert Drive(zupt_steps=1).rows(np.array([0.09, 0.09, 0.11]))[2].tolist() == [False, True, False]


def test_a_signal_that_is_not_there_is_nan_and_whole_numbers_are_floats():
    assert np.isnan(as_signal(None, 3)).tolist() == [True] * 3
    given = as_signal(np.array([1, 2], dtype=np.int16), 2)
    assert (given.dtype, given.tolist()) == (float, [1.0, 2.0])


def test_an_interval_is_a_positive_number_of_seconds():
    assert nominal_interval(0.02) == 0.02
    assert isinstance(nominal_interval(1), float)
    with pytest.raises(ValueError, match="the nominal interval is missing: give dt= in s, or noise="):
        nominal_interval(None)
    for dt in (0.0, -1.0, NAN, np.inf):
        with pytest.raises(ValueError, match=f"must be a positive number of seconds, but it is {dt}"):
            nominal_interval(dt)
