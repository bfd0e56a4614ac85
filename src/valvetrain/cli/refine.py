"""``valvetrain refine``: numerical and physical uncertainty of the headline numbers of a spring or
a train.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from valvetrain.cli.options import (
    CaseArgument,
    DaskOption,
    ElementsOption,
    ImplausibleOption,
    JsonOption,
    LimitOption,
    OutputOption,
    QuietOption,
    SetOption,
    SpeedOption,
    WorkersOption,
    name_case,
    read_engine_speeds,
    read_workers,
    take_folder,
)

if TYPE_CHECKING:
    from valvetrain.cli.outcome import Outcome
    from valvetrain.parameters.case import Case
    from valvetrain.runs.cost import Limits
    from valvetrain.runs.error_bars import UncertaintyStudy


def register_refine(app: typer.Typer) -> None:
    """Add the command."""
    app.command("refine")(refine)


@dataclass(frozen=True)
class RefineRequest:
    """A request of ``refine``: case, folder of the case file, output folder and time;
    ``engine_speeds`` (rad/s of the crank, None: the case's own), workers and limits of the runs,
    and whether implausible values pass.
    """

    case: Case
    folder: Path
    output: Path | None
    created_at: datetime
    engine_speeds: tuple[float, ...] | None
    workers: int
    limits: Limits
    implausible: bool
    command: str = "refine"


def refine(
    case: CaseArgument,
    output: OutputOption = None,
    engine_speed: SpeedOption = None,
    elements_per_coil: ElementsOption = None,
    settings: SetOption = None,
    dask: DaskOption = "",
    workers: WorkersOption = None,
    limit: LimitOption = None,
    implausible: ImplausibleOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """State the uncertainty of the headline numbers of a spring or a train: finer meshes and steps,
    other contact constants.
    """
    from valvetrain.cli.guard import interrupted
    from valvetrain.cli.options import choose_case, folder_of
    from valvetrain.cli.outcome import deliver
    from valvetrain.runs.cost import FEWER_REFINED, read_limits, refuse_cost
    from valvetrain.runs.request_cost import refine_cost

    name_case(case, settings)
    chosen = choose_case(case, settings, elements_per_coil)
    take_folder(output)
    request = RefineRequest(
        chosen,
        folder_of(case),
        output,
        datetime.now(UTC).replace(microsecond=0),
        read_engine_speeds(engine_speed),
        read_workers(workers, dask),
        read_limits(limit),
        implausible,
    )
    cost = refine_cost(chosen, request.engine_speeds, request.workers)
    refuse_cost(cost, request.limits, fewer=FEWER_REFINED)
    study, stopped = _refined(request)
    outcome = _saved_outcome(request, study, stopped)
    if not stopped:
        deliver(outcome)
        return
    with suppress(typer.Exit):
        deliver(outcome)
    sentence = f"{study.finished} of {study.runs} runs were finished, and their numbers are saved in '{outcome.data['folder']}'"
    raise typer.Exit(
        interrupted(f"interrupted: {sentence}; start the command again to compute all of them")
    )


def _refined(request: RefineRequest) -> tuple[UncertaintyStudy, bool]:
    """The study, and whether it was stopped."""
    from valvetrain.cli.progress import announce_runs, progress_bar
    from valvetrain.runs.error_bars import RefinementStopped
    from valvetrain.runs.refine import refined

    case = request.case
    announce_runs(case)
    try:
        with progress_bar(case.name) as report:
            return refined(
                case,
                engine_speeds=request.engine_speeds,
                workers=request.workers,
                progress=report,
                limits=request.limits,
                implausible=request.implausible,
            ), False
    except RefinementStopped as cut:
        return cut.study, True


def _saved_outcome(request: RefineRequest, study: UncertaintyStudy, stopped: bool) -> Outcome:
    """The study written to its folder, with a sentence where it was ``stopped`` or a variant
    failed.
    """
    from valvetrain.cli.run_answer import saved_result
    from valvetrain.solution.atomic import write_text
    from valvetrain.views.json import uncertainty_object
    from valvetrain.views.refinement import RefineAnswer
    from valvetrain.views.text import rpm
    from valvetrain.views.uncertainty_tables import levels_table, uncertainty_table

    case, engine_speeds = request.case, request.engine_speeds
    if stopped:
        rest = f"interrupted: {study.finished} of {study.runs} runs were finished; a speed or variant without all of its runs has no bars"
        study = replace(study, failures=(*study.failures, rest))
    data = {
        "command": "refine", "case": case.name, "title": case.title, "elements_per_coil": list(study.elements_per_coil),
        "uncertainties": [uncertainty_object(row) for row in study.rows], "completed": not study.failures,
        "failures": list(study.failures), "page": "report.html",
    }  # fmt: skip

    def write(folder: Path) -> list[Path]:
        table = write_text(folder / "uncertainty.csv", uncertainty_table(study.rows).csv())
        return [table, write_text(folder / "levels.csv", levels_table(study).csv())]

    choices = {
        "engine_speeds": [rpm(speed) for speed in engine_speeds or case.operation.engine_speeds],
        "engine_speed_unit": "rpm",
    }
    text = case.record().text
    return saved_result(
        request, text, data, lambda _: RefineAnswer(study), write, choices, failures=study.failures
    )
