"""Independent runs over threads or processes: their order, and every bit, is the same for any
number of workers.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from numbers import Integral
from typing import Any, TypeVar

from valvetrain.errors import InputError, RunFailedError
from valvetrain.runs.stopping import PointsStopped, look
from valvetrain.runs.workers import Lost, as_they_come, in_processes, one_thread

Case = TypeVar("Case")
Result = TypeVar("Result")


def map_cases(
    function: Callable[[Case], Result],
    cases: Iterable[Case],
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Result, ...]:
    """A function of every case, in their order, over processes: every case runs by itself, so
    results do not depend on ``workers``.

    Parameters
    ----------
    function : of one case; importable (a module-level function or a partial of one), with results
        that pickle
    cases : what the function takes, one after the other
    workers : processes; None for one per core, 1 for this process
    progress : called as ``progress(done, total)`` after each case

    Returns
    -------
    tuple of the results, one per case

    Raises
    ------
    InputError : fewer than one worker; what the function raises; RunFailedError where the worker of
        a case is killed again and again

    Examples
    --------
    >>> import valvetrain as vt
    >>> [case.name for case in vt.map_cases(vt.load_case, ["job-t", "gu2021-beehive"], workers=1)]
    ['job-t', 'gu2021-beehive']
    """
    items: Sequence[Case] = tuple(cases)
    count = min(worker_count(workers), max(len(items), 1))
    results: dict[int, Result] = {}
    for place, result in _results(function, items, count):
        if isinstance(result, Lost):
            raise RunFailedError(
                "a worker process was killed, and so was the one that tried its case again; take fewer workers"
            )
        results[place] = result
        if progress is not None:
            progress(len(results), len(items))
    return tuple(results[place] for place in range(len(items)))


def worker_count(workers: int | None) -> int:
    """``workers``, None for the cores there are. Raises :class:`InputError` for what is no whole
    number of 1 or more.
    """
    if workers is None:
        return available_cores()
    if not (isinstance(workers, Integral) and workers >= 1):
        raise InputError(
            f"workers must be 1 or more, a whole number; it is {str(workers)[:40]}", "--workers"
        )
    return int(workers)


def available_cores() -> int:
    """Cores this process may use."""
    return (
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
    )


def _results(
    function: Callable[[Case], Result], items: Sequence[Case], count: int
) -> Iterator[tuple[int, Any]]:
    if count == 1:
        yield from enumerate(map(function, items))
    else:
        yield from in_processes(_of_one, function, items, count)


def _of_one(function: Callable[[Case], Result], item: Case) -> Result:
    return function(item)


Point = TypeVar("Point")
Shared = TypeVar("Shared")
Progress = Callable[[float, str], None]
#: What is told of a run whose worker was killed.
LOST = "the worker process that ran it was killed, and so was the one that tried it again"
LOST_REMEDY = "take fewer workers if the memory was not enough"


def map_points(
    function: Callable[[Shared, Point], Result],
    shared: Shared,
    points: Sequence[Point],
    workers: int | None = None,
    processes: bool = False,
    tell: Callable[[int, int], None] | None = None,
    *,
    lost: Callable[[Point], Result] | None = None,
    finished: Callable[[int, Result], None] | None = None,
) -> tuple[Result, ...]:
    """``function(shared, point)`` of every point, in order. ``shared`` is handed to each worker
    once.

    Threads by default (compiled time integration holds no interpreter lock); ``processes`` where
    Python itself is the work, and then
    ``function`` must be importable. ``tell(done, total)`` after each, ``finished(place, result)``
    as each comes. A point whose worker is
    killed is tried again; ``lost(point)`` stands for one that is not to be had. Raises
    :class:`InputError` for fewer than one worker,
    :class:`RunFailedError` for a lost point where nothing stands for it, and :class:`PointsStopped`
    with what is finished.
    """
    count = worker_count(workers)
    count = min(count, max(len(points), 1))
    results: dict[int, Result] = {}
    try:
        with one_thread():
            for place, result in _results_engine(function, shared, points, count, processes):
                if isinstance(result, Lost):
                    if lost is None:
                        raise RunFailedError(f"a run is lost: {LOST}; {LOST_REMEDY}")
                    result = lost(points[place])
                results[place] = result
                if finished is not None:
                    finished(place, result)
                if tell is not None:
                    tell(len(results), len(points))
    except KeyboardInterrupt:
        raise PointsStopped(results) from None
    return tuple(results[place] for place in range(len(points)))


def _results_engine(
    function: Callable[[Shared, Point], Result],
    shared: Shared,
    points: Sequence[Point],
    count: int,
    processes: bool,
) -> Iterator[tuple[int, Any]]:
    if count == 1:
        for place, point in enumerate(points):
            look()
            yield place, function(shared, point)
    elif not processes:
        with threads(count) as pool:
            yield from as_they_come(
                {pool.submit(function, shared, point): place for place, point in enumerate(points)}
            )
    else:
        yield from in_processes(function, shared, points, count)


@contextmanager
def threads(count: int) -> Iterator[ThreadPoolExecutor]:
    """A pool of ``count`` threads; where its block ends by an exception, runs that go on are not
    waited for.
    """
    pool = ThreadPoolExecutor(max(1, count))
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()
