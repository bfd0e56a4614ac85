"""``valvetrain compare-test``: a case against measured cycles or values, and whether the model is
adequate.
"""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Any

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
    asking,
    name_case,
    read_models,
    read_names,
    read_workers,
    take_folder,
)
from valvetrain.cli.run_answer import SavedRequest, saved_result

#: Argument of :func:`compare_with_test`, or of the gauge -> its option, what follows that, and its help.
ASKED = {
    "quantity": ("--quantity", "NAME", "The model's curve, where the file calls it otherwise."),
    "engine_speed": ("--rpm", "SPEED", "Crank speed where the test does not state it."),
    "bandwidth": ("--bandwidth", "FREQUENCY", "Filter the model by a gauge of '10 kHz'."),
    "sensor": ("--sensor", "WORDS", "More of the gauge: 'natural_frequency=40 kHz, order=2'."),
    "shared": ("--shared", "AMOUNTS", "Errors that all cycles share: '2 N, 0.5 %, 0.1 deg'."),
    "fitted": ("--fitted", "N", "Number of model parameters fitted to this test."),
    "level": (
        "--level",
        "SHARE",
        "Share of adequate models that the test may refute (default: 0.05).",
    ),
}


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("compare-test")(asking(compare_test, ASKED))


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
    spring: SpringOption = None,
    spring_set: SpringSetOption = None,
    settings: SetOption = None,
    elements_per_coil: ElementsOption = None,
    output: OutputOption = None,
    workers: WorkersOption = None,
    limit: LimitOption = None,
    implausible: ImplausibleOption = False,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
    *,
    answers: dict[str, Any],
) -> None:
    """Whether a model agrees with a test within the scatter of the test, and where it is worst."""
    from valvetrain.cli.options import choose_case, folder_of, read_sensor
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_runs, progress_bar
    from valvetrain.compare_test.answer import AgainstTestAnswer
    from valvetrain.compare_test.compare import compare_with_test
    from valvetrain.compare_test.reader import read_test
    from valvetrain.compare_test.tables import compare_test_json, write_compare_test

    name_case(case, settings)
    take_folder(output)
    repeated = ["--test", str(test)]
    repeated += [part for name, value in answers.items() for part in (ASKED[name][0], str(value))]
    repeated += [part for text in spring_set or () for part in ("--spring-set", text)]
    bandwidth, words = answers.pop("bandwidth", None), answers.pop("sensor", None)
    gauge = read_sensor(bandwidth, words) if bandwidth or words else None
    chosen = choose_case(case, settings, elements_per_coil)
    measured = read_test(test, answers.get("quantity", ""))
    announce_runs(chosen)
    with progress_bar(chosen.name) as report:
        result = compare_with_test(
            chosen,
            measured,
            **answers,
            models=read_models(spring),
            spring_sets=read_names(spring_set),
            sensor=gauge,
            workers=read_workers(workers),
            progress=report,
            limit=", ".join(limit or ()),
            implausible=implausible,
        )
    request = SavedRequest("compare-test", chosen, output, folder_of(case))
    failed = list(result.failures)
    data = {
        "command": "compare-test",
        "completed": not failed,
        "failures": failed,
    } | compare_test_json(result)
    deliver(
        saved_result(
            request,
            result.study.record.text,
            data,
            lambda folder: AgainstTestAnswer(result, test=shlex.join(repeated)),
            lambda folder: write_compare_test(result, folder),
            {"test": str(test)},
            open_page,
            failed,
        )
    )
