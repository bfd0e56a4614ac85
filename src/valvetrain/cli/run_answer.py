"""Common parts of ``run``, ``compare`` and ``sweep``: their options, the limit of a request, the
saved folder and the answer.
"""

from __future__ import annotations

import functools
import inspect
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol, get_type_hints

import typer

from valvetrain.cli.options import (
    FIGURE_FORMATS,
    CaseArgument,
    DaskOption,
    ElementsOption,
    FiguresOption,
    ImplausibleOption,
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
    UnitsOption,
    WorkersOption,
    at_end,
    choose_case,
    folder_of,
    name_case,
    read_engine_speeds,
    read_models,
    read_names,
    read_workers,
    take_folder,
    take_units,
)
from valvetrain.cli.outcome import complain
from valvetrain.errors import InputError
from valvetrain.runs.run_folders import ANSWER

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.cli.outcome import Outcome
    from valvetrain.cli.progress import Report
    from valvetrain.parameters.case import Case
    from valvetrain.runs.cost import Limits
    from valvetrain.runs.train_runs import Finished
    from valvetrain.solution.partial_failures import PartialFailures
    from valvetrain.solution.provenance import Provenance
    from valvetrain.solution.study import Study
    from valvetrain.views.files import UnfinishedRun
    from valvetrain.views.shown import Shown


class Named(Protocol):
    """A case, or another subject whose runs are saved under its name."""

    @property
    def name(self) -> str: ...


class KeepRequest(Protocol):
    """A request whose run is saved: command, case, folder of the case file, output folder and time."""

    @property
    def command(self) -> str: ...
    @property
    def case(self) -> Named: ...
    @property
    def folder(self) -> Path: ...
    @property
    def output(self) -> Path | None: ...
    @property
    def created_at(self) -> datetime: ...


@dataclass(frozen=True)
class SavedRequest:
    """A :class:`KeepRequest` of a command that runs no study."""

    command: str
    case: Named
    output: Path | None
    created_at: datetime
    folder: Path = Path()


def show_page(page: Path) -> None:
    """Open a page in the browser."""
    import webbrowser

    webbrowser.open(page.resolve().as_uri())


@dataclass(frozen=True)
class StudyRequest:
    """One study as requested: the ``case`` with its changes and the ``folder`` of its file;
    ``engine_speeds`` (rad/s of the crank, None: the case's own); words of spring models and sets
    (empty: the study's own choice); where results go and how they are shown.
    """

    command: str
    case: Case
    folder: Path
    engine_speeds: tuple[float, ...] | None
    spring_models: tuple[str, ...]
    spring_sets: tuple[str, ...]
    workers: int
    limits: Limits
    implausible: bool
    output: Path | None
    report: bool
    figures: str
    published: bool
    open_page: bool
    created_at: datetime

    def keywords(self, report: Report, finished: Finished | None = None) -> dict[str, Any]:
        """What every function that computes a study takes of a request, with where progress and runs go."""
        arrived = {} if finished is None else {"finished": finished, "limits": self.limits}
        return arrived | {
            "spring_models": self.spring_models, "spring_sets": self.spring_sets, "workers": self.workers, "progress": report,
            "created_at": self.created_at.isoformat(), "implausible": self.implausible,
        }  # fmt: skip


