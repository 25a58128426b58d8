"""The order of results is that of the work, whoever does it; who dies is said, or replaced."""

import os
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest

from baroarma.executors import in_order
from baroarma.experiments.trials import Measurement, Trial, run_trials


def slow_square(x):
    """Take longer for what comes first, so that it is done last."""
    time.sleep(0.02 * (8 - x))
    return x * x


def die_once(x, *, marker):
    """End the process that meets 3 for the first time, without a word; then do as the others."""
    if x == 3 and not marker.exists():
        marker.touch()
        os._exit(1)
    time.sleep(0.1)
    return x * x, os.getpid()


def measure(trial):
    return {("noise", "m"): Measurement(float(trial.rng("rest").normal()))}


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_come_in_the_order_of_the_work(jobs):
    assert list(in_order(slow_square, range(8), jobs=jobs)) == [x * x for x in range(8)]


def test_any_executor_will_do():
    with ThreadPoolExecutor(4) as threads:
        assert list(in_order(slow_square, range(8), executor=threads)) == [x * x for x in range(8)]
        assert threads.submit(int).result() == 0  # it is not shut down


def test_no_work_is_done_at_once():
    assert list(in_order(slow_square, [])) == []


def test_a_process_that_dies_is_said_in_a_sentence(tmp_path):
    with pytest.raises(ChildProcessError, match="ended before its work was done"):
        list(in_order(partial(die_once, marker=tmp_path / "died"), range(8), jobs=2))


def test_trials_are_the_same_for_any_number_of_workers():
    tasks = [(measure, Trial(seed=5, number=n)) for n in range(6)]
    alone = list(run_trials(tasks, 1))
    assert list(run_trials(tasks, 2)) == alone
    with ThreadPoolExecutor(3) as threads:
        assert list(run_trials(tasks, executor=threads)) == alone
    assert len({str(measured) for measured in alone}) == 6


@pytest.fixture(scope="module")
def dask_cluster():
    """Two worker processes of a Dask cluster on this machine; those that die are started anew."""
    distributed = pytest.importorskip("distributed", reason="Dask isn't installed: extra 'cluster'")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@pytest.mark.filterwarnings("ignore")  # Dask's own
def test_a_dask_cluster_finishes_the_work_of_a_worker_that_was_killed(dask_cluster, tmp_path):
    killer = partial(die_once, marker=tmp_path / "died")
    found = list(in_order(killer, range(12), executor=dask_cluster.get_executor()))
    assert (tmp_path / "died").exists()
    assert [square for square, _ in found] == [x * x for x in range(12)]
    # one worker may have done all: what the killed one had finished is lost with it
    assert os.getpid() not in {worker for _, worker in found}


@pytest.mark.filterwarnings("ignore")
def test_trials_on_a_dask_cluster_are_those_of_this_process(dask_cluster):
    tasks = [(measure, Trial(seed=5, number=n)) for n in range(6)]
    assert list(run_trials(tasks, executor=dask_cluster.get_executor())) == list(run_trials(tasks, 1))
