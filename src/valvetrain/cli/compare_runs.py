"""``valvetrain compare-runs``: what differs between two kept runs, in inputs and in results."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import JsonOption, QuietOption
from valvetrain.cli.runs import RootOption

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.studies.run_differences import ResultDifference
    from valvetrain.studies.run_store import KeptRun

RunArgument = Annotated[
    str,
    typer.Argument(
        help="A run: its folder, its digest, a case (its newest run), CASE/latest or latest."
    ),
]
#: Rows printed; --json has them all.
MOST_ROWS = 30


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("compare-runs")(compare_runs)


def compare_runs(
    a: RunArgument,
    b: RunArgument,
    folder: RootOption = Path("runs"),
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Show what differs between two kept runs: inputs by key path, then results, headline numbers
    first.
    """
    from valvetrain.cli.outcome import Outcome, deliver, measured
    from valvetrain.studies.run_differences import input_differences, result_differences
    from valvetrain.studies.run_store import find_run

    one, other = find_run(a, folder), find_run(b, folder)
    inputs, results = input_differences(one, other), result_differences(one, other)
    data: dict[str, Any] = {
        "command": "compare-runs", "a": str(one.folder), "b": str(other.folder),
        "inputs": [{"key": key, "a": first, "b": second} for key, first, second in inputs],
        "results": [
            {
                "quantity": row.quantity, "run": row.run, "a": measured(row.a, row.unit), "b": measured(row.b, row.unit),
                "difference": measured(row.difference, row.unit),
            }
            for row in results
        ],
    }  # fmt: skip
    deliver(Outcome(data, lambda console: _show(console, (one, other), inputs, results)))


def _show(
    console: Console,
    pair: tuple[KeptRun, KeptRun],
    inputs: tuple[tuple[str, Any, Any], ...],
    results: tuple[ResultDifference, ...],
) -> None:
    from valvetrain.cli.tables import plain_table
    from valvetrain.report.run_differences import INPUT_HEADS, RESULT_HEADS, input_rows, result_rows

    for name, run in zip("AB", pair, strict=True):
        console.print(f"{name}  {run.folder}", soft_wrap=True)
    console.print()
    if inputs:
        console.print(plain_table(INPUT_HEADS, input_rows(inputs[:MOST_ROWS])))
    else:
        console.print("the inputs are the same")
    rows = result_rows(results)
    console.print()
    if rows:
        console.print(plain_table(RESULT_HEADS, rows[:MOST_ROWS], right=(2, 3, 5)))
    elif not results:
        console.print("the results are the same")
    left, alone = (
        max(0, len(inputs) - MOST_ROWS) + max(0, len(rows) - MOST_ROWS),
        len(results) - len(rows),
    )
    if alone:
        console.print(
            f"\n{alone} number{'s stand' if alone > 1 else ' stands'} in one of the two runs only; --json has them"
        )
    if left:
        console.print(f"\nand {left} more differences; --json has them all")
