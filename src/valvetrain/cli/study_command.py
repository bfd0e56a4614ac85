"""What ``run``, ``compare`` and ``sweep`` share: their options, the bound on a request, the folder that is kept, and the answer."""

from __future__ import annotations

import functools
import inspect
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol, get_type_hints

from valvetrain.cli.case_choice import IN_EVERY_SPRING, choose_case, folder_of
from valvetrain.cli.options import (
    CaseArgument,
    ElementsOption,
    FiguresOption,
    JsonOption,
    LimitOption,
    OpenOption,
    OutputOption,
    PublishedOption,
    QuietOption,
    ReportOption,
    SetOption,
    SpeedOption,
    SpringOption,
    SpringSetOption,
    WorkersOption,
    read_engine_speeds,
    read_models,
    read_words,
    read_workers,
)
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.cli.bounds import Limits
    from valvetrain.cli.progress import Report
    from valvetrain.parameters.case import Case
    from valvetrain.solution.provenance import Provenance
    from valvetrain.solution.study import Study


class KeepRequest(Protocol):
    """What the kept folder of a run needs to know: command, case, the folder its file lies in, where results go, and the time."""

    @property
    def command(self) -> str: ...
    @property
    def case(self) -> Case: ...
    @property
    def folder(self) -> Path: ...
    @property
    def output(self) -> Path | None: ...
    @property
    def created_at(self) -> datetime: ...


@dataclass(frozen=True)
class StudyRequest:
    """One study as asked for: the ``case`` with its changes and the ``folder`` its file lies in; ``engine_speeds`` (rad/s of the crank,
    None: the case's own); words of spring models and sets (empty: the study's own choice); where results go and how they are shown."""

    command: str
    case: Case
    folder: Path
    engine_speeds: tuple[float, ...] | None
    spring_models: tuple[str, ...]
    spring_sets: tuple[str, ...]
    workers: int
    limits: Limits
    output: Path | None
    report: bool
    figures: bool
    published: bool
    open_page: bool
    created_at: datetime


def _shared(
    case: CaseArgument, engine_speed: SpeedOption = None, spring: SpringOption = None, spring_set: SpringSetOption = None,
    settings: SetOption = None, elements_per_coil: ElementsOption = None, output: OutputOption = None, workers: WorkersOption = None,
    limit: LimitOption = None, report: ReportOption = True, figures: FiguresOption = False, published: PublishedOption = False,
    open_page: OpenOption = False, as_json: JsonOption = False, quiet: QuietOption = False, more: Mapping[str, Any] = MappingProxyType({}),
) -> dict[str, Any]:  # fmt: skip
    """Read the options that all studies share; :func:`valvetrain.cli.outcome.set_manner` has read the last two."""
    from valvetrain.cli.bounds import read_limits
    from valvetrain.studies.run_store import check_folder

    chosen = choose_case(case, settings, elements_per_coil, more)
    check_folder(output or Path("runs"), kept=output is None)
    speeds = read_engine_speeds(engine_speed)
    if speeds and chosen.lift_law is None:
        raise InputError(f"case '{chosen.name}' has no lift law, so nothing moves at an engine speed; add a [lift_law] table")
    return {
        "case": chosen, "folder": folder_of(case), "engine_speeds": speeds, "spring_models": read_models(spring),
        "spring_sets": read_words(spring_set), "workers": read_workers(workers), "limits": read_limits(limit), "output": output,
        "report": report or open_page, "figures": figures, "published": published, "open_page": open_page,
        "created_at": datetime.now(UTC).replace(microsecond=0),
    }  # fmt: skip


