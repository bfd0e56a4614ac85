"""``valvetrain cases`` lists and prints the library."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from valvetrain.cli.options import JsonOption, QuietOption

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.parameters.case import CaseSummary


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("cases")(cases)


def cases(
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="Print the file of this case.", show_default=False)] = None,
    as_json: JsonOption = False, quiet: QuietOption = False,
) -> None:  # fmt: skip
    """List the cases that ship with the package, or print one of their files."""
    from valvetrain.cli.outcome import Outcome, deliver, to_json
    from valvetrain.parameters.loading import LIBRARY, library_names, list_cases

    if name is None:
        found = list_cases()
        data = {"command": "cases", "cases": [{key: getattr(one, key) for key in ("name", "title", "holds", "sources")} for one in found]}
        deliver(Outcome(data, lambda console: _show_cases(console, found)))
        return
    from valvetrain.errors import InputError
    from valvetrain.parameters.changes import nearest

    if name not in library_names():
        raise InputError(f"there is no case '{name[:60]}' in the library; {nearest(name, library_names())}")
    text = (LIBRARY / f"{name}.toml").read_text(encoding="utf-8")
    if as_json or not quiet:
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
