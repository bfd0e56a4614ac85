"""Linear algebra on one thread while runs are computed: its own threads wait for each other longer
than such small matrices take.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager

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
