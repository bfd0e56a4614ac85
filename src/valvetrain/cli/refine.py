"""``valvetrain refine``: numerical and physical uncertainty of the headline numbers of a spring or
a train.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from valvetrain.cli.request import DaskLine, command_of
from valvetrain.cli.run_answer import SavedRequest, saved_result
from valvetrain.runs.requests import Refine

if TYPE_CHECKING:
    from valvetrain.cli.outcome import Outcome
    from valvetrain.runs.error_bars import UncertaintyStudy


def refine(request: Refine, line: DaskLine, folder: Path) -> None:
    """State the uncertainty of the headline numbers of a spring or a train: finer meshes and steps,
    other contact constants.
    """
    from valvetrain.cli.guard import interrupted
    from valvetrain.cli.outcome import deliver
    from valvetrain.runs.cost import FEWER_REFINED, refuse_cost

    refuse_cost(request.cost(), request.limit, fewer=FEWER_REFINED)
    saved = SavedRequest(request.command, request.case, line.output, folder)
    study, stopped = _refined(request)
    outcome = _saved_outcome(request, saved, study, stopped, line.open_page)
    if not stopped:
        deliver(outcome)
        return
    with suppress(typer.Exit):
        deliver(outcome)
    sentence = f"{study.finished} of {study.runs} runs were finished, and their numbers are saved in '{outcome.data['folder']}'"
    raise typer.Exit(
        interrupted(f"interrupted: {sentence}; start the command again to compute all of them")
    )


register_refine = command_of(Refine, DaskLine, refine)


def _refined(request: Refine) -> tuple[UncertaintyStudy, bool]:
    """The study, and whether it was stopped."""
    from valvetrain.cli.progress import announce_runs, progress_bar
    from valvetrain.runs.error_bars import RefinementStopped
    from valvetrain.runs.refine import refined
    from valvetrain.runs.workers import worker_count

    case = request.case
    announce_runs(case)
    try:
        with progress_bar(case.name) as report:
            return refined(
                case,
                engine_speeds=request.engine_speeds,
                workers=worker_count(request.workers),
                progress=report,
                limits=request.limit,
                implausible=request.implausible,
            ), False
    except RefinementStopped as cut:
        return cut.study, True


def _saved_outcome(
    request: Refine, saved: SavedRequest, study: UncertaintyStudy, stopped: bool, open_page: bool
) -> Outcome:
    """The study written to its folder, with a sentence where it was ``stopped`` or a variant
    failed.
    """
    from valvetrain.parameters.summary import rpm
    from valvetrain.solution.atomic import write_text
    from valvetrain.views.json import uncertainty_object
    from valvetrain.views.refinement import RefineAnswer
    from valvetrain.views.study_files import levels_table, uncertainty_table

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
        table = write_text(folder / "uncertainty.csv", uncertainty_table(study.rows))
        return [table, write_text(folder / "levels.csv", levels_table(study))]

    choices = {
        "engine_speeds": [rpm(speed) for speed in engine_speeds or case.operation.engine_speeds],
        "engine_speed_unit": "rpm",
    }
    text = case.record().text
    return saved_result(
        saved, text, data, lambda _: RefineAnswer(study), write, choices, open_page, study.failures
    )
