"""``valvetrain run-up``: a train from one engine speed to another, and what it does on the way."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import typer

from valvetrain.cli.study_command import StudyRequest, answer_study, study_command
from valvetrain.errors import InputError


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("run-up")(run_up)


@study_command
def run_up(
    request: StudyRequest,
    first: Annotated[
        str,
        typer.Option(
            "--from", metavar="SPEED", help="Engine speed at the start, in steady motion."
        ),
    ] = "1000 rpm",
    last: Annotated[
        str,
        typer.Option(
            "--to", metavar="SPEED", help="Engine speed at the end; a lower one is a run-down."
        ),
    ] = "6000 rpm",
    duration: Annotated[
        str, typer.Option("--duration", metavar="TIME", help="Duration of the run-up.")
    ] = "2 s",
) -> None:
    """Accelerate a train through its speeds: envelope of forces, loss of contact and float over
    engine speed.
    """
    from valvetrain.cli.limits import say_cost
    from valvetrain.cli.options import read_engine_speeds
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.studies.cost import FEWER
    from valvetrain.studies.request_cost import run_up_cost
    from valvetrain.studies.run_up import run_up_study
    from valvetrain.units import parse_quantity

    if request.engine_speeds:
        raise InputError(
            "a run-up goes --from one speed --to another; leave --engine-speed out",
            "--engine-speed",
        )
    begin, end = (
        _one(read_engine_speeds(text, where), where)
        for text, where in ((first, "--from"), (last, "--to"))
    )
    seconds = parse_quantity(duration, "time", "--duration")
    if not seconds > 0:
        raise InputError(
            f"the run-up must take a positive time; it takes {seconds:g} s", "--duration"
        )
    request = replace(request, command="run-up")
    say_cost(run_up_cost(request, (begin, end, seconds)), request.limits, FEWER)
    announce_compilation("train")
    answer_study(
        request,
        lambda report, finished: run_up_study(
            request.case,
            (begin, end, seconds),
            spring_models=request.spring_models,
            spring_sets=request.spring_sets,
            workers=request.workers,
            progress=report,
            created_at=request.created_at.isoformat(),
            implausible=request.implausible,
        ),
        choices={"first_engine_speed": first, "last_engine_speed": last, "duration": duration},
    )


def _one(speeds: tuple[float, ...] | None, where: str) -> float:
    if speeds is None or len(speeds) != 1:
        raise InputError("a run-up has one speed at either end; write such as '6000 rpm'", where)
    return speeds[0]
