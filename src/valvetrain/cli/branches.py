"""``valvetrain branches``: motions of a train over engine speed, rising and falling, with their stability."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from valvetrain.cli.options import (
    CaseArgument,
    JsonOption,
    OpenOption,
    OutputOption,
    QuietOption,
    SetOption,
    SpringOption,
    SpringSetOption,
    name_case,
    read_engine_speeds,
    read_models,
    read_names,
    take_folder,
)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("branches")(branches)


def branches(
    case: CaseArgument,
    engine_speed: Annotated[
        str,
        typer.Option("--rpm", metavar="SPEEDS", help="Speeds of the march: '7000:9700:25 rpm'."),
    ],
    quantity: Annotated[
        str,
        typer.Option(
            "--quantity", metavar="NAME", help="loft_gap, seating_velocity, float_excess_lift, ..."
        ),
    ] = "loft_gap",
    revolutions: Annotated[
        int,
        typer.Option("--revolutions", metavar="N", help="Cam revolutions of the march at most."),
    ] = 40_000,
    spring: SpringOption = None,
    spring_set: SpringSetOption = None,
    settings: SetOption = None,
    output: OutputOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Motions of a train over engine speed, up and down: hysteresis, periods, chaos and what is unstable."""
    from valvetrain.cli.options import choose_case, folder_of, read_count
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_runs, progress_bar
    from valvetrain.cli.run_answer import SavedRequest, saved_result
    from valvetrain.runs.branch_march import branches as march
    from valvetrain.views.branches import BranchesAnswer
    from valvetrain.views.text import rpm

    name_case(case, settings)
    chosen = choose_case(case, settings)
    take_folder(output)
    read_count(revolutions, 1, 10**7, "--revolutions")
    speeds = read_engine_speeds(engine_speed) or ()
    models, sets = read_models(spring), read_names(spring_set)
    announce_runs(chosen)
    with progress_bar(chosen.name) as report:
        found = march(
            chosen,
            speeds,
            models,
            spring_sets=sets,
            quantity=quantity,
            revolutions=revolutions,
            progress=report,
        )
    data = {
        "command": "branches",
        "case": chosen.name,
        "label": found.label,
        "quantity": quantity,
        "revolutions": found.revolutions,
        "complete": found.complete,
        "hysteresis": [
            [one.lower_engine_speed, one.upper_engine_speed] for one in found.hysteresis
        ],
        "points": found.to_records(),
    }

    def write(folder: Path) -> list[Path]:
        return [found.save(folder / "branches.nc")]

    request = SavedRequest("branches", chosen, output, folder_of(case))
    choices = {
        "engine_speeds": [rpm(one) for one in speeds],
        "engine_speed_unit": "rpm",
        "quantity": quantity,
    }
    deliver(
        saved_result(
            request,
            chosen.record().text,
            data,
            lambda _: BranchesAnswer(found),
            write,
            choices,
            open_page,
        )
    )
