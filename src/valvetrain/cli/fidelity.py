"""``valvetrain fidelity``: which spring model is good enough up to which engine speed."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated

import typer

from valvetrain.cli.study_command import StudyRequest, answer_study, study_command

#: Crank speeds (rpm) of a comparison that names none: first, last, step.
USUAL = (1000, 9000, 500)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("fidelity")(fidelity)


@study_command
def fidelity(
    request: StudyRequest,
    reference: Annotated[
        str,
        typer.Option(
            "--reference", metavar="MODEL", help="Spring model that the others are judged by."
        ),
    ] = "",
    tolerance: Annotated[
        str,
        typer.Option(
            "--tolerance",
            metavar="SHARE",
            help="Largest difference of a model that is good enough.",
        ),
    ] = "5 %",
) -> None:
    """Which spring model is good enough where: all models over engine speed (default: 1000:9000:500
    rpm) beside finite elements.
    """
    from valvetrain.cli.limits import say_cost
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.errors import InputError
    from valvetrain.studies.cost import FEWER
    from valvetrain.studies.fidelity import (
        fidelity_cost,
        fidelity_models,
        fidelity_study,
        refuse_tolerance,
    )
    from valvetrain.units import parse_quantity

    if len(request.spring_sets) > 1:
        raise InputError("models are compared for one spring set; name one", "--spring-set")
    chosen = request.spring_sets[0] if request.spring_sets else ""
    first, last, step = USUAL
    speeds = request.engine_speeds or tuple(
        value * math.pi / 30 for value in range(first, last + 1, step)
    )
    models, share = (
        fidelity_models(request.case, request.spring_models, chosen, reference),
        parse_quantity(tolerance, "ratio", "--tolerance"),
    )
    refuse_tolerance(share)
    request = replace(request, engine_speeds=speeds, spring_models=models)
    say_cost(
        fidelity_cost(request.case, speeds, models, chosen, request.workers), request.limits, FEWER
    )
    announce_compilation("statics", "transient", "train")
    answer_study(
        request,
        lambda report, finished: fidelity_study(
            request.case,
            speeds,
            spring_models=models,
            spring_set=chosen,
            tolerance=share,
            workers=request.workers,
            progress=report,
            created_at=request.created_at.isoformat(),
            finished=finished,
            limits=request.limits,
            implausible=request.implausible,
        ),
        choices={"reference": models[-1], "tolerance": share},
    )
