"""Jobs as processes: progress, cancel, bounds, restart, and nothing left running when a server ends
or is killed.

Evidence: observed processes of the system (not our own records), with a stand-in for the command
line; one real run at the end.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from valvetrain.errors import InputError
from valvetrain.parameters.loading import parse_case
from valvetrain.runs.cost import Limits
from valvetrain.workbench import job_process
from valvetrain.workbench.jobs import JobRequest, Jobs
from valvetrain.workbench.requests import STORED
from valvetrain.workbench.workspace import Workspace
from workbench_parts import SMALL, lives, stand_in, wait_for

pytestmark = pytest.mark.skipif(os.name != "posix", reason="processes are ended by signals")


@pytest.fixture
def workspace(tmp_path):
    found = Workspace(tmp_path / "bench")
    found.upload("small.toml", SMALL.encode())
    return found


@pytest.fixture
def fake(tmp_path, monkeypatch):
    """Says what the stand-in does; gives the numbers of the processes it began."""
    monkeypatch.setattr(job_process, "SUPERVISOR", stand_in(tmp_path))
    monkeypatch.setenv("PIDS", str(tmp_path / "pids"))

    def choose(mode: str) -> None:
        monkeypatch.setenv("FAKE", mode)

    return choose


def pids(workspace: Workspace) -> list[int]:
    path = workspace.folder.parent / "pids"
    return [int(word) for word in path.read_text().split()] if path.exists() else []


def running(workspace: Workspace) -> list[int]:
    found = wait_for(lambda: pids(workspace))
    assert isinstance(found, list) and all(map(lives, found))
    return found


def ended(jobs: Jobs, job_id: str):
    wait_for(lambda: jobs.status(job_id).ended)
    return jobs.status(job_id)


RUN = JobRequest("run", "small")


def test_a_job_runs_to_its_end_and_names_its_run(workspace, fake):
    fake("quick")
    with Jobs(workspace) as jobs:
        found = ended(jobs, jobs.submit(RUN))
    assert (found.state, found.share, found.error) == ("finished", 1.0, "")
    assert found.run_id == "small/20260101-000000-00000000"
    assert not list(workspace.jobs_folder.iterdir()), (
        "its inputs stand with the run and nowhere else"
    )


def test_a_refusal_of_the_command_is_the_jobs_sentence(workspace, fake):
    fake("refused")
    with Jobs(workspace) as jobs:
        found = ended(jobs, jobs.submit(RUN))
    assert (found.state, found.error, found.run_id) == (
        "failed",
        "spring.wire_diameter: a wire of 4 m is no wire",
        "",
    )


@pytest.mark.parametrize("mode", ["sleep", "deaf"])
def test_a_cancelled_job_leaves_no_process_and_keeps_what_it_finished(workspace, fake, mode):
    fake(mode)
    with Jobs(workspace) as jobs:
        job_id = jobs.submit(RUN)
        numbers_of = running(workspace)
        wait_for(lambda: jobs.status(job_id).share == 0.25)
        assert (
            jobs.status(job_id).text == "first half"
            and jobs.status(job_id).seconds_left is not None
        )
        jobs.cancel(job_id)
        found = ended(jobs, job_id)
        wait_for(lambda: not any(map(lives, numbers_of)))
    assert found.state == "cancelled"
    assert bool(found.run_id) is (mode == "sleep"), "one that does not obey is killed"


def test_the_longest_time_ends_a_job(workspace, fake):
    fake("sleep")
    with Jobs(workspace, limits=Limits(1.5, 4e9)) as jobs:
        found = ended(jobs, jobs.submit(RUN))
        assert not any(map(lives, pids(workspace)))
    assert (
        found.state == "failed"
        and "the longest time of a job" in found.error
        and "is saved" in found.error
    )


@pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")
def test_the_largest_memory_ends_a_job(workspace, fake):
    fake("hungry")
    with Jobs(workspace, limits=Limits(3600.0, 200e6)) as jobs:
        found = ended(jobs, jobs.submit(RUN))
        wait_for(lambda: not any(map(lives, pids(workspace))))
    assert found.state == "failed" and "more than 200 MB" in found.error


def test_jobs_wait_for_each_other_and_not_more_than_may(workspace, fake):
    fake("sleep")
    with Jobs(workspace, most_running=1, most_waiting=1) as jobs:
        first = jobs.submit(RUN)
        running(workspace)
        second = jobs.submit(RUN)
        assert jobs.status(second).state == "queued"
        with pytest.raises(InputError, match="1 jobs are waiting already"):
            jobs.submit(RUN)
        jobs.cancel(second)
        assert jobs.status(second).state == "cancelled" and jobs.status(first).state == "running"
        assert [one.job_id for one in jobs.jobs("small")] == [second, first]


def test_a_server_that_ends_stops_its_jobs_and_those_that_wait_go_on_with_the_next(workspace, fake):
    fake("sleep")
    with Jobs(workspace) as jobs:
        first, second = jobs.submit(RUN), jobs.submit(RUN)
        running(workspace)
    assert not any(map(lives, pids(workspace)))
    fake("quick")
    with Jobs(workspace) as again:
        found = again.status(first)
        assert found.state == "interrupted" and found.run_id
        assert ended(again, second).state == "finished"
        assert ended(again, again.restart(first)).state == "finished"


def test_nothing_runs_on_when_the_server_is_killed(workspace, fake, tmp_path):
    fake("sleep")
    server = (
        "import sys, time; from pathlib import Path; from valvetrain.workbench import job_process as one, jobs; "
        "from valvetrain.workbench.workspace import Workspace; "
        f"one.SUPERVISOR = {stand_in(tmp_path)!r}; found = jobs.Jobs(Workspace(Path({str(workspace.folder)!r}))); "
        "print(found.submit(jobs.JobRequest('run', 'small')), flush=True); time.sleep(120)"
    )
    process = subprocess.Popen([sys.executable, "-c", server], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    job_id = process.stdout.readline().strip()
    numbers_of = running(workspace)
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    wait_for(lambda: not any(map(lives, numbers_of)))
    with Jobs(workspace) as jobs:
        assert jobs.status(job_id).state == "interrupted"
        wait_for(lambda: jobs.status(job_id).run_id)
        assert "the server ended while this job ran" in jobs.status(job_id).error
        fake("quick")
        assert ended(jobs, jobs.restart(job_id)).state == "finished"


@pytest.mark.parametrize(
    ("request_of_a_page", "words"),
    [
        (JobRequest("run", "small", {"engine_speeds": "4000 kg"}), "is a mass"),
        (JobRequest("run", "small", {"engine_speeds": "--output=/tmp"}), "engine_speeds"),
        (JobRequest("run", "small", {"models": ["masless"]}), "did you mean"),
        (JobRequest("run", "small", {"spring_sets": ["x"]}), "no spring set"),
        (JobRequest("exec", "small"), "no kind of job"),
        (JobRequest("run", "small", {"engine_speeds": "4000, " * 500 + "1 rpm"}), "give a range"),
        (JobRequest("study", "small"), "no quantity to vary"),
        (
            JobRequest("study", "small", {"quantity": "spring.mass", "points": "1"}),
            "outside 2 to 200",
        ),
        (JobRequest("run", "small", {"workers": "64"}), "no field of a run"),
        (JobRequest("run", "small", {"models": []}), "tick one or more"),
        (JobRequest("run", "../small"), "no name of a file"),
        (JobRequest("sweep", "small", {"engine_speeds": "1:2000000:1 rpm"}), "speeds"),
        (
            JobRequest(
                "run",
                "small",
                {"engine_speeds": "10:3000:0.5 rpm"},
            ),
            "valvetrain serve --limit",
        ),
    ],
)
def test_what_is_refused_is_refused_before_a_process_begins(
    workspace, fake, request_of_a_page, words
):
    fake("quick")
    with Jobs(workspace) as jobs, pytest.raises(InputError) as refused:
        jobs.submit(request_of_a_page)
    assert words in str(refused.value)
    assert not list(workspace.jobs_folder.iterdir())


def test_no_word_of_a_request_can_be_an_option_of_its_own():
    """Every word that holds what a page sent begins with the option it belongs to, and the file
    stands behind the last option.
    """
    evil = "--output=/tmp/x"
    given = {"models": [evil], "engine_speeds": evil, "spring_sets": [evil], "implausible": False}
    asked = JobRequest("run", "small", given)
    words = asked.command_line(evil, 2, Limits(), evil)
    flags = ("--json", "--limit=", "--workers=", "--model=", "--spring-set=", "--rpm=")
    assert words[0] == "run" and words[-2:] == ["--", evil]
    assert all(word.startswith(flags) for word in words[1:-2])
    assert STORED.validate_json(STORED.dump_json(asked)) == asked
    with pytest.raises(InputError):
        asked.read(parse_case(SMALL, "small"))


def test_a_real_run_is_kept_in_the_workspace_and_answers(workspace, monkeypatch):
    """The command line itself, as a job: its run lies in the run store and its page is read back."""
    monkeypatch.setenv("PYTHONPATH", str(Path(job_process.__file__).parents[2]))
    with Jobs(workspace) as jobs:
        job_id = jobs.submit(
            JobRequest("run", "small", {"models": ["massless"], "engine_speeds": "3000, 4000 rpm"})
        )
        wait_for(lambda: jobs.status(job_id).ended, 120.0)
        found = jobs.status(job_id)
    assert (found.state, found.error) == ("finished", "")
    run = workspace.run(found.run_id)
    assert run.models == ("massless",) and run.engine_speeds == (3000.0, 4000.0) and run.completed
    assert [one.run_id for one in workspace.runs("small")] == [found.run_id]
    peak = run.answer["runs"][1]["quantities"]["peak_spring_force"]
    assert peak["value"] == pytest.approx(250 + 32 * 9, abs=0.01)  # preload and rate times lift
    assert run.page.read_text("utf-8").rstrip().endswith("</html>")
    assert json.loads((run.folder / "run.json").read_text())["case"] == "small"
    assert workspace.download(found.run_id, "report") == run.folder / "report.html"
