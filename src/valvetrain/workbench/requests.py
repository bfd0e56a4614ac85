"""The request of a job, checked and turned into arguments of the command; no part of it reaches a
shell.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.loading import parse_toml
from valvetrain.parameters.overrides import read_assignment
from valvetrain.registry import find
from valvetrain.runs.cost import Cost, Limits, refuse_cost
from valvetrain.units import si_speeds
from valvetrain.units.text import clipped
from valvetrain.workbench.edits import refuse_foreign_files

JobKind = Literal["run", "compare", "sweep", "static", "modes", "study"]
#: Options that a kind takes in addition to those of all, by their long names.
OPTIONS: dict[str, tuple[str, ...]] = {
    "run": (), "compare": (), "sweep": ("resolution", "float-lift", "bounce-height", "no-critical-speeds"),
    "static": ("to", "steps", "height", "load"), "modes": ("count", "compression", "attached-mass", "free-end"), "study": (),
}  # fmt: skip
_FLAGS = ("no-critical-speeds", "free-end")
#: Kinds that move the case, and so have engine speeds.
_MOVING = ("run", "compare", "sweep")
#: Speeds (rpm) of a sweep that names none, as the command has them.
_SWEEP = "1000:9000:100 rpm"
MAX_SETTINGS, MAX_WORD_LENGTH, MAX_STUDY_LENGTH = 100, 2000, 200_000
_WORD = re.compile(r"[^\W_][\w.,:+/ ()-]*")


@dataclass(frozen=True)
class JobRequest:
    """A request.

    Parameters
    ----------
    kind : ``run``, ``compare``, ``sweep``, ``static``, ``modes`` or ``study``
    case : id of the case; it is read when the job is submitted
    spring_models : words of spring models, empty for the case's own
    engine_speeds : crank speeds as ``--engine-speed`` takes them, ``"4200, 5600 rpm"`` or
        ``"1000:9000:100 rpm"``; empty for the case's own
    spring_sets : spring sets of a train, empty for its own
    settings : further values, key path -> text, as ``--set`` takes them
    options : options of the kind by their long names without dashes, such as
        ``{"resolution": "10 rpm"}`` of a sweep; ``"true"`` for flags
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


@dataclass(frozen=True)
class _Request:
    """The part of a request that its cost is estimated from."""

    command: str
    case: Case
    engine_speeds: tuple[float, ...] | None
    spring_models: tuple[str, ...]
    spring_sets: tuple[str, ...]
    workers: int


def changes_of(request: JobRequest) -> dict[str, Any]:
    """Key path -> value of the settings, as the command line reads them. Raises
    :class:`InputError`.
    """
    return dict(read_assignment(f"{key}={value}", key) for key, value in request.settings.items())


def check_request(request: JobRequest, case: Case) -> None:
    """Refuse, with an :class:`InputError`, what the command line would refuse later, and what it
    must never be shown.
    """
    if request.kind not in OPTIONS:
        raise InputError(
            f"'{clipped(str(request.kind), 20)}' is no kind of job; {nearest(str(request.kind), tuple(OPTIONS))}",
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
    if request.engine_speeds:
        if request.kind not in _MOVING:
            raise InputError(
                f"a job of kind {request.kind} has no engine speed; leave it out", "engine_speeds"
            )
        si_speeds(request.engine_speeds, "engine_speed", "engine_speeds")
    known = OPTIONS[request.kind]
    for name, value in request.options.items():
        if name not in known:
            raise InputError(
                f"'{clipped(name, 40)}' is no option of {request.kind}; {nearest(name, known)}",
                name,
            )
        if name not in _FLAGS and not _WORD.fullmatch(value):
            raise InputError(
                f"'{clipped(value, 40)}' is no value of this option; write such as '10 rpm'", name
            )
    texts = (
        *request.settings,
        *request.settings.values(),
        *request.options.values(),
        request.engine_speeds,
    )
    if len(request.settings) > MAX_SETTINGS or any(
        len(text) > MAX_WORD_LENGTH or "\0" in text for text in texts
    ):
        raise InputError(
            f"more than {MAX_SETTINGS} values, or one longer than {MAX_WORD_LENGTH} characters, are set; edit the case instead",
            "settings",
        )
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
    ]
    if request.kind not in ("static", "modes"):
        arguments.append(f"--workers={workers}")
    if request.kind == "study":
        return [*arguments, f"--output={folder}", "--", file]
    arguments += [f"--spring={word}" for word in request.spring_models] + [
        f"--spring-set={word}" for word in request.spring_sets
    ]
    arguments += [f"--engine-speed={request.engine_speeds}"] if request.engine_speeds else []
    arguments += [f"--set={key}={value}" for key, value in request.settings.items()]
    for name, value in request.options.items():
        arguments += (
            ([f"--{name}"] if value == "true" else []) if name in _FLAGS else [f"--{name}={value}"]
        )
    arguments += ["--implausible"] if request.implausible else []
    return [*arguments, "--", file]


def cost_of(request: JobRequest, case: Case, workers: int) -> Cost:
    """Estimated cost of a request, as the command line estimates it; of a study, nothing (its own
    process does).
    """
    from valvetrain.runs.request_cost import request_cost, static_cost
    from valvetrain.runs.statics import CURVE_OF_MODES

    if request.kind == "study":
        return Cost()
    if request.kind in ("static", "modes"):
        steps = (
            request.options.get("steps", "24") if request.kind == "static" else str(CURVE_OF_MODES)
        )
        count = request.options.get("count", "24") if request.kind == "modes" else "0"
        whole = [int(text) if text.isdecimal() else 0 for text in (steps, count)]
        return static_cost(
            case,
            request.spring_models,
            spring_sets=request.spring_sets,
            steps=whole[0],
            modes=whole[1],
        )
    text = request.engine_speeds or (_SWEEP if request.kind == "sweep" else "")
    speeds = si_speeds(text, "engine_speed", "engine_speeds") if text else None
    run_request = _Request(
        request.kind, case, speeds, request.spring_models, request.spring_sets, workers
    )
    sweeps = request.kind == "sweep"
    return request_cost(
        run_request, not sweeps, sweeps and request.options.get("no-critical-speeds") != "true"
    )


def cost_text(cost: Cost, limits: Limits) -> str:
    """The cost as text. Raises :class:`InputError` where it is beyond the bounds of a job."""
    return refuse_cost(cost, limits, "valvetrain serve --limit ")


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
    return json.dumps(asdict(request))


def request_of(text: str) -> JobRequest:
    """The request of :func:`request_json`."""
    given = json.loads(text)
    listed = {name: tuple(given[name]) for name in ("spring_models", "spring_sets")}
    return JobRequest(**{**given, **listed})
