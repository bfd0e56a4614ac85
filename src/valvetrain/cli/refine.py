"""``valvetrain refine``: numerical and physical uncertainty of the headline numbers of a spring or a train."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from valvetrain.cli.options import (
    CaseArgument,
    ElementsOption,
    JsonOption,
    OutputOption,
    QuietOption,
    SetOption,
    SpeedOption,
    WorkersOption,
    read_engine_speeds,
    read_workers,
)

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.cli.outcome import Outcome
    from valvetrain.parameters.case import Case
    from valvetrain.studies.uncertainty import UncertaintyStudy


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("refine")(refine)


@dataclass(frozen=True)
class RefineRequest:
    """What was asked for: the case, the folder its file lies in, where results go, and the time."""

    case: Case
    folder: Path
    output: Path | None
    created_at: datetime
    command: str = "refine"


def refine(
    case: CaseArgument, output: OutputOption = None, engine_speed: SpeedOption = None, elements_per_coil: ElementsOption = None,
    settings: SetOption = None, workers: WorkersOption = None, as_json: JsonOption = False, quiet: QuietOption = False,
) -> None:  # fmt: skip
    """State the uncertainty of the headline numbers of a spring or a train: finer meshes and steps, other contact constants."""
    from valvetrain.cli.case_choice import choose_case, folder_of
    from valvetrain.cli.outcome import deliver
    from valvetrain.studies.run_store import ROOT, check_folder

    chosen = choose_case(case, settings, elements_per_coil)
    check_folder(output or ROOT, kept=output is None)
    request = RefineRequest(chosen, folder_of(case), output, datetime.now(UTC).replace(microsecond=0))
    deliver(_outcome(request, read_engine_speeds(engine_speed), read_workers(workers)))


def _outcome(request: RefineRequest, engine_speeds: tuple[float, ...] | None, workers: int) -> Outcome:
    from valvetrain.cli.outcome import Outcome
    from valvetrain.cli.progress import announce_compilation, busy, progress_bar
    from valvetrain.cli.study_command import keep_run
    from valvetrain.report.json import uncertainty_object
    from valvetrain.report.uncertainty_section import uncertainty_page, uncertainty_table
    from valvetrain.report.words import rpm
    from valvetrain.report.write import write_page
    from valvetrain.solution.atomic import write_text
    from valvetrain.studies.refined import refined

    case = request.case
    announce_compilation(*(("train",) if case.train is not None else ("statics", "transient")))
    with progress_bar(case.name) as report:
        study = refined(case, engine_speeds=engine_speeds, workers=workers, progress=report)
    data = {
        "command": "refine", "case": case.name, "title": case.title, "elements_per_coil": list(study.elements_per_coil),
        "uncertainties": [uncertainty_object(row) for row in study.rows], "completed": not study.failures, "page": "report.html",
    }  # fmt: skip

    def write(folder: Path) -> list[Path]:
        table = write_text(folder / "uncertainty.csv", uncertainty_table(study.rows).csv())
        page, figures = write_page(uncertainty_page(study), folder)
        return [table, *figures, page]

    choices = {"engine_speeds": [rpm(speed) for speed in engine_speeds or case.operation.engine_speeds], "engine_speed_unit": "rpm"}
    with busy("writing files"):
        folder, files = keep_run(request, case.record().text, choices, data, write)
    data |= {"folder": str(folder), "files": files, "page": str(folder / "report.html")}
    return Outcome(data, lambda console: _show(console, study, str(folder / "report.html")), study.failures)


def _show(console: Console, study: UncertaintyStudy, page: str) -> None:
    from valvetrain.cli.tables import plain_table, shown_words
    from valvetrain.report.words import speed_words
    from valvetrain.solution.definition import label_of

    console.print(study.record.title or study.record.name)
    meshes = ", ".join(map(str, study.elements_per_coil))
    varied = f"{meshes} elements per coil, step halved" if meshes else "step halved twice, springs divided more finely, half the samples"
    console.print(f"{varied}, contact constants varied")
    headers = ("quantity", "value", "± num.", "unit", "order", "contact stiffness", "contact damping")
    for speed, label in dict.fromkeys((row.engine_speed, row.label) for row in study.rows):
        rows = []
        for row in (row for row in study.rows if (row.engine_speed, row.label) == (speed, label)):
            name = row.quantity
            trusted = row.observed_order is not None and row.observed_order >= 0.5
            order = f"{row.observed_order:.1f}" if trusted else "–"
            ranges = [
                " to ".join(dict.fromkeys(shown_words(name, value, 4)[0] for value in values))
                for values in (row.contact_stiffness, row.contact_damping)
            ]
            value, word = shown_words(name, row.value)
            rows.append((label_of(name), value, shown_words(name, row.numerical, 2)[0], word, order, *ranges))
        place = "statics and modes" if speed is None else f"{speed_words(speed)}{f', {label}' if label else ''}"
        console.print()
        console.print(plain_table(headers, rows, place, right=(1, 2, 4, 5, 6)))
    console.print(f"\nresults  {page}", soft_wrap=True)
