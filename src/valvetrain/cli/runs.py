"""``valvetrain runs`` and ``compare-runs``: saved runs listed and compared."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import JsonOption, QuietOption

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.runs.differences import ResultDifference
    from valvetrain.runs.run_folders import UnfinishedFolder
    from valvetrain.runs.saved_runs import SavedRun


RootOption = Annotated[
    Path, typer.Option("--folder", metavar="FOLDER", help="Folder that runs are saved in.")
]
#: Rows printed; --json has them all.
RUNS_MAX_ROWS = 15


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
    from valvetrain.runs.run_folders import unfinished_runs
    from valvetrain.runs.saved_runs import list_saved_runs

    found, begun = list_saved_runs(case or "", folder), unfinished_runs(case or "", folder)
    data = {
        "command": "runs",
        "runs": [_run_object(run) for run in found],
        "unfinished": [
            {
                "created_at": one.created_at,
                "case": one.case,
                "state": "going on" if one.living else "killed",
                "finished_runs": one.finished,
                "command_line": list(one.command_line),
                "folder": str(one.folder),
            }
            for one in begun
        ],
    }

    def show(console: Console) -> None:
        if found or not begun:
            _show(console, found, folder)
        if begun:
            _show_unfinished(console, begun)

    deliver(Outcome(data, show))


def _run_object(run: SavedRun) -> dict[str, Any]:
    return {
        "created_at": run.created_at,
        "case": run.case,
        "digest": run.digest,
        "asked": run.answer.get("command"),
        "spring_models": run.choices.get("spring_models", []),
        "engine_speeds": {"values": run.choices.get("engine_speeds", []), "unit": "rpm"},
        "completed": run.answer.get("completed"),
        "state": run.state,
        "headline": run.headline,
        "folder": str(run.folder),
    }


def _show(console: Console, found: tuple[SavedRun, ...], folder: Path) -> None:
    from valvetrain.cli.outcome import plain_table

    if not found:
        console.print(f"no runs under '{folder}'; 'valvetrain run CASE' makes one")
        return
    named = dict.fromkeys(
        _headline_label(run) for run in found[:RUNS_MAX_ROWS] if run.headline is not None
    )
    alone = next(iter(named)) if len(named) == 1 else ""
    headers = (
        "time (UTC)",
        "case",
        "digest",
        "asked",
        "models",
        "rpm",
        "",
        alone.replace(" ", "\n", 1) or "headline",
    )
    table = plain_table(headers, (_row(run, not alone) for run in found[:RUNS_MAX_ROWS]))
    for place in (0, 1, 2, 3, 6):
        table.columns[place].no_wrap = True
    table.columns[4].min_width = 14
    console.print(table)
    if len(found) > RUNS_MAX_ROWS:
        console.print(f"and {len(found) - RUNS_MAX_ROWS} older ones; --json has them all")
    console.print(
        "\n'valvetrain compare-runs A B' compares two by digest or folder; 'valvetrain run FOLDER' repeats one.",
        soft_wrap=True,
    )


def _headline_label(run: SavedRun) -> str:
    """Label of the headline of a run, with the cut-off of that run."""
    from valvetrain.runs.differences import cut_off_of
    from valvetrain.solution.definition import label_cut_off, label_of
    from valvetrain.solution.force_peak import FORCE_BANDWIDTH

    label_cut_off(cut_off_of(run) or FORCE_BANDWIDTH)
    return "" if run.headline is None else label_of(run.headline["quantity"])


def _row(run: SavedRun, named: bool) -> tuple[str, ...]:
    from valvetrain.parameters.summary import number
    from valvetrain.solution.definition import shown

    best = run.headline
    speeds = run.engine_speeds
    speed_range = (
        "–"
        if not speeds
        else f"{speeds[0]:g}"
        if len(speeds) == 1
        else f"{speeds[0]:g}–{speeds[-1]:g} ({len(speeds)})"
    )
    models = run.spring_models
    summary = ""
    if best is not None:
        value, unit = shown(best["quantity"], best["value"])
        summary = f"{_headline_label(run) if named else ''} {number(value)} {unit}".strip()
    return (
        run.created_at[5:16].replace("T", " "),
        run.case,
        run.digest,
        run.command,
        ",\n".join(models[:2]) + (f" +{len(models) - 2}" if len(models) > 2 else ""),
        speed_range,
        "" if (ended := run.state) == "completed" else ended,
        summary,
    )


def _show_unfinished(console: Console, begun: tuple[UnfinishedFolder, ...]) -> None:
    from valvetrain.runs.run_folders import LIST

    console.print(
        f"\nbegun and not finished{f', the newest {RUNS_MAX_ROWS} of {len(begun)}' if len(begun) > RUNS_MAX_ROWS else ''}:"
    )
    for one in begun[:RUNS_MAX_ROWS]:
        when, how = one.created_at[5:16].replace("T", " "), "running" if one.living else "killed"
        holds = f"{one.finished} finished run{'' if one.finished == 1 else 's'}, {one.files} file{'' if one.files == 1 else 's'}"
        console.print(f"  {when}  {one.case}, {how}: {holds} in '{one.folder}'", soft_wrap=True)
        if not one.living and one.command:
            console.print(f"    again from its begin: {one.command}", soft_wrap=True)
    if any(not one.living for one in begun):
        summary = (
            f"numbers of finished runs are in '{LIST}', their channels in run-0001.nc and so on"
        )
        console.print(
            f"\nOf a killed run {summary}; delete its folder to remove it.", soft_wrap=True
        )


RunArgument = Annotated[
    str,
    typer.Argument(
        help="A run: its folder, its digest, a case (its newest run), CASE/latest or latest."
    ),
]
#: Rows printed; --json has them all.
COMPARE_RUNS_MAX_ROWS = 30


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
    """Show what differs between two saved runs: inputs by key path, then results, headline numbers
    first.
    """
    from valvetrain.cli.outcome import Outcome, deliver, measured
    from valvetrain.runs.differences import input_differences, result_differences
    from valvetrain.runs.saved_runs import find_run

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
        "failed": {"a": list(one.failures), "b": list(other.failures)},
    }  # fmt: skip
    deliver(
        Outcome(
            data, lambda console: _show_compare_runs(console, (one, other), inputs, results), ()
        )
    )


def _show_compare_runs(
    console: Console,
    pair: tuple[SavedRun, SavedRun],
    inputs: tuple[tuple[str, Any, Any], ...],
    results: tuple[ResultDifference, ...],
) -> None:
    from valvetrain.cli.outcome import plain_table
    from valvetrain.report.run_summary import INPUT_HEADS, RESULT_HEADS, input_rows, result_rows

    for name, run in zip("AB", pair, strict=True):
        console.print(f"{name}  {run.folder}", soft_wrap=True)
    console.print()
    if inputs:
        console.print(plain_table(INPUT_HEADS, input_rows(inputs[:COMPARE_RUNS_MAX_ROWS])))
    else:
        console.print("the inputs are the same")
    rows = result_rows(results)
    console.print()
    if rows:
        console.print(plain_table(RESULT_HEADS, rows[:COMPARE_RUNS_MAX_ROWS], right=(2, 3, 5)))
    elif not results:
        alike = all(run.state == "completed" for run in pair)
        console.print(f"the results {'' if alike else 'that are there '}are the same")
    for name, run in zip("AB", pair, strict=True):
        for sentence in run.failures[:RUNS_MAX_ROWS]:
            console.print(f"{name} failed: {sentence}", soft_wrap=True)
    left, alone = (
        max(0, len(inputs) - COMPARE_RUNS_MAX_ROWS) + max(0, len(rows) - COMPARE_RUNS_MAX_ROWS),
        len(results) - len(rows),
    )
    if alone:
        console.print(
            f"\n{alone} number{'s are' if alone > 1 else ' is'} in one of the two runs only; --json has them"
        )
    if left:
        console.print(f"\nand {left} more differences; --json has them all")
