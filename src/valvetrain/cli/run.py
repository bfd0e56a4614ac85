"""``valvetrain run``, ``sweep``, ``compare`` and ``run-up``: a case at its engine speeds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from valvetrain.cli.outcome import tell
from valvetrain.cli.request import MotionLine, command_of
from valvetrain.cli.run_answer import answer_study
from valvetrain.runs.requests import Compare, Run, RunUp, Sweep

SOLID = "solid"
#: Models that a run of the solid alone shows next to it.
SOLID_AND_OTHERS = ("finite-element", SOLID, "modal-varied")
#: Kernels of a sweep.
KERNELS = ("statics", "transient", "train")


def run(request: Run, line: MotionLine, folder: Path) -> None:
    """Run a case at all its engine speeds: answer, data files and a report page."""
    from valvetrain.runs.run import run_study

    case = request.case
    if request.models == (SOLID,) and case.train is None:
        request = replace(request, models=SOLID_AND_OTHERS)
        tell("the rod and the modal model run next to the solid")
    if case.train is None and not (request.engine_speeds or case.operation.engine_speeds):
        more = (
            "add --rpm 4200 for its motion"
            if case.lift_law is not None
            else "its motion needs a [lift_law] table"
        )
        tell(
            f"case '{case.name}' names no engine speed, so statics and modes only are computed; {more}"
        )
    answer_study(request, line, folder, run_study, request.cost())


register_run = command_of(Run, MotionLine, run, compute="error_bars")


def sweep(request: Sweep, line: MotionLine, folder: Path) -> None:
    """Sweep a case over engine speed, by default to 1.2 times its red line: forces, clash, surge, and
    where contact is lost.
    """
    from valvetrain.runs.run import sweep_study

    request = request.with_speeds()
    answer_study(request, line, folder, sweep_study, request.cost(), KERNELS)


register_sweep = command_of(Sweep, MotionLine, sweep, compute="error_bars")


def compare(request: Compare, line: MotionLine, folder: Path) -> None:
    """Run a case by several spring models, side by side; a spring alone by solid finite elements
    too.
    """
    from valvetrain.runs.compare import compare_study

    answer_study(request, line, folder, compare_study, request.cost())


register_compare = command_of(Compare, MotionLine, compare, compute="error_bars")


def run_up(request: RunUp, line: MotionLine, folder: Path) -> None:
    """Accelerate a train through its speeds: envelope of forces, loss of contact and float over
    engine speed.
    """
    from valvetrain.runs.run_up import run_up_study

    answer_study(request, line, folder, run_up_study, request.cost(), ("train",))


register_run_up = command_of(RunUp, MotionLine, run_up)
