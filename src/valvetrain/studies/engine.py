"""Independent runs over threads or processes: their order, and every bit, is the same for any number of workers."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any, TypeVar

from valvetrain.errors import InputError
from valvetrain.studies.batch import available_cores, start_method

Point = TypeVar("Point")
Result = TypeVar("Result")
Shared = TypeVar("Shared")
Progress = Callable[[float, str], None]

#: What every worker process was handed once, instead of with each point.
_SHARED: list[Any] = []


def map_points(
    function: Callable[[Shared, Point], Result], shared: Shared, points: Sequence[Point], workers: int | None = None,
    processes: bool = False, tell: Callable[[int, int], None] | None = None,
) -> tuple[Result, ...]:  # fmt: skip
    """``function(shared, point)`` of every point, in order. ``shared`` is handed to each worker once.

    Threads by default (compiled time integration holds no interpreter lock); ``processes`` where Python itself is the work, and then
    ``function`` must be importable. ``tell(done, total)`` after each. Raises :class:`InputError` for fewer than one worker.
    """
    count = available_cores() if workers is None else workers
    if count < 1:
        raise InputError(f"workers must be 1 or more; it is {count}", "--workers")
    count = min(count, max(len(points), 1))
    results: list[Result] = []
    for result in _results(function, shared, points, count, processes):
        results.append(result)
        if tell is not None:
            tell(len(results), len(points))
    return tuple(results)


def _results(
    function: Callable[[Shared, Point], Result], shared: Shared, points: Sequence[Point], count: int, processes: bool
) -> Iterator[Result]:
    if count == 1:
        yield from (function(shared, point) for point in points)
    elif not processes:
        with ThreadPoolExecutor(count) as pool:
            yield from pool.map(lambda point: function(shared, point), points)
    else:
        context = multiprocessing.get_context(start_method())
        with ProcessPoolExecutor(count, context, initializer=_begin, initargs=(function, shared)) as workers:
            yield from workers.map(_one, points, chunksize=max(1, len(points) // (8 * count)))


def _begin(function: Any, shared: Any) -> None:
    # Ctrl-C reaches every process of a terminal; the one that answers it is the parent
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _SHARED[:] = [function, shared]


def _one(point: Any) -> Any:
    return _SHARED[0](_SHARED[1], point)