def study_command(function: Callable[..., None]) -> Callable[..., None]:
    """Give ``function(request, own options...)`` the options that all studies share; its own come after them in the help.

    An own option that :data:`valvetrain.cli.case_choice.IN_EVERY_SPRING` knows is set in the case.
    """
    own = list(inspect.signature(function).parameters.values())[1:]
    shared = list(inspect.signature(_shared).parameters.values())[:-1]

    @functools.wraps(function)
    def command(**given: Any) -> None:
        mine = {parameter.name: given.pop(parameter.name) for parameter in own}
        if function.__name__ == "sweep" and (text := given["engine_speed"]) and not any(char.isalpha() for char in text):
            given["engine_speed"] = f"{text} rpm"  # a range over the whole engine can mean nothing else
        options = {f"--{name.replace('_', '-')}": value for name, value in mine.items()}
        more = {option: value for option, value in options.items() if option in IN_EVERY_SPRING}
        function(StudyRequest(command=function.__name__, **_shared(**given, more=more)), **mine)

    hints = get_type_hints(_shared, include_extras=True) | {
        name: hint for name, hint in get_type_hints(function, vars(sys.modules[function.__module__]), include_extras=True).items()
        if name in {parameter.name for parameter in own}
    }  # fmt: skip
    keyword = inspect.Parameter.KEYWORD_ONLY
    parameters = [parameter.replace(kind=keyword, annotation=hints[parameter.name]) for parameter in (*shared, *own)]
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {parameter.name: hints[parameter.name] for parameter in parameters}
    del command.__wrapped__  # typer would look through it at the shorter signature
    return command


def answer_study(
    request: StudyRequest, compute: Callable[[Report], Study], at_once: bool = True, choices: Mapping[str, Any] = MappingProxyType({})
) -> None:  # fmt: skip
    """Compute the study, keep it in its folder and print its answer. ``at_once``: whether Ctrl-C may end the process on the spot;
    ``choices``: what the command was asked besides, kept among the inputs."""
    from valvetrain.cli.answers import show_study
    from valvetrain.cli.outcome import Outcome, deliver
    from valvetrain.cli.progress import busy, progress_bar
    from valvetrain.report.json import study_json
    from valvetrain.report.words import rpm
    from valvetrain.report.write import write_study

    with progress_bar(request.case.name, at_once) as report:
        study = compute(report)
    data = study_json(study) | {"command": request.command, "completed": not study.failures}
    pages: list[Path] = []

    def write(folder: Path) -> list[Path]:
        files = write_study(study, folder, page=request.report, figures=request.figures)
        pages.extend([files.page] if files.page else [])
        return [*files.data, *files.figures, *pages]

    asked = {
        **choices, "engine_speeds": [rpm(value) for value in study.engine_speeds], "engine_speed_unit": "rpm",
        "spring_models": list(dict.fromkeys(run.model for run in study.solutions)) or list(request.spring_models),
        "spring_sets": list(request.spring_sets),
    }  # fmt: skip
    with busy("writing files"):
        folder, files = keep_run(request, study.record.text, asked, data, write, study.solutions[0].provenance if study.solutions else None)
    page = pages[0] if pages else None
    if page is not None and request.open_page:
        import webbrowser

        webbrowser.open(page.resolve().as_uri())
    data |= {"folder": str(folder), "files": files, "page": None if page is None else str(page)}
    deliver(Outcome(data, lambda console: show_study(console, study, folder, page, request.published), study.failures))


def keep_run(
    request: KeepRequest, text: str, choices: Mapping[str, Any], data: Mapping[str, Any], write: Callable[[Path], list[Path]],
    made_by: Provenance | None = None,
) -> tuple[Path, list[str]]:  # fmt: skip
    """Make the folder of a run, let ``write`` fill it, and put inputs (``text``: the resolved case) and ``run.json`` beside.

    ``data``: the JSON answer; ``made_by``: versions that ran (default: those here). The folder, and the paths of all files in it.
    """
    from valvetrain.cli.outcome import plain
    from valvetrain.solution.provenance import collect_provenance
    from valvetrain.studies.run_answer import ANSWER
    from valvetrain.studies.run_store import collect_inputs, keep, link_latest, new_folder

    inputs = collect_inputs(request.case.name, text, request.folder, {"command": request.command, **choices})
    folder = request.output or new_folder(inputs, request.created_at)
    written = [path.relative_to(folder).as_posix() for path in write(folder)]
    origin = made_by or collect_provenance(request.case.name, "")
    answer = plain(data) | {
        "created_at": request.created_at.isoformat(), "command_line": ["valvetrain", *sys.argv[1:]], "files": written,
        "versions": {"valvetrain": origin.package_version, "python": origin.python_version, **origin.dependencies},
    }  # fmt: skip
    kept = keep(folder, inputs, answer)
    if request.output is None:
        link_latest(folder)
    return folder, [str(folder / name) for name in (*kept.answer["files"], ANSWER)]
