"""``valvetrain check`` says what a case file was understood to hold, or what is wrong with it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from valvetrain.cli.options import ElementsOption, JsonOption, QuietOption, SetOption, SpringOption, read_models

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.parameters.case import Case


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("check")(check)


def check(
    case: Annotated[str, typer.Argument(metavar="FILE", help="Case file, or name of a library case.", show_default=False)],
    spring: SpringOption = None, settings: SetOption = None, elements_per_coil: ElementsOption = None, as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:  # fmt: skip
    """Read a case file and print what it was understood to say, or what is wrong with it, and where."""
    from valvetrain.cli.case_choice import choose_case
    from valvetrain.cli.case_facts import case_facts, lift_quantities
    from valvetrain.cli.outcome import Outcome, deliver
    from valvetrain.cli.results import quantities_object
    from valvetrain.quantities.design import design_quantities
    from valvetrain.system.build import build

    chosen = choose_case(case, settings, elements_per_coil)
    build(chosen, spring_models=read_models(spring))  # what only shows when the parts are put together
    quantities = design_quantities(chosen) | lift_quantities(chosen)
    facts = case_facts(chosen)
    data = {
        "command": "check", "case": chosen.name, "title": chosen.title, "holds": _holds(chosen), "facts": dict(facts),
        "quantities": quantities_object(quantities),
    }  # fmt: skip
    deliver(Outcome(data, lambda console: _show_check(console, chosen, facts, quantities)))


def _holds(case: Case) -> list[str]:
    return [name for name in ("spring", "spring_card", "lift_law", "train", "published") if getattr(case, name)]


def _show_check(console: Console, case: Case, facts: list[tuple[str, str]], quantities: dict[str, float]) -> None:
    from valvetrain.cli.tables import plain_table, quantity_rows

    console.print(f"{case.name}: a valid case with {', '.join(_holds(case))}\n")
    console.print(plain_table(("", ""), facts))
    if quantities:
        console.print()
        console.print(plain_table(("", "", ""), quantity_rows(quantities), right=(1,)))
