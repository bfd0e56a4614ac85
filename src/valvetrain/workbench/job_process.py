"""One job as a process: its inputs on disk, its progress over a pipe, and what it left, read from
what the command printed.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from valvetrain.parameters.bounded_file import SIDE_FILES_VARIABLE
from valvetrain.runs.cost import Limits, duration_text, memory_text
from valvetrain.runs.run_folders import unfinished_runs
from valvetrain.solution.atomic import is_living, write_bytes, write_text
from valvetrain.workbench.requests import JobRequest, QuantityStudy
from valvetrain.workbench.saved_runs import STUDIES, read_object
from valvetrain.workbench.store import inside, writing
from valvetrain.workbench.supervisor import GRACE, MEMORY_UP, TIME_UP, read_progress
from valvetrain.workbench.workspace import Workspace

#: The study file of a job; no case has a name that begins so.
STUDY_FILE = "_study.toml"
SERVER_ENDED = "the server ended while this job ran"
ANSWER, COMPLAINTS, LOCK = "answer.json", "complaints.txt", "lock"
#: The process that runs the command line.
SUPERVISOR = [sys.executable, "-m", "valvetrain.workbench.supervisor"]
#: Largest answer of a command that is read (bytes).
MAX_ANSWER = 200_000_000


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a job ended: its state, a sentence, the run it left and the share that was done."""

    state: str
    error: str = ""
    run_id: str = ""
    share: float = 0.0


def write_inputs(workspace: Workspace, job_id: str, request: JobRequest, text: str) -> None:
    """Put what a job needs into its folder: the current case, the files it names, and the
    study file.
    """
    folder = inside(workspace.jobs_folder, job_id)
    try:
        with writing("the inputs of this job", "job"):
            for name, content in workspace.files(request.case).items():
                write_bytes(inside(folder, name), content)
            write_text(folder / f"{request.case}.toml", text)
            asked = request.read(workspace.parse(request.case, text))
            if isinstance(asked, QuantityStudy):
                study = asked.file_text(f"{request.case}.toml")
                write_text(folder / STUDY_FILE, study)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def wait_until_left(workspace: Workspace, job_id: str) -> None:
    """Wait until the process of a job whose server was killed has written what it had; it ends by
    itself.
    """
    path, last = workspace.jobs_folder / job_id / LOCK, time.monotonic() + 2 * GRACE
    while path.exists() and is_living(path) and time.monotonic() < last:
        time.sleep(0.1)


def settle(workspace: Workspace, job_id: str) -> Outcome:
    """How a job ended that was not watched to its end: a run with what it had, or folders of runs
    it left.
    """
    run_id = _run_id(workspace, read_object(workspace.jobs_folder / job_id / ANSWER, MAX_ANSWER))
    left = (
        "; what it had finished is saved"
        if run_id
        else f"{_left(workspace, job_id)}; start it again"
    )
    return Outcome("interrupted", f"{SERVER_ENDED}{left}", run_id)


