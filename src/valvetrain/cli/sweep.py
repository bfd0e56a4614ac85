"""``valvetrain sweep``: a case over engine speed, up to loss of control."""

from __future__ import annotations

import math
from dataclasses import replace

import typer

from valvetrain.cli.study_command import StudyRequest, answer_study, study_command

#: Crank speeds (rpm) of a sweep that names none: first, last, step.
USUAL = (1000, 9000, 100)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("sweep")(sweep)


@study_command
def sweep(request: StudyRequest) -> None:
    """Sweep a case over engine speed (default: 1000:9000:100 rpm): forces, clash, surge, and where contact is lost."""
    from valvetrain.cli.limits import refuse_beyond
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.studies.sweep import sweep_study

    first, last, step = USUAL
    engine_speeds = request.engine_speeds or tuple(value * math.pi / 30 for value in range(first, last + 1, step))
    request = replace(request, engine_speeds=engine_speeds)
    refuse_beyond(request, whole=False)
    announce_compilation("statics", "transient", "train")
    answer_study(
        request,
        lambda report: sweep_study(
            request.case, engine_speeds, spring_models=request.spring_models, spring_sets=request.spring_sets, workers=request.workers,
            progress=report, created_at=request.created_at.isoformat(),
        ),
    )  # fmt: skip
