"""Common parts of ``run``, ``compare`` and ``sweep``: the limit of a request, the saved folder and the answer."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import typer

from valvetrain.cli.outcome import at_end, complain
from valvetrain.cli.request import StudyLine
from valvetrain.runs.cost import FEWER, Cost, refuse_cost
from valvetrain.runs.requests import Request, Watch
from valvetrain.runs.run_folders import ANSWER

if TYPE_CHECKING:
    from valvetrain.cli.outcome import Outcome
    from valvetrain.solution.provenance import Provenance
    from valvetrain.solution.status import PartialFailures
    from valvetrain.solution.study import Study
    from valvetrain.views.files import UnfinishedRun
    from valvetrain.views.shown import Shown

CaseRequest = TypeVar("CaseRequest", bound=Request)


@dataclass(frozen=True)
class SavedRequest:
    """A request whose run is saved: command, case or other subject with a name, output folder, folder of the case file, time."""

    command: str
    case: Any
    output: Path | None
    folder: Path = Path()
    created_at: datetime = field(
        default_factory=lambda: datetime.now(UTC).replace(microsecond=0), init=False
    )


def show_page(page: Path) -> None:
    """Open a page in the browser."""
    import webbrowser

    webbrowser.open(page.resolve().as_uri())


def answer_study(
    request: CaseRequest,
    line: StudyLine,
    folder: Path,
    compute: Callable[[CaseRequest, Watch], Study],
    cost: Cost,
    kernels: Sequence[str] = (),
    fewer: str = FEWER,
) -> None:
    """Compute the study, save it and print its answer; a stopped one saves what was finished.

    Parameters
    ----------
    request, line : what is computed, and how it is answered
    folder : that of the case file
    compute : gives the study of the request
    cost : of the request, which is refused beyond its limits
    kernels : kinds of kernels that it needs; where none is given, those of the runs of its case
    fewer : what to request less of
    """
    from valvetrain.cli.guard import interrupted
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_compilation, announce_runs, progress_bar
    from valvetrain.runs.run_folders import unfinished_folder
    from valvetrain.runs.stopping import StudyStopped
    from valvetrain.views.files import UnfinishedRun

    refuse_cost(cost, request.limit, fewer=fewer)
    if kernels:
        announce_compilation(*kernels)
    else:
        announce_runs(request.case)
    saved = SavedRequest(request.command, request.case, line.output, folder)
    now = saved.created_at
    begun = ("valvetrain", *sys.argv[1:])
    unfinished = UnfinishedRun(
        lambda: line.output or unfinished_folder(request.case.name, now), begun
    )
    at_end(unfinished.release)
    stopped = False
    try:
        with progress_bar(request.case.name) as report:
            study = compute(request, Watch(report, unfinished.add, now.isoformat()))
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
    outcome = _saved_outcome(request, line, saved, study, unfinished)
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
    request: Request, line: StudyLine, saved: SavedRequest, study: Study, unfinished: UnfinishedRun
) -> Outcome:
    """The study written to its folder: its answer, with a sentence per part of it that failed."""
    from valvetrain.cli.outcome import Outcome
    from valvetrain.cli.progress import busy
    from valvetrain.parameters.summary import rpm
    from valvetrain.solution.status import PartialFailures
    from valvetrain.views.answer import Answer
    from valvetrain.views.results import answer_json, write_answer
    from valvetrain.views.terminal import screen

    gaps = PartialFailures(unfinished.gaps.sentences)
    none: tuple[str, ...] = ()
    failures = gaps.part("list of failures", none, lambda: study.failures)
    plain: dict[str, Any] = {"case": request.case.name, "failures": list(failures)}
    data = gaps.part("JSON answer", plain, answer_json, study) | {"command": request.command}
    used = list(dict.fromkeys(one.model for one in study.solutions or study.rest))
    speeds = [rpm(value) for value in study.engine_speeds]
    choices = request.stored() | {"engine_speeds": speeds, "engine_speed_unit": "rpm"}
    choices |= {"models": used} if used else {}
    origin = study.solutions[0].provenance if study.solutions else None
    pages: list[Path] = []

    def all_failures() -> tuple[str, ...]:
        failed = tuple(dict.fromkeys((*failures, *gaps.sentences)))
        data.update(completed=not failed, failures=list(failed))
        return failed

    def write(folder: Path) -> list[Path]:
        with_page = line.report or line.open_page
        files = write_answer(
            study, folder, with_page, line.figures, written_before=unfinished.file_of
        )
        pages.extend([files.page] if files.page else [])
        for sentence in files.gaps:
            gaps.add(sentence)
        all_failures()
        return [*files.data, *files.figures, *pages]

    with busy("writing files"):
        folder, files = keep_run(
            saved, study.record.text, choices, data, write, origin, unfinished, gaps
        )
    page = pages[0] if pages else None
    data.update(folder=str(folder), files=files, page=None if page is None else str(page))
    if page is not None and line.open_page:
        show_page(page)
    return Outcome(
        data,
        lambda console: console.print(screen(Answer(study), str(page or ""), str(folder))),
        all_failures(),
    )


def keep_run(
    request: SavedRequest,
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
        FORCE,
        Inputs,
        collect_inputs,
        save_run,
    )
    from valvetrain.solution.provenance import collect_provenance
    from valvetrain.solution.status import PartialFailures
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
        folder = missing.part("folder of the run", begun.folder, finish_folder, begun.folder, *stem)
    else:
        folder = new_folder(*stem)
    missing.part("mark of the unfinished run", None, begun.begin, folder)
    written = [path.relative_to(folder).as_posix() for path in write(folder)]
    origin = made_by or collect_provenance(request.case.name, "")
    answer = (
        {"completed": True}
        | plain(data)
        | {
            "created_at": request.created_at.isoformat(),
            "command_line": ["valvetrain", *sys.argv[1:]],
            "files": written,
            "versions": {
                "valvetrain": origin.package_version,
                "python": origin.python_version,
                **origin.dependencies,
            },
        }
    )
    if isinstance(request.case, Case):
        cut_off = {"value": request.case.operation.force_bandwidth, "unit": "Hz"}
        answer |= {DEFINITIONS: {FORCE: {"below": cut_off}}}
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
    request: SavedRequest,
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
    from valvetrain.solution.status import PartialFailures
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
