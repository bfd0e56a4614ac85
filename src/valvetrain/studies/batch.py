"""Repeated runs over independent cases: one small function, the same answer for any number of workers."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

from valvetrain.errors import InputError

Case = TypeVar("Case")
Result = TypeVar("Result")


def map_cases(
    function: Callable[[Case], Result],
    cases: Iterable[Case],
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Result, ...]:
    """A function of every case, in their order, over processes: every case runs by itself, so results do not depend on ``workers``.

    Parameters
    ----------
    function : of one case; importable (a module-level function or a partial of one), with results that pickle
    cases : what the function takes, one after the other
    workers : processes; None for one per core, 1 for this process
    progress : called as ``progress(done, total)`` after each case

    Returns
    -------
    tuple of the results, one per case

    Raises
    ------
    InputError : fewer than one worker; what the function raises

    Examples
    --------
    >>> import valvetrain as vt
    >>> [case.name for case in vt.map_cases(vt.load_case, ["job-t", "gu2021-beehive"], workers=1)]
    ['job-t', 'gu2021-beehive']
    """
    items: Sequence[Case] = tuple(cases)
    count = available_cores() if workers is None else workers
    if count < 1:
        raise InputError(f"workers must be 1 or more; it is {count}")
    count = min(count, max(len(items), 1))
    results = []
    for done, result in enumerate(_results(function, items, count), start=1):
        results.append(result)
        if progress is not None:
            progress(done, len(items))
    return tuple(results)


def available_cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)


def _results(function: Callable[[Case], Result], items: Sequence[Case], count: int) -> Iterator[Result]:
    if count == 1:
        yield from map(function, items)
        return
    # a forked child of a threaded parent can hang; a fresh interpreter costs half a second and loads the compiled kernels from disk
    method = start_method()
    # Ctrl-C reaches every process of a terminal; the one that answers it is this one
    quiet = (signal.SIGINT, signal.SIG_IGN)
    with ProcessPoolExecutor(count, multiprocessing.get_context(method), initializer=signal.signal, initargs=quiet) as pool:
        yield from pool.map(function, items, chunksize=max(1, len(items) // (8 * count)))


def start_method() -> str:
    """How worker processes begin: forked where no thread runs, else as fresh interpreters."""
    import threading

    return "fork" if "fork" in multiprocessing.get_all_start_methods() and threading.active_count() == 1 else "spawn"
