"""Finished points on disk: nothing lost, nothing twice, and what is damaged computed again."""

from __future__ import annotations

import math
import os

import numpy as np
import pytest

from valvetrain import InputError
from valvetrain.explore.outputs import Outcome
from valvetrain.explore.store import FILE, Store
from valvetrain.solution.status import COMPLETED, Status

FAILED = Status("refused", "the coils overlap; thin the wire")


def key(number: int) -> bytes:
    return number.to_bytes(16, "big")


def outcome(number: int) -> Outcome:
    """Values whose bits no decimal text of ten digits holds."""
    if number % 7 == 3:
        return Outcome(FAILED)
    return Outcome(
        COMPLETED, {"peak_spring_force": math.pi * number, "clash_count": math.sqrt(number)}
    )


def filled(folder, numbers, close=True) -> Store:
    store = Store(folder)
    for number in numbers:
        store.add(key(number), outcome(number))
    if close:
        store.close()
    return store


def held(folder, count) -> None:
    """All of the first ``count`` points are there with their bits, and no other."""
    with Store(folder) as store:
        assert len(store) == count
        assert all(store.outcome(key(number)) == outcome(number) for number in range(count))


def test_a_store_that_is_not_closed_loses_nothing(tmp_path):
    """As after SIGKILL: every point is in the file once ``add`` has returned."""
    left = filled(tmp_path, range(300), close=False)
    os.close(left._handle)
    held(tmp_path, 300)


@pytest.mark.parametrize("cut", [1, 20, 200])
def test_a_line_that_was_half_written_costs_that_point_alone(tmp_path, cut):
    filled(tmp_path, range(5))
    content = (tmp_path / FILE).read_bytes()
    last = content[:-1].rindex(b"\n") + 1
    (tmp_path / FILE).write_bytes(content[: max(last, len(content) - cut)])
    held(tmp_path, 4)
    filled(tmp_path, [4])
    held(tmp_path, 5)


def test_a_lost_worker_is_not_stored_so_that_the_point_is_tried_again(tmp_path):
    with Store(tmp_path) as store:
        store.add(key(1), Outcome(Status("worker-lost", "killed")))
        assert store.outcome(key(1)).status.code == "worker-lost"
    held(tmp_path, 0)


def test_a_damaged_byte_costs_the_points_from_there_on_and_changes_none(tmp_path):
    filled(tmp_path, range(9))
    path = tmp_path / FILE
    content = path.read_bytes()
    for index in np.linspace(0, len(content) - 1, 60).astype(int):
        path.write_bytes(content[:index] + bytes([content[index] ^ 0x20]) + content[index + 1 :])
        held(tmp_path, content[:index].count(b"\n"))


def test_two_processes_do_not_work_on_one_store(tmp_path):
    pytest.importorskip("fcntl")
    with Store(tmp_path):
        with pytest.raises(InputError, match="another process"):
            Store(tmp_path)
    Store(tmp_path).close()
