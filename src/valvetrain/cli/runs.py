"""``valvetrain runs`` and ``compare-runs``: saved runs listed and compared."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.cli.request import AnswerLine, command_without_case
from valvetrain.runs.request_fields import option, read_path, read_text

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.runs.saved_runs import SavedRun

RUN = "A run: its folder, its digest, a case (its newest run), CASE/latest or latest."


@dataclass(frozen=True, kw_only=True)
class StoreLine(AnswerLine):
    """The command line of a command about saved runs."""

    folder: Path = option(
        read_path, "Folder that runs are saved in.", "--folder", "FOLDER", default="runs"
    )


@dataclass(frozen=True, kw_only=True)
class RunsLine(StoreLine):
    """The command line of ``runs``."""

    case: str = option(read_text, "List the runs of this case only.", metavar="[CASE]", default="")


@dataclass(frozen=True, kw_only=True)
class CompareRunsLine(StoreLine):
    """The command line of ``compare-runs``."""

    a: str = option(read_text, RUN, metavar="A")
    b: str = option(read_text, RUN, metavar="B")


def runs(line: RunsLine) -> None:
    """List the runs that were saved, newest first, and those that were begun and not finished."""
    from valvetrain.cli.outcome import Outcome, deliver
    from valvetrain.findings.rules_saved import SavedFacts
    from valvetrain.findings.words import Words
    from valvetrain.runs.run_folders import unfinished_runs
    from valvetrain.runs.saved_runs import list_saved_runs
    from valvetrain.views.saved import SavedAnswer
    from valvetrain.views.terminal import screen

    case, folder = line.case, line.folder
    facts = SavedFacts(list_saved_runs(case, folder), unfinished_runs(case, folder), folder, case)
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


register_runs = command_without_case("runs", RunsLine, runs)


def _run_object(run: SavedRun) -> dict[str, Any]:
    return {
        "created_at": run.created_at,
        "case": run.case,
        "digest": run.digest,
        "asked": run.answer.get("command"),
        "models": run.choices.get("models", []),
        "engine_speeds": {"values": run.choices.get("engine_speeds", []), "unit": "rpm"},
        "completed": run.state == "completed",
        "state": run.state,
        "verdict": run.verdict or None,
        "folder": str(run.folder),
    }


def compare_runs(line: CompareRunsLine) -> None:
    """Show what differs between two saved runs: the largest change of a headline number, the inputs, the results."""
    from valvetrain.cli.outcome import Outcome, deliver, plain_table
    from valvetrain.findings.engine import measured
    from valvetrain.findings.words import Words
    from valvetrain.runs.differences import differences
    from valvetrain.runs.saved_runs import find_run
    from valvetrain.views.saved import DifferenceAnswer
    from valvetrain.views.terminal import screen

    answer = DifferenceAnswer(
        differences(find_run(line.a, line.folder), find_run(line.b, line.folder))
    )
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


register_compare_runs = command_without_case("compare-runs", CompareRunsLine, compare_runs)
