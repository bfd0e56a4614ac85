"""``valvetrain run``: a whole case, by every engine speed and model."""

from __future__ import annotations

import typer

from valvetrain.cli.outcome import tell
from valvetrain.cli.study_command import StudyRequest, answer_study, study_command


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("run")(run)


@study_command
def run(request: StudyRequest) -> None:
    """Run a case at all its engine speeds: answer, data files and a report page."""
    from valvetrain.cli.limits import refuse_beyond
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.studies.run import run_study

    refuse_beyond(request)
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
    announce_compilation(*(("train",) if case.train is not None else ("statics", "transient")))
    answer_study(
        request,
        lambda report, finished: run_study(
            case,
            engine_speeds=request.engine_speeds,
            spring_models=request.spring_models,
            spring_sets=request.spring_sets,
            workers=request.workers,
            progress=report,
            finished=finished,
            created_at=request.created_at.isoformat(),
            limits=request.limits,
            implausible=request.implausible,
        ),
    )
