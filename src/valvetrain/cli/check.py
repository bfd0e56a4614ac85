"""``valvetrain check`` says what a case file was understood to hold, or what is wrong with it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from valvetrain.cli.options import ElementsOption, ImplausibleOption, JsonOption, QuietOption, SetOption, SpringOption, read_models
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.parameters.case import Case
    from valvetrain.system.problem import Problem


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("check")(check)


def check(
    case: Annotated[str, typer.Argument(metavar="FILE", help="Case file, or name of a library case.", show_default=False)],
    spring: SpringOption = None, settings: SetOption = None, elements_per_coil: ElementsOption = None,
    implausible: ImplausibleOption = False, as_json: JsonOption = False, quiet: QuietOption = False,
) -> None:  # fmt: skip
    """Check a case file: print its values as they were understood, or what is wrong with it, and where."""
    from valvetrain.cli.case_choice import choose_case
    from valvetrain.cli.case_facts import case_facts, case_quantities
    from valvetrain.cli.outcome import Outcome, deliver
    from valvetrain.report.json import quantities_object

    chosen = choose_case(case, settings, elements_per_coil)
    problem = put_together(chosen, read_models(spring), implausible)
    quantities = case_quantities(chosen, problem)
    facts = case_facts(chosen)
    data = {
        "command": "check", "case": chosen.name, "title": chosen.title, "holds": _holds(chosen), "facts": dict(facts),
        "quantities": quantities_object(quantities),
    }  # fmt: skip
    deliver(Outcome(data, lambda console: _show_check(console, chosen, facts, quantities)))


def put_together(case: Case, models: tuple[str, ...], implausible: bool = False) -> Problem | None:
    """Build everything that ``run`` builds, the springs of every set too: what is wrong may only show there. None for a lift law alone.

    ``implausible``: values pass that no valvetrain can have.
    """
    from valvetrain.studies.before_run import refusals_before_run
    from valvetrain.system.build import build, lift_law_of

    if case.train is None and not case.springs:
        lift_law_of(case)
        return None
    problem = build(case, spring_models=models)
    problem.must_run()
    refused = refusals_before_run(problem, implausible)
    if refused and (models or len(refused) == len(problem.members)):
        raise InputError(next(iter(refused.values())), "--spring" if models else "")
    sets = tuple(case.train.springs) if case.train is not None else ()
    for member in build(case, spring_models=models, spring_sets=sets).members if sets else ():
        if not member.refusal and not member.model.needs_rest:
            member.system(built=problem.built)
    return problem


def _holds(case: Case) -> list[str]:
    named = (("spring", case.springs), ("lift_law", case.lift_law), ("train", case.train), ("published", case.published))
    return [name for name, held in named if held]


def _show_check(console: Console, case: Case, facts: list[tuple[str, str]], quantities: dict[str, float]) -> None:
    from valvetrain.cli.tables import plain_table, quantity_rows

    console.print(f"{case.name}: a valid case with {', '.join(_holds(case))}\n")
    console.print(plain_table(("", ""), facts))
    if quantities:
        console.print()
        console.print(plain_table(("", "", ""), quantity_rows(quantities), right=(1,)))
