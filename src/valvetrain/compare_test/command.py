"""``valvetrain compare-test``: a case against measured cycles or values, and whether the model is
adequate.
"""

from __future__ import annotations

import shlex
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

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
from valvetrain.cli.run_answer import SavedRequest, saved_result


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
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.compare_test.adequacy import LEVEL
    from valvetrain.compare_test.answer import AgainstTestAnswer
    from valvetrain.compare_test.compare import compare_with_test
    from valvetrain.compare_test.files import compare_test_json, write_compare_test
    from valvetrain.compare_test.reader import read_test
    from valvetrain.session import call_case

    call_case([case, *(part for text in settings or () for part in ("--set", text))])
    take_folder(output)
    gauge = read_sensor(bandwidth, sensor, None) if bandwidth or sensor else None
    chosen = choose_case(case, settings, elements_per_coil)
    measured = read_test(test, quantity, channel)
    announce_compilation(*(("train",) if chosen.train is not None else ("statics", "transient")))
    with progress_bar(chosen.name) as report:
        result = compare_with_test(
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
        "--sensor": sensor, "--shared": shared, "--fitted": fitted or "", "--level": level if level != LEVEL else ""
    }  # fmt: skip
    repeated = [part for key, value in options.items() if value for part in (key, str(value))]
    repeated += [part for text in spring_set or () for part in ("--spring-set", text)]
    now = datetime.now(UTC).replace(microsecond=0)
    request = SavedRequest("compare-test", chosen, output, now, folder_of(case))
    failed = list(result.failures)
    data = {
        "command": "compare-test",
        "completed": not failed,
        "failures": failed,
    } | compare_test_json(result)
    test_words = shlex.join(repeated)
    text = result.study.record.text
    deliver(
        saved_result(
            request,
            text,
            data,
            lambda folder: AgainstTestAnswer(result, test=test_words),
            lambda folder: write_compare_test(result, folder),
            {"test": str(test)},
            open_page,
            failed,
        )
    )
