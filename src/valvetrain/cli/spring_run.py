"""``run`` for a case with a spring alone: the spring study, its files and its table."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.cli.options import make_folder
from valvetrain.cli.outcome import Outcome, tell
from valvetrain.cli.run_request import RunRequest
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.parameters.case import Case
    from valvetrain.quantities.study import SpringStudy


def run_spring(request: RunRequest) -> Outcome:
    """Run the study, write its folder, and hand back what to print."""
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.cli.results import study_object
    from valvetrain.studies.spring_study import MODELS, run_spring_study

    case, models = request.case, request.spring_models or MODELS
    check_models(models, MODELS)
    speeds = _engine_speeds(case, request.engine_speeds)
    make_folder(request.output)
    announce_compilation("statics", *(["transient"] if speeds and "finite-element" in models else []))
    with progress_bar(case.name) as report:
        study = run_spring_study(
            case, engine_speeds=speeds, models=models, workers=request.workers, progress=report,
            created_at=datetime.now(UTC).isoformat(timespec="seconds"),
        )  # fmt: skip
    data_files, page = write_files(study, request.output, request.report)
    failures = study_failures(study)
    data: dict[str, Any] = {
        "command": "run", "case": case.name, "title": case.title, "elements_per_coil": case.rod.elements_per_coil,
        "completed": not failures, **study_object(study), "folder": str(request.output),
        "files": [str(path) for path in data_files], "page": None if page is None else str(page),
    }  # fmt: skip
    return Outcome(data, lambda console: _show(console, study, request.output, page), failures)


def check_models(wanted: Sequence[str], known: Sequence[str]) -> None:
    """Raise :class:`InputError` with the nearest name for a spring model that is not ``known``."""
    from valvetrain.parameters.changes import nearest

    for name in wanted:
        if name not in known:
            raise InputError(f"spring model '{name[:40]}' is unknown here; {nearest(name, tuple(known))}", "--spring")


def _engine_speeds(case: Case, asked: tuple[float, ...] | None) -> tuple[float, ...]:
    speeds = case.operation.engine_speeds if asked is None else asked
    if speeds and case.lift_law is None:
        raise InputError(f"case '{case.name}' has no lift law, so nothing moves at an engine speed; add a [lift_law] table")
    if not speeds:
        more = "add --engine-speed '4200 rpm' for its motion" if case.lift_law is not None else "its motion needs a [lift_law] table"
        tell(f"case '{case.name}' names no engine speed, so statics and modes only are computed; {more}")
    return speeds


def study_failures(study: SpringStudy) -> tuple[str, ...]:
    """A sentence per part of the study that did not complete."""
    from valvetrain.report.words import speed_words

    found = [
        f"{part}: {result.status.sentence()}"
        for part, result in (("static curve", study.static_curve), ("modes", study.modal_result))
        if result is not None and not result.status.completed
    ]
    runs = [run for run in study.solutions if not run.status.completed]
    return (*found, *(f"{run.model} at {speed_words(run.engine_speed)}: {run.status.sentence()}" for run in runs))


def write_files(study: SpringStudy, folder: Path, report: bool) -> tuple[list[Path], Path | None]:
    """The data files and, with ``report``, the page; what a failed run computed is written too."""
    from valvetrain.cli.progress import busy
    from valvetrain.report.comparison_grid import comparison_table
    from valvetrain.report.earlier_files import remove_earlier
    from valvetrain.report.write import write_report, write_solution, write_statics
    from valvetrain.solution.atomic import write_text

    with busy("writing files"):
        if report:
            files = write_report(study, folder)
            return [*files.data, *files.figures], files.page
        data = [path for solution in study.solutions for path in write_solution(solution, folder)] + write_statics(study, folder)
        if study.comparisons:
            data.append(write_text(folder / "comparison.csv", comparison_table(study.comparisons).csv()))
        remove_earlier(folder, "report", data)
        return data, None


def _show(console: Console, study: SpringStudy, folder: Path, page: Path | None) -> None:
    from valvetrain.cli.study_tables import show_study

    show_study(console, study)
    console.print(f"\nresults  {folder}", soft_wrap=True)
    if page is not None:
        console.print(f"report   {page}", soft_wrap=True)
