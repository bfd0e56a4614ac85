"""``valvetrain study`` and ``valvetrain optimise``: points of a case from a study file, searches of
springs and lift laws from an optimisation file.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    DaskOption,
    JsonOption,
    LimitOption,
    OpenOption,
    QuietOption,
    WorkersOption,
    at_end,
    points_folder,
    read_workers,
)
from valvetrain.cli.run_answer import keep_points

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.cli.outcome import Outcome
    from valvetrain.explore.optimum import Optimum
    from valvetrain.explore.table import StudyTable
    from valvetrain.runs.cost import Cost

#: Folders of studies and searches by default, by the name of their file.
STUDIES, SEARCHES = Path("runs/studies"), Path("runs/optimise")
#: Finished points, below the folder of a study or search.
POINTS = "points"
STUDY_JSON, OPTIMUM_JSON = "study.json", "optimum.json"


def register(app: typer.Typer) -> None:
    """Add ``study``."""
    app.command("study")(study)


def register_optimise(app: typer.Typer) -> None:
    """Add ``optimise``."""
    app.command("optimise")(optimise)


@dataclass(frozen=True)
class _Request:
    plan: Any
    folder: Path
    workers: int
    open_page: bool


def study(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="Study file (docs/studies.md): case, varied quantities, outputs."
        ),
    ],
    output: Annotated[Path | None, points_folder("runs/studies/FILE")] = None,
    dask: DaskOption = "",
    workers: WorkersOption = None,
    limit: LimitOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Parameter study: grid, list or random draws over any quantities of a case; tolerances with
    Sobol indices, surrogates.
    """
    from valvetrain.explore.files import case_words
    from valvetrain.explore.study import estimate_study, read_plan, read_study_file, run_plan
    from valvetrain.runs.cost import read_limits
    from valvetrain.runs.run_folders import safe_name
    from valvetrain.session import call_case

    limits, count = read_limits(limit), read_workers(workers, dask)
    text = read_study_file(file)
    plan = read_plan(text)
    call_case(case_words(text))
    at_end(partial(call_case, []))
    folder = output or STUDIES / safe_name(file.stem)
    estimate = estimate_study(plan, count)
    _announce(estimate.cost, limits, folder, f"{estimate.points} points, {{}}; finished ones")
    _compile("statics", "transient", *(["train"] if plan.case and plan.case.train else []))
    request = _Request(plan, folder, count, open_page)
    _answer(request, partial(run_plan, limits=limits), _study_written)


def optimise(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Optimisation file (docs/optimisation.md): ranges, objectives, bounds.",
        ),
    ],
    output: Annotated[Path | None, points_folder("runs/optimise/FILE")] = None,
    dask: DaskOption = "",
    workers: WorkersOption = None,
    limit: LimitOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Search the best spring or lift law within bounds on space, coil bind, stress, float and
    clash. A cut search is resumed.
    """
    from valvetrain.explore import optimise as search
    from valvetrain.explore.objective import read_optimum
    from valvetrain.explore.optimum_file import read_optimum_file
    from valvetrain.runs.cost import read_limits
    from valvetrain.runs.run_folders import safe_name

    limits, count = read_limits(limit), read_workers(workers, dask)
    plan = read_optimum(read_optimum_file(file))
    folder = output or SEARCHES / safe_name(file.stem)
    estimate = search.estimate_search(plan, count)
    announcement = f"{estimate.trials} trials, {{}} at most; finished points"
    _announce(estimate.cost, limits, folder, announcement, fewer=search.FEWER)
    requests = [one.outputs.request for one in plan.plans.values()]
    moves = any(one.motion for one in requests)
    if moves or not all(one.sizes_alone for one in requests):
        train = ["train"] if plan.case and plan.case.train else []
        _compile("statics", *(["transient"] if moves else []), *train)
    request = _Request(plan, folder, count, open_page)
    _answer(request, partial(search.run_search, limits=limits), _optimum_written)


def _announce(cost: Cost, limits: Any, folder: Path, text: str, **fewer: str) -> None:
    """Refuse a request beyond the limits, and say what takes long."""
    from valvetrain.cli.outcome import WORTH_SAYING, tell
    from valvetrain.runs.cost import refuse_cost

    estimate = refuse_cost(cost, limits, **fewer)
    if cost.seconds > WORTH_SAYING:
        tell(f"{text.format(estimate)} are stored in '{folder / POINTS}'")


def _compile(*kernels: str) -> None:
    from valvetrain.cli.progress import announce_compilation

    announce_compilation(*kernels)


def _answer(
    request: _Request, compute: Callable[..., Any], write: Callable[[_Request, Any], Outcome]
) -> None:
    from valvetrain.cli.guard import interrupted
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import progress_bar
    from valvetrain.explore.optimise import SearchInterrupted
    from valvetrain.explore.study import PointsInterrupted

    points = request.folder / POINTS
    try:
        with progress_bar(request.plan.title) as report:
            found = compute(request.plan, request.workers, folder=points, progress=report)
    except PointsInterrupted as cut:
        done = sum(one.code != "interrupted" for one in cut.table.statuses)
        text = f"{done} of {len(cut.table)} points are stored in '{points}'"
    except SearchInterrupted as cut:
        write(request, cut.optimum)
        text = f"{len(cut.optimum.trials) - 1} trials are in '{request.folder}'"
    else:
        deliver(write(request, found))
        return
    raise typer.Exit(interrupted(f"interrupted: {text}; start the command again to continue"))


def _study_written(request: _Request, table: StudyTable) -> Outcome:
    """The files of a finished study, and its answer."""
    from valvetrain.cli.outcome import Outcome
    from valvetrain.explore.study_answer import StudyAnswer
    from valvetrain.explore.study_files import points_json, write_points
    from valvetrain.solution.partial_failures import PartialFailures
    from valvetrain.views.terminal import screen

    failures = PartialFailures()
    answer = points_json(table)  # first, for it computes the error bars
    write = partial(write_points, table, request.folder, failures)
    data = keep_points("study", answer, request, write, STUDY_JSON, failures)
    # that some points of a study cannot be built is part of its answer
    found = table.failures[:1]
    if table.completed.any():
        statuses = [one for one in table.statuses if not one.completed]
        pairs = zip(table.failures, statuses, strict=True)
        found = tuple(text for text, one in pairs if one.code == "worker-lost")[:5]
    page = str(data["page"] or "")
    return Outcome(
        data,
        lambda console: console.print(screen(StudyAnswer(table), page, str(request.folder))),
        (*found, *failures.sentences),
    )


def _optimum_written(request: _Request, found: Optimum) -> Outcome:
    """The files of a search, and its answer."""
    from valvetrain.cli.outcome import Outcome
    from valvetrain.explore.optimum_answer import answer_of_search
    from valvetrain.explore.optimum_files import best_file, optimum_json, write_optimum
    from valvetrain.solution.partial_failures import PartialFailures
    from valvetrain.views.terminal import screen

    failures = PartialFailures()
    write = partial(write_optimum, found, request.folder, failures)
    data = keep_points("optimise", optimum_json(found), request, write, OPTIMUM_JSON, failures)
    file = best_file(found, request.folder)
    no_design = found.best is None and found.finished
    nothing = (str(answer_of_search(found).verdict),) if no_design else ()

    def show(console: Console) -> None:
        console.print(screen(answer_of_search(found, file), data["page"] or "", data["folder"]))

    return Outcome(data, show, (*nothing, *failures.sentences))
