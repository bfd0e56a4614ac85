"""A study on a real local Dask cluster: the bits of one process, a worker killed on the way, the
client killed and gone on.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import MODULE, call, process_environment, wait_until
from valvetrain.explore.executors import DaskExecutor
from valvetrain.solution.status import COMPLETED

pytest.importorskip("distributed")

#: Set by ``make faults``, for what takes too long for every run of the tests.
LONG = "VALVETRAIN_LONG"
TEXT = """
case = "gu2021-beehive"
engine_speeds = "6000 rpm"
spring_models = ["multi-mass"]
outputs = ["peak_spring_force", "clash_count"]
points = {{ sampler = "sobol", count = {count}, seed = 4 }}
vary = [{{ key = "spring.precompression", low = "6 mm", high = "8 mm" }}]
"""


def children(process_id: int) -> list[int]:
    """Processes below a process, all generations."""
    listed = subprocess.run(
        ["ps", "-e", "-o", "pid=,ppid="], capture_output=True, text=True, check=True
    ).stdout
    parents: dict[int, list[int]] = {}
    for line in listed.splitlines():
        own, parent = map(int, line.split())
        parents.setdefault(parent, []).append(own)
    found, left = [], [process_id]
    while left:
        mine = parents.get(left.pop(), [])
        found += mine
        left += mine
    return found


def workers_of(process_id: int) -> list[int]:
    """Worker processes of a local cluster: those that say so."""

    def words(one: int) -> str:
        try:
            with open(f"/proc/{one}/cmdline", "rb") as stream:
                return stream.read().replace(b"\0", b" ").decode()
        except OSError:
            return ""

    return [one for one in children(process_id) if "spawn_main" in words(one)]


def kept(folder) -> int:
    file = folder / "points" / "points.jsonl"
    return file.read_bytes().count(b"\n") - 1 if file.exists() else 0


@pytest.mark.slow
@pytest.mark.skipif(
    not os.environ.get(LONG) or not os.path.isdir("/proc"),
    reason=f"a minute: make faults sets {LONG}; needs /proc",
)
def test_a_worker_and_then_the_client_are_killed_and_every_point_is_found_once(tmp_path):
    count = 64
    text = TEXT.format(count=count)
    file, folder = tmp_path / "study.toml", tmp_path / "out"
    file.write_text(text)
    command = [
        sys.executable,
        *MODULE,
        "study",
        str(file),
        "--output",
        str(folder),
        "--workers",
        "2",
        "--dask",
        "local",
        "--json",
    ]
    began = subprocess.Popen(
        command,
        cwd=tmp_path,
        env=process_environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    wait_until(lambda: kept(folder) >= 8 or began.poll() is not None, "the first points")
    assert began.poll() is None
    os.kill(workers_of(began.pid)[0], signal.SIGKILL)
    reached = kept(folder)
    wait_until(
        lambda: kept(folder) >= reached + 8 or began.poll() is not None,
        "points after the loss of a worker",
    )
    assert began.poll() is None
    began.kill()
    began.communicate(timeout=60)
    there = kept(folder)
    done = subprocess.run(
        command,
        cwd=tmp_path,
        env=process_environment(),
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    data = json.loads(done.stdout)
    assert data["computed_now"] == count - there > 0
    alone = vt.study(text, workers=1)
    found = np.array([row["outputs"] for row in data["rows"]], dtype=float)
    assert np.array_equal(found, alone.values) and data["completed_points"] == count


def test_a_cluster_by_its_address_gives_the_bits_of_one_process():
    """In threads of this process, so that nothing is started."""
    import distributed

    text = TEXT.format(count=4).replace("multi-mass", "massless")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None, silence_logs=50
    ) as cluster:
        found = vt.study(text, dask=cluster.scheduler_address, workers=1)
    alone = vt.study(text, workers=1)
    assert np.array_equal(found.values, alone.values, equal_nan=True) and set(found.statuses) == {
        COMPLETED
    }


def tripled(shared: tuple[int, str], number: int) -> int:
    return shared[0] * number


def test_no_batch_of_many_loses_what_all_of_them_share():
    """A search asks for batch after batch; the release of the last one's shared part took away that
    of the next, of the same content.
    """
    import distributed

    shared = (3, "x" * 100_000)
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None, silence_logs=50
    ) as cluster:
        executor = DaskExecutor(cluster.scheduler_address, 2)
        try:
            for first in range(12):
                found = dict(executor.run(tripled, shared, range(first, first + 3)))
                assert found == {place: 3 * (first + place) for place in range(3)}
            assert dict(executor.run(tripled, (5, ""), range(2))) == {0: 0, 1: 5}
        finally:
            executor.close()


def test_a_scheduler_that_is_not_there_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "study.toml"
    file.write_text(TEXT.format(count=2))
    answer = call("study", str(file), "--quiet", "--dask", "no scheme://nowhere")
    assert (
        answer.exit_code == 2 and "--dask" in answer.stderr and len(answer.stderr.splitlines()) == 1
    )


def test_without_dask_the_command_that_installs_it_is_told(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(vt.ValvetrainError, match="pip install"):
        vt.study(TEXT.format(count=2), dask="local", workers=1)
    monkeypatch.undo()
    monkeypatch.setitem(sys.modules, "dask_jobqueue", None)
    with pytest.raises(vt.ValvetrainError, match="dask-jobqueue"):
        vt.study(TEXT.format(count=2), dask="slurm", workers=1)


def test_a_study_without_dask_never_loads_it(tmp_path):
    heavy = "('dask', 'distributed', 'sklearn')"
    code = f"import sys, valvetrain as vt; vt.study(sys.argv[1], workers=1); print([n for n in {heavy} if n in sys.modules])"
    file = tmp_path / "study.toml"
    file.write_text(TEXT.format(count=2).replace("multi-mass", "massless"))
    done = subprocess.run(
        [sys.executable, "-c", code, str(file)],
        capture_output=True,
        text=True,
        env=process_environment(),
        check=True,
    )
    assert done.stdout.strip() == "[]"
