"""Commands of trains: ``run`` for a case with a train, ``compare`` and ``sweep``."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    CaseArgument,
    JsonOption,
    OutputOption,
    SetOption,
    SpeedOption,
    WorkersOption,
    make_folder,
    read_engine_speeds,
    read_output,
    read_workers,
)
from valvetrain.cli.outcome import Outcome, measured
from valvetrain.cli.run_request import RunRequest
from valvetrain.cli.spring_compare import (
    SOLID,
    SolidCoreOption,
    SolidElementsOption,
    SolidOptions,
    SolidRideOption,
    SolidRingsOption,
    SolidTimeOption,
    compare_spring,
)
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.parameters.case import Case
    from valvetrain.quantities.valvetrain_study import TrainRun, TrainStudy
    from valvetrain.studies.sweep import TrainSweep

SpringsOption = Annotated[
    str | None,
    typer.Option(
        "--springs",
        metavar="MODELS",
        help="Spring models, such as massless,multi-mass,wave-rod,finite-element.",
        show_default=False,
    ),
]
SetsOption = Annotated[
    str | None,
    typer.Option("--spring-sets", metavar="SETS", help="Spring sets of the case, such as stock,performance.", show_default=False),
]
ReportOption = Annotated[bool, typer.Option("--report/--no-report", help="Write the report page and its figures.")]


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command("compare")(compare)
    app.command("sweep")(sweep)


def run_train(request: RunRequest) -> Outcome:
    """``valvetrain run`` of a case with a train: all its variants, or the spring models asked for."""
    return _study_outcome("run", request, request.spring_models)


def compare(
    case: CaseArgument, springs: SpringsOption = None, output: OutputOption = None, engine_speed: SpeedOption = None,
    settings: SetOption = None, solid_elements_per_coil: SolidElementsOption = None, solid_core: SolidCoreOption = None,
    solid_rings: SolidRingsOption = None, solid_motion: SolidRideOption = None, solid_time_limit: SolidTimeOption = None,
    workers: WorkersOption = None, report: ReportOption = True, as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Run a case's train (or spring) by several spring models, side by side; a spring by solid finite elements too."""
    from valvetrain.cli.case_choice import choose_case
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.registry import run_case

    chosen, models = choose_case(case, settings), _names(springs)
    solid = SolidOptions(solid_elements_per_coil, solid_core, solid_rings, solid_motion, solid_time_limit)
    if solid.given and SOLID not in models:
        raise InputError("options of the solid model need the solid model; add --springs finite-element,solid", "--solid-...")
    if SOLID in models and chosen.train is not None:
        raise InputError(f"solid finite elements run for a spring alone, and case '{chosen.name}' is a train; leave solid out", "--springs")
    if chosen.train is not None:
        models = models or ("massless", "multi-mass", "modal-uniform", "wave-rod")
    request = RunRequest(
        case=chosen, engine_speeds=read_engine_speeds(engine_speed), spring_models=models, workers=read_workers(workers),
        output=read_output(output, f"{chosen.name}-compare"), report=report,
    )  # fmt: skip
    if SOLID in models:
        deliver(compare_spring(request, solid), as_json)
    elif chosen.train is None:
        deliver(run_case(request), as_json)
    else:
        deliver(_study_outcome("compare", request, models), as_json)


