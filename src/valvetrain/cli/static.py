"""``valvetrain static``: force and stiffness over compression."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import CaseArgument, ElementsOption, JsonOption, SetOption, read_count, read_length
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.cli.outcome import Outcome
    from valvetrain.parameters.case import Case
    from valvetrain.solution.static import StaticCurve


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("static")(static)


def static(
    case: CaseArgument,
    to: Annotated[
        str | None, typer.Option("--to", metavar="LENGTH", help="Largest compression, such as '12 mm' (default: beyond full lift).")
    ] = None,
    steps: Annotated[int, typer.Option("--steps", metavar="N", help="Number of even steps.")] = 24,
    csv: Annotated[Path | None, typer.Option("--csv", metavar="FILE", help="Write the curve to a CSV file.", show_default=False)] = None,
    settings: SetOption = None,
    elements_per_coil: ElementsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Force and stiffness over compression, coils closing, by the finite-element rod."""
    from valvetrain.cli.case_choice import choose_case
    from valvetrain.cli.outcome import deliver

    chosen = choose_case(case, settings, elements_per_coil)
    largest = _reach(chosen, read_length(to, "--to"))
    read_count(steps, 2, 2000, "--steps")
    if csv is not None and csv.is_dir():
        raise InputError(f"'{csv}' is a folder; give the name of a file", "--csv")
    deliver(compute_static(chosen, largest, steps, csv), as_json)


def _reach(case: Case, largest: float | None) -> float | None:
    """Checks ``--to`` against the room the spring has; None stays None."""
    spring = case.require_spring()
    room = spring.free_length - spring.solid_height
    if largest is not None and not 0 < largest < room:
        reason = f"{largest * 1e3:g} mm is no compression of this spring, which is solid at {room * 1e3:.4g} mm; give one between"
        raise InputError(reason, "--to")
    return largest


def compute_static(case: Case, largest: float | None, steps: int, csv: Path | None = None) -> Outcome:
    """Solve the static curve up to ``largest`` (m; None: a little beyond full lift) and write ``csv`` where asked."""
    from valvetrain.cli.outcome import Outcome, measured
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.cli.results import quantities_object, status_object
    from valvetrain.quantities.statics import static_quantities
    from valvetrain.report.figures.statics import static_table
    from valvetrain.solution.atomic import write_text
    from valvetrain.springs.finite_element import FiniteElementRod
    from valvetrain.studies.spring_runs import static_curve
    from valvetrain.studies.spring_study import static_reach

    announce_compilation("statics")
    model = FiniteElementRod.from_case(case)
    if largest is None:
        largest = static_reach(case, model)
    with progress_bar("static curve") as report:
        curve = static_curve(model, largest, steps, lambda at: report(at.state.compression / largest, f"{at.retainer_force:.0f} N"))
    quantities = static_quantities(curve, case.installation.precompression)
    units = {"compression": "m", "force": "N", "stiffness": "N/m"}
    arrays = {name: {"values": getattr(curve, name), "unit": unit} for name, unit in units.items()}
    data: dict[str, Any] = {
        "command": "static", "case": case.name, "spring_model": model.name, "elements_per_coil": case.rod.elements_per_coil,
        "status": status_object(curve.status), "quantities": quantities_object(quantities), "static_curve": arrays,
        "largest_compression": measured(float(curve.compression[-1]), "m"),
    }  # fmt: skip
    if csv is not None:
        data["files"] = [str(write_text(csv, static_table(curve).csv()))]
    failures = () if curve.status.completed else (f"static curve of '{case.name}': {curve.status.sentence()}",)
    return Outcome(data, lambda console: _show(console, case, curve, quantities, csv), failures)


def _show(console: Console, case: Case, curve: StaticCurve, quantities: dict[str, float], csv: Path | None) -> None:
    from valvetrain.cli.tables import plain_table, quantity_rows
    from valvetrain.parameters.words import number
    from valvetrain.report.figures.statics import static_table

    data = static_table(curve)
    headers = [f"{column.name} ({column.unit})" if column.unit else column.name for column in data.columns]
    console.print(f"{case.name}: static curve by the finite-element rod, {case.rod.elements_per_coil} elements per coil\n")
    console.print(plain_table(headers, ([number(value, 5) for value in row] for row in data.rows()), right=range(len(headers))))
    if quantities:
        console.print()
        console.print(plain_table(("", "", ""), quantity_rows(quantities), right=(1,)))
    if csv is not None:
        console.print(f"\nwritten to {csv}")
