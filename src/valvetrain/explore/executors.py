"""Who computes the points of a study: this process, processes of this machine, or a Dask cluster.
The same bits from each.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Protocol

from valvetrain.errors import InputError, MissingExtraError
from valvetrain.runs.stopping import check_stop
from valvetrain.runs.workers import Lost, in_processes, one_thread

Function = Callable[[Any, Any], Any]
HINT = "Dask is asked for (--dask) but not installed; install the extra: pip install 'valvetrain[studies]'"
#: Times that Dask tries a job whose worker is lost, and a job alone after that.
TRIALS = 3
#: Classes of dask-jobqueue by the word of their scheduler.
QUEUES = {
    "slurm": "SLURMCluster",
    "pbs": "PBSCluster",
    "sge": "SGECluster",
    "lsf": "LSFCluster",
    "htcondor": "HTCondorCluster",
}


class Executor(Protocol):
    """Computes ``function(shared, job)`` of jobs, each answered once."""

    @property
    def workers(self) -> int:
        """Jobs at a time, as far as it is known."""
        ...

    def run(
        self, function: Function, shared: Any, jobs: Sequence[Any]
    ) -> Iterator[tuple[int, Any]]:
        """(place, result) of every job as it is finished; :class:`valvetrain.runs.workers.Lost`
        for one that is not to be had.
        """
        ...

    def close(self) -> None:
        """Give back what it holds."""
        ...


@dataclass(frozen=True, slots=True)
class LocalExecutor:
    """This process for one worker, else processes of this machine."""

    workers: int

    def run(
        self, function: Function, shared: Any, jobs: Sequence[Any]
    ) -> Iterator[tuple[int, Any]]:
        if self.workers > 1 and len(jobs) > 1:
            yield from in_processes(function, shared, jobs, min(self.workers, len(jobs)))
            return
        with one_thread():
            for place, job in enumerate(jobs):
                check_stop()
                yield place, function(shared, job)

    def close(self) -> None:
        """Nothing is held."""


class DaskExecutor:
    """A Dask cluster: ``local``, the address of a scheduler, or the word of a queue of
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
                "--dask",
            ) from error
        self._client: Any = self._left.enter_context(client)
        self._sent: tuple[Any, Any] | None = None

    def _cluster(self, distributed: Any, where: str, workers: int) -> Any:
        if where == "local":
            made = distributed.LocalCluster(
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
            made = getattr(
                dask_jobqueue, QUEUES[where]
            )()  # its settings are those of the site (jobqueue.yaml)
            made.scale(workers)
        else:
            return where
        return self._left.enter_context(made)

    def run(
        self, function: Function, shared: Any, jobs: Sequence[Any]
    ) -> Iterator[tuple[int, Any]]:
        import distributed

        client = self._client
        if self._sent is None or self._sent[0] is not shared:
            # sent once and under a name of its own: by a name made from the content, a batch could
            # lose it to the release of the last
            self._sent = shared, client.scatter(shared, broadcast=True, hash=False)
        common = self._sent[1]
        futures = client.map(
            _one,
            list(enumerate(jobs)),
            function=function,
            shared=common,
            pure=False,
            retries=TRIALS,
        )
        places = {future.key: place for place, future in enumerate(futures)}
        waiting: Any = distributed.as_completed  # untyped
        coming = waiting(futures, loop=client.loop)
        del futures
        try:
            for future in coming:
                check_stop()
                place = places.pop(future.key)
                error = future.exception() if future.status == "error" else None
                if error is not None and type(error).__name__ != "KilledWorker":
                    raise error
                yield (
                    place,
                    Lost() if error is not None or future.status != "finished" else future.result(),
                )
                future.release()
        finally:
            coming.clear()

    def close(self) -> None:
        """Leave the cluster; one made here ends."""
        self._sent = None
        self._left.close()


def _one(numbered: tuple[int, Any], *, function: Function, shared: Any) -> Any:
    return function(shared, numbered[1])


def executor_for(workers: int, dask: str = "") -> Executor:
    """The crew asked for."""
    return DaskExecutor(dask, workers) if dask else LocalExecutor(workers)
