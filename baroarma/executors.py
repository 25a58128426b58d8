"""Many pieces of work: here, in processes of this machine, or by any executor, such as a Dask cluster's.

What comes back is in the order of the work, whoever did it and whenever it was done.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

Work = TypeVar("Work")
Result = TypeVar("Result")


def in_order(
    function: Callable[[Work], Result],
    items: Sequence[Work],
    *,
    jobs: int | None = None,
    executor: Executor | None = None,
) -> Iterator[Result]:
    """Apply a function to all items, and yield the results in the items' order.

    Parameters
    ----------
    function : callable
        A function of a module, or a `functools.partial` of one, so that other processes find it.
    items : sequence
        What to apply it to.
    jobs : int, optional
        Processes; 1: this one alone; default: one per core.  More are started afresh, for a fork of a process
        with threads may hang; so a script that asks for them needs ``if __name__ == "__main__":``.
    executor : concurrent.futures.Executor, optional
        Does the work instead, such as ``Client(...).get_executor()`` of Dask; it is not shut down.

    Raises
    ------
    ChildProcessError
        If a process ended before its work was done.  (Dask tries again on another worker.)

    Examples
    --------
    >>> list(in_order(abs, [-1, 2, -3], jobs=1))
    [1, 2, 3]
    """
    jobs = min(jobs or os.cpu_count() or 1, len(items))
    if executor is not None:
        yield from executor.map(function, items)
    elif jobs <= 1:
        yield from map(function, items)
    else:
        yield from _in_processes(function, items, jobs)


def _in_processes(function: Callable[[Work], Result], items: Sequence[Work], jobs: int) -> Iterator[Result]:
    pool = ProcessPoolExecutor(jobs, get_context("spawn"))
    try:
        yield from pool.map(function, items)
    except BrokenExecutor as error:
        raise ChildProcessError(
            f"one of {jobs} processes ended before its work was done, perhaps for want of memory; try fewer"
        ) from error
    finally:
        pool.shutdown(cancel_futures=True)
