import numpy as np
import pytest

from baroarma.estimators.height.drive import Drive

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
