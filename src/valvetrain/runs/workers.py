"""Independent runs over threads or processes: their order, and every bit, is the same for any
number of workers.

Worker processes never outlive the process they serve; the runs of one that was killed are tried
again.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import multiprocessing.connection
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from contextvars import ContextVar
from numbers import Integral
from typing import Any, Protocol, TypeVar

from valvetrain.errors import InputError, RunFailedError
from valvetrain.runs.stopping import POLL_INTERVAL, PointsStopped, check_stop

Point = TypeVar("Point")
Shared = TypeVar("Shared")
Result = TypeVar("Result")
Progress = Callable[[float, str], None]
#: Message of a run whose worker was killed, and its remedy.
LOST = "the worker process that ran it was killed, and so was the one that tried it again"
LOST_REMEDY = "take fewer workers if the memory was not enough"


class RemoteWorkers(Protocol):
    """Workers elsewhere, such as :class:`valvetrain.runs.cluster.Cluster`: ``workers`` runs at a time."""

    workers: int

    def stream(
        self, function: Callable[[Any, Any], Any], shared: Any, points: Sequence[Any]
    ) -> Iterator[tuple[int, Any]]:
        """(index, ``function(shared, point)``) of every point as it is finished."""
        ...

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """``function(*arguments)``."""
        ...


#: Where runs go (:func:`valvetrain.runs.cluster.on_cluster`), None for this machine.
CLUSTER: ContextVar[RemoteWorkers | None] = ContextVar("cluster", default=None)

_LOCK, _LIMIT = threading.Lock(), ExitStack()
_inside = 0


@contextmanager
def one_thread() -> Iterator[None]:
    """One thread for the linear algebra of this process and of those it forks, until the last such
    block has ended.
    """
    global _inside
    with _LOCK:
        if _inside == 0:
            _LIMIT.enter_context(_limited())
        _inside += 1
    try:
        yield
    finally:
        with _LOCK:
            _inside -= 1
            if _inside == 0:
                _LIMIT.close()


def _limited() -> AbstractContextManager[object]:
    import scipy.linalg  # noqa: F401  a library that is loaded later has threads of its own again
    from threadpoolctl import threadpool_limits

    limit: AbstractContextManager[object] = threadpool_limits(1, user_api="blas")
    return limit


#: Pools in which a run is tried together with others, and then alone, which finds the one that
#: kills its worker.
TOGETHER, ALONE = 2, 2
_PR_SET_PDEATHSIG = 1
#: Function and shared data that every worker process received once, instead of with each point.
_SHARED: list[Any] = []


class Lost:
    """Result of a run whose worker process was killed whenever it was tried."""


def start_method() -> str:
    """How worker processes begin: forked where no thread runs, else as fresh interpreters."""
    return (
        "fork"
        if "fork" in multiprocessing.get_all_start_methods() and threading.active_count() == 1
        else "spawn"
    )


def in_processes(
    function: Callable[[Any, Any], Any], shared: Any, points: Sequence[Any], count: int
) -> Iterator[tuple[int, Any]]:
    """(index, ``function(shared, point)``) of every point as it is finished, over ``count``
    processes; :class:`Lost` for one that cannot be computed. What ``function`` raises is raised
    here.
    """
    left = dict(enumerate(points))
    with one_thread():
        for _ in range(TOGETHER):
            if left:
                yield from _finished(function, shared, left, min(count, len(left)))
        for index in tuple(left):
            alone = {index: left[index]}
            for _ in range(ALONE):
                if alone:
                    yield from _finished(function, shared, alone, 1)
            if alone:
                yield index, Lost()


def _finished(
    function: Any, shared: Any, left: dict[int, Any], count: int
) -> Iterator[tuple[int, Any]]:
    """What one pool finishes of ``left``, removed from it; ends early where a worker is killed."""
    context = multiprocessing.get_context(start_method())
    pool = ProcessPoolExecutor(
        count, context, initializer=_begin, initargs=(os.getpid(), function, shared)
    )
    try:
        for index, result in as_they_come(
            {pool.submit(_one, point): index for index, point in left.items()}
        ):
            del left[index]
            yield index, result
        pool.shutdown()
    except BrokenProcessPool:
        return
    finally:
        _end(pool)


def as_they_come(jobs: Mapping[Future[Any], int]) -> Iterator[tuple[int, Any]]:
    """(index, result) of every job as it ends, each yielded once and then released; checks for a
    stop request meanwhile.

    What a job raises is raised here; that its worker was killed is raised after all other jobs.
    """
    indices, broken = dict(jobs), None
    del jobs
    while indices:
        done, _ = wait(indices, POLL_INTERVAL, FIRST_COMPLETED)
        check_stop()
        for index, job in sorted(
            ((indices.pop(one), one) for one in done), key=lambda pair: pair[0]
        ):
            try:
                result = job.result()
            except BrokenProcessPool as error:
                broken = error
                continue
            del job
            yield index, result
            del result
        del done
    if broken is not None:
        raise broken


def result_of(job: Future[Any]) -> Any:
    """The result of one job; checks for a stop request while it waits."""
    while not wait((job,), POLL_INTERVAL).done:
        check_stop()
    check_stop()
    return job.result()


def _end(pool: ProcessPoolExecutor) -> None:
    """End a pool without waiting for runs whose results are no longer needed."""
    workers = list((getattr(pool, "_processes", None) or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    for worker in workers:
        if worker.is_alive():
            worker.terminate()
    for worker in workers:
        worker.join(timeout=5)


def _begin(parent: int, function: Any, shared: Any) -> None:
    quiet_worker(parent)
    _limited()  # for good: a worker process computes runs and nothing else
    _SHARED[:] = [function, shared]


def _one(point: Any) -> Any:
    return _SHARED[0](_SHARED[1], point)


def quiet_worker(parent: int) -> None:
    """Make this worker process leave Ctrl-C to its ``parent`` (process id) and end with it, however
    that ends.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it reaches every process of a terminal
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if sys.platform == "linux":
        with suppress(AttributeError, OSError):
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it ended before that call
            os._exit(1)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """Wait for the end of the parent, where the system does not kill orphans."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        multiprocessing.connection.wait([parent.sentinel])
        os._exit(1)


class StandingPool:
    """Worker processes for many batches of ``function(shared, point)``; ``count`` 1: this process;
    the cluster where one is in use. A context manager.

    A run whose worker is killed is tried again by :func:`in_processes`; what cannot be computed
    comes back as :class:`Lost`.
    """

    def __init__(self, function: Callable[[Any, Any], Any], shared: Any, count: int) -> None:
        self.function, self.shared, self.count = function, shared, count
        self._pool: ProcessPoolExecutor | None = None
        self._left = ExitStack()

    def __enter__(self) -> StandingPool:
        self._left.enter_context(one_thread())
        try:
            self._start()
        except BaseException:
            self._left.close()
            raise
        return self

    def _start(self) -> None:
        if self.count > 1 and CLUSTER.get() is None:
            context = multiprocessing.get_context(start_method())
            self._pool = ProcessPoolExecutor(
                self.count,
                context,
                initializer=_begin,
                initargs=(os.getpid(), self.function, self.shared),
            )
            result_of(self._pool.submit(os.getpid))  # starts all of them before any thread runs

    def __exit__(self, *_: object) -> None:
        if self._pool is not None:
            _end(self._pool)
        self._left.close()

    def stream(self, points: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        """(index, result) of every point of one batch as it is finished."""
        if (cluster := CLUSTER.get()) is not None:
            yield from cluster.stream(self.function, self.shared, points)
            return
        if self._pool is None:
            for index, point in enumerate(points):
                check_stop()
                yield index, self.function(self.shared, point)
            return
        left = set(range(len(points)))
        try:
            for index, result in as_they_come(
                {self._pool.submit(_one, point): index for index, point in enumerate(points)}
            ):
                left.discard(index)
                yield index, result
        except BrokenProcessPool:
            again = sorted(left)
            for number, result in in_processes(
                self.function, self.shared, [points[index] for index in again], self.count
            ):
                yield again[number], result
            _end(self._pool)
            self._start()


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
    """``function(shared, point)`` of every point, in order. ``shared`` is sent to each worker once.

    Threads by default (compiled time integration holds no interpreter lock); ``processes`` where
    Python itself is the work, and then ``function`` must be importable. ``tell(done, total)`` is
    called after each, ``finished(index, result)`` as each arrives. A point whose worker is killed
    is tried again; ``lost(point)`` replaces the result of one that cannot be computed. Raises
    :class:`InputError` for fewer than one worker, :class:`RunFailedError` for a lost point without
    a replacement, and :class:`PointsStopped` with what is finished.
    """
    count = min(worker_count(workers), max(len(points), 1))
    results: dict[int, Result] = {}
    try:
        with one_thread():
            for index, result in _results(function, shared, points, count, processes):
                if isinstance(result, Lost):
                    if lost is None:
                        raise RunFailedError(f"a run is lost: {LOST}; {LOST_REMEDY}")
                    result = lost(points[index])
                results[index] = result
                if finished is not None:
                    finished(index, result)
                if tell is not None:
                    tell(len(results), len(points))
    except KeyboardInterrupt:
        raise PointsStopped(results) from None
    return tuple(results[index] for index in range(len(points)))


def _results(
    function: Callable[[Shared, Point], Result],
    shared: Shared,
    points: Sequence[Point],
    count: int,
    processes: bool,
) -> Iterator[tuple[int, Any]]:
    if (cluster := CLUSTER.get()) is not None:
        yield from cluster.stream(function, shared, points)
    elif count == 1:
        for index, point in enumerate(points):
            check_stop()
            yield index, function(shared, point)
    elif not processes:
        with threads(count) as pool:
            yield from as_they_come(
                {pool.submit(function, shared, point): index for index, point in enumerate(points)}
            )
    else:
        yield from in_processes(function, shared, points, count)


def worker_count(workers: int | None) -> int:
    """``workers``, None for the cores there are, or for what the cluster in use takes at a time.
    Raises :class:`InputError` for what is no whole number of 1 or more.
    """
    if workers is None:
        cluster = CLUSTER.get()
        return available_cores() if cluster is None else cluster.workers
    if not (isinstance(workers, Integral) and workers >= 1):
        raise InputError(
            f"workers must be 1 or more, a whole number; it is {str(workers)[:40]}", "workers"
        )
    return int(workers)


def workers_here(workers: int) -> int:
    """Those of ``workers`` that take memory of this machine: none where a cluster is in use."""
    return workers if CLUSTER.get() is None else 0


def available_cores() -> int:
    """Cores this process may use."""
    return (
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
    )


@contextmanager
def threads(count: int) -> Iterator[ThreadPoolExecutor]:
    """A pool of ``count`` threads; where its block ends by an exception, it does not wait for
    unfinished runs.
    """
    pool = ThreadPoolExecutor(max(1, count))
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


def return_memory() -> None:
    """Give freed memory back to the system, which the C library of Linux keeps between smaller
    objects: a sweep of slow speeds would grow by several MB a run.
    """
    with suppress(OSError, AttributeError):
        ctypes.CDLL("libc.so.6").malloc_trim(0)
