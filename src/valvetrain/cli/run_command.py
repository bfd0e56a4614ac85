"""``valvetrain run``: a whole case, by every engine speed and model, beside what was published."""

from __future__ import annotations

from typing import Annotated

import typer

from valvetrain.cli.options import (
    CaseArgument,
    ElementsOption,
    JsonOption,
    OutputOption,
    SetOption,
    SpeedOption,
    WorkersOption,
    read_engine_speeds,
    read_output,
    read_workers,
)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("run")(run)


def run(
    case: CaseArgument,
    output: OutputOption = None,
    engine_speed: SpeedOption = None,
    spring: Annotated[
        list[str] | None,
        typer.Option("--spring", metavar="MODEL", help="Spring model, repeatable, such as finite-element or modal.", show_default=False),
    ] = None,
    settings: SetOption = None,
    elements_per_coil: ElementsOption = None,
    workers: WorkersOption = None,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Write the report page and its figures.")] = True,
    as_json: JsonOption = False,
) -> None:
    """Run a case at all its engine speeds: table, data files and a report page."""
    from valvetrain.cli.case_choice import choose_case
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.registry import run_case
    from valvetrain.cli.run_request import RunRequest

    chosen = choose_case(case, settings, elements_per_coil)
    models = tuple(dict.fromkeys(name.strip() for text in spring or () for name in text.split(",")))
    request = RunRequest(
        case=chosen, engine_speeds=read_engine_speeds(engine_speed), spring_models=models, workers=read_workers(workers),
        output=read_output(output, chosen.name), report=report,
    )  # fmt: skip
    deliver(run_case(request), as_json)
