"""``valvetrain compare-test``: a case against measured cycles or values, and whether the model is
adequate.
"""

from __future__ import annotations

import shlex
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    CaseArgument,
    ElementsOption,
    ImplausibleOption,
    JsonOption,
    LimitOption,
    OpenOption,
    OutputOption,
    QuietOption,
    SetOption,
    SpringOption,
    SpringSetOption,
    WorkersOption,
    asks,
    read_models,
    read_names,
    read_workers,
    take_folder,
)
from valvetrain.cli.run_answer import SavedRequest, keep_run, show_page

if TYPE_CHECKING:
    from valvetrain.compare_test.compare import ModelAgainstTest


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("compare-test")(compare_test)


def compare_test(
    case: CaseArgument,
    test: Annotated[
        Path,
        typer.Option(
            "--test",
            metavar="FILE",
            help="Measured cycles, or a table of values with scatter or repeats.",
        ),
    ],
    quantity: Annotated[
        str, asks("--quantity", "NAME", "The model's curve, where the file calls it otherwise.")
    ] = "",
    channel: Annotated[
        int, asks("--channel", "N", "Which channel of a file of several, from 1.")
    ] = 0,
    engine_speed: Annotated[
        str | None, asks("--engine-speed", "SPEED", "Crank speed where the test does not state it.")
    ] = None,
    spring: SpringOption = None,
    spring_set: SpringSetOption = None,
    bandwidth: Annotated[
        str | None, asks("--bandwidth", "FREQUENCY", "Filter the model by a gauge of '10 kHz'.")
    ] = None,
    sensor: Annotated[
        str | None,
        asks("--sensor", "KEY=VALUE", "More of the gauge: 'natural_frequency=40 kHz, order=2'."),
    ] = None,
    shared: Annotated[
        str, asks("--shared", "AMOUNTS", "Errors that all cycles share: '2 N, 0.5 %, 0.1 deg'.")
    ] = "",
    fitted: Annotated[
        int,
        typer.Option(
            "--fitted", metavar="N", help="Number of model parameters fitted to this test."
        ),
    ] = 0,
    level: Annotated[
        float,
        typer.Option(
            "--level", metavar="SHARE", help="Level: share of adequate models the test may refute."
        ),
    ] = 0.05,
    settings: SetOption = None,
    elements_per_coil: ElementsOption = None,
    output: OutputOption = None,
    workers: WorkersOption = None,
    limit: LimitOption = None,
    implausible: ImplausibleOption = False,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Whether a model agrees with a test within the scatter of the test, and where it is worst."""
    from valvetrain.cli.options import choose_case, folder_of, read_sensor
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.compare_test.adequacy import LEVEL
    from valvetrain.compare_test.compare import compare_with_test
    from valvetrain.compare_test.reader import read_test
    from valvetrain.session import call_case

    call_case([case, *(one for text in settings or () for one in ("--set", text))])
    take_folder(output)
    gauge = read_sensor(bandwidth, sensor, None) if bandwidth or sensor else None
    chosen = choose_case(case, settings, elements_per_coil)
    measured = read_test(test, quantity, channel)
    announce_compilation(*(("train",) if chosen.train is not None else ("statics", "transient")))
    with progress_bar(chosen.name) as report:
        found = compare_with_test(
            chosen,
            measured,
            quantity=quantity,
            engine_speed=engine_speed,
            spring_models=read_models(spring),
            spring_set=read_names(spring_set),
            sensor=gauge,
            fitted=fitted,
            shared=shared,
            level=level,
            workers=read_workers(workers),
            progress=report,
            limit=", ".join(limit or ()),
            implausible=implausible,
        )
    options = {
        "--test": str(test), "--quantity": quantity, "--channel": channel or "", "--engine-speed": engine_speed, "--bandwidth": bandwidth,
        "--sensor": sensor, "--shared": shared, "--fitted": fitted or "", "--level": level if level != LEVEL else "",
    }  # fmt: skip
    repeated = [part for key, value in options.items() if value for part in (key, str(value))]
    repeated += [part for text in spring_set or () for part in ("--spring-set", text)]
    now = datetime.now(UTC).replace(microsecond=0)
    request = SavedRequest("compare-test", chosen, output, now, folder_of(case))
    _answer(found, request, str(test), shlex.join(repeated), open_page)


def _answer(
    found: ModelAgainstTest, request: SavedRequest, test: str, options: str, open_page: bool
) -> None:
    """Save the folder (page, files, run.json) and print the answer; ``options``: those of the test, to be copied."""
    from valvetrain.cli.outcome import Outcome, deliver
    from valvetrain.cli.progress import busy
    from valvetrain.compare_test.answer import AgainstTestAnswer
    from valvetrain.compare_test.files import compare_test_json, write_compare_test
    from valvetrain.findings.words import Words
    from valvetrain.solution.partial_failures import PartialFailures
    from valvetrain.views.results import write_page
    from valvetrain.views.terminal import screen

    answer = AgainstTestAnswer(found, test=options)
    plain = AgainstTestAnswer(found, Words(case=answer.words.case), options)
    data: dict[str, Any] = {
        "command": "compare-test", "completed": not found.failures, "failures": list(found.failures), **compare_test_json(found),
        "findings": [one.to_dict() for one in plain.findings],
    }  # fmt: skip
    gaps, pages = PartialFailures(), list[Path]()

    def fill(folder: Path) -> list[Path]:
        if not found.runs:
            return []
        pages.extend(filter(None, (write_page(answer, folder, gaps),)))
        return [*write_compare_test(found, folder), *pages]

    with busy("writing files"):
        origin = found.study.solutions[0].provenance if found.study.solutions else None
        folder, files = keep_run(
            request, found.study.record.text, {"test": test}, data, fill, origin
        )
    if open_page and pages:
        show_page(pages[0])
    page = str(pages[0]) if pages else ""
    data |= {"folder": str(folder), "files": files, "page": page or None}
    deliver(
        Outcome(
            data,
            lambda console: console.print(screen(answer, page, str(folder))),
            (*found.failures, *gaps.sentences),
        )
    )
