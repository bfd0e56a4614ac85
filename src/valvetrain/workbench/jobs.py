"""Jobs: runs, comparisons, sweeps and studies, each in a process of its own that a server starts, watches, bounds and ends.

What a job was asked and how it went stands in the database, so that a closed tab and a server that is started again find it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from valvetrain.workbench.workspace import Workspace

JobKind = Literal["run", "compare", "sweep", "static", "modes", "study"]
JobState = Literal["queued", "running", "finished", "failed", "cancelled", "interrupted"]


@dataclass(frozen=True)
class JobRequest:
    """What is asked.

    Parameters
    ----------
    kind : ``run``, ``compare``, ``sweep``, ``static``, ``modes`` or ``study``
    case : id of the case; it is taken as it stands when the job is submitted
    spring_models : words of spring models, empty for the case's own
    engine_speeds : crank speeds as ``--engine-speed`` takes them, ``"4200, 5600 rpm"`` or ``"1000:9000:100 rpm"``; empty for the case's own
    spring_sets : spring sets of a train, empty for its own
    settings : values set besides, key path -> text, as ``--set`` takes them
    options : options of the kind by their long names without dashes, such as ``{"resolution": "10 rpm"}`` of a sweep
    study : text of the study file (TOML) of a study, whose ``case`` is replaced by this one
    implausible : let values pass that no valvetrain can have
    """

    kind: JobKind
    case: str
    spring_models: tuple[str, ...] = ()
    engine_speeds: str = ""
    spring_sets: tuple[str, ...] = ()
    settings: Mapping[str, str] = field(default_factory=dict)
    options: Mapping[str, str] = field(default_factory=dict)
    study: str = ""
    implausible: bool = False


@dataclass(frozen=True, slots=True)
class JobStatus:
    """How a job stands.

    Parameters
    ----------
    job_id, case, kind : which one
    state : ``queued``, ``running``, ``finished``, ``failed``, ``cancelled`` or ``interrupted``
    share : share of the work done, 0 to 1
    text : what is going on
    seconds_left : estimate (s), None while nothing can be said
    error : sentence where it failed or was interrupted
    run_id : the kept run, empty while there is none; a cancelled or interrupted job may have one with what was finished
    created_at, started_at, ended_at : seconds since the epoch, None where not yet
    """

    job_id: str
    case: str
    kind: JobKind
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

    Parameters
    ----------
    workspace : whose cases and runs
    most_running : jobs at a time
    most_waiting : jobs that may wait; more are refused
    most_seconds : longest time of one job (s)
    most_memory : largest memory of one job (bytes)
    """

    def __init__(
        self, workspace: Workspace, most_running: int = 1, most_waiting: int = 8, most_seconds: float = 3600.0,
        most_memory: float = 4e9,
    ) -> None:  # fmt: skip
        self.workspace = workspace
        self.most_running, self.most_waiting, self.most_seconds, self.most_memory = most_running, most_waiting, most_seconds, most_memory

    def submit(self, request: JobRequest) -> str:
        """Put a job in the queue; its id. Raises :class:`InputError` for a case or choice that is refused, and beyond the bounds."""
        raise NotImplementedError

    def estimate(self, request: JobRequest) -> str:
        """What a job will cost, ``"about 12 s and 35 MB"``. Raises :class:`InputError` where it is refused, with the reason."""
        raise NotImplementedError

    def status(self, job_id: str) -> JobStatus:
        """How a job stands. Raises :class:`InputError` for an unknown id."""
        raise NotImplementedError

    def jobs(self, case: str | None = None, most: int = 50) -> list[JobStatus]:
        """Jobs, newest first; of one case where given."""
        raise NotImplementedError

    def cancel(self, job_id: str) -> None:
        """Stop a job; what was finished is kept. Nothing where it has ended."""
        raise NotImplementedError

    def restart(self, job_id: str) -> str:
        """Start a job that failed, was cancelled or interrupted again, as it was asked; the new id."""
        raise NotImplementedError

    def stop(self) -> None:
        """End the running jobs, which are then shown as interrupted, and start no more."""

    def __enter__(self) -> Jobs:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
