"""``valvetrain compare-test``: a case against measured cycles or values, and whether the model is
adequate.
"""

from __future__ import annotations

from collections.abc import Iterable
from datetime import UTC, datetime
from functools import partial
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
    from rich.console import Console

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
    """Model against test: overlay, errors by event and stage, band of the difference, Fisher's test
    of adequacy.
    """
    from valvetrain.cli.options import choose_case, folder_of, read_sensor
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.compare_test.compare import compare_with_test
    from valvetrain.compare_test.reader import read_test

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
    _answer(
        found,
        SavedRequest(
            "compare-test",
            chosen,
            output,
            datetime.now(UTC).replace(microsecond=0),
            folder_of(case),
        ),
        str(test),
        open_page,
    )


def _answer(found: ModelAgainstTest, request: SavedRequest, test: str, open_page: bool) -> None:
    from valvetrain.cli.outcome import Outcome, deliver
    from valvetrain.cli.progress import busy
    from valvetrain.compare_test.page import (
        compare_test_json,
        compare_test_page,
        write_compare_test,
    )
    from valvetrain.report.page import render
    from valvetrain.solution.atomic import write_text

    data: dict[str, Any] = {
        "command": "compare-test",
        "completed": not found.failures,
        "failures": list(found.failures),
    }
    data |= compare_test_json(found)
    pages: list[Path] = []

    def fill(folder: Path) -> list[Path]:
        if not found.runs:
            return []
        pages.append(write_text(folder / "report.html", render(compare_test_page(found))))
        return [*write_compare_test(found, folder), *pages]

    with busy("writing files"):
        origin = found.study.solutions[0].provenance if found.study.solutions else None
        folder, files = keep_run(
            request, found.study.record.text, {"test": test}, data, fill, origin
        )
    if open_page and pages:
        show_page(pages[0])
    data |= {"folder": str(folder), "files": files, "page": str(pages[0]) if pages else None}
    from valvetrain.report.verdict import verdict_of

    show = partial(_show, found=found, folder=folder)
    deliver(Outcome(data, show, found.failures, verdict_of(found)))


def _show(console: Console, found: ModelAgainstTest, folder: Path) -> None:
    from valvetrain.cli.outcome import plain_table
    from valvetrain.compare_test import summary, tables
    from valvetrain.measured.cycles import MeasuredCycles
    from valvetrain.report.columns import text_table

    def show_table(columns: tables.Columns, rows: Iterable[Any]) -> None:
        headings, texts, right = text_table(columns, rows)
        console.print()
        console.print(plain_table(headings, texts, right=right))

    test, best = found.test, found.best if found.runs else None
    console.print(f"test: {summary.text_of_test(found)}", soft_wrap=True)
    if test.synthetic:
        console.print(summary.SYNTHETIC, soft_wrap=True)
    if best is None:
        return
    console.print()
    for sentence in summary.verdict_sentences(found):
        console.print(sentence, soft_wrap=True)
    unit, factor = summary.unit_of_test(found)
    if tested := tables.with_adequacy(found.runs):
        show_table(tables.adequacy_columns(unit, factor), tested)
    if isinstance(test, MeasuredCycles):
        show_table(tables.agreement_columns(unit, factor), tables.with_agreement(found.runs))
        events = sorted(best.events, key=tables.is_spike)
        show_table(tables.event_columns(unit, factor, best.label), events)
        console.print(f"\n{summary.events_sentence(best)}", soft_wrap=True)
    else:
        console.print()
        for one in found.runs:
            console.print(summary.outside_sentence(one), soft_wrap=True)
        show_table(tables.value_columns(best.label), best.values)
    console.print()
    for note in dict.fromkeys(found.notes):
        console.print(f"{note[:1].upper()}{note[1:]}.", soft_wrap=True)
    console.print(f"results in {folder}", soft_wrap=True)
