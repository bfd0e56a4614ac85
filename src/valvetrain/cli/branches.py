"""``valvetrain branches``: motions of a train over engine speed, rising and falling, with their stability."""

from __future__ import annotations

from pathlib import Path

from valvetrain.cli.request import SavedLine, command_of
from valvetrain.runs.requests import March


def branches(request: March, line: SavedLine, folder: Path) -> None:
    """Motions of a train over engine speed, up and down: hysteresis, periods, chaos and what is unstable."""
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_runs, progress_bar
    from valvetrain.cli.run_answer import SavedRequest, saved_result
    from valvetrain.parameters.summary import rpm
    from valvetrain.runs.branch_march import branches as march
    from valvetrain.runs.cost import refuse_cost
    from valvetrain.views.branches import BranchesAnswer

    case, quantity, speeds = request.case, request.quantity, request.march_speeds
    refuse_cost(request.cost(), request.limit, fewer="speeds or revolutions")
    announce_runs(case)
    with progress_bar(case.name) as report:
        result = march(
            case,
            speeds,
            request.models,
            spring_sets=request.spring_sets,
            quantity=quantity,
            revolutions=request.revolutions,
            progress=report,
            implausible=request.implausible,
        )
    data = {
        "command": request.command,
        "case": case.name,
        "label": result.label,
        "quantity": quantity,
        "revolutions": result.revolutions,
        "complete": result.complete,
        "hysteresis": [
            [one.lower_engine_speed, one.upper_engine_speed] for one in result.hysteresis
        ],
        "points": result.to_records(),
    }
    choices = {
        "engine_speeds": [rpm(one) for one in speeds],
        "engine_speed_unit": "rpm",
        "quantity": quantity,
    }
    deliver(
        saved_result(
            SavedRequest(request.command, case, line.output, folder),
            case.record().text,
            data,
            lambda _: BranchesAnswer(result),
            lambda path: [result.save(path / "branches.nc")],
            choices,
            line.open_page,
        )
    )


register = command_of(March, SavedLine, branches)