def shared_options(
    case: CaseArgument,
    engine_speed: SpeedOption = None,
    spring: SpringOption = None,
    spring_set: SpringSetOption = None,
    settings: SetOption = None,
    elements_per_coil: ElementsOption = None,
    output: OutputOption = None,
    dask: DaskOption = "",
    workers: WorkersOption = None,
    limit: LimitOption = None,
    implausible: ImplausibleOption = False,
    report: ReportOption = True,
    figures: FiguresOption = "",
    published: PublishedOption = False,
    open_page: OpenOption = False,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> dict[str, Any]:
    """Read the options that all studies share; :func:`valvetrain.cli.outcome.set_manner` has read
    the last two.
    """
    from valvetrain.runs.cost import read_limits

    take_units(units)
    name_case(
        case, settings, [part for text in spring_set or () for part in ("--spring-set", text)]
    )
    if figures not in ("", *FIGURE_FORMATS):
        raise InputError(
            f"'{figures}' is no format of figures; use {', '.join(FIGURE_FORMATS)}", "--figures"
        )
    chosen = choose_case(case, settings, elements_per_coil)
    take_folder(output)
    speeds = read_engine_speeds(engine_speed)
    if speeds and chosen.lift_law is None:
        raise InputError(
            f"case '{chosen.name}' has no lift law, so nothing moves at an engine speed; add a [lift_law] table"
        )
    return {
        "case": chosen,
        "folder": folder_of(case),
        "engine_speeds": speeds,
        "spring_models": read_models(spring),
        "spring_sets": read_names(spring_set),
        "workers": read_workers(workers, dask),
        "limits": read_limits(limit),
        "implausible": implausible,
        "output": output,
        "report": report or open_page,
        "figures": figures,
        "published": published,
        "open_page": open_page,
        "created_at": datetime.now(UTC).replace(microsecond=0),
    }


def run_command(function: Callable[..., None], without: Sequence[str] = ()) -> Callable[..., None]:
    """Give ``function(request, own options...)`` the options that all studies share, but those in ``without``;
    its own come after them in the help.
    """
    own = list(inspect.signature(function).parameters.values())[1:]
    every = inspect.signature(shared_options).parameters.values()
    shared = [parameter for parameter in every if parameter.name not in without]

    @functools.wraps(function)
    def command(**given: Any) -> None:
        mine = {parameter.name: given.pop(parameter.name) for parameter in own}
        function(StudyRequest(command=function.__name__, **shared_options(**given)), **mine)

    hints = get_type_hints(shared_options, include_extras=True) | {
        name: hint
        for name, hint in get_type_hints(
            function, vars(sys.modules[function.__module__]), include_extras=True
        ).items()
        if name in {parameter.name for parameter in own}
    }
    keyword = inspect.Parameter.KEYWORD_ONLY
    parameters = [
        parameter.replace(kind=keyword, annotation=hints[parameter.name])
        for parameter in (*shared, *own)
    ]
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {parameter.name: hints[parameter.name] for parameter in parameters}
    del command.__wrapped__  # typer would look through it at the shorter signature
    return command


def rest_command(function: Callable[..., None]) -> Callable[..., None]:
    """As :func:`run_command`, of springs at rest, without the options of motion."""
    return run_command(function, ("engine_speed", "dask", "workers", "published"))


def answer_study(
    request: StudyRequest,
    compute: Callable[[Report, Finished], Study],
    choices: Mapping[str, Any] = MappingProxyType({}),
) -> None:
    """Compute the study, save its folder and print its answer; a stopped one saves what was
    finished.

    ``compute`` reports its progress and each solution as it comes; ``choices``: what the command was
    further choices, saved among the inputs.
    """
    from valvetrain.cli.guard import interrupted
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import progress_bar
    from valvetrain.runs.run_folders import unfinished_folder
    from valvetrain.runs.stopping import StudyStopped
    from valvetrain.views.files import UnfinishedRun

    begun = ("valvetrain", *sys.argv[1:])
    unfinished = UnfinishedRun(
        lambda: request.output or unfinished_folder(request.case.name, request.created_at), begun
    )
    at_end(unfinished.release)
    stopped = False
    try:
        with progress_bar(request.case.name) as report:
            study = compute(report, unfinished.add)
    except StudyStopped as cut:
        study, stopped = cut.study, True
    except BaseException as error:
        if unfinished.folder is not None:
            sentence = f"what was finished is saved in '{unfinished.folder}'"
            if isinstance(error, KeyboardInterrupt):
                interrupted(f"interrupted: {sentence}")
            else:
                complain(sentence)
        raise
    outcome = _saved_outcome(request, study, choices, unfinished)
    if not stopped:
        deliver(outcome)
        return
    with suppress(typer.Exit):
        deliver(outcome)
    done = sum(run.status.code != "interrupted" for run in study.solutions)
    sentence = (
        f"{done} of {len(study.solutions)} runs were finished and are saved"
        if done
        else "springs at rest, which were finished, are saved"
    )
    raise typer.Exit(
        interrupted(
            f"interrupted: {sentence} in '{outcome.data['folder']}'; start the command again to compute all of them"
        )
    )


def _saved_outcome(
    request: StudyRequest, study: Study, choices: Mapping[str, Any], unfinished: UnfinishedRun
) -> Outcome:
    """The study written to its folder: its answer, with a sentence per part of it that failed."""
    from valvetrain.cli.outcome import Outcome
    from valvetrain.solution.partial_failures import PartialFailures
    from valvetrain.views.results import answer_json
    from valvetrain.views.text import rpm

    gaps = PartialFailures(unfinished.gaps.sentences)
    none: tuple[str, ...] = ()
    failures = gaps.part("list of failures", none, lambda: study.failures)
    plain: dict[str, Any] = {"case": request.case.name, "failures": list(failures)}
    data = gaps.part("JSON answer", plain, answer_json, study) | {"command": request.command}
    choices_made = {
        **choices, "engine_speeds": [rpm(value) for value in study.engine_speeds], "engine_speed_unit": "rpm",
        "spring_models": list(dict.fromkeys(one.model for one in study.solutions or study.rest)) or list(request.spring_models),
        "spring_sets": list(request.spring_sets),
    }  # fmt: skip
    origin = study.solutions[0].provenance if study.solutions else None
    folder, page, failed = save_study(
        request, study, choices_made, data, failures, origin, gaps, unfinished, request.report, request.figures
    )  # fmt: skip
    if page is not None and request.open_page:
        show_page(page)
    return Outcome(
        data,
        lambda console: show_study(console, study, folder, page, request.published),
        failed,
    )


def show_study(
    console: Console, study: Study, folder: Path, page: Path | None, published: bool = False
) -> None:
    """Print the answer of a study; with ``published`` every printed value and what the source states."""
    from valvetrain.cli.outcome import plain_table
    from valvetrain.views.answer import Answer
    from valvetrain.views.terminal import screen

    answer = Answer(study)
    console.print(screen(answer, str(page or ""), str(folder)))
    for key, table in answer.tables().items() if published else ():
        if key in ("published", "source"):
            console.print(plain_table(table.columns, table.rows, f"\n{table.title}"))


def save_study(
    request: KeepRequest,
    study: Study,
    choices: Mapping[str, Any],
    data: dict[str, Any],
    failures: Sequence[str],
    made_by: Provenance | None,
    gaps: PartialFailures,
    unfinished: UnfinishedRun | None = None,
    report: bool = True,
    figures: str = "",
) -> tuple[Path, Path | None, tuple[str, ...]]:
    """Write a study to the folder of its run: the folder, the page, and all that failed.

    ``data``, the JSON answer, is completed with them; the other arguments are those of
    :func:`keep_run` and :func:`valvetrain.views.results.write_answer`.
    """
    from valvetrain.cli.progress import busy
    from valvetrain.views.results import write_answer

    pages: list[Path] = []

    def all_failures() -> tuple[str, ...]:
        failed = tuple(dict.fromkeys((*failures, *gaps.sentences)))
        data.update(completed=not failed, failures=list(failed))
        return failed

    def write(folder: Path) -> list[Path]:
        saved = {} if unfinished is None else {"written_before": unfinished.file_of}
        files = write_answer(study, folder, report, figures, **saved)
        pages.extend([files.page] if files.page else [])
        for sentence in files.gaps:
            gaps.add(sentence)
        all_failures()
        return [*files.data, *files.figures, *pages]

    with busy("writing files"):
        folder, files = keep_run(
            request, study.record.text, choices, data, write, made_by, unfinished, gaps
        )
    page = pages[0] if pages else None
    data.update(folder=str(folder), files=files, page=None if page is None else str(page))
    return folder, page, all_failures()


def keep_run(
    request: KeepRequest,
    text: str,
    choices: Mapping[str, Any],
    data: Mapping[str, Any],
    write: Callable[[Path], list[Path]],
    made_by: Provenance | None = None,
    unfinished: UnfinishedRun | None = None,
    gaps: PartialFailures | None = None,
) -> tuple[Path, list[str]]:
    """Make the folder of a run, mark it as unfinished, let ``write`` fill it, put inputs (``text``:
    the resolved case) and ``run.json``, and remove the mark.

    ``data``: the JSON answer; ``made_by``: versions that ran (default: those here); ``unfinished``:
    what the run saved while it went on. The folder, and the paths of all files in it; parts that
    fail are named in ``gaps``.
    """
    from valvetrain.cli.outcome import plain
    from valvetrain.parameters.case import Case
    from valvetrain.runs.run_folders import finish_folder, link_latest, new_folder
    from valvetrain.runs.saved_runs import (
        DEFINITIONS,
        Inputs,
        collect_inputs,
        definitions,
        save_run,
    )
    from valvetrain.solution.partial_failures import PartialFailures
    from valvetrain.solution.provenance import collect_provenance
    from valvetrain.views.files import UnfinishedRun

    missing = PartialFailures() if gaps is None else gaps
    choices_made = {"command": request.command, **choices}
    bare = Inputs(request.case.name, text, {}, choices_made)
    inputs = missing.part(
        "inputs of the run",
        bare,
        collect_inputs,
        request.case.name,
        text,
        request.folder,
        choices_made,
    )
    begun = unfinished or UnfinishedRun(lambda: folder)
    at_end(begun.release)
    stem = inputs.case, inputs.digest, request.created_at
    if request.output is not None:
        folder = request.output
    elif begun.folder is not None:
        part = "folder of the run"
        folder = missing.part(part, begun.folder, finish_folder, begun.folder, *stem)
    else:
        folder = new_folder(*stem)
    missing.part("mark of the unfinished run", None, begun.begin, folder)
    written = [path.relative_to(folder).as_posix() for path in write(folder)]
    origin = made_by or collect_provenance(request.case.name, "")
    answer = plain(data) | {
        "created_at": request.created_at.isoformat(),
        "command_line": ["valvetrain", *sys.argv[1:]],
        "files": written,
        "versions": {
            "valvetrain": origin.package_version,
            "python": origin.python_version,
            **origin.dependencies,
        },
    }
    if isinstance(request.case, Case):
        answer |= {DEFINITIONS: definitions(request.case.operation.force_bandwidth)}
    saved = missing.part(
        f"file '{ANSWER}' could not be written", None, save_run, folder, inputs, answer
    )
    if saved is None:
        return folder, [str(folder / name) for name in written]
    missing.part("mark of the unfinished run", None, begun.finish)
    if request.output is None:
        missing.part("link to the latest run", None, link_latest, folder)
    return folder, [str(folder / name) for name in (*saved.answer["files"], ANSWER)]


def saved_result(
    request: KeepRequest,
    text: str,
    data: dict[str, Any],
    show: Callable[[Path], Shown],
    write: Callable[[Path], list[Path]],
    choices: Mapping[str, Any],
    open_page: bool = False,
    failures: Sequence[str] = (),
) -> Outcome:
    """Save a result that is no study in the folder of its run, with its page: its answer.

    ``show``: the answer that names files of a folder; ``write``: fills the folder; the rest as for :func:`keep_run`.
    """
    from valvetrain.cli.outcome import Outcome
    from valvetrain.cli.progress import busy
    from valvetrain.solution.partial_failures import PartialFailures
    from valvetrain.units.reader import for_reader
    from valvetrain.views.results import write_page
    from valvetrain.views.terminal import screen

    gaps = PartialFailures()

    def fill(folder: Path) -> list[Path]:
        data["findings"] = [one.to_dict() for one in show(folder).findings]
        with for_reader():
            page = write_page(show(folder), folder, gaps)
        return [*write(folder), *filter(None, (page,))]

    with busy("writing files"):
        folder, files = keep_run(request, text, choices, data, fill)
    page = str(folder / "report.html")
    data |= {"folder": str(folder), "files": files, "page": page}
    if open_page:
        show_page(Path(page))
    failed = (*failures, *gaps.sentences)
    return Outcome(data, lambda console: console.print(screen(show(folder), page)), failed)