def sweep(
    case: CaseArgument,
    engine_speed: Annotated[
        str, typer.Option("--engine-speed", metavar="SPEEDS", help="Crank speeds, '1000:9000:100' (rpm) or '4200, 5600 rpm'.")
    ] = "1000:9000:100",
    springs: SpringsOption = None, spring_sets: SetsOption = None, output: OutputOption = None, settings: SetOption = None,
    workers: WorkersOption = None, report: ReportOption = True, as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Sweep a train over engine speed up to loss of control, per spring."""
    from valvetrain.cli.case_choice import choose_case
    from valvetrain.cli.outcome import deliver

    chosen = choose_case(case, settings)
    text = engine_speed if any(char.isalpha() for char in engine_speed) else f"{engine_speed} rpm"
    speeds = read_engine_speeds(text) or ()
    folder = read_output(output, f"{chosen.name}-sweep")
    deliver(_sweep_outcome(chosen, speeds, _names(springs), _names(spring_sets), read_workers(workers), folder, report), as_json)


def _names(text: str | None) -> tuple[str, ...]:
    return tuple(dict.fromkeys(part.strip() for part in (text or "").split(",") if part.strip()))


def _check_models(models: tuple[str, ...]) -> None:
    from valvetrain.parameters.changes import nearest
    from valvetrain.system.spring_choice import SPRING_MODELS

    for name in models:
        if name not in SPRING_MODELS:
            raise InputError(f"spring model '{name[:40]}' is unknown here; {nearest(name, SPRING_MODELS)}", "--springs")


def _study_outcome(command: str, request: RunRequest, models: tuple[str, ...]) -> Outcome:
    from valvetrain.cli.progress import announce_compilation, busy, progress_bar
    from valvetrain.report.train_report import write_train_report
    from valvetrain.studies.train_study import run_train_study

    _check_models(models)
    make_folder(request.output)
    announce_compilation("train")
    with progress_bar(request.case.name) as report:
        study = run_train_study(
            request.case, engine_speeds=request.engine_speeds, spring_models=models, workers=request.workers, progress=report,
            created_at=datetime.now(UTC).isoformat(timespec="seconds"),
        )  # fmt: skip
    with busy("writing files"):
        files = write_train_report(study, request.output, request.report)
    failures = tuple(f"{run.label}: {run.status.sentence()}" for run in study.runs if not run.status.completed)
    data = _study_object(command, study)
    data |= {
        "completed": not failures, "folder": str(request.output), "files": [str(path) for path in (*files.data, *files.figures)],
        "page": str(files.page) if request.report else None,
    }  # fmt: skip
    return Outcome(data, lambda console: _show_study(console, study, str(files.page) if request.report else str(request.output)), failures)


def _study_object(command: str, study: TrainStudy) -> dict[str, Any]:
    from valvetrain.cli.results import comparison_objects, quantities_object

    still: dict[str, dict[str, float]] = {}
    for key, value in study.quantities.items():
        if key.engine_speed is None:
            still.setdefault(key.label or "case", {})[key.name] = value
    return {
        "command": command, "case": study.case.name, "title": study.case.title,
        "quantities": {name: quantities_object(values) for name, values in still.items()}, "runs": [_run_object(run) for run in study.runs],
        "comparisons": comparison_objects(study.comparisons),
        "findings": [
            {"place": item.place, "finding": item.statement, "computed": item.computed, "verdict": item.verdict} for item in study.findings
        ],
        "notes": list(study.notes), "cite": list(study.provenance.citations),
    }  # fmt: skip


def _run_object(run: TrainRun) -> dict[str, Any]:
    from valvetrain.cli.results import engine_speed_object, quantities_object, status_object

    return {
        "label": run.label, "spring_model": run.spring_model, "spring_set": run.spring_set,
        "engine_speed": engine_speed_object(run.engine_speed),
        "status": status_object(run.status), "quantities": quantities_object(run.quantities),
        "events": [
            {"kind": event.kind, "where": event.where, "cam_angle": measured(event.cam_angle, "rad"),
            "duration": measured(event.duration, "s"),
             "size": measured(event.size, event.unit), "cause": str(event.details.get("cause", ""))}
            for event in run.events
        ],
        "time_per_cycle": measured(run.wall_time_per_cycle, "s"),
    }  # fmt: skip


def _show_study(console: Console, study: TrainStudy, page: str) -> None:
    import numpy as np

    from valvetrain.cli.study_tables import show_comparisons
    from valvetrain.cli.tables import plain_table
    from valvetrain.report.train_report import summary_table
    from valvetrain.report.words import number

    console.print(study.case.title or study.case.name)
    data = summary_table(study.runs)
    names = [column.name for column in data.columns]
    for first in range(2, len(names), 4):  # four runs side by side fit 100 columns
        chosen = [0, 1, *range(first, min(first + 4, len(names)))]
        rows = [[_word(row[place], number, np) for place in chosen] for row in data.rows()]
        console.print()
        console.print(plain_table([names[place] for place in chosen], rows, right=range(2, len(chosen))))
    if study.comparisons:
        show_comparisons(console, study.comparisons)
    for item in study.findings:
        console.print(f"\n{item.place}: {item.statement}\n  computed: {item.computed}\n  verdict:  {item.verdict}", soft_wrap=True)
    for note in study.notes:
        console.print(f"\n{note}", soft_wrap=True)
    for run in study.runs:
        if not run.status.completed:
            console.print(f"\n{run.label}: {run.status.sentence()}", soft_wrap=True)
    console.print(f"\nresults  {page}", soft_wrap=True)


def _word(value: Any, number: Any, np: Any) -> str:
    if isinstance(value, float):
        return "–" if not np.isfinite(value) else str(number(value))
    return str(value)


def _sweep_outcome(
    case: Case, speeds: tuple[float, ...], models: tuple[str, ...], sets: tuple[str, ...], workers: int, folder: Any, report: bool
) -> Outcome:
    from valvetrain.cli.progress import announce_compilation, busy, progress_bar
    from valvetrain.report.train_report import write_sweep_report
    from valvetrain.studies.sweep import run_sweep

    _check_models(models)
    make_folder(folder)
    announce_compilation("train")
    with progress_bar(case.name) as progress:
        result = run_sweep(case, speeds, spring_models=models, spring_sets=sets, workers=workers, progress=progress)
    with busy("writing files"):
        files = write_sweep_report(result, folder, report)
    data = {
        "command": "sweep", "case": case.name, "title": case.title, "series": [_series_object(item) for item in result.series],
        "wall_time": measured(result.wall_time, "s"), "completed": not result.failures, "folder": str(folder),
        "files": [str(path) for path in (*files.data, *files.figures)], "page": str(files.page) if report else None,
    }  # fmt: skip
    return Outcome(data, lambda console: _show_sweep(console, result, str(files.page) if report else str(folder)), result.failures)


def _series_object(item: Any) -> dict[str, Any]:
    from valvetrain.report.words import rpm
    from valvetrain.solution.quantity import unit_of

    columns = {name: {"values": values, "unit": unit_of(name)} for name, values in item.columns.items()}
    return {
        "spring_set": item.spring_set, "spring_model": item.spring_model,
        "float_engine_speed": measured(rpm(item.float_engine_speed), "rpm"),
        "contact_loss_engine_speed": measured(rpm(item.contact_loss_engine_speed), "rpm"),
        "lone_float_engine_speeds": {"values": [rpm(speed) for speed in item.lone_float_engine_speeds], "unit": "rpm"},
        "rigid_contact_loss_engine_speed": measured(rpm(item.rigid_engine_speed), "rpm"),
        "engine_speed": {"values": [rpm(speed) for speed in item.engine_speeds], "unit": "rpm"}, "columns": columns,
        "surge_orders": {"values": item.orders, "unit": "N"}, "statuses": [status.code for status in item.statuses],
    }  # fmt: skip


def _speed_or(engine_speed: float, words: str) -> str:
    from valvetrain.report.words import number, rpm

    return words if engine_speed != engine_speed else number(rpm(engine_speed))


def _show_sweep(console: Console, result: TrainSweep, page: str) -> None:
    import numpy as np

    from valvetrain.cli.tables import plain_table
    from valvetrain.report.words import number, rpm

    console.print(result.case.title or result.case.name)
    console.print()
    rows = [
        (item.label, _speed_or(item.contact_loss_engine_speed, "never"), number(rpm(item.rigid_engine_speed)),
         _speed_or(item.float_engine_speed, "never"), ", ".join(f"{rpm(speed):g}" for speed in item.lone_float_engine_speeds) or "–",
         number(float(np.nanmax(item.columns["peak_open_cam_contact_force"]))),
         number(float(np.nanmax(item.columns["seating_velocity"]))))
        for item in result.series
    ]  # fmt: skip
    headers = (
        "springs",
        "contact first lost (rpm)",
        "by rigid theory (rpm)",
        "floats from (rpm)",
        "at single speeds (rpm)",
        "largest cam force (N)",
        "largest seating velocity (m/s)",
    )
    console.print(plain_table(headers, rows, right=(1, 2, 3, 4, 5, 6)))
    console.print(f"\n{len(result.series[0].engine_speeds)} speeds per spring, {result.wall_time:.1f} s\nresults  {page}", soft_wrap=True)
