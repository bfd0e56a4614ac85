"""Executors of points: in-process, processes of this machine, or Dask. Results are bit-identical."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from typing import Any, Protocol

from valvetrain.errors import InputError, MissingExtraError
from valvetrain.runs.stopping import check_stop
from valvetrain.runs.workers import Lost, StandingPool

Function = Callable[[Any, Any], Any]
HINT = "Dask is requested (--dask) but not installed; install the extra: pip install 'valvetrain[studies]'"
#: Times that Dask tries a job whose worker is lost, and a job alone after that.
TRIALS = 3
#: Classes of dask-jobqueue by the name of their scheduler.
QUEUES = {
    "slurm": "SLURMCluster",
    "pbs": "PBSCluster",
    "sge": "SGECluster",
    "lsf": "LSFCluster",
    "htcondor": "HTCondorCluster",
}


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


class DaskExecutor:
    """A Dask cluster: ``local``, the address of a scheduler, or the name of a queue of
    dask-jobqueue (``slurm``, ``pbs``).

    Raises :class:`MissingExtraError` where Dask, or dask-jobqueue for a queue, is not installed,
    :class:`InputError` where the scheduler
    does not answer.
    """

    def __init__(self, where: str, workers: int) -> None:
        try:
            import distributed
        except ImportError as error:
            raise MissingExtraError(HINT) from error
        self._left = ExitStack()
        self.workers = workers
        connect: Any = distributed.Client
        try:
            cluster = self._cluster(distributed, where, workers)
            client = connect(cluster, timeout="20s", set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            self._left.close()
            raise InputError(
                f"no Dask scheduler answers at '{where[:80]}' ({type(error).__name__}); check the address",
                "dask",
            ) from error
        self._client: Any = self._left.enter_context(client)
        self._sent: tuple[Any, Any] | None = None

    def _cluster(self, distributed: Any, where: str, workers: int) -> Any:
        if where == "local":
            cluster = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                dashboard_address=None,
                protocol="tcp",
                silence_logs=50,
            )
        elif where in QUEUES:
            try:
                import dask_jobqueue
            except ImportError as error:
                raise MissingExtraError(
                    f"--dask {where} needs dask-jobqueue; install it: pip install dask-jobqueue"
                ) from error
            cluster = getattr(
                dask_jobqueue, QUEUES[where]
            )()  # its settings are those of the site (jobqueue.yaml)
            cluster.scale(workers)
        else:
            return where
        return self._left.enter_context(cluster)

    def run(
        self, function: Function, shared: Any, jobs: Sequence[Any]
    ) -> Iterator[tuple[int, Any]]:
        import distributed

        client = self._client
        if self._sent is None or self._sent[0] is not shared:
            # sent once and under a name of its own: by a name made from the content, a batch could
            # lose it to the release of the last
            self._sent = shared, client.scatter(shared, broadcast=True, hash=False)
        on_cluster = self._sent[1]
        futures = client.map(
            _one,
            list(enumerate(jobs)),
            function=function,
            shared=on_cluster,
            pure=False,
            retries=TRIALS,
        )
        indices = {future.key: index for index, future in enumerate(futures)}
        waiting: Any = distributed.as_completed  # untyped
        coming = waiting(futures, loop=client.loop)
        del futures
        try:
            for future in coming:
                check_stop()
                index = indices.pop(future.key)
                error = future.exception() if future.status == "error" else None
                if error is not None and type(error).__name__ != "KilledWorker":
                    raise error
                yield (
                    index,
                    Lost() if error is not None or future.status != "finished" else future.result(),
                )
                future.release()
        finally:
            coming.clear()

    def close(self) -> None:
        """Leave the cluster; a local one ends."""
        self._sent = None
        self._left.close()


def _one(numbered: tuple[int, Any], *, function: Function, shared: Any) -> Any:
    return function(shared, numbered[1])


def executor_for(workers: int, dask: str = "") -> Executor:
    """The executor for ``--workers`` and ``--dask``."""
    return DaskExecutor(dask, workers) if dask else LocalExecutor(workers)
