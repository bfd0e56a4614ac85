"""``valvetrain quantities``: names of the numbers of a result, with unit and definition."""

from __future__ import annotations

from typing import Annotated

import typer

from valvetrain.cli.options import JsonOption, QuietOption
from valvetrain.cli.outcome import Outcome, deliver, plain_table
from valvetrain.errors import InputError


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("quantities")(quantities)


def quantities(
    words: Annotated[
        str,
        typer.Argument(
            metavar="[WORDS]",
            help="Words of the name or its label, such as 'spring force'; all quantities without any.",
        ),
    ] = "",
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """List the quantities of results: name, the unit they are shown in, and definition."""
    from valvetrain.solution.definition import tables

    wanted = words.lower().replace("_", " ").split()
    rows = [
        (row.name, row.shown_unit, row.definition)
        for table in tables().values()
        for row in table
        if all(word in f"{row.name} {row.label}".lower() for word in wanted)
    ]
    if not rows:
        raise InputError(
            f"no quantity has '{words[:80]}' in its name; give fewer words, or none for all"
        )
    data = [dict(zip(("name", "shown_unit", "definition"), row, strict=True)) for row in rows]
    heads = ("quantity", "unit", "definition")
    deliver(Outcome({"quantities": data}, lambda console: console.print(plain_table(heads, rows))))
