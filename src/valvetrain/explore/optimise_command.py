"""``valvetrain optimise``: searches of springs and lift laws, from an optimisation file."""

from __future__ import annotations

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
    points_folder,
    read_workers,
)
from valvetrain.cli.study_command import keep_points

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.explore.objective import OptimumPlan
    from valvetrain.explore.optimum import Optimum

#: Folder of searches by default, by the name of their file.
HOME = Path("runs/optimise")
#: Finished points, below the folder of a search.
POINTS = "points"
ANSWER = "optimum.json"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("optimise")(optimise)


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
    from valvetrain.cli.limits import WORTH_SAYING
    from valvetrain.cli.outcome import tell
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.explore.objective import read_optimum
    from valvetrain.explore.optimise import FEWER, estimate_search
    from valvetrain.explore.optimum_file import read_optimum_file
    from valvetrain.runs.cost import read_limits, refuse_cost
    from valvetrain.runs.saved_runs import safe_name

    limits, count = read_limits(limit), read_workers(workers)
    plan = read_optimum(read_optimum_file(file))
    folder = output or HOME / safe_name(file.stem)
    estimate = estimate_search(plan, count)
    reported = refuse_cost(estimate.cost, limits, fewer=FEWER)
    if estimate.cost.seconds > WORTH_SAYING:
        tell(
            f"{estimate.trials} trials, {reported} at most; finished points are stored in '{folder / POINTS}'"
        )
    moves = any(one.outputs.request.motion for one in plan.plans.values())
    if moves or any(not one.outputs.request.sizes_alone for one in plan.plans.values()):
        announce_compilation(
            "statics",
            *(["transient"] if moves else []),
            *(["train"] if plan.case and plan.case.train is not None else []),
        )
    _answer(_Request(plan, folder, count, dask, open_page), limits)


@dataclass(frozen=True)
class _Request:
    plan: OptimumPlan
    folder: Path
    workers: int
    dask: str
    open_page: bool


def _answer(request: _Request, limits: Any) -> None:
    from valvetrain.cli.guard import interrupted
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import progress_bar
    from valvetrain.explore.optimise import SearchInterrupted, run_search

    try:
        with progress_bar(request.plan.title) as report:
            found = run_search(
                request.plan, request.workers, request.dask, request.folder / POINTS, limits, report
            )
    except SearchInterrupted as cut:
        done = len(cut.optimum.trials) - 1
        _written(request, cut.optimum)
        phrase = f"{done} trials are in '{request.folder}'; start the command again to continue"
        raise typer.Exit(interrupted(f"interrupted: {phrase}")) from None
    deliver(_written(request, found))


def _written(request: _Request, found: Optimum) -> Any:
    """The files of a search, and its answer."""
    from valvetrain.cli.outcome import Outcome
    from valvetrain.explore.optimum_page import optimum_json, write_optimum
    from valvetrain.explore.optimum_summary import answer
    from valvetrain.solution.partial_failures import PartialFailures

    gaps = PartialFailures()
    data = keep_points(
        "optimise",
        optimum_json(found),
        request,
        partial(write_optimum, found, request.folder, gaps),
        ANSWER,
        gaps,
    )
    failures = () if found.best is not None or not found.finished else (answer(found),)
    return Outcome(
        data, lambda console: _show(console, found, request.folder), (*failures, *gaps.sentences)
    )


def _show(console: Console, found: Optimum, folder: Path) -> None:
    from valvetrain.cli.outcome import plain_table
    from valvetrain.explore.optimum_page import ANSWER_HEADS, BEST, answer_rows
    from valvetrain.explore.optimum_summary import sentences

    console.print(found.plan.title)
    console.print()
    if found.best is not None:
        console.print(plain_table(ANSWER_HEADS, answer_rows(found), right=(1, 2, 4)))
        console.print()
        for sentence in sentences(found):
            console.print(sentence, soft_wrap=True)
    console.print(
        f"{len(found.trials)} trials, {found.computed} points computed in {found.seconds:.0f} s",
        soft_wrap=True,
    )
    if found.best is not None:
        console.print(f"run the best  valvetrain run {folder / BEST}", soft_wrap=True)
    console.print(f"results  {folder}", soft_wrap=True)
