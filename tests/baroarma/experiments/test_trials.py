"""Trials are independent of each other's company, and reproducible."""

import math

import pytest

from baroarma.experiments.trials import Measurement, Trial, average, run_trials


def draw(trial):
    return {("row", "number"): Measurement(float(trial.rng("a").random()))}


def test_trials_come_in_the_order_of_their_tasks():
    # that workers change nothing is shown by the command line's test, with trials that other processes find
    tasks = [(draw, Trial(7, number)) for number in range(5)]
    assert list(run_trials(tasks, workers=1)) == [draw(trial) for _, trial in tasks]


def test_seed_number_and_name_make_the_noise():
    def noise(trial, *names):
        return trial.rng(*names).random()

    first = noise(Trial(0, 0), "rest")
    assert noise(Trial(0, 0, ("sg14-a",)), "rest") == first
    others = [noise(Trial(1, 0), "rest"), noise(Trial(0, 1), "rest"), noise(Trial(0, 0), "fall")]
    assert len({first, *others}) == 4


def test_the_sd_is_that_over_trials():
    found = average([Measurement(1.0), Measurement(2.0), Measurement(3.0)])
    assert found == (2.0, 1.0, 3)


def test_the_sd_is_that_within_trials_where_the_paper_means_that():
    assert average([Measurement(1.0, 0.2), Measurement(2.0, 0.4)]) == pytest.approx((1.5, 0.3, 2))


def test_one_trial_has_no_sd_and_none_has_no_mean():
    assert average([Measurement(1.0)]) == (1.0, None, 1)
    assert average([Measurement(math.nan)]) == (None, None, 0)
