"""``valvetrain cases`` lists and prints the library; ``valvetrain check`` says what a case file was understood to hold."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from valvetrain.cli.options import JsonOption, SetOption

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.parameters.case import Case, CaseSummary


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command("cases")(cases)
    app.command("check")(check)


def cases(
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="Print the file of this case.", show_default=False)] = None,
    as_json: JsonOption = False,
) -> None:
    """List the cases that ship with the package, or print one of their files."""
    from valvetrain.cli.outcome import Outcome, deliver, to_json
    from valvetrain.parameters.loading import LIBRARY, library_names, list_cases

    if name is None:
        found = list_cases()
        data = {"command": "cases", "cases": [{key: getattr(one, key) for key in ("name", "title", "holds", "sources")} for one in found]}
        deliver(Outcome(data, lambda console: _show_cases(console, found)), as_json)
        return
    from valvetrain.errors import InputError
    from valvetrain.parameters.changes import nearest

    if name not in library_names():
        raise InputError(f"there is no case '{name[:60]}' in the library; {nearest(name, library_names())}")
    text = (LIBRARY / f"{name}.toml").read_text(encoding="utf-8")
    sys.stdout.write(to_json({"command": "cases", "case": name, "text": text}) + "\n" if as_json else text)


def _show_cases(console: Console, found: tuple[CaseSummary, ...]) -> None:
    from valvetrain.citations import references
    from valvetrain.cli.tables import plain_table

    def source(keys: tuple[str, ...]) -> str:
        known = (references().get(key.split(",")[0]) for key in keys)
        return "; ".join(_short(reference.field("author"), reference.field("year")) for reference in known if reference is not None)

    console.print(plain_table(("name", "title", "source"), ((one.name, one.title, source(one.sources)) for one in found)))
    console.print("\n'valvetrain cases NAME' prints the file of a case, 'valvetrain run NAME' runs it.")


def _short(authors: str, year: str) -> str:
    families = [author.split(",")[0].strip("{} ") for author in authors.split(" and ")]
    return f"{families[0]}{' et al.' if len(families) > 1 else ''} ({year})"


def check(
    case: Annotated[str, typer.Argument(metavar="FILE", help="Case file, or name of a library case.", show_default=False)],
    settings: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Read a case file and print what it was understood to say, or what is wrong with it, and where."""
    from valvetrain.cli.case_choice import choose_case
    from valvetrain.cli.case_facts import case_facts, lift_quantities
    from valvetrain.cli.outcome import Outcome, deliver
    from valvetrain.cli.results import quantities_object
    from valvetrain.quantities.design import design_quantities

    chosen = choose_case(case, settings)
    quantities = design_quantities(chosen) | lift_quantities(chosen)
    _check_parts(chosen)
    facts = case_facts(chosen)
    data = {
        "command": "check", "case": chosen.name, "title": chosen.title, "holds": _holds(chosen), "facts": dict(facts),
        "quantities": quantities_object(quantities),
    }  # fmt: skip
    deliver(Outcome(data, lambda console: _show_check(console, chosen, facts, quantities)), as_json)


def _check_parts(case: Case) -> None:
    """What only shows when the parts are put together: a spring that binds, a cam that cannot be made, a contact without a law."""
    from valvetrain.quantities.design import check_room

    check_room(case)
    if case.train is not None and case.lift_law is not None:
        from valvetrain.system.build_train import build_train

        for spring_set in case.train.springs or ("",):
            build_train(case, spring_set=spring_set, spring_model="massless")


def _holds(case: Case) -> list[str]:
    return [name for name in ("spring", "spring_card", "lift_law", "train", "published") if getattr(case, name)]


def _show_check(console: Console, case: Case, facts: list[tuple[str, str]], quantities: dict[str, float]) -> None:
    from valvetrain.cli.tables import plain_table, quantity_rows

    console.print(f"{case.name}: a valid case with {', '.join(_holds(case))}\n")
    console.print(plain_table(("", ""), facts))
    if quantities:
        console.print()
        console.print(plain_table(("", "", ""), quantity_rows(quantities), right=(1,)))
