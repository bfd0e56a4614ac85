"""Runs on real Dask clusters: the bits of one process for every command, a worker killed on the way,
the client killed and gone on, a scheduler that ends, the job script of docs/clusters.md.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import MODULE, call, process_environment, wait_until
from unit.test_identification_answer import CARD, FILE
from valvetrain.errors import RunFailedError
from valvetrain.explore.files import FileText
from valvetrain.explore.study import StudyModel, estimate_study, read_plan
from valvetrain.runs.cluster import Cluster
from valvetrain.runs.workers import map_points
from valvetrain.solution.status import COMPLETED

pytest.importorskip("distributed")

#: Set by ``make faults``, for what takes too long for every run of the tests.
LONG = "VALVETRAIN_LONG"
TEXT = """
case = "gu2021-beehive-blind"
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
    words = f"study {file} --output {folder} --workers 2 --dask local --json"
    command, here = (
        [sys.executable, *MODULE, *words.split()],
        {"cwd": tmp_path, "env": process_environment()},
    )
    began = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **here)
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
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True, **here)
    data = json.loads(done.stdout)
    assert data["computed"] == count - there > 0
    alone = vt.study(text, workers=1)
    found = np.array([[row[name] for name in alone.outputs] for row in data["rows"]], dtype=float)
    assert np.array_equal(found, alone.values) and data["completed_points"] == count


def test_a_cluster_by_its_address_gives_the_bits_of_one_process():
    """In threads of this process, so that nothing is started."""
    text = TEXT.format(count=4).replace("multi-mass", "massless").replace(', "clash_count"', "")
    with threads_of_this_process(1) as address:
        found = vt.study(text, dask=address, workers=1)
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
    shared = (3, "x" * 100_000)
    with threads_of_this_process(2) as address, vt.runs.on_cluster(address) as count:
        assert count == 2
        for first in range(12):
            found = map_points(tripled, shared, range(first, first + 3), processes=True)
            assert found == tuple(3 * (first + place) for place in range(3))
        assert map_points(tripled, (5, ""), range(2)) == (0, 5)


@contextmanager
def threads_of_this_process(count: int) -> Iterator[str]:
    """Address of a cluster for which nothing is started."""
    import distributed

    options = {"processes": False, "dashboard_address": None, "silence_logs": 50}
    workers = min(count, 1)
    with distributed.LocalCluster(
        n_workers=workers, threads_per_worker=count, **options
    ) as cluster:
        yield cluster.scheduler_address


@pytest.mark.parametrize(
    "compute",
    [
        lambda: vt.sweep("job-t", "1000:3000:1000 rpm", ["massless", "multi-mass"]),
        lambda: vt.sweep("tdi-pushrod", "6000, 7000 rpm", ["massless"], spring_sets="stock"),
        pytest.param(
            lambda: vt.refine("job-t", "2000 rpm"),
            marks=pytest.mark.skipif(not os.environ.get(LONG), reason=f"make faults sets {LONG}"),
        ),
    ],
    ids=["springs", "trains", "refine"],
)
@pytest.mark.slow
def test_what_runs_side_by_side_has_the_bits_of_one_process_on_a_cluster(compute, monkeypatch):
    """Contract: sweeps and refinements go to the cluster in use."""
    submitted = noted_submissions(monkeypatch)
    with threads_of_this_process(2) as address, vt.runs.on_cluster(address):
        found = compute()
    assert submitted
    assert numbers_of(found) == numbers_of(compute())


def noted_submissions(monkeypatch) -> list[tuple]:
    """What clusters are given from now on."""
    submitted: list[tuple] = []
    for name in ("stream", "call"):
        own = getattr(Cluster, name)

        def noted(self, *arguments, own=own):
            submitted.append(arguments)
            return own(self, *arguments)

        monkeypatch.setattr(Cluster, name, noted)
    return submitted


def test_identify_on_a_cluster_has_the_bits_of_one_process(tmp_path, monkeypatch):
    """Contract: the command submits its points to the cluster and finds what one process finds."""
    (tmp_path / "card.toml").write_text(CARD)
    (tmp_path / "two.toml").write_text(FILE)
    submitted = noted_submissions(monkeypatch)

    def found(folder: str, *more: str) -> dict:
        words = ("--json", "--output", str(tmp_path / folder), *more)
        answer = call("identify", str(tmp_path / "two.toml"), *words)
        assert answer.exit_code == 0, answer.stderr
        data = json.loads(answer.stdout)
        return {key: data[key] for key in ("branches", "predicted")}

    with threads_of_this_process(1) as address:
        on_cluster = found("cluster", "--dask", address)
    assert submitted
    assert on_cluster == found("alone", "--workers", "1")


