"""``valvetrain static``: force and stiffness over compression."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    MAX_COUNTED,
    CaseArgument,
    ElementsOption,
    ImplausibleOption,
    JsonOption,
    LimitOption,
    QuietOption,
    SetOption,
    SpringOption,
    SpringSetOption,
    read_amounts,
    read_count,
    read_length,
    read_models,
    read_names,
)
from valvetrain.cli.run_answer import SavedRequest, save_study

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from valvetrain.cli.outcome import Outcome
    from valvetrain.parameters.case import Case
    from valvetrain.solution.static import RestPoint, SpringAtRest
    from valvetrain.solution.study import Study


KeepOption = Annotated[
    bool,
    typer.Option(
        "--keep", help="Save the answer as runs are saved: data files, report page and inputs."
    ),
]


def saved_outcome(
    outcome: Outcome, study: Study, case: Case, folder: Path, choices: Mapping[str, Any]
) -> Outcome:
    """The outcome with its ``study`` written to a new folder of saved runs; ``folder``: that of the
    case file, ``choices``: further choices of the command.
    """
    from valvetrain.solution.partial_failures import PartialFailures

    data = dict(outcome.data)
    made = {**choices, "spring_models": list(dict.fromkeys(one.model for one in study.rest))}
    now = datetime.now(UTC).replace(microsecond=0)
    home, _, failed = save_study(
        SavedRequest(study.command, case, None, now, folder), study, made, data, outcome.failures, study.provenance, PartialFailures()
    )  # fmt: skip

    def show(console: Any) -> None:
        outcome.show(console)
        console.print(f"\nsaved in {home}", soft_wrap=True)

    return replace(outcome, data=data, show=show, failures=failed)


#: Most rows of a curve that are printed; the CSV file has them all.
MAX_ROWS = 30
#: Columns of a curve and their units: nominal shear by EN 13906-1, and the largest shear along the
#: wire where its section loads are known.
COLUMNS = (
    ("compression", "mm"), ("force", "N"), ("stiffness", "N/mm"), ("height", "mm"), ("nominal shear", "MPa"), ("wire shear", "MPa"),
)  # fmt: skip


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("static")(static)


def static(
    case: CaseArgument,
    to: Annotated[
        str | None,
        typer.Option(
            "--to",
            metavar="LENGTH",
            help="Largest compression, such as '12 mm' (default: beyond full lift).",
        ),
    ] = None,
    steps: Annotated[int, typer.Option("--steps", metavar="N", help="Number of even steps.")] = 24,
    height: Annotated[
        list[str] | None,
        typer.Option(
            "--height",
            metavar="LENGTH",
            help="Height between the seats to solve too: '32 mm'. Repeatable.",
            show_default=False,
        ),
    ] = None,
    load: Annotated[
        list[str] | None,
        typer.Option(
            "--load",
            metavar="FORCE",
            help="Load to solve as well: '400 N'. Repeatable.",
            show_default=False,
        ),
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(
            "--csv", metavar="FILE", help="Write the curve to a CSV file.", show_default=False
        ),
    ] = None,
    spring: SpringOption = None,
    spring_set: SpringSetOption = None,
    settings: SetOption = None,
    elements_per_coil: ElementsOption = None,
    limit: LimitOption = None,
    implausible: ImplausibleOption = False,
    keep: KeepOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Force, stiffness and stress over compression, coils closing, of every spring of a case, and
    at heights and loads requested.
    """
    from valvetrain.cli.options import choose_case, folder_of
    from valvetrain.cli.outcome import deliver, say_cost
    from valvetrain.runs.cost import FEWER_AT_REST, read_limits
    from valvetrain.runs.request_cost import static_cost
    from valvetrain.solution.atomic import check_target

    chosen, largest = choose_case(case, settings, elements_per_coil), read_length(to, "--to")
    read_count(steps, 2, MAX_COUNTED, "--steps")
    if csv is not None:
        check_target(csv, "--csv")
    heights, loads = (
        read_amounts(height, "length", "--height"),
        read_amounts(load, "force", "--load"),
    )
    models, sets = read_models(spring), read_names(spring_set)
    cost = static_cost(
        chosen, models, spring_sets=sets, steps=steps, heights=len(heights), loads=len(loads)
    )
    say_cost(cost, read_limits(limit), FEWER_AT_REST)
    home = folder_of(case) if keep else None
    deliver(
        compute_static(chosen, models, sets, largest, steps, csv, heights, loads, implausible, home)
    )


