"""Unit: linear algebra has one thread while runs are computed, in this process and in workers, and
its own number again after.
"""

from __future__ import annotations

import multiprocessing

import pytest
import scipy.linalg  # noqa: F401  its library counts too
from threadpoolctl import threadpool_info, threadpool_limits

from valvetrain.runs.workers import StandingPool, map_points, one_thread


def counts(*_: object) -> list[int]:
    """Threads of every library of linear algebra that this process has loaded."""
    return [one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"]


@pytest.fixture(autouse=True)
def many():
    with threadpool_limits(3, user_api="blas"):
        assert set(counts()) == {3}
        yield
        assert set(counts()) == {3}, "as it was"


def in_pool(workers: int) -> list[list[int]]:
    with StandingPool(counts, None, workers) as pool:
        return [one for _, one in pool.stream(range(3))]


def in_processes(workers: int) -> list[list[int]]:
    return list(map_points(counts, None, range(3), workers, True))


def in_threads(workers: int) -> list[list[int]]:
    return list(map_points(counts, None, range(3), workers))


@pytest.mark.parametrize("method", ["fork", "spawn"])
@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("asked", [in_pool, in_processes, in_threads])
def test_runs_are_computed_with_one_thread_each(asked, workers, method, monkeypatch):
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip("this system starts processes in one way alone")
    monkeypatch.setattr("valvetrain.runs.workers.start_method", lambda: method)
    found = asked(workers)
    assert len(found) == 3 and all(one and set(one) == {1} for one in found)


def test_the_last_of_several_blocks_gives_the_threads_back():
    first, second = one_thread(), one_thread()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert set(counts()) == {1}
    second.__exit__(None, None, None)
    assert set(counts()) == {3}


def test_a_failed_run_gives_the_threads_back():
    with pytest.raises(ZeroDivisionError):
        map_points(lambda *_: 1 // 0, None, range(3), 1)
    assert set(counts()) == {3}
