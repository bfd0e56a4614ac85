"""Independent runs over threads or processes: their order, and every bit, is the same for any
number of workers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, TypeVar

from valvetrain.errors import RunFailedError
from valvetrain.studies.batch import worker_count
from valvetrain.studies.blas_threads import one_thread
from valvetrain.studies.stopping import PointsStopped, look
from valvetrain.studies.workers import Lost, as_they_come, in_processes

Point = TypeVar("Point")
Result = TypeVar("Result")
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
            for place, result in _results(function, shared, points, count, processes):
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


def _results(
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
