"""``compare`` for a case with a spring alone: rod, modal model and solid finite elements about the installed state."""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import make_folder, read_count
from valvetrain.cli.outcome import Outcome, measured, tell
from valvetrain.cli.run_request import RunRequest
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.parameters.case import Case
    from valvetrain.quantities.spring_comparison import Difference, ModelStatics, SpringComparison
    from valvetrain.studies.solid_comparison import SolidChoice

SOLID = "solid"
SolidElementsOption = Annotated[
    int | None,
    typer.Option("--solid-elements-per-coil", metavar="N", help="Solid elements along a coil (default: 12).", show_default=False),
]
SolidCoreOption = Annotated[
    int | None, typer.Option("--solid-core", metavar="N", help="Solid cells across the section's core (default: 1).", show_default=False)
]
SolidRingsOption = Annotated[
    int | None, typer.Option("--solid-rings", metavar="N", help="Rings of solid cells around the core (default: 1).", show_default=False)
]
SolidRideOption = Annotated[
    str | None,
    typer.Option(
        "--solid-motion", metavar="FIRST:LAST", show_default=False,
        help="Ride the lift law by solid finite elements too, between two cam angles such as '85:105 deg'; takes minutes.",
    ),
]  # fmt: skip
SolidTimeOption = Annotated[
    str | None,
    typer.Option("--solid-time-limit", metavar="TIME", help="Longest run of the solver, such as '30 min' (default).", show_default=False),
]


@dataclass(frozen=True)
class SolidOptions:
    """The options of the solid model as given; None for those that were not."""

    elements_per_coil: int | None = None
    core: int | None = None
    rings: int | None = None
    ride: str | None = None
    time_limit: str | None = None

    @property
    def given(self) -> bool:
        """Whether any was given."""
        return any(value is not None for value in (self.elements_per_coil, self.core, self.rings, self.ride, self.time_limit))


def compare_spring(request: RunRequest, options: SolidOptions) -> Outcome:
    """Run the comparison, write its folder, and hand back what to print. Without the solver the error names the command to install it."""
    from valvetrain.cli.progress import announce_compilation, busy, progress_bar
    from valvetrain.cli.spring_run import check_models
    from valvetrain.report.spring_comparison_page import write_comparison
    from valvetrain.studies.solid_comparison import MODELS, run_solid_comparison, solid_cost

    case, models = request.case, request.spring_models
    check_models(models, MODELS)
    choice = read_choice(case, request, options)
    cost = solid_cost(case, choice)
    make_folder(request.output)
    tell(_cost_words(cost, choice))
    announce_compilation("statics", *(["transient"] if choice.ride else []))
    with progress_bar(case.name, at_once=False) as report:
        study = run_solid_comparison(
            case, models=models, choice=choice, workers=request.workers, progress=report,
            created_at=datetime.now(UTC).isoformat(timespec="seconds"),
        )  # fmt: skip
    with busy("writing files"):
        files = write_comparison(study, request.output, request.report)
    place = str(files.page) if request.report else str(request.output)
    data = _object(study) | {
        "completed": not study.failures, "folder": str(request.output), "files": [str(path) for path in (*files.data, *files.figures)],
        "page": str(files.page) if request.report else None,
    }  # fmt: skip
    return Outcome(data, lambda console: _show(console, study, place), study.failures)


def read_choice(case: Case, request: RunRequest, options: SolidOptions) -> SolidChoice:
    """The options as numbers. Raises :class:`InputError` for those that cannot be."""
    from valvetrain.studies.solid_comparison import SolidChoice
    from valvetrain.units import parse_quantity

    choice = SolidChoice()
    time_limit = choice.time_limit
    if options.time_limit is not None:
        time_limit = parse_quantity(options.time_limit, "time", "--solid-time-limit")
        if not time_limit > 0:
            raise InputError(f"'{options.time_limit}' is no time to compute in; give such as '30 min'", "--solid-time-limit")
    ride = read_motion(options.ride)
    speeds = request.engine_speeds or case.operation.engine_speeds
    if ride is not None and len(speeds) != 1:
        raise InputError(f"a ride needs one engine speed, not {len(speeds)}; add such as --engine-speed '4200 rpm'", "--solid-motion")
    return SolidChoice(
        read_count(options.elements_per_coil or choice.elements_per_coil, 4, 200, "--solid-elements-per-coil"),
        read_count(choice.core if options.core is None else options.core, 1, 12, "--solid-core"),
        read_count(choice.rings if options.rings is None else options.rings, 1, 12, "--solid-rings"),
        time_limit, ride, speeds[0] if ride is not None else 0.0,
    )  # fmt: skip