def compute_static(
    case: Case,
    spring_models: tuple[str, ...],
    spring_sets: tuple[str, ...],
    largest: float | None,
    steps: int,
    csv: Path | None = None,
    heights: tuple[float, ...] = (),
    loads: tuple[float, ...] = (),
    implausible: bool = False,
    keep: Path | None = None,
) -> Outcome:
    """Solve the static curves up to ``largest`` (m; None: a little beyond full lift), and at
    ``heights`` (m) and ``loads`` (N); write ``csv`` on request. ``implausible``: let values pass
    that no spring can have; ``keep``: folder of the case, to save the answer.
    """
    from valvetrain.cli.outcome import Outcome
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.report.json import study_json
    from valvetrain.report.verdict import verdict_of
    from valvetrain.runs.statics import static_study
    from valvetrain.solution.atomic import write_text

    announce_compilation("statics")
    with progress_bar("static curve") as report:
        study = static_study(
            case,
            spring_models,
            spring_sets=spring_sets,
            command="static",
            largest_compression=largest,
            steps=steps,
            heights=heights,
            loads=loads,
            progress=report,
            implausible=implausible,
        )
    data = study_json(study)
    if csv is not None:
        data["files"] = [str(write_text(csv, curve_text(study)))]
    show = partial(_show, study=study, csv=csv)
    outcome = Outcome(data, show, study.failures, verdict_of(study))
    return outcome if keep is None else saved_outcome(outcome, study, case, keep, {"steps": steps})


def curve_text(study: Study) -> str:
    """The static curves as CSV; with several, the spring and its model are its first columns."""
    several = len(study.rest) > 1
    lines = [
        ("spring,model," if several else "")
        + ",".join(f"{name} [{unit}]" for name, unit in COLUMNS)
    ]
    for one in study.rest:
        place = f"{one.spring},{one.model}," if several else ""
        lines += [
            place + ",".join("" if value is None else repr(value) for value in row)
            for row in _rows(one)
        ]
    return "\n".join(lines) + "\n"


def _rows(one: SpringAtRest) -> list[tuple[float | None, ...]]:
    """Rows of :data:`COLUMNS`, in their units, None where the model or the spring gives none."""
    if one.curve is None:
        return []
    curve, nominal = one.curve, one.stress_per_force
    free = (
        None
        if one.installed is None or one.installed.height is None
        else one.installed.height + one.installed.compression
    )
    along = (
        None
        if one.stress is None
        else one.stress.shear_at(curve.compression).max(axis=1) * (curve.force > 0)
    )
    return [
        (
            float(place) * 1e3,
            float(force),
            float(stiffness) * 1e-3,
            None if free is None else (free - float(place)) * 1e3,
            None if nominal is None else nominal * float(force) * 1e-6,
            None if along is None else float(along[index]) * 1e-6,
        )
        for index, (place, force, stiffness) in enumerate(
            zip(curve.compression, curve.force, curve.stiffness, strict=True)
        )
    ]


def _point_tables(points: tuple[RestPoint, ...]) -> Iterator[Table]:
    """The states requested: the columns of a curve, and what acts on the retainer where it is
    known.
    """
    from valvetrain.cli.outcome import plain_table
    from valvetrain.parameters.summary import number

    def rows(fields: tuple[tuple[str, float], ...]) -> list[list[str]]:
        failed = [[getattr(point, name) for name, _ in fields] for point in points]
        return [
            [
                number(None if v is None else v * scale, 5)
                for v, (_, scale) in zip(row, fields, strict=True)
            ]
            for row in failed
        ]

    columns = (
        "compression",
        "force",
        "stiffness",
        "height",
        "nominal_shear_stress",
        "shear_stress",
    )
    headers = [f"{name} ({unit})" for name, unit in COLUMNS]
    yield plain_table(
        headers,
        rows(tuple(zip(columns, (1e3, 1.0, 1e-3, 1e3, 1e-6, 1e-6), strict=True))),
        "as requested",
        right=range(6),
    )
    if any(point.torque is not None for point in points):
        on_retainer = (
            ("compression", 1e3),
            ("torque", 1.0),
            ("moment", 1.0),
            ("side_force", 1.0),
            ("rotation", 180 / math.pi),
        )
        headers = [
            "compression (mm)",
            "torque (N m)",
            "moment (N m)",
            "side force (N)",
            "rotation (deg)",
        ]
        yield plain_table(headers, rows(on_retainer), "on the retainer", right=range(5))


def _show(console: Console, study: Study, csv: Path | None) -> None:
    from valvetrain.cli.outcome import plain_table, quantity_rows
    from valvetrain.parameters.summary import number

    console.print(study.record.title or study.record.name)
    for one, quantities in zip(study.rest, study.still.values(), strict=True):
        rows = _rows(one)
        each = -(-len(rows) // MAX_ROWS)
        failed = [
            place for place in range(len(COLUMNS)) if any(row[place] is not None for row in rows)
        ]
        console.print()
        label = ([number(row[place], 5) for place in failed] for row in rows[::each])
        headers = [f"{COLUMNS[place][0]} ({COLUMNS[place][1]})" for place in failed]
        console.print(
            plain_table(headers, label, f"{one.spring} by {one.model}", right=range(len(failed)))
        )
        for table in _point_tables(one.points) if one.points else ():
            console.print()
            console.print(table)
        if quantities:
            console.print()
            console.print(plain_table(("", "", ""), quantity_rows(quantities), right=(1,)))
        if one.curve is not None and one.curve.status.completed and one.curve.status.message:
            console.print(f"\n{one.curve.status.message}", soft_wrap=True)
    if csv is not None:
        console.print(f"\nwritten to {csv}", soft_wrap=True)
