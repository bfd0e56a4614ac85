"""Executors of points: in-process, processes of this machine, or the cluster in use."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

from valvetrain.runs.workers import StandingPool

Function = Callable[[Any, Any], Any]


class Executor(Protocol):
    """Computes ``function(shared, job)`` of jobs, one result each."""

    @property
    def workers(self) -> int:
        """Jobs at a time."""
        ...

    def run(
        self, function: Function, shared: Any, jobs: Sequence[Any]
    ) -> Iterator[tuple[int, Any]]:
        """(place, result) of every job as it is finished; :class:`valvetrain.runs.workers.Lost`
        for one whose workers were killed.
        """
        ...

    def close(self) -> None:
        """Release processes and connections."""
        ...


class LocalExecutor:
    """This process for one worker, else processes of this machine that stay for many batches of the
    same function and shared object.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._pool: StandingPool | None = None

    def run(
        self, function: Function, shared: Any, jobs: Sequence[Any]
    ) -> Iterator[tuple[int, Any]]:
        if not jobs:
            return
        pool = self._pool
        if pool is None or pool.function is not function or pool.shared is not shared:
            self.close()
            self._pool = pool = StandingPool(function, shared, self.workers).__enter__()
        yield from pool.stream(jobs)

    def close(self) -> None:
        """End the processes."""
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.__exit__()
