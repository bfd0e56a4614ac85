"""The request of a job, checked and turned into arguments of the command; no part of it reaches a
shell.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

from pydantic import TypeAdapter

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.loading import parse_toml
from valvetrain.registry import find
from valvetrain.runs.cost import Cost, Limits, RunRequest, cost_text, refuse_cost, request_cost
from valvetrain.units import si_speeds
from valvetrain.units.text import clipped
from valvetrain.workbench.edits import refuse_foreign_files

JobKind = Literal["run", "sweep", "study"]
KINDS = get_args(JobKind)
#: Speeds (rpm) of a sweep that names none, as the command has them.
_SWEEP = "1000:9000:100 rpm"
MAX_SPEEDS_LENGTH, MAX_STUDY_LENGTH = 2000, 200_000


@dataclass(frozen=True)
class JobRequest:
    """A request.

    Parameters
    ----------
    kind : ``run``, ``sweep`` or ``study``
    case : id of the case; it is read when the job is submitted
    spring_models : words of spring models, empty for the case's own
    engine_speeds : crank speeds as ``--rpm`` takes them, ``"4200, 5600 rpm"`` or
        ``"1000:9000:100 rpm"``; empty for the case's own
    spring_sets : spring sets of a train, empty for its own
    study : text of the study file (TOML) of a study, whose ``case`` is replaced by this one
    """

    kind: JobKind
    case: str
    spring_models: tuple[str, ...] = ()
    engine_speeds: str = ""
    spring_sets: tuple[str, ...] = ()
    study: str = ""


_ADAPTER = TypeAdapter(JobRequest)


def check_request(request: JobRequest, case: Case) -> None:
    """Refuse, with an :class:`InputError`, what the command line would refuse later, and what it
    must never be shown.
    """
    if request.kind not in KINDS:
        raise InputError(
            f"'{clipped(str(request.kind), 20)}' is no kind of job; {nearest(str(request.kind), KINDS)}",
            "kind",
        )
    for word in request.spring_models:
        find("springs", word)
    for word in request.spring_sets:
        if case.train is None or word not in case.train.springs:
            raise InputError(
                f"'{clipped(word, 40)}' is no spring set of this case; choose one of its own",
                "spring_sets",
            )
    if len(request.engine_speeds) > MAX_SPEEDS_LENGTH:
        raise InputError(f"more than {MAX_SPEEDS_LENGTH} characters; give a range", "engine_speeds")
    if request.engine_speeds:
        si_speeds(request.engine_speeds, "engine_speed", "engine_speeds")
    if request.kind == "study":
        tree = _study_tree(request.study)
        given = tree.get("changes")
        refuse_foreign_files(case.text, dict(given) if isinstance(given, dict) else None)


def command_arguments(
    request: JobRequest, file: str, workers: int, limits: Limits, folder: str
) -> list[str]:
    """Words of the command line; ``file``: the case, or the study file, whose points and answer go
    to ``folder``.
    """
    arguments = [
        request.kind,
        "--json",
        f"--limit={limits.seconds:.0f} s",
        f"--limit={limits.bytes / 1e6:.0f} MB",
        f"--workers={workers}",
    ]
    if request.kind == "study":
        return [*arguments, f"--output={folder}", "--", file]
    arguments += [f"--model={word}" for word in request.spring_models] + [
        f"--spring-set={word}" for word in request.spring_sets
    ]
    arguments += [f"--rpm={request.engine_speeds}"] if request.engine_speeds else []
    return [*arguments, "--", file]


def cost_of(request: JobRequest, case: Case, workers: int) -> Cost:
    """Estimated cost of a request, as the command line estimates it; of a study, nothing (its own
    process does).
    """
    if request.kind == "study":
        return Cost()
    sweeps = request.kind == "sweep"
    text = request.engine_speeds or (_SWEEP if sweeps else "")
    speeds = si_speeds(text, "engine_speed", "engine_speeds") if text else None
    asked = RunRequest(
        request.kind, case, speeds, request.spring_models, request.spring_sets, workers
    )
    return request_cost(asked, not sweeps, sweeps)


def allowed_cost_text(cost: Cost, limits: Limits) -> str:
    """The cost as text. Raises :class:`InputError` where it is beyond the bounds of a job."""
    refuse_cost(cost, limits, "valvetrain serve --limit ")
    return cost_text(cost)


def study_text(request: JobRequest, case_file: str) -> str:
    """The study file with the case put in."""
    import tomlkit

    document = tomlkit.parse(request.study)
    document["case"] = case_file
    return tomlkit.dumps(document)


def _study_tree(text: str) -> dict[str, Any]:
    if len(text) > MAX_STUDY_LENGTH:
        raise InputError(
            f"the study file is longer than {MAX_STUDY_LENGTH} characters; shorten it", "study"
        )
    tree = parse_toml(text, "study", "study file")
    if "vary" not in tree or "outputs" not in tree:
        raise InputError(
            "a study needs outputs and at least one [[vary]] table; add them (docs/studies.md)",
            "study",
        )
    return tree


def request_json(request: JobRequest) -> str:
    """The request as text, for the database."""
    return _ADAPTER.dump_json(request).decode()


def request_of(text: str) -> JobRequest:
    """The request of :func:`request_json`."""
    return _ADAPTER.validate_json(text)
