"""Runs on a Dask cluster: one context, in which whatever is computed side by side is submitted to
the cluster instead of to processes of this machine. Results are bit-identical on like machines.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from valvetrain.errors import InputError, MissingExtraError, RunFailedError
from valvetrain.runs.stopping import POLL_INTERVAL, check_stop
from valvetrain.runs.workers import CLUSTER, Lost, one_thread, worker_count

HINT = "Dask is requested (--dask) but not installed; install the extra: pip install 'valvetrain[studies]'"
#: Times that Dask tries a job whose worker is lost.
TRIALS = 3
#: Seconds in which a scheduler must answer, and in which one given by address must have a worker.
PATIENCE = 20.0


@contextmanager
def on_cluster(where: str, workers: int | None = None) -> Iterator[int]:
    """Everything computed side by side in the block runs on a Dask cluster: sweeps, refinements,
    comparisons of models, studies, searches and identifications.

    Parameters
    ----------
    where : "local", the address of a scheduler, or the path of its scheduler file (.json); empty: this
        machine
    workers : workers to start of "local"; all cores of this machine by default. A scheduler has its own

    Yields
    ------
    int : runs at a time

    Raises
    ------
    InputError : no scheduler answers, or it has no workers; MissingExtraError where Dask is not
        installed; RunFailedError in the block where the scheduler ends

    Examples
    --------
    >>> import valvetrain as vt
    >>> with vt.runs.on_cluster("", workers=1) as at_a_time:
    ...     study = vt.sweep("job-t", "1000:2000:1000 rpm", ["massless"])
    >>> at_a_time, len(study.solutions)
    (1, 2)
    """
    count = worker_count(workers)
    if not where:
        yield count
        return
    cluster = Cluster(where, count)
    token = CLUSTER.set(cluster)
    try:
        yield cluster.workers
    finally:
        CLUSTER.reset(token)
        cluster.close()


class Cluster:
    """A connection to a Dask cluster; see :func:`on_cluster`."""

    def __init__(self, where: str, workers: int) -> None:
        try:
            import distributed
        except ImportError as error:
            raise MissingExtraError(HINT) from error
        self.where, self.workers = where[:80], workers
        self._left = ExitStack()
        self._left.callback(_quiet().setLevel, _quiet().level)
        _quiet().setLevel(logging.CRITICAL)  # a scheduler that ends is one sentence of ours
        connect: Any = distributed.Client
        file = {"scheduler_file": where} if where.endswith(".json") else {}
        try:
            if file and not Path(where).is_file():
                raise FileNotFoundError(where)
            cluster = None if file else self._cluster(distributed, where, workers)
            client = connect(cluster, timeout=PATIENCE, set_as_default=False, **file)
        except (OSError, TimeoutError, ValueError) as error:
            self._left.close()
            raise InputError(
                f"no Dask scheduler answers at '{self.where}' ({type(error).__name__}); check the address",
                "dask",
            ) from error
        self._client: Any = self._left.enter_context(client)
        if where != "local":
            self.workers = self._its_workers()
        self._sent: tuple[Any, Any] | None = None

    def _cluster(self, distributed: Any, where: str, workers: int) -> Any:
        if where != "local":
            return where
        cluster = distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address=":0",  # any free port
            protocol="tcp",
            silence_logs=50,
        )
        return self._left.enter_context(cluster)

    def _its_workers(self) -> int:
        """Runs that the workers of a scheduler take at a time."""
        until = time.monotonic() + PATIENCE
        while not (threads := sum(self._client.nthreads().values())):
            check_stop()
            if time.monotonic() > until:
                self._left.close()
                raise InputError(
                    f"the Dask scheduler at '{self.where}' has no workers; start some: dask worker ADDRESS",
                    "dask",
                )
            time.sleep(POLL_INTERVAL)
        return int(threads)

    def stream(
        self, function: Callable[[Any, Any], Any], shared: Any, points: Sequence[Any]
    ) -> Iterator[tuple[int, Any]]:
        """(index, ``function(shared, point)``) of every point as it is finished; :class:`Lost` for
        one that kills its workers.
        """
        import distributed

        client = self._client
        if self._sent is None or self._sent[0] is not shared:
            # sent once and under a name of its own: by a name made from the content, a batch could
            # lose it to the release of the last
            self._sent = shared, client.scatter(shared, broadcast=True, hash=False)
        futures = client.map(
            _one,
            list(enumerate(points)),
            function=function,
            shared=self._sent[1],
            pure=False,
            retries=TRIALS,
        )
        indices = {future.key: index for index, future in enumerate(futures)}
        finished: Any = distributed.as_completed  # untyped
        coming = finished(futures, loop=client.loop)
        del futures
        try:
            while indices:
                check_stop()
                batch = coming.next_batch(block=False)
                if not batch:
                    time.sleep(POLL_INTERVAL)
                for future in batch:
                    yield indices.pop(future.key), self._result(future)
                    future.release()
        finally:
            coming.clear()

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """``function(*arguments)``, by a thread that waits for it; :class:`Lost` as above."""
        future = self._client.submit(_called, function, arguments, pure=False, retries=TRIALS)
        while not future.done():
            check_stop()
            time.sleep(POLL_INTERVAL)
        return self._result(future)

    def _result(self, future: Any) -> Any:
        from distributed.client import FutureCancelledError
        from distributed.comm.core import CommClosedError

        if future.status == "finished":
            with suppress(
                CommClosedError, FutureCancelledError
            ):  # it ends while the result is fetched
                return future.result()
        elif future.status == "error":
            error = future.exception()
            if type(error).__name__ == "KilledWorker":
                return Lost()
            raise error
        raise RunFailedError(
            f"the Dask scheduler at '{self.where}' ended; finished points are saved: start the scheduler and run the command again"
        )

    def close(self) -> None:
        """Leave the cluster; a local one ends."""
        self._sent = None
        self._left.close()


def _quiet() -> logging.Logger:
    return logging.getLogger("distributed.client")


def _one(numbered: tuple[int, Any], *, function: Callable[[Any, Any], Any], shared: Any) -> Any:
    with one_thread():
        return function(shared, numbered[1])


def _called(function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    with one_thread():
        return function(*arguments)
