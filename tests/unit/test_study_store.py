"""Finished points on disk: nothing lost, nothing twice, and what is damaged refused with a
sentence.
"""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import numpy as np
import pytest

import valvetrain
from valvetrain import InputError
from valvetrain.explore.point import Outcome
from valvetrain.explore.store import CHUNK, JOURNAL, PointStore, computing_sources
from valvetrain.solution.status import COMPLETED, Status

OUTPUTS = ("peak_spring_force", "clash_count")
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


def filled(folder, numbers, close=True) -> PointStore:
    store = PointStore(folder, OUTPUTS)
    for number in numbers:
        store.add(key(number), outcome(number))
    if close:
        store.close()
    return store


def held(folder, count) -> None:
    """All of the first ``count`` points are there with their bits, and no other."""
    store = PointStore(folder, OUTPUTS)
    assert len(store) == count
    assert all(store.outcome(key(number)) == outcome(number) for number in range(count))
    store.close()


def test_points_come_back_to_the_last_bit_with_status_and_sentence(tmp_path):
    filled(tmp_path, range(40))
    held(tmp_path, 40)


def test_a_store_that_is_not_closed_loses_nothing(tmp_path):
    """As after SIGKILL: what was added stands in the journal, beyond whole chunks."""
    left = filled(tmp_path, range(CHUNK + 10), close=False)
    assert len(list(tmp_path.glob("chunk-*.nc"))) == 1 and (tmp_path / JOURNAL).stat().st_size > 0

    os.close(left._handle)
    held(tmp_path, CHUNK + 10)


@pytest.mark.parametrize("cut", [1, 20, 200])
def test_a_line_that_was_half_written_costs_that_point_alone(tmp_path, cut):
    left = filled(tmp_path, range(5), close=False)

    os.close(left._handle)
    content = (tmp_path / JOURNAL).read_bytes()
    last = content[:-1].rindex(b"\n") + 1
    (tmp_path / JOURNAL).write_bytes(content[: max(last, len(content) - cut)])
    held(tmp_path, 4)
    filled(tmp_path, [4])
    held(tmp_path, 5)


def test_a_point_that_stands_in_chunk_and_journal_is_there_once(tmp_path):
    """As after a kill between writing a chunk and emptying the journal."""
    left = filled(tmp_path, range(5), close=False)
    journal = (tmp_path / JOURNAL).read_bytes()
    left.close()
    (tmp_path / JOURNAL).write_bytes(journal)
    held(tmp_path, 5)
    assert (tmp_path / JOURNAL).stat().st_size == 0


def test_a_lost_worker_is_not_kept_so_that_the_point_is_tried_again(tmp_path):
    store = PointStore(tmp_path, OUTPUTS)
    store.add(key(1), Outcome(Status("worker-lost", "killed")))
    assert store.status(key(1)).code == "worker-lost"
    store.close()
    held(tmp_path, 0)


def test_points_of_other_outputs_are_left_alone(tmp_path):
    filled(tmp_path, range(3))
    other = PointStore(tmp_path, ("clash_count",))
    assert len(other) == 0
    other.close()
    held(tmp_path, 3)


def test_every_flipped_byte_of_a_chunk_is_refused_or_changes_nothing(tmp_path):
    filled(tmp_path, range(9))
    (path,) = tmp_path.glob("chunk-*.nc")
    content = path.read_bytes()
    for place in np.linspace(0, len(content) - 1, 60).astype(int):
        path.write_bytes(content[:place] + bytes([content[place] ^ 0x20]) + content[place + 1 :])
        with pytest.raises(InputError) as caught:
            PointStore(tmp_path, OUTPUTS)
        assert "\n" not in str(caught.value)
    path.write_bytes(content)
    held(tmp_path, 9)


@pytest.mark.parametrize("text", [b"", b"no chunk", b"\x89HDF\r\n"])
def test_a_file_that_is_no_chunk_is_refused_with_its_name(tmp_path, text):
    (tmp_path / "chunk-0.nc").write_bytes(text)
    with pytest.raises(InputError, match=r"chunk-0.nc"):
        PointStore(tmp_path, OUTPUTS)


def test_two_processes_do_not_work_on_one_store(tmp_path):
    pytest.importorskip("fcntl")
    first = PointStore(tmp_path, OUTPUTS)
    with pytest.raises(InputError, match="another process"):
        PointStore(tmp_path, OUTPUTS)
    first.close()
    PointStore(tmp_path, OUTPUTS).close()


def test_a_journal_line_is_text_that_people_can_read(tmp_path):
    filled(tmp_path, [5], close=False)
    line = (tmp_path / JOURNAL).read_text().partition(" ")[2]
    assert [float.fromhex(one) for one in json.loads(line)["values"]] == [5 * math.pi, math.sqrt(5)]


def test_points_grow_stale_with_what_computes_and_not_with_pages_and_commands():
    names = {
        path.relative_to(Path(valvetrain.__file__).parent).as_posix()
        for path in computing_sources()
    }
    assert {
        "explore/evaluate.py",
        "cosserat/step_kernels.py",
        "runs/run.py",
        "measured/sensor.py",
    } <= names
    assert not {
        name for name in names if name.startswith(("cli/", "report/", "film/", "workbench/"))
    }
    assert "explore/study_page.py" not in names and "explore/study_command.py" not in names
