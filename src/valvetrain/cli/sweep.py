"""``valvetrain sweep``: a case over engine speed, up to loss of control."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated

import typer

from valvetrain.cli.study_command import StudyRequest, answer_study, study_command

#: Crank speeds (rpm) of a sweep that names none: first, last, step.
USUAL = (1000, 9000, 100)
CriticalOption = Annotated[
    bool,
    typer.Option(
        "--no-critical-speeds",
        help="Do not search where a train loses contact, floats and bounces.",
    ),
]
ResolutionOption = Annotated[
    str,
    typer.Option("--resolution", metavar="SPEED", help="Width of the brackets of critical speeds."),
]
FloatOption = Annotated[
    str,
    typer.Option(
        "--float-lift", metavar="LIFT", help="Lift above the rigid one beyond which a valve floats."
    ),
]
BounceOption = Annotated[
    str,
    typer.Option("--bounce-height", metavar="LIFT", help="Height beyond which a bounce counts."),
]


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("sweep")(sweep)


@study_command
def sweep(
    request: StudyRequest,
    no_critical_speeds: CriticalOption = False,
    resolution: ResolutionOption = "10 rpm",
    float_lift: FloatOption = "0.05 mm",
    bounce_height: BounceOption = "0.1 mm",
) -> None:
    """Sweep a case over engine speed (default: 1000:9000:100 rpm): forces, clash, surge, and where
    contact is lost.
    """
    from valvetrain.cli.limits import refuse_beyond
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.studies.critical_speeds import read_options
    from valvetrain.studies.sweep import sweep_study

    critical = read_options(resolution, float_lift, bounce_height)
    first, last, step = USUAL
    engine_speeds = request.engine_speeds or tuple(
        value * math.pi / 30 for value in range(first, last + 1, step)
    )
    request = replace(request, engine_speeds=engine_speeds)
    refuse_beyond(request, whole=False, searches=not no_critical_speeds)
    announce_compilation("statics", "transient", "train")
    answer_study(
        request,
        lambda report, finished: sweep_study(
            request.case,
            engine_speeds,
            spring_models=request.spring_models,
            spring_sets=request.spring_sets,
            workers=request.workers,
            progress=report,
            finished=finished,
            created_at=request.created_at.isoformat(),
            critical=None if no_critical_speeds else critical,
            limits=request.limits,
            implausible=request.implausible,
        ),
    )
