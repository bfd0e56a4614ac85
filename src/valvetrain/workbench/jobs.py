"""Jobs: runs, comparisons, sweeps and studies, each in a process of its own that a server starts,
watches, bounds and ends.

The request of a job and its outcome are in the database, so that a closed tab and a server that
is started again find it.
"""

from __future__ import annotations

import logging
import secrets
import shutil
import sqlite3
import threading
import time
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

from valvetrain.errors import InputError
from valvetrain.runs.cost import Limits
from valvetrain.runs.workers import available_cores
from valvetrain.units.text import clipped
from valvetrain.workbench.job_process import (
    JobProcess,
    Outcome,
    settle,
    wait_until_left,
    write_inputs,
)
from valvetrain.workbench.requests import STORED, JobRequest
from valvetrain.workbench.workspace import Workspace

JobState = Literal["queued", "running", "finished", "failed", "cancelled", "interrupted"]
#: Bounds of one job where none are given.
DEFAULT_LIMITS = Limits(3600.0, 4e9)
#: Jobs that the database stores; older ones that have ended are deleted, their runs stay.
MAX_ENDED = 1000
#: Time between two looks at the queue, and two tries to write what the disk did not take (s).
LOOK = 5.0
_COLUMNS = "id, case_name, kind, state, share, text, seconds_left, error, run_id, created_at, started_at, ended_at"


@dataclass(frozen=True, slots=True)
class JobStatus:
    """State of a job.

    Parameters
    ----------
    job_id, case, kind : which one
    state : ``queued``, ``running``, ``finished``, ``failed``, ``cancelled`` or ``interrupted``
    share : share of the work done, 0 to 1
    text : what is going on
    seconds_left : estimate (s), None while nothing can be said
    error : sentence where it failed or was interrupted, and on parts that a finished one could not
        do
    run_id : the saved run, empty while there is none; a cancelled or interrupted job may have one
        with what was finished
    created_at, started_at, ended_at : seconds since the epoch, None where not yet
    """

    job_id: str
    case: str
    kind: str
    state: JobState
    share: float = 0.0
    text: str = ""
    seconds_left: float | None = None
    error: str = ""
    run_id: str = ""
    created_at: float = 0.0
    started_at: float | None = None
    ended_at: float | None = None

    @property
    def ended(self) -> bool:
        """Whether nothing more will happen."""
        return self.state not in ("queued", "running")