def read_motion(words: str | None) -> tuple[float, float] | None:
    """First and last cam angle (rad) from ``'85:105 deg'``; None for None. Raises :class:`InputError`."""
    if words is None:
        return None
    from valvetrain.units import parse_quantity

    match = re.fullmatch(r"\s*([^:\s]+)\s*:\s*([^:\s]+)\s+(\S+)\s*", words)
    if match is None:
        raise InputError(f"'{words[:40]}' is no ride; write two cam angles such as '85:105 deg'", "--solid-motion")
    first, last = (parse_quantity(f"{match[place]} {match[3]}", "angle", "--solid-motion") for place in (1, 2))
    return first, last


def _cost_words(cost: Any, choice: SolidChoice) -> str:
    size = f"{cost.elements} elements, {cost.unknowns} unknowns"
    words = f"solid finite elements: {size}; statics and modes take about {_about(cost.statics)}"
    if choice.ride is not None:
        words += f", the ride of {cost.increments} increments about {_about(cost.ride)}"
    return f"{words}; each run is stopped after {_about(choice.time_limit)}"


def _about(seconds: float) -> str:
    return f"{max(1.0, seconds):.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"


def _object(study: SpringComparison) -> dict[str, Any]:
    from valvetrain.cli.results import engine_speed_object, status_object

    rides = [
        {
            "spring_model": run.model, "engine_speed": engine_speed_object(run.engine_speed), "status": status_object(run.status),
            "cam_angle": {"values": run.cam_angle, "unit": "rad"},
            "retainer_force": {"values": run.channel("retainer_force"), "unit": "N"},
            "seat_force": {"values": run.channel("seat_force"), "unit": "N"},
        }
        for run in study.rides
    ]  # fmt: skip
    return {
        "command": "compare", "case": study.case.name, "title": study.case.title, "reference": study.reference,
        "installed_compression": measured(study.installed, "m"), "models": [_model_object(item) for item in study.members],
        "differences": [_difference_object(study, row) for row in study.differences], "rides": rides, "notes": list(study.notes),
        "cite": list(study.provenance.citations),
    }  # fmt: skip


def _model_object(item: ModelStatics) -> dict[str, Any]:
    from valvetrain.cli.results import status_object

    units = {"compression": "m", "force": "N", "stiffness": "N/m"}
    modes = [
        {"mode": place + 1, "natural_frequency": measured(float(value), "Hz"), "axial": place in item.modes.axial_modes}
        for place, value in enumerate(item.modes.natural_frequency)
    ]
    return {
        "spring_model": item.model, "mesh": dict(item.facts), "wall_time": measured(item.wall_time, "s"),
        "static_status": status_object(item.curve.status), "modal_status": status_object(item.modes.status),
        "static_curve": {name: {"values": getattr(item.curve, name), "unit": unit} for name, unit in units.items()}, "modes": modes,
    }  # fmt: skip


def _difference_object(study: SpringComparison, row: Difference) -> dict[str, Any]:
    place = {"mode": int(row.place), "axial_mode": row.axial or None} if row.unit == "Hz" else {"compression": measured(row.place, "m")}
    others = study.models[1:]
    return {
        "quantity": row.quantity, **place, "values": {name: measured(value, row.unit) for name, value in row.values.items()},
        "relative_difference": {name: measured(row.relative(name, study.reference), "1") for name in others},
        "shape_agreement": {name: measured(value, "1") for name, value in row.shape_agreement.items()},
    }  # fmt: skip


def _show(console: Console, study: SpringComparison, page: str) -> None:
    from valvetrain.cli.tables import plain_table, shown
    from valvetrain.report import theme
    from valvetrain.report.spring_comparison_page import share_words
    from valvetrain.report.words import number

    console.print(study.case.title or study.case.name)
    others = study.models[1:]
    headers = ["", "unit", *(theme.model_words(name) for name in study.models), *("difference" for _ in others)]
    rows = []
    for row in study.differences:
        axial = f", axial {row.axial}" if row.axial else ""
        place = f"mode {row.place:.0f}{axial}" if row.unit == "Hz" else f"{row.quantity} at {number(row.place * 1e3)} mm"
        values = [shown(row.values.get(name), row.unit)[0] for name in study.models]
        rows.append([place, shown(None, row.unit)[1], *values, *(share_words(row.relative(name, study.reference)) for name in others)])
    console.print()
    console.print(plain_table(headers, rows, right=range(2, len(headers))))
    for note in study.notes:
        console.print(f"\n{note}")
    console.print(f"\nresults  {page}", soft_wrap=True)
