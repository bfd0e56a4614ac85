"""Repeated runs over independent cases: one small function, the same answer for any number of
workers.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from numbers import Integral
from typing import Any, TypeVar

from valvetrain.errors import InputError, RunFailedError
from valvetrain.studies.workers import Lost, in_processes

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
