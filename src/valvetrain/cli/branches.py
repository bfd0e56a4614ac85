"""``valvetrain branches``: motions of a train over engine speed, rising and falling, with their stability."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path

from valvetrain.cli.request import SavedLine, command_of
from valvetrain.errors import InputError
from valvetrain.runs.request_fields import option, read_count, read_speeds, read_text
from valvetrain.runs.requests import SpringRequest


@dataclass(frozen=True, kw_only=True)
class BranchesRequest(SpringRequest):
    """A march of a train up and down through engine speeds."""

    command = "branches"

    engine_speeds: tuple[float, ...] = option(
        read_speeds, "Speeds of the march: '7000:9700:25 rpm'.", "--rpm", "SPEEDS", default=()
    )
    quantity: str = option(
        read_text,
        "loft_gap, seating_velocity, float_excess_lift, ...",
        "--quantity",
        "NAME",
        default="loft_gap",
    )
    revolutions: int = option(
        partial(read_count, 1, 10**7),
        "Cam revolutions of the march at most.",
        "--revolutions",
        "N",
        default="40000",
    )

    def __post_init__(self) -> None:
        """Raise :class:`InputError` without a speed."""
        if not self.engine_speeds:
            raise InputError("a march needs engine speeds; give --rpm 7000:9700:25", "--rpm")


def branches(request: BranchesRequest, line: SavedLine, folder: Path) -> None:
    """Motions of a train over engine speed, up and down: hysteresis, periods, chaos and what is unstable."""
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_runs, progress_bar
    from valvetrain.cli.run_answer import SavedRequest, saved_result
    from valvetrain.parameters.summary import rpm
    from valvetrain.runs.branch_march import branches as march
    from valvetrain.views.branches import BranchesAnswer

    case, quantity = request.case, request.quantity
    announce_runs(case)
    with progress_bar(case.name) as report:
        result = march(
            case,
            request.engine_speeds,
            request.models,
            spring_sets=request.spring_sets,
            quantity=quantity,
            revolutions=request.revolutions,
            progress=report,
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
        "engine_speeds": [rpm(one) for one in request.engine_speeds],
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


register = command_of(BranchesRequest, SavedLine, branches, limit=None, implausible=None)