@dataclass(eq=False)
class JobProcess:
    """The process of one job.

    Parameters
    ----------
    workspace, job_id, request : which one
    workers : runs at a time within it
    limits : longest time (s) and largest memory (bytes)
    """

    workspace: Workspace
    job_id: str
    request: JobRequest
    workers: int
    limits: Limits
    _process: subprocess.Popen[bytes] | None = None
    _requested_end: str = ""
    _share: float = 0.0
    _text: str = "starting"
    _begun: float = 0.0

    @property
    def progress(self) -> tuple[float, str, float | None]:
        """Share of the work done, what is going on, and seconds left (None while nothing can be
        said).
        """
        share, begun = self._share, self._begun
        left = (
            (time.monotonic() - begun) * (1 - share) / share if begun and 0.02 < share < 1 else None
        )
        return share, self._text, left

    def run(self) -> Outcome:
        """Start the process, follow its progress and wait for its end."""
        folder = inside(self.workspace.jobs_folder, self.job_id)
        studied = self.request.kind == QuantityStudy.command
        name = STUDY_FILE if studied else f"{self.request.case}.toml"
        saved = f"runs/{STUDIES}/{self.request.case}-{self.job_id}"
        sentence = self.request.command_line(
            f"jobs/{self.job_id}/{name}", self.workers, self.limits, saved
        )
        bounds = [str(self.limits.seconds), str(self.limits.bytes), str(folder / LOCK)]
        reading, writing = os.pipe()
        environment = {
            **os.environ,
            "VALVETRAIN_PROGRESS": str(writing),
            SIDE_FILES_VARIABLE: "1",
            "OPENBLAS_NUM_THREADS": "1",
            "OMP_NUM_THREADS": "1",
        }
        with os.fdopen(reading, "rb") as report_lines:
            try:
                with (
                    (folder / ANSWER).open("wb") as answer,
                    (folder / COMPLAINTS).open("wb") as complaints,
                ):
                    self._process = subprocess.Popen(
                        [*SUPERVISOR, *bounds, *sentence], cwd=self.workspace.folder, env=environment,
                        stdin=subprocess.PIPE, stdout=answer, stderr=complaints, pass_fds=(writing,), start_new_session=True,
                    )  # fmt: skip
            finally:
                os.close(writing)
            if self._requested_end:
                self.end(self._requested_end)
            for line in report_lines:
                self._hear(line)
        code = self._process.wait()
        self._close()
        return self._outcome(folder, code)

    def _hear(self, line: bytes) -> None:
        if (heard := read_progress(line)) is not None:
            share, self._text = heard
            if share is not None:
                self._begun = self._begun or time.monotonic()
                self._share = share

    def end(self, state: str) -> None:
        """Ask the job to stop, by the end of its standard input: ``cancelled``, or ``interrupted`` as the server ends."""
        self._requested_end, self._text = self._requested_end or state, "stopping"
        if self._process is not None:
            self._close()

    def _close(self) -> None:
        if self._process is not None and self._process.stdin is not None:
            with suppress(OSError, ValueError):
                self._process.stdin.close()

    def _outcome(self, folder: Path, code: int) -> Outcome:
        answer = read_object(folder / ANSWER, MAX_ANSWER)
        run_id, share = _run_id(self.workspace, answer), self._share
        saved = "; what it had finished is saved" if run_id else _left(self.workspace, self.job_id)
        if code == TIME_UP:
            sentence = f"was stopped after {duration_text(self.limits.seconds)}, the longest time of a job{saved}; choose fewer speeds or models"
            return Outcome("failed", sentence, run_id, share)
        if code == MEMORY_UP:
            sentence = f"was stopped because it took more than {memory_text(self.limits.bytes)}, the largest memory of a job{saved}"
            return Outcome("failed", f"{sentence}; choose fewer speeds or elements", run_id, share)
        if self._requested_end:
            sentence = {
                "cancelled": "was cancelled",
                "interrupted": SERVER_ENDED,
            }[self._requested_end]
            return Outcome(self._requested_end, f"{sentence}{saved}", run_id, share)
        sentences = [str(sentence) for sentence in answer.get("failures", ()) or ()]
        if run_id and (code == 0 or _some_completed(answer)):
            return Outcome("finished", "; ".join(sentences[:3]), run_id, 1.0)
        return Outcome(
            "failed",
            _error(answer) or "; ".join(sentences[:3]) or _complaint(folder),
            run_id,
            share,
        )


def _run_id(workspace: Workspace, answer: dict[str, Any]) -> str:
    """Id of the run that the command saved, empty where there is none."""
    folder = answer.get("folder")
    if not isinstance(folder, str) or not (workspace.folder / folder).is_dir():
        return ""
    path = (workspace.folder / folder).resolve()
    root = workspace.runs_folder.resolve()
    return path.relative_to(root).as_posix() if path.is_relative_to(root) and path != root else ""


def _some_completed(answer: dict[str, Any]) -> bool:
    """Whether anything of a run that did not wholly complete came out."""
    runs = [
        one.get("status", {}).get("code") for one in answer.get("runs", ()) if isinstance(one, dict)
    ]
    return "completed" in runs or (not runs and bool(answer.get("springs_at_rest")))


def _error(answer: dict[str, Any]) -> str:
    """The sentence of a command that refused."""
    error = answer.get("error")
    if not isinstance(error, dict):
        return ""
    where, message = str(error.get("where", "")), str(error.get("message", ""))
    return f"{where}: {message}" if where else message


def _complaint(folder: Path) -> str:
    """The last line on standard error."""
    with suppress(OSError):
        lines = (
            (folder / COMPLAINTS)
            .read_bytes()[-4000:]
            .decode("utf-8", "replace")
            .strip()
            .splitlines()
        )
        if lines:
            return lines[-1][:400]
    return "ended without an answer; start it again"


def _left(workspace: Workspace, job_id: str) -> str:
    """Words on finished runs that a killed job left in a folder of its own."""
    for one in unfinished_runs(root=workspace.runs_folder):
        if not one.living and any(job_id in word for word in one.command_line) and one.finished > 1:
            return f"; {one.finished} runs that it had finished are in {one.folder.relative_to(workspace.folder)}"
    return ""
