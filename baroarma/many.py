"""Many recordings at once: identify and compare them in processes of this machine or on a cluster.

Files are read where the work is done, so that only names and results travel.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from functools import partial
from typing import TYPE_CHECKING, Any

from baroarma.executors import in_order
from baroarma.recording import Recording

if TYPE_CHECKING:
    from baroarma.comparison import Comparison
    from baroarma.identification import Identification

StrPath = str | os.PathLike[str]
Source = Recording | StrPath | Sequence[StrPath]
"""A recording, its file, or its files."""


def identify_many(
    recordings: Sequence[Source],
    *,
    mapping: Mapping[str, str] | None = None,
    jobs: int | None = None,
    executor: Executor | None = None,
    **options: Any,
) -> list[Identification]:
    """Learn the noise from many recordings at rest.

    Parameters
    ----------
    recordings : sequence of Recording, path, or sequence of paths
        Each a recording, its file or its files; a long file is read part by part.
    mapping : mapping of str to str, optional
        As for `baroarma.read`.
    jobs, executor
        Who does the work, see `baroarma.executors.in_order`.
    **options
        As for `baroarma.identify`.

    Returns
    -------
    list of Identification
        In the order of the recordings, whoever did the work.

    Examples
    --------
    >>> from baroarma.simulation import simulate_rest
    >>> nights = [simulate_rest(duration=120, seed=seed) for seed in (1, 2)]
    >>> [found.model.has_gauss_markov for found in identify_many(nights, jobs=1)]
    [True, True]
    """
    work = partial(_identified, mapping=mapping, options=options)
    return list(in_order(work, recordings, jobs=jobs, executor=executor))


def compare_many(
    recordings: Sequence[Source],
    *,
    mapping: Mapping[str, str] | None = None,
    jobs: int | None = None,
    executor: Executor | None = None,
    **options: Any,
) -> list[Comparison]:
    """Run several presets on many recordings.

    Parameters
    ----------
    recordings, mapping, jobs, executor
        As for `identify_many`.  Times per sample are fair only if the workers have a core each.
    **options
        As for `baroarma.compare`.

    Returns
    -------
    list of Comparison
        In the order of the recordings.

    Examples
    --------
    >>> from baroarma.simulation import simulate
    >>> squats = [simulate("squat", duration=20, seed=seed) for seed in (1, 2)]
    >>> tables = compare_many(squats, jobs=1, presets=("sg14-a", "lee16"))
    >>> [[row.preset for row in table.rows] for table in tables]
    [['sg14-a', 'lee16'], ['sg14-a', 'lee16']]
    """
    work = partial(_compared, mapping=mapping, options=options)
    return list(in_order(work, recordings, jobs=jobs, executor=executor))


def _identified(source: Source, mapping: Mapping[str, str] | None, options: dict[str, Any]) -> Identification:
    from baroarma.formats.long import is_long
    from baroarma.identification import identify
    from baroarma.streaming import read_rest

    if not isinstance(source, Recording) and len(paths := _paths(source)) == 1 and is_long(paths[0], mapping):
        return identify(read_rest(paths[0], mapping=mapping), **options)
    return identify(_read(source, mapping), **options)


def _compared(source: Source, mapping: Mapping[str, str] | None, options: dict[str, Any]) -> Comparison:
    from baroarma.comparison import compare

    return compare(_read(source, mapping), **options)


def _read(source: Source, mapping: Mapping[str, str] | None) -> Recording:
    from baroarma.formats import read

    return source if isinstance(source, Recording) else read(*_paths(source), mapping=mapping)


def _paths(source: StrPath | Sequence[StrPath]) -> Sequence[StrPath]:
    return (source,) if isinstance(source, str | os.PathLike) else source
