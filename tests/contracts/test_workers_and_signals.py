"""Killed workers, killed parents, Ctrl-C and SIGTERM: what was finished is there, and nothing goes
on or stays behind.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest
import typer

from fault_parts import (
    SWEEP,
    gone,
    killed_always,
    killed_once,
    marked,
    square,
    started,
)
from unit.cli_parts import process, process_environment, wait_until
from valvetrain.cli.guard import GuardedGroup, interrupted
from valvetrain.errors import RunFailedError
from valvetrain.runs.stopping import PointsStopped, Stopped, listening
from valvetrain.runs.workers import map_points, result_of, threads

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="finds processes by their environment in /proc"
)
ROWS = "unfinished-runs.jsonl"


def test_a_killed_worker_costs_no_result(tmp_path):
    points = range(12)
    expected = map_points(square, tmp_path, points, 1)
    assert (
        map_points(killed_once, tmp_path, points, 2, processes=True)
        == expected
        == tuple(n * n for n in points)
    )
    assert (tmp_path / "killed").exists()


def test_a_run_that_always_kills_its_worker_costs_itself_alone(tmp_path):
    came: list[int] = []
    found = map_points(
        killed_always,
        tmp_path,
        range(6),
        2,
        processes=True,
        lost=lambda point: -point,
        finished=lambda place, _: came.append(place),
    )
    assert found == (0, 1, 4, -3, 16, 25) and sorted(came) == list(range(6))
    with pytest.raises(RunFailedError, match="killed"):
        map_points(killed_always, tmp_path, (2, 3), 2, processes=True)


def test_a_speed_whose_worker_is_killed_is_a_status_and_the_others_are_there(monkeypatch):
    """The status of the whole study: the run of one speed kills every process but this one."""
    import valvetrain.runs.train_runs as run
    from valvetrain.parameters.loading import load_case
    from valvetrain.runs.api import simulate

    usual, here = run.train_block, os.getpid()

    def deadly(shared, block):
        if block[-1][1] > 300 and os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        return usual(shared, block)

    deadly.__module__, deadly.__qualname__ = run.__name__, "train_block"
    monkeypatch.setattr(run, "train_block", deadly)
    monkeypatch.setattr("valvetrain.runs.workers.start_method", lambda: "fork")
    study = simulate(
        load_case("tdi-pushrod"),
        engine_speeds=(150.0, 295.0, 305.0),
        models=("massless",),
        spring_sets=("stock",),
        workers=2,
        whole=False,
    )
    assert [one.status.code for one in study.solutions] == ["completed", "completed", "worker-lost"]
    assert (
        len(study.failures) == 1
        and "was killed" in study.failures[0]
        and "fewer workers" in study.failures[0]
    )


def test_workers_end_with_a_parent_that_is_killed(tmp_path):
    code = (
        "from pathlib import Path; from fault_parts import slow; from valvetrain.runs.workers import map_points\n"
        f"map_points(slow, Path({str(tmp_path)!r}), (1, 2), 2, processes=True)"
    )
    tests = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    path = os.pathsep.join((tests, os.path.join(os.path.dirname(tests), "src")))
    with started(folder=tmp_path, code=code, PYTHONPATH=path) as (run, mark):
        wait_until(lambda: len(list(tmp_path.glob("begun-*"))) == 2, "both workers begin")
        assert len(marked(mark)) >= 3
        run.kill()
        run.wait()
        gone(mark)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_sweep_that_is_stopped_keeps_what_was_finished(tmp_path, number):
    with started(*SWEEP, folder=tmp_path) as (run, mark):
        wait_until(lambda: rows_of(tmp_path / "out") >= 3, "three runs are finished")
        run.send_signal(number)
        _, errors = run.communicate(timeout=60)
        gone(mark)
    assert (
        run.returncode == 128 + number
        and errors.splitlines()[-1].startswith("interrupted: ")
        and "Traceback" not in errors
    )
    answer = json.loads((tmp_path / "out" / "run.json").read_text())
    states = [one["status"]["code"] for one in answer["runs"]]
    assert (
        len(states) == 161
        and states.count("interrupted") == 161 - sum(code != "interrupted" for code in states) > 0
    )
    assert sum(bool(one["quantities"]) for one in answer["runs"]) >= 3 and not answer["completed"]
    assert f"interrupted: {161 - states.count('interrupted')} of 161 runs were finished" in errors
    assert not (tmp_path / "out" / ROWS).exists() and not list(tmp_path.rglob("*.part"))


def test_a_sweep_that_is_killed_leaves_its_finished_runs_and_the_next_run_mends_the_folder(
    tmp_path,
):
    with started(*SWEEP, folder=tmp_path) as (run, mark):
        wait_until(lambda: rows_of(tmp_path / "out") >= 3, "three runs are finished")
        run.kill()
        run.wait()
        gone(mark)
    rows = [
        json.loads(line) for line in (tmp_path / "out" / ROWS).read_text().split("\n")[:-1]
    ]  # the last may be cut
    assert len(rows) >= 3 and all(
        row["quantities"]["peak_spring_force"]["value"] > 0 for row in rows
    )
    (tmp_path / "out" / ".quantities.csv.abcdefgh.valvetrain.part").write_text("half of")
    again = [word if word != SWEEP[3] else "1000:1100:25 rpm" for word in SWEEP]
    done = process(*again, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    whole, peaks = json.loads((tmp_path / "out" / "run.json").read_text())["runs"], {}
    # the neighbours from whose motion a speed starts are others, so the numbers agree to 1e-4 only
    for one in (*rows, *whole):
        force = one["quantities"]["peak_spring_force"]["value"]
        same = peaks.setdefault(one["engine_speed"]["value"], force)
        assert force == pytest.approx(same, rel=1e-4)
    assert not (tmp_path / "out" / ROWS).exists() and not list((tmp_path / "out").glob(".*.part"))


def test_a_request_to_stop_that_the_interpreter_drops_is_still_heard(monkeypatch):
    """A KeyboardInterrupt within a destructor is printed and forgotten; who waits looks at the
    note.
    """

    class Dropped:
        def __del__(self) -> None:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.01)  # the handler runs here, where what it raises is lost

    hears = signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # tests in the background of a script have it ignored
    end = threading.Event()
    with threads(1) as pool, listening():
        job = pool.submit(end.wait, 3.0)
        begun = time.monotonic()
        monkeypatch.setattr(sys, "unraisablehook", lambda _: None)
        dropped = Dropped()
        del dropped
        with pytest.raises(Stopped):
            result_of(job)
        assert time.monotonic() - begun < 2.0
        end.set()
    signal.signal(signal.SIGINT, hears)


def test_a_background_job_leaves_ctrl_c_to_others_and_hears_sigterm():
    """A shell ignores SIGINT for the background jobs of a script, and nohup SIGHUP: both stay
    ignored, for that was asked.
    """
    before = {
        number: signal.signal(number, signal.SIG_IGN) for number in (signal.SIGINT, signal.SIGHUP)
    }
    try:
        with pytest.raises(Stopped), listening():
            os.kill(os.getpid(), signal.SIGINT)
            os.kill(os.getpid(), signal.SIGHUP)
            assert (
                signal.getsignal(signal.SIGINT) is signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
            )
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(1)
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def test_a_study_that_is_stopped_hands_over_what_it_has(tmp_path):
    def stop_at_three(shared, point):
        if point == 3:
            raise KeyboardInterrupt
        return point

    with pytest.raises(PointsStopped) as cut:
        map_points(stop_at_three, tmp_path, range(6), 1)
    assert cut.value.results == {0: 0, 1: 1, 2: 2}


def rows_of(folder) -> int:
    """Finished runs that a run has listed so far."""
    try:
        return (folder / ROWS).read_text().count("\n")
    except OSError:
        return 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_command_that_is_stopped_again_while_it_tells_what_it_kept_has_the_code_of_its_signal(
    number,
):
    """The parser makes 130 of every interruption, of one that comes after the first was told too."""
    app = typer.Typer(cls=GuardedGroup)

    @app.command("wait")
    def wait():
        try:
            os.kill(os.getpid(), number)
            time.sleep(5)
        except KeyboardInterrupt:
            interrupted("what was finished is kept")
            raise

    @app.command("other")
    def other():
        """So that there is a group."""

    before = signal.signal(number, signal.default_int_handler)
    try:
        assert app(["wait"], standalone_mode=False) == 128 + number
    finally:
        signal.signal(number, before)


LOADING = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
class Stopping:
    def find_spec(self, name, path=None, target=None):
        if name == "valvetrain.cli.main":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Stopping())
from valvetrain.__main__ import main
main()
"""


def test_ctrl_c_while_the_command_loads_ends_it_without_a_traceback(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", LOADING],
        cwd=tmp_path,
        env=process_environment(),
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")
