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
