"""``valvetrain identify``: quantities of a case from measurements, with what is left open."""

from __future__ import annotations

import shutil
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

import typer

from valvetrain.cli.options import (
    DaskOption,
    JsonOption,
    LimitOption,
    OpenOption,
    OutputOption,
    QuietOption,
    WorkersOption,
    asks,
    read_names,
    read_workers,
    take_folder,
)
from valvetrain.cli.outcome import WORTH_SAYING
from valvetrain.cli.run_answer import SavedRequest, keep_run, show_page
from valvetrain.errors import InputError


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("identify")(identify)


def identify(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="Identification file: case, quantities with priors, measurements."
        ),
    ],
    method: Annotated[
        str, asks("--method", "METHOD", "least-squares or nested instead of the file's.")
    ] = "",
    seed: Annotated[int | None, asks("--seed", "N", "Seed of all random numbers.")] = None,
    profile: Annotated[
        list[str] | None,
        asks("--profile", "QUANTITIES", "Quantities whose profile is computed; repeatable."),
    ] = None,
    output: OutputOption = None,
    dask: DaskOption = "",
    workers: WorkersOption = None,
    limit: LimitOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Identify quantities of a case from measurements: likeliest values, intervals, separate
    solutions. A cut search is resumed.
    """
    from valvetrain.cli.guard import interrupted
    from valvetrain.cli.outcome import Outcome, deliver, tell
    from valvetrain.cli.progress import busy, progress_bar
    from valvetrain.explore.identification_answer import IdentificationAnswer
    from valvetrain.explore.identification_file import read_request
    from valvetrain.explore.identification_files import (
        CASE,
        identification_json,
        write_identification,
    )
    from valvetrain.explore.identify import identify_request
    from valvetrain.explore.store import FILE
    from valvetrain.findings.words import Words
    from valvetrain.runs.cost import read_limits
    from valvetrain.runs.run_folders import ROOT, safe_name
    from valvetrain.solution.atomic import is_abandoned, write_text
    from valvetrain.solution.partial_failures import PartialFailures
    from valvetrain.views.terminal import screen

    take_folder(output, FILE)
    request = read_request(file)
    changes: dict[str, Any] = {"method": method} if method else {}
    if seed is not None:
        changes["seed"] = seed
    try:
        search = replace(request.search, **changes)
    except InputError as error:
        raise InputError(error.reason, f"--{error.where}") from None
    request = replace(request, search=search, profiles=read_names(profile) or request.profiles)
    points = output or ROOT / safe_name(request.case.name) / f"points-{request.identity[:12]}"
    now = datetime.now(UTC).replace(microsecond=0)
    saved = SavedRequest("identify", request.case, output, now, file.parent)

    def reported(phrase: str, seconds: float) -> None:
        if seconds > WORTH_SAYING:
            tell(f"this will take {phrase}")

    again = (
        f"the points computed so far are stored in '{points}'; start the command again to continue"
    )
    try:
        with progress_bar(request.title) as report:
            found = identify_request(
                request,
                folder=points,
                workers=read_workers(workers, dask),
                report=report,
                limits=read_limits(limit),
                tell=reported,
            )
    except KeyboardInterrupt:
        interrupted(f"interrupted: {again}")
        raise
    except InputError:
        with suppress(OSError):  # a folder of no points is of no use
            stored = points / FILE
            if output is None and is_abandoned(stored) and not stored.stat().st_size:
                shutil.rmtree(points)
        raise
    data = {"command": "identify", "case": request.case.name, **identification_json(found), "completed": found.whole}  # fmt: skip
    gaps = PartialFailures()

    def fill(folder: Path) -> list[Path]:
        written = [write_text(folder / "identification.toml", request.text)]
        written += write_identification(found, folder, gaps)
        if folder.resolve() != points.resolve():  # last: a killed command finds its points again
            shutil.move(str(points / FILE), folder / FILE)
            shutil.rmtree(points, ignore_errors=True)
        return [*written, folder / FILE]

    choices = {
        "identification": request.text, "method": search.method, "seed": search.seed, "profiles": list(request.profiles),
    }  # fmt: skip
    folder = points
    with busy("writing files"):
        if found.whole:
            text = request.case.record().text
            folder, files = keep_run(saved, text, choices, data, fill, gaps=gaps)
        else:
            files = [str(path) for path in write_identification(found, points, gaps)]
    page = folder / "report.html"
    answer = IdentificationAnswer(found, Words(case=str(folder / CASE)))
    outcome = Outcome(
        data | {"folder": str(folder), "files": files, "page": str(page)},
        lambda console: console.print(screen(answer, str(page))),
        gaps.sentences,
    )
    if found.whole:
        if open_page:
            show_page(page)
        deliver(outcome)
        return
    with suppress(typer.Exit):
        deliver(outcome)
    raise typer.Exit(interrupted(f"interrupted: {again}"))
