"""``valvetrain runs`` and ``compare-runs``: saved runs listed and compared."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import JsonOption, QuietOption

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.runs.saved_runs import SavedRun

RootOption = Annotated[
    Path, typer.Option("--folder", metavar="FOLDER", help="Folder that runs are saved in.")
]
RunArgument = Annotated[
    str,
    typer.Argument(
        help="A run: its folder, its digest, a case (its newest run), CASE/latest or latest."
    ),
]


def register_runs(app: typer.Typer) -> None:
    """Add the command."""
    app.command("runs")(runs)


def runs(
    case: Annotated[
        str | None,
        typer.Argument(
            metavar="[CASE]", help="List the runs of this case only.", show_default=False
        ),
    ] = None,
    folder: RootOption = Path("runs"),
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """List the runs that were saved, newest first, and those that were begun and not finished."""
    from valvetrain.cli.outcome import Outcome, deliver
    from valvetrain.findings.rules_saved import SavedFacts
    from valvetrain.findings.words import Words
    from valvetrain.runs.run_folders import unfinished_runs
    from valvetrain.runs.saved_runs import list_saved_runs
    from valvetrain.views.saved import SavedAnswer
    from valvetrain.views.terminal import screen

    of = case or ""
    facts = SavedFacts(list_saved_runs(of, folder), unfinished_runs(of, folder), folder, of)
    data = {
        "command": "runs",
        "runs": [_run_object(run) for run in facts.runs],
        "unfinished": [
            {
                "created_at": one.created_at, "case": one.case, "state": "going on" if one.living else "killed",
                "finished_runs": one.finished, "command_line": list(one.command_line), "folder": str(one.folder),
            }
            for one in facts.unfinished
        ],
        "findings": [one.to_dict() for one in SavedAnswer(facts, words=Words()).findings],
    }  # fmt: skip
    deliver(Outcome(data, lambda console: console.print(screen(SavedAnswer(facts)))))


def _run_object(run: SavedRun) -> dict[str, Any]:
    return {
        "created_at": run.created_at,
        "case": run.case,
        "digest": run.digest,
        "asked": run.answer.get("command"),
        "models": run.choices.get("models", []),
        "engine_speeds": {"values": run.choices.get("engine_speeds", []), "unit": "rpm"},
        "completed": run.answer.get("completed"),
        "state": run.state,
        "headline": run.headline,
        "verdict": run.verdict or None,
        "folder": str(run.folder),
    }


def register_compare_runs(app: typer.Typer) -> None:
    """Add the command."""
    app.command("compare-runs")(compare_runs)


def compare_runs(
    a: RunArgument,
    b: RunArgument,
    folder: RootOption = Path("runs"),
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Show what differs between two saved runs: the largest change of a headline number, the inputs, the results."""
    from valvetrain.cli.outcome import Outcome, deliver, plain_table
    from valvetrain.findings.engine import measured
    from valvetrain.findings.words import Words
    from valvetrain.runs.differences import differences
    from valvetrain.runs.saved_runs import find_run
    from valvetrain.views.saved import DifferenceAnswer
    from valvetrain.views.terminal import screen

    answer = DifferenceAnswer(differences(find_run(a, folder), find_run(b, folder)))
    both = answer.both
    data: dict[str, Any] = {
        "command": "compare-runs", "a": str(both.a.folder), "b": str(both.b.folder),
        "inputs": [{"key": key, "a": first, "b": second} for key, first, second in both.inputs],
        "results": [
            {
                "quantity": row.quantity, "run": row.run, "a": measured(row.a, row.unit), "b": measured(row.b, row.unit),
                "difference": measured(row.difference, row.unit), "bar": measured(row.bar or None, row.unit),
            }
            for row in both.results
        ],
        "failed": {"a": list(both.a.failures), "b": list(both.b.failures)},
        "findings": [one.to_dict() for one in DifferenceAnswer(both, words=Words()).findings],
    }  # fmt: skip

    def show(console: Console) -> None:
        console.print(screen(answer))
        if len(both.inputs) > 1:
            table = answer.tables()["inputs"]
            console.print(plain_table(table.columns, table.rows))

    deliver(Outcome(data, show))
