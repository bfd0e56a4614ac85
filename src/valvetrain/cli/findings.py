"""``valvetrain findings``: what a finding of a code means."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import typer
from rich.console import Console

from valvetrain.cli.options import JsonOption, QuietOption
from valvetrain.cli.outcome import Outcome, deliver, plain_table


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("findings")(findings)


def findings(
    code: Annotated[
        str,
        typer.Argument(metavar="[CODE]", help="Code of a finding, such as C101; all without one."),
    ] = "",
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Explain a finding: what it says, when it holds, what it reads and what to do next."""
    from valvetrain.findings.table import every_rule, explain

    if code:
        told = explain(code)
        deliver(Outcome(told, lambda console: _show(console, list(told.items()))))
        return
    rows = [(one.code, one.level, one.text) for one in every_rule()]
    data = {"findings": [dict(zip(("code", "level", "says"), row, strict=True)) for row in rows]}
    deliver(Outcome(data, lambda console: _show(console, rows)))


def _show(console: Console, rows: Sequence[tuple[str, ...]]) -> None:
    console.print(plain_table([""] * len(rows[0]), rows))
