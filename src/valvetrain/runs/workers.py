"""Worker processes that never outlive the process they serve, and the runs of one that was killed."""

from __future__ import annotations

import ctypes
import multiprocessing
import multiprocessing.connection
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from typing import Any

from valvetrain.runs.stopping import LOOK, look

_LOCK, _LIMIT = threading.Lock(), ExitStack()
_inside = 0


@contextmanager
def one_thread() -> Iterator[None]:
    """One thread for the linear algebra of this process and of those it forks, until the last block
    that asks for it has ended.
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


def stay_on_one_thread() -> None:
    """The same for good: this is a worker process, which computes runs and nothing else."""
    _limited()


def _limited() -> AbstractContextManager[object]:
    import scipy.linalg  # noqa: F401  a library that is loaded later has threads of its own again
    from threadpoolctl import threadpool_limits

    limit: AbstractContextManager[object] = threadpool_limits(1, user_api="blas")
    return limit


#: Pools in which a run is tried together with others; after that each is tried alone, so that one
#: that kills its worker is found.
TOGETHER = 2
#: Trials of a run alone before it is given up.
ALONE = 2
_PR_SET_PDEATHSIG = 1
#: What every worker process was handed once, instead of with each point.
_SHARED: list[Any] = []


class Lost:
    """Stands for a run whose worker process was killed whenever it was tried."""


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
    """(place, ``function(shared, point)``) of every point as it is finished, over ``count``
    processes; :class:`Lost` for one that is not
    to be had. What ``function`` raises is raised here."""
    left = dict(enumerate(points))
    with one_thread():
        for _ in range(TOGETHER):
            if left:
                yield from _finished(function, shared, left, min(count, len(left)))
        for place in tuple(left):
            alone = {place: left[place]}
            for _ in range(ALONE):
                if alone:
                    yield from _finished(function, shared, alone, 1)
            if alone:
                yield place, Lost()


def _finished(
    function: Any, shared: Any, left: dict[int, Any], count: int
) -> Iterator[tuple[int, Any]]:
    """What one pool finishes of ``left``, which it is taken out of; ends early where a worker is
    killed.
    """
    context = multiprocessing.get_context(start_method())
    pool = ProcessPoolExecutor(
        count, context, initializer=_begin, initargs=(os.getpid(), function, shared)
    )
    try:
        for place, result in as_they_come(
            {pool.submit(_one, point): place for place, point in left.items()}
        ):
            del left[place]
            yield place, result
        pool.shutdown()
    except BrokenProcessPool:
        return
    finally:
        _end(pool)


def as_they_come(jobs: Mapping[Future[Any], int]) -> Iterator[tuple[int, Any]]:
    """(place, result) of every job as it ends, each handed out once and not kept; looks for a
    request to stop meanwhile.

    What a job raises is raised here, that its worker was killed after all others.
    """
    places, broken = dict(jobs), None
    del jobs
    while places:
        done, _ = wait(places, LOOK, FIRST_COMPLETED)
        look()
        for place, job in sorted(
            ((places.pop(one), one) for one in done), key=lambda pair: pair[0]
        ):
            try:
                result = job.result()
            except BrokenProcessPool as error:
                broken = error
                continue
            del job
            yield place, result
            del result
        del done
    if broken is not None:
        raise broken


def result_of(job: Future[Any]) -> Any:
    """The result of one job; looks for a request to stop while it waits."""
    while not wait((job,), LOOK).done:
        look()
    look()
    return job.result()


def _end(pool: ProcessPoolExecutor) -> None:
    """End a pool, where there is still something to end, without waiting for runs that nobody asks
    for any more.
    """
    workers = list((getattr(pool, "_processes", None) or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    for worker in workers:
        if worker.is_alive():
            worker.terminate()
    for worker in workers:
        worker.join(timeout=5)


def _begin(parent: int, function: Any, shared: Any) -> None:
    quiet_worker(parent)
    stay_on_one_thread()
    _SHARED[:] = [function, shared]


def _one(point: Any) -> Any:
    return _SHARED[0](_SHARED[1], point)


def quiet_worker(parent: int) -> None:
    """Make this worker process leave Ctrl-C to its ``parent`` (process id) and end with it, however
    that ends.
    """
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # it reaches every process of a terminal; the one that answers it is the parent
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if sys.platform == "linux":
        with suppress(AttributeError, OSError):
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it ended before that call
            os._exit(1)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """Where the system kills no orphans, a thread waits for the end of the parent."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        multiprocessing.connection.wait([parent.sentinel])
        os._exit(1)


class StandingPool:
    """Worker processes that stay for many batches of ``function(shared, point)``; ``count`` 1: this
    process. Use it as a context.

    Results stand in the order of the points. A run whose worker is killed is tried again by
    :func:`in_processes`; what is not to be had
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
        if self.count > 1:
            context = multiprocessing.get_context(start_method())
            self._pool = ProcessPoolExecutor(
                self.count,
                context,
                initializer=_begin,
                initargs=(os.getpid(), self.function, self.shared),
            )
            result_of(
                self._pool.submit(os.getpid)
            )  # begins all of them now, before any thread runs

    def __exit__(self, *_: object) -> None:
        if self._pool is not None:
            _end(self._pool)
        self._left.close()

    def map(self, points: Sequence[Any]) -> list[Any]:
        """The results of one batch."""
        results = dict(self.stream(points))
        return [results[place] for place in range(len(points))]

    def stream(self, points: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        """(place, result) of every point of one batch as it is finished."""
        if self._pool is None:
            for place, point in enumerate(points):
                look()
                yield place, self.function(self.shared, point)
            return
        left = set(range(len(points)))
        try:
            for place, result in as_they_come(
                {self._pool.submit(_one, point): place for place, point in enumerate(points)}
            ):
                left.discard(place)
                yield place, result
        except BrokenProcessPool:
            again = sorted(left)
            for number, result in in_processes(
                self.function, self.shared, [points[place] for place in again], self.count
            ):
                yield again[number], result
            _end(self._pool)
            self._start()