class Jobs:
    """The jobs of a workspace; use it as a context, or call :meth:`stop` at the end.

    Jobs that a killed server left running are ``interrupted``; those that waited continue.

    Parameters
    ----------
    workspace : whose cases and runs
    most_running : jobs at a time
    most_waiting : jobs that may wait; more are refused
    limits : longest time and largest memory of one job
    """

    def __init__(
        self,
        workspace: Workspace,
        most_running: int = 1,
        most_waiting: int = 8,
        limits: Limits = DEFAULT_LIMITS,
    ) -> None:
        self.workspace, self.limits = workspace, limits
        self.most_running, self.most_waiting = most_running, most_waiting
        self.workers = max(1, min(4, available_cores() // max(1, most_running)))
        self._changed, self._stopping = threading.Condition(), False
        self._running: dict[str, JobProcess] = {}
        self._unsaved: dict[str, dict[str, Any]] = {}
        self._threads: list[threading.Thread] = []
        self._recover()
        self._manager = threading.Thread(target=self._manage, name="jobs", daemon=True)
        self._manager.start()

    def submit(self, request: JobRequest) -> str:
        """Put a job in the queue; its id. Raises :class:`InputError` for a case or choice that is
        refused, and beyond the bounds.
        """
        with self.workspace.turn:  # the files of a case stay those that its text names
            job_id = self._queued(request)
        with suppress(InputError):
            self._forget()
        return job_id

    def estimate(self, request: JobRequest) -> str:
        """What a job will cost, ``"about 12 s and 35 MB"``. Raises :class:`InputError` where it is
        refused, with the reason.
        """
        return self._check(request, self.workspace.text(request.case))

    def status(self, job_id: str) -> JobStatus:
        """The state of a job. Raises :class:`InputError` for an unknown id."""
        return self._with_progress(JobStatus(*self._row(job_id, _COLUMNS)))

    def jobs(self, case: str | None = None, most: int = 50) -> list[JobStatus]:
        """Jobs, newest first; of one case where given."""
        where, given = ("WHERE case_name = ?", (case,)) if case is not None else ("", ())
        with self.workspace.store.connected() as base:
            rows = base.execute(
                f"SELECT {_COLUMNS} FROM jobs {where} ORDER BY created_at DESC, id DESC LIMIT ?",
                (*given, most),
            ).fetchall()
        return [self._with_progress(JobStatus(*row)) for row in rows]

    def request(self, job_id: str) -> JobRequest:
        """The request of a job. Raises :class:`InputError` for an unknown id."""
        return STORED.validate_json(self._row(job_id, "request")["request"])

    def _row(self, job_id: str, columns: str) -> sqlite3.Row:
        with self.workspace.store.connected() as base:
            row: sqlite3.Row | None = base.execute(
                f"SELECT {columns} FROM jobs WHERE id = ?", (str(job_id),)
            ).fetchone()
        if row is None:
            raise InputError(
                f"there is no job '{clipped(str(job_id), 40)}'; it may have been forgotten", "job"
            )
        return row

    def cancel(self, job_id: str) -> None:
        """Stop a job; what was finished is saved. Nothing where it has ended."""
        with self._changed:
            if (process := self._running.get(job_id)) is not None:
                process.end("cancelled")
                return
            if self.status(job_id).state == "queued":
                self._end(job_id, Outcome("cancelled"))

    def restart(self, job_id: str) -> str:
        """Start a job that ended again, with its request and its case as it is now; the new
        id.
        """
        if not self.status(job_id).ended:
            raise InputError("this job has not ended; wait for it, or cancel it", "job")
        return self.submit(self.request(job_id))

    @property
    def running(self) -> int:
        """Number of jobs that run."""
        return len(self._running)

    def stop(self) -> None:
        """End the running jobs, which are then shown as interrupted with what they had, and start
        no more; those that wait stay.
        """
        with self._changed:
            self._stopping = True
            for process in self._running.values():
                process.end("interrupted")
            self._changed.notify_all()
        self._manager.join()
        for thread in self._threads:
            thread.join()

    def __enter__(self) -> Jobs:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _check(self, request: JobRequest, text: str) -> str:
        return request.cost_text(self.workspace.parse(request.case, text), self.limits)

    def _queued(self, request: JobRequest) -> str:
        text = self.workspace.text(request.case)
        self._check(request, text)
        with self._changed:
            if self._stopping:
                raise InputError("the server is ending; start it again", "job")
            with self.workspace.store.connected() as base:
                (waiting,) = base.execute(
                    "SELECT COUNT(*) FROM jobs WHERE state = 'queued'"
                ).fetchone()
                if waiting >= self.most_waiting:
                    raise InputError(
                        f"{waiting} jobs are waiting already; wait for one, or cancel one", "job"
                    )
                job_id = f"{time.strftime('%Y%m%d-%H%M%S', time.gmtime())}-{secrets.token_hex(4)}"
                base.execute(
                    "INSERT INTO jobs (id, case_name, kind, request, state, text, created_at) VALUES (?, ?, ?, ?, 'queued', 'waiting', ?)",
                    (
                        job_id,
                        request.case,
                        request.kind,
                        STORED.dump_json(request).decode(),
                        time.time(),
                    ),
                )
                write_inputs(self.workspace, job_id, request, text)
            self._changed.notify_all()
        return job_id

    def _manage(self) -> None:
        """Start the oldest job that waits whenever a process is free; no fault of the disk or the
        database ends this.
        """
        fault = ""
        with self._changed:
            while not self._stopping:
                try:
                    self._save()
                    fault, waits = "", not self._start_oldest()
                except Exception as error:
                    before, fault, waits = fault, str(error), True
                    if fault != before:
                        logging.getLogger(__name__).warning("no job can be started: %s", fault)
                if waits:
                    self._changed.wait(LOOK)

    def _start_oldest(self) -> bool:
        """Start the oldest job that waits where a process is free; whether one was started."""
        if len(self._running) >= self.most_running:
            return False
        with self.workspace.store.connected() as base:
            row = base.execute(
                "SELECT id, request FROM jobs WHERE state = 'queued' ORDER BY created_at, id LIMIT 1"
            ).fetchone()
            if row is None:
                return False
            job_id, request = row["id"], STORED.validate_json(row["request"])
            base.execute(
                "UPDATE jobs SET state = 'running', text = '', started_at = ? WHERE id = ?",
                (time.time(), job_id),
            )
        process = JobProcess(self.workspace, job_id, request, self.workers, self.limits)
        self._running[job_id] = process
        thread = threading.Thread(
            target=self._follow, args=(job_id, process), name=f"job {job_id}", daemon=True
        )
        self._threads = [one for one in self._threads if one.is_alive()] + [thread]
        thread.start()
        return True

    def _follow(self, job_id: str, process: JobProcess) -> None:
        """Run one job to its end."""
        try:
            outcome = process.run()
        except Exception as error:  # a fault here must not leave a job running for ever
            outcome = Outcome(
                "failed", f"could not be started ({type(error).__name__}: {error}); try again"
            )
        with self._changed:
            self._running.pop(job_id, None)
            self._end(job_id, outcome)
            self._changed.notify_all()

    def _end(self, job_id: str, outcome: Outcome) -> None:
        """Save how a job ended; where the database does not take it now, it is tried again."""
        self._unsaved[job_id] = {**asdict(outcome), "ended_at": time.time()}
        with suppress(InputError):
            self._save()

    def _save(self) -> None:
        """Write the outcomes that the database has not taken yet."""
        for job_id, ended in list(self._unsaved.items()):
            with self.workspace.store.connected() as base:
                base.execute(
                    "UPDATE jobs SET state = :state, error = :error, run_id = :run_id, share = :share, "
                    "ended_at = :ended_at, text = '', seconds_left = NULL WHERE id = :id",
                    {**ended, "id": job_id},
                )
            del self._unsaved[job_id]
            if ended["state"] == "finished":
                shutil.rmtree(self.workspace.jobs_folder / job_id, ignore_errors=True)

    def _with_progress(self, found: JobStatus) -> JobStatus:
        found = replace(found, **self._unsaved.get(found.job_id, {}))
        process = self._running.get(found.job_id)
        if found.state != "running" or process is None:
            return found
        share, text, left = process.progress
        return replace(found, share=share, text=text, seconds_left=left)

    def _recover(self) -> None:
        """Jobs of a server that was killed: interrupted, with what they had once their own
        processes have ended too.
        """
        with self.workspace.store.connected() as base:
            left = [
                row["id"] for row in base.execute("SELECT id FROM jobs WHERE state = 'running'")
            ]
            base.execute(
                "UPDATE jobs SET state = 'interrupted', seconds_left = NULL, text = '', ended_at = ?, "
                "error = 'the server ended while this job ran; start it again' WHERE state = 'running'",
                (time.time(),),
            )
        if left:
            thread = threading.Thread(
                target=self._settle, args=(left,), name="settling", daemon=True
            )
            self._threads.append(thread)
            thread.start()

    def _settle(self, left: list[str]) -> None:
        for job_id in left:
            with suppress(InputError, OSError):
                wait_until_left(self.workspace, job_id)
                found = settle(self.workspace, job_id)
                with self._changed:
                    self._end(job_id, found)

    def _forget(self) -> None:
        """Forget the oldest ended jobs beyond :data:`MAX_KEPT`, and the inputs of those that
        will not be started again.
        """
        with self.workspace.store.connected() as base:
            query = "SELECT id FROM jobs WHERE state NOT IN ('queued', 'running') ORDER BY created_at DESC LIMIT -1 OFFSET ?"
            old = [row["id"] for row in base.execute(query, (MAX_ENDED,))]
            base.executemany("DELETE FROM jobs WHERE id = ?", [(one,) for one in old])
        for one in old:
            shutil.rmtree(self.workspace.jobs_folder / one, ignore_errors=True)
