"""``valvetrain static``: force and stiffness over compression."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from valvetrain.cli.options import (
    CaseArgument,
    ElementsOption,
    JsonOption,
    QuietOption,
    SetOption,
    SpringOption,
    SpringSetOption,
    read_count,
    read_length,
    read_models,
    read_words,
)
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.cli.outcome import Outcome
    from valvetrain.parameters.case import Case
    from valvetrain.solution.static import StaticCurve
    from valvetrain.solution.study import Study

#: Most rows of a curve that are printed; the CSV file has them all.
MOST_ROWS = 30


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("static")(static)


def static(
    case: CaseArgument,
    to: Annotated[
        str | None, typer.Option("--to", metavar="LENGTH", help="Largest compression, such as '12 mm' (default: beyond full lift).")
    ] = None,
    steps: Annotated[int, typer.Option("--steps", metavar="N", help="Number of even steps.")] = 24,
    csv: Annotated[Path | None, typer.Option("--csv", metavar="FILE", help="Write the curve to a CSV file.", show_default=False)] = None,
    spring: SpringOption = None, spring_set: SpringSetOption = None, settings: SetOption = None, elements_per_coil: ElementsOption = None,
    as_json: JsonOption = False, quiet: QuietOption = False,
) -> None:  # fmt: skip
    """Force and stiffness over compression, coils closing, of every spring of a case."""
    from valvetrain.cli.case_choice import choose_case
    from valvetrain.cli.outcome import deliver

    chosen, largest = choose_case(case, settings, elements_per_coil), read_length(to, "--to")
    read_count(steps, 2, 2000, "--steps")
    if csv is not None and csv.is_dir():
        raise InputError(f"'{csv}' is a folder; give the name of a file", "--csv")
    deliver(compute_static(chosen, read_models(spring), read_words(spring_set), largest, steps, csv))


def compute_static(
    case: Case, spring_models: tuple[str, ...], spring_sets: tuple[str, ...], largest: float | None, steps: int, csv: Path | None = None
) -> Outcome:  # fmt: skip
    """Solve the static curves up to ``largest`` (m; None: a little beyond full lift) and write ``csv`` where asked."""
    from valvetrain.cli.outcome import Outcome
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.report.json import study_json
    from valvetrain.solution.atomic import write_text
    from valvetrain.studies.rest_study import rest_study

    announce_compilation("statics")
    with progress_bar("static curve") as report:
        study = rest_study(
            case, spring_models, spring_sets=spring_sets, command="static", largest_compression=largest, steps=steps, progress=report
        )  # fmt: skip
    data = study_json(study)
    if csv is not None:
        data["files"] = [str(write_text(csv, curve_text(study)))]
    return Outcome(data, lambda console: _show(console, study, csv), study.failures)


def curve_text(study: Study) -> str:
    """The static curves as CSV; with several, the spring and its model stand in front."""
    several = len(study.rest) > 1
    lines = [("spring,model," if several else "") + "compression [mm],force [N],stiffness [N/mm]"]
    for one in study.rest:
        place = f"{one.spring},{one.model}," if several else ""
        lines += [place + ",".join(map(repr, row)) for row in _rows(one.curve)]
    return "\n".join(lines) + "\n"


def _rows(curve: StaticCurve | None) -> list[tuple[float, float, float]]:
    if curve is None:
        return []
    return [
        (float(compression) * 1e3, float(force), float(stiffness) * 1e-3)
        for compression, force, stiffness in zip(curve.compression, curve.force, curve.stiffness, strict=True)
    ]


def _show(console: Console, study: Study, csv: Path | None) -> None:
    from valvetrain.cli.tables import plain_table, quantity_rows
    from valvetrain.parameters.words import number

    console.print(study.record.title or study.record.name)
    headers = ("compression (mm)", "force (N)", "stiffness (N/mm)")
    for one, quantities in zip(study.rest, study.still.values(), strict=True):
        rows = _rows(one.curve)
        each = -(-len(rows) // MOST_ROWS)
        console.print()
        words = ([number(value, 5) for value in row] for row in rows[::each])
        console.print(plain_table(headers, words, f"{one.spring} by {one.model}", right=range(3)))
        if quantities:
            console.print()
            console.print(plain_table(("", "", ""), quantity_rows(quantities), right=(1,)))
        if one.curve is not None and one.curve.status.completed and one.curve.status.message:
            console.print(f"\n{one.curve.status.message}", soft_wrap=True)
    if csv is not None:
        console.print(f"\nwritten to {csv}", soft_wrap=True)