def numbers_of(found) -> list[object]:
    if hasattr(found, "solutions"):
        critical = getattr(found, "critical_speeds", ())
        return [(run.label, run.engine_speed, dict(run.quantities)) for run in found.solutions] + [
            critical
        ]
    return [(one.quantity, one.engine_speed, one.value, one.numerical) for one in found.rows]


def test_a_scheduler_that_is_not_there_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "study.toml"
    file.write_text(TEXT.format(count=2))
    answer = call("study", str(file), "--quiet", "--dask", "no scheme://nowhere")
    assert (
        answer.exit_code == 2 and "--dask" in answer.stderr and len(answer.stderr.splitlines()) == 1
    )


def test_estimates_are_made_by_the_workers_of_the_cluster(monkeypatch):
    """Closed form: forty workers take a fortieth of the time of one, and no memory of this machine."""
    monkeypatch.setattr(Cluster, "_its_workers", lambda self: 40)
    plan = read_plan(FileText(TEXT.format(count=64), "study", Path(), StudyModel))
    alone, two = estimate_study(plan, 1), estimate_study(plan, 2)
    with threads_of_this_process(1) as address, vt.runs.on_cluster(address, workers=1) as count:
        there = estimate_study(plan, count)
    assert there.seconds == pytest.approx(alone.seconds / 40)
    assert there.bytes == pytest.approx(2 * alone.bytes - two.bytes)


def test_a_scheduler_without_workers_is_one_sentence(monkeypatch):
    monkeypatch.setattr("valvetrain.runs.cluster.PATIENCE", 2.0)
    with threads_of_this_process(0) as address:
        with pytest.raises(vt.InputError, match="has no workers; start some"):
            vt.study(TEXT.format(count=2), dask=address)


def test_a_scheduler_that_ends_is_told_as_such_and_not_as_a_killed_worker(tmp_path):
    """Contract: what was finished before arrives, then one sentence that names the scheduler."""

    def slow(shared: None, number: int) -> int:
        time.sleep(0.2)
        return number

    file = tmp_path / "scheduler.json"
    options = {"cwd": tmp_path, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    options["env"] = process_environment()
    dask = [sys.executable, "-m", "dask"]
    scheduler = subprocess.Popen(
        [*dask, "scheduler", "--scheduler-file", str(file), "--port", "0", "--no-dashboard"],
        **options,
    )
    words = f"worker --scheduler-file {file} --nthreads 1 --no-nanny --no-dashboard"
    worker = subprocess.Popen([*dask, *words.split()], **options)
    try:
        wait_until(file.is_file, "the scheduler's file")
        finished: list[int] = []

        def end_of_the_scheduler(index: int, _: int) -> None:
            finished.append(index)
            if len(finished) == 2:
                scheduler.kill()

        with (
            vt.runs.on_cluster(str(file)),
            pytest.raises(RunFailedError, match=r"scheduler .* ended"),
        ):
            map_points(slow, None, range(200), finished=end_of_the_scheduler)
        assert len(finished) >= 2
    finally:
        scheduler.kill()
        worker.kill()
        scheduler.wait()
        worker.wait()


def test_without_dask_the_command_that_installs_it_is_told(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(vt.ValvetrainError, match="pip install"):
        vt.study(TEXT.format(count=2), dask="local", workers=1)


def test_a_study_without_dask_never_loads_it(tmp_path):
    heavy = "('dask', 'distributed', 'sklearn')"
    code = f"import sys, valvetrain as vt; vt.study(sys.argv[1], workers=1); print([n for n in {heavy} if n in sys.modules])"
    file = tmp_path / "study.toml"
    file.write_text(
        TEXT.format(count=2).replace("multi-mass", "massless").replace(', "clash_count"', "")
    )
    done = subprocess.run([sys.executable, "-c", code, str(file)], capture_output=True, text=True, env=process_environment(), check=True)  # fmt: skip
    assert done.stdout.strip() == "[]"
