"""``valvetrain study``: points over any quantities of a case, from a study file."""

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

    from valvetrain.explore.table import StudyPlan, StudyTable

#: Folder of studies by default, by the name of their file.
HOME = Path("runs/studies")
#: Finished points, below the folder of a study.
POINTS = "points"
ANSWER = "study.json"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("study")(study)


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
    from valvetrain.cli.limits import WORTH_SAYING
    from valvetrain.cli.outcome import tell
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.explore.study import estimate_study
    from valvetrain.explore.study_file import read_plan, read_study_file
    from valvetrain.runs.cost import read_limits, refuse_cost
    from valvetrain.runs.saved_runs import safe_name

    limits, count = read_limits(limit), read_workers(workers)
    plan = read_plan(read_study_file(file))
    folder = output or HOME / safe_name(file.stem)
    estimate = estimate_study(plan, count)
    reported = refuse_cost(estimate.cost, limits)
    if estimate.cost.seconds > WORTH_SAYING:
        tell(
            f"{estimate.points} points, {reported}; finished ones are stored in '{folder / POINTS}'"
        )
    announce_compilation(
        "statics", "transient", *(["train"] if plan.case and plan.case.train is not None else [])
    )
    _answer(_Request(plan, folder, count, dask, open_page), limits)


@dataclass(frozen=True)
class _Request:
    plan: StudyPlan
    folder: Path
    workers: int
    dask: str
    open_page: bool


def _answer(request: _Request, limits: Any) -> None:
    from valvetrain.cli.guard import interrupted
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import progress_bar
    from valvetrain.explore.study import PointsInterrupted, run_plan

    try:
        with progress_bar(request.plan.title) as report:
            table = run_plan(
                request.plan, request.workers, request.dask, request.folder / POINTS, limits, report
            )
    except PointsInterrupted as cut:
        done = sum(one.code != "interrupted" for one in cut.table.statuses)
        phrase = f"{done} of {len(cut.table)} points are stored in '{request.folder / POINTS}'; start the command again to continue"
        raise typer.Exit(interrupted(f"interrupted: {phrase}")) from None
    deliver(_written(request, table))


def _written(request: _Request, table: StudyTable) -> Any:
    """The files of a finished study, and its answer."""
    from valvetrain.cli.outcome import Outcome
    from valvetrain.explore.study_page import points_json, write_points
    from valvetrain.solution.partial_failures import PartialFailures

    gaps = PartialFailures()
    data = keep_points(
        "study",
        points_json(table),
        request,
        partial(write_points, table, request.folder, gaps),
        ANSWER,
        gaps,
    )
    failures = _failures(table)
    return Outcome(
        data, lambda console: _show(console, table, request.folder), (*failures, *gaps.sentences)
    )


def _failures(table: StudyTable) -> tuple[str, ...]:
    """A sentence where no point came out, or a worker was lost; that some points of a study cannot
    be built is part of its answer.
    """
    if not table.completed.any():
        return table.failures[:1]
    return tuple(
        sentence
        for sentence, one in zip(
            table.failures, filter(lambda s: not s.completed, table.statuses), strict=True
        )
        if one.code == "worker-lost"
    )[:5]


def _show(console: Console, table: StudyTable, folder: Path) -> None:
    from valvetrain.cli.outcome import plain_table
    from valvetrain.explore.study_page import ANSWER_HEADS, answer_rows, sentences

    several = len(table.plan.runs) > 1
    rows = [row if several else (row[0], *row[2:]) for row in answer_rows(table)]
    heads = ANSWER_HEADS if several else (ANSWER_HEADS[0], *ANSWER_HEADS[2:])
    first = 2 if several else 1
    console.print(table.plan.title)
    console.print()
    console.print(plain_table(heads, rows, right=range(first, first + 5)))
    console.print()
    for sentence in sentences(table):
        console.print(sentence)
    for sentence in table.failures[:3]:
        console.print(f"  {sentence}", soft_wrap=True)
    there = len(table) - table.computed
    console.print(
        f"{table.computed} points computed{f', {there} read from the store' if there > 0 else ''}",
        soft_wrap=True,
    )
    console.print(f"results  {folder}", soft_wrap=True)
