"""``valvetrain modes``: natural frequencies about a compressed state."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import CaseArgument, ElementsOption, JsonOption, SetOption, read_count, read_length
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.cli.outcome import Outcome
    from valvetrain.parameters.case import Case
    from valvetrain.solution.modal import ModalResult


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("modes")(modes)


def modes(
    case: CaseArgument,
    count: Annotated[int, typer.Option("--count", metavar="N", help="Number of modes, lowest first.")] = 24,
    compression: Annotated[
        str | None, typer.Option("--compression", metavar="LENGTH", help="State they are about, such as '7 mm' (default: as installed).")
    ] = None,
    settings: SetOption = None,
    elements_per_coil: ElementsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Natural frequencies about the installed state, both ends held, coils that touch kept together."""
    from valvetrain.cli.case_choice import choose_case
    from valvetrain.cli.outcome import deliver

    chosen = choose_case(case, settings, elements_per_coil)
    spring = chosen.require_spring()
    read_count(count, 1, 400, "--count")
    wanted = read_length(compression, "--compression")
    room = spring.free_length - spring.solid_height
    if wanted is not None and wanted >= room:
        raise InputError(f"{wanted * 1e3:g} mm is too much, the spring is solid at {room * 1e3:.4g} mm; give less", "--compression")
    deliver(compute_modes(chosen, count, wanted), as_json)


def compute_modes(case: Case, count: int, compression: float | None = None) -> Outcome:
    """Modes about ``compression`` (m from the free state; None: as installed)."""
    from valvetrain.cli.outcome import Outcome, measured
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.cli.results import quantities_object, status_object
    from valvetrain.quantities.statics import modal_quantities
    from valvetrain.springs.finite_element import FiniteElementRod
    from valvetrain.studies.spring_runs import modal_result

    announce_compilation("statics")
    model = FiniteElementRod.from_case(case, **({} if compression is None else {"precompression": compression}))
    with progress_bar("modes"):
        result = modal_result(model, count)
    listed: list[dict[str, Any]] = [
        {
            "mode": place + 1, "natural_frequency": measured(float(frequency), "Hz"),
            "axial_transmission_ratio": measured(float(result.axial_transmission[place]), "1"), "axial": place in result.axial_modes,
        }
        for place, frequency in enumerate(result.natural_frequency)
    ]  # fmt: skip
    data = {
        "command": "modes", "case": case.name, "spring_model": model.name, "elements_per_coil": case.rod.elements_per_coil,
        "status": status_object(result.status), "compression": measured(result.compression, "m"),
        "quantities": quantities_object(modal_quantities(result)), "modes": listed,
    }  # fmt: skip
    failures = () if result.status.completed else (f"modes of '{case.name}': {result.status.sentence()}",)
    return Outcome(data, lambda console: _show(console, case, result), failures)


def _show(console: Console, case: Case, result: ModalResult) -> None:
    from valvetrain.cli.tables import plain_table
    from valvetrain.parameters.words import number

    names = {place: f"axial mode {index}" for index, place in enumerate(result.axial_modes, start=1)}
    rows = [
        (str(place + 1), number(float(frequency), 5), f"{result.axial_transmission[place]:+.3f}".replace("-", "−"), names.get(place, ""))
        for place, frequency in enumerate(result.natural_frequency)
    ]
    state = f"{number(result.compression * 1e3)} mm compression"
    console.print(f"{case.name}: modes at {state}, both ends held, coils that touch kept together\n")
    console.print(plain_table(("mode", "frequency (Hz)", "axial transmission", ""), rows, right=(0, 1, 2)))
