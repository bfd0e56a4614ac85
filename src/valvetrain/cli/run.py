"""``valvetrain run``: a whole case, by every engine speed and model."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import typer

from valvetrain.cli.outcome import tell
from valvetrain.cli.run_answer import StudyRequest, answer_study, run_command
from valvetrain.errors import InputError

SOLID = "solid"
#: Models that a run of the solid alone shows next to it.
SOLID_AND_OTHERS = ("finite-element", SOLID, "modal-varied")


def register_run(app: typer.Typer) -> None:
    """Add the command."""
    app.command("run")(run)


@run_command
def run(request: StudyRequest) -> None:
    """Run a case at all its engine speeds: answer, data files and a report page."""
    from valvetrain.cli.progress import announce_runs
    from valvetrain.runs.cost import refuse_cost
    from valvetrain.runs.request_cost import request_cost
    from valvetrain.runs.run import run_study

    if request.spring_models == (SOLID,) and request.case.train is None:
        request = replace(request, spring_models=SOLID_AND_OTHERS)
        tell("the rod and the modal model run next to the solid")
    refuse_cost(request_cost(request), request.limits)
    case = request.case
    if case.train is None and not (request.engine_speeds or case.operation.engine_speeds):
        more = (
            "add --engine-speed '4200 rpm' for its motion"
            if case.lift_law is not None
            else "its motion needs a [lift_law] table"
        )
        tell(
            f"case '{case.name}' names no engine speed, so statics and modes only are computed; {more}"
        )
    announce_runs(case)
    answer_study(
        request,
        lambda report, finished: run_study(
            case,
            engine_speeds=request.engine_speeds,
            error_bars=True,
            **request.keywords(report, finished),
        ),
    )


CriticalOption = Annotated[
    bool,
    typer.Option(
        "--no-critical-speeds",
        help="Do not search where a train loses contact, floats and bounces.",
    ),
]
ResolutionOption = Annotated[
    str,
    typer.Option(
        "--resolution",
        metavar="SPEED",
        help="A fifth of the distance of the speeds at which critical speeds are looked for.",
    ),
]
FloatOption = Annotated[
    str,
    typer.Option(
        "--float-lift",
        metavar="LIFT",
        help="Lift above the rigid lift beyond which a valve floats.",
    ),
]
BounceOption = Annotated[
    str,
    typer.Option("--bounce-height", metavar="LIFT", help="Height beyond which a bounce counts."),
]


def register_sweep(app: typer.Typer) -> None:
    """Add the command."""
    app.command("sweep")(sweep)


@run_command
def sweep(
    request: StudyRequest,
    no_critical_speeds: CriticalOption = False,
    resolution: ResolutionOption = "10 rpm",
    float_lift: FloatOption = "0.05 mm",
    bounce_height: BounceOption = "0.1 mm",
) -> None:
    """Sweep a case over engine speed, by default to 1.2 times its red line: forces, clash, surge, and
    where contact is lost.
    """
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.runs.cost import refuse_cost
    from valvetrain.runs.critical_speeds import read_options
    from valvetrain.runs.request_cost import request_cost
    from valvetrain.runs.run import sweep_speeds, sweep_study

    critical = read_options(resolution, float_lift, bounce_height)
    engine_speeds = request.engine_speeds or sweep_speeds(request.case)
    request = replace(request, engine_speeds=engine_speeds)
    cost = request_cost(request, whole=False, searches=not no_critical_speeds)
    refuse_cost(cost, request.limits)
    announce_compilation("statics", "transient", "train")
    answer_study(
        request,
        lambda report, finished: sweep_study(
            request.case,
            engine_speeds,
            critical=None if no_critical_speeds else critical,
            error_bars=True,
            **request.keywords(report, finished),
        ),
    )


def register_compare(app: typer.Typer) -> None:
    """Add the command."""
    app.command("compare")(compare)


@run_command
def compare(request: StudyRequest) -> None:
    """Run a case by several spring models, side by side; a spring alone by solid finite elements
    too.
    """
    from valvetrain.cli.progress import announce_runs
    from valvetrain.runs.compare import compare_study
    from valvetrain.runs.cost import refuse_cost
    from valvetrain.runs.request_cost import request_cost

    refuse_cost(request_cost(request), request.limits)
    announce_runs(request.case)
    answer_study(
        request,
        lambda report, finished: compare_study(
            request.case,
            engine_speeds=request.engine_speeds,
            error_bars=True,
            **request.keywords(report, finished),
        ),
    )


def register_run_up(app: typer.Typer) -> None:
    """Add the command."""
    app.command("run-up")(run_up)


@run_command
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
    from valvetrain.cli.options import read_engine_speeds
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.runs.cost import refuse_cost
    from valvetrain.runs.request_cost import run_up_cost
    from valvetrain.runs.run_up import run_up_study
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
    refuse_cost(run_up_cost(request, (begin, end, seconds)), request.limits)
    announce_compilation("train")
    answer_study(
        request,
        lambda report, _: run_up_study(
            request.case, (begin, end, seconds), **request.keywords(report)
        ),
        choices={"first_engine_speed": first, "last_engine_speed": last, "duration": duration},
    )


def _one(speeds: tuple[float, ...] | None, where: str) -> float:
    if speeds is None or len(speeds) != 1:
        raise InputError("a run-up has one speed at either end; write such as '6000 rpm'", where)
    return speeds[0]
