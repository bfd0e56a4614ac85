"""``valvetrain compare-springs``: two springs side by side in one engine."""

from __future__ import annotations

from pathlib import PurePath
from typing import Annotated

import typer

from valvetrain.cli.options import (
    CaseArgument,
    ImplausibleOption,
    JsonOption,
    LimitOption,
    OpenOption,
    OutputOption,
    QuietOption,
    SetOption,
    SpeedOption,
    SpringOption,
    UnitsOption,
    WorkersOption,
    choose_case,
)
from valvetrain.cli.run_answer import (
    StudyRequest,
    answer_study,
    shared_options,
)
from valvetrain.errors import InputError

#: Step (rpm) between the crank speeds of a comparison that names none.
STEP = 500


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("compare-springs")(compare_springs)


def compare_springs(
    first: CaseArgument,
    second: CaseArgument,
    train: Annotated[
        str,
        typer.Option(
            "--train",
            metavar="CASE",
            help="Engine in which both run (default: that of a case of the two that has one).",
        ),
    ] = "",
    engine_speed: SpeedOption = None,
    spring: SpringOption = None,
    settings: SetOption = None,
    output: OutputOption = None,
    workers: WorkersOption = None,
    limit: LimitOption = None,
    implausible: ImplausibleOption = False,
    open_page: OpenOption = False,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Compare two springs in one engine over its speed: surge, clash, stress, float, side by side.

    A spring is a case with \\[spring], as spring-card writes it, or an engine, of which the set in
    use is taken; --set changes the engine.
    """
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.runs.compare_springs import compared, models_of, with_two_springs
    from valvetrain.runs.cost import refuse_cost
    from valvetrain.runs.critical_speeds import CriticalOptions
    from valvetrain.runs.request_cost import request_cost
    from valvetrain.runs.run import sweep_speeds, sweep_study

    pair = (choose_case(first), choose_case(second))
    engine = train or next(
        (name for name, case in zip((first, second), pair, strict=True) if case.train is not None),
        "",
    )
    if not engine:
        raise InputError(
            "neither case has a train that moves the springs; give the engine with --train CASE",
            "--train",
        )
    shared = shared_options(
        engine, engine_speed, spring, settings=settings, output=output, workers=workers, limit=limit, implausible=implausible, open_page=open_page,
        units=units,
    )  # fmt: skip
    stems = (PurePath(first).stem, PurePath(second).stem)
    case = with_two_springs(shared["case"], *pair, stems)
    shared |= {"case": case, "spring_models": models_of(case, shared["spring_models"])}
    speeds = shared["engine_speeds"] = shared["engine_speeds"] or sweep_speeds(case, STEP)
    request = StudyRequest(command="compare-springs", **shared)
    refuse_cost(request_cost(request, whole=False, searches=True), request.limits)
    announce_compilation("statics", "transient", "train")
    answer_study(
        request,
        lambda report, finished: compared(
            lambda: sweep_study(
                case, speeds, critical=CriticalOptions(), **request.keywords(report, finished)
            )
        ),
    )
