"""``valvetrain compare-test``: a case against measured cycles or values, and whether the model is
adequate.
"""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from valvetrain.cli.request import SavedLine, command_of
from valvetrain.errors import FrozenMapping, InputError
from valvetrain.runs.request_fields import (
    option,
    options_of,
    read_count,
    read_pairs,
    read_path,
    read_positive,
    read_speed,
    read_text,
    read_within,
    read_words,
)
from valvetrain.runs.requests import ParallelRequest, SpringRequest


def read_gauge(given: Any, where: str) -> FrozenMapping:
    """Properties of a gauge: ``KEY=VALUE, ...``."""
    return read_pairs(read_words(given, where), where)


@dataclass(frozen=True, kw_only=True)
class CompareTestRequest(SpringRequest, ParallelRequest):
    """A case against a test."""

    command = "compare-test"

    test: Path | None = option(
        read_path,
        "Measured cycles, or a table of values with scatter or repeats.",
        "--test",
        "FILE",
    )
    quantity: str = option(
        read_text,
        "The model's curve, where the file calls it otherwise.",
        "--quantity",
        "NAME",
        default="",
    )
    engine_speed: float | None = option(
        read_speed, "Crank speed where the test does not state it.", "--rpm", "SPEED"
    )
    bandwidth: float | None = option(
        partial(read_positive, "frequency"),
        "Filter the model by a gauge of '10 kHz'.",
        "--bandwidth",
        "FREQUENCY",
    )
    sensor: FrozenMapping = option(
        read_gauge,
        "More of the gauge: 'natural_frequency=40 kHz, order=2'.",
        "--sensor",
        "WORDS",
        default=FrozenMapping(),
    )
    shared: str = option(
        read_text,
        "Errors that all cycles share: '2 N, 0.5 %, 0.1 deg'.",
        "--shared",
        "AMOUNTS",
        default="",
    )
    fitted: int = option(
        partial(read_count, 0, 10**6),
        "Number of model parameters fitted to this test.",
        "--fitted",
        "N",
        default=0,
    )
    level: float = option(
        partial(read_within, "ratio", 0.0, 1.0),
        "Share of adequate models that the test may refute.",
        "--level",
        "SHARE",
        default="0.05",
    )

    def __post_init__(self) -> None:
        """Raise :class:`InputError` without a test, and for a bandwidth that is given twice."""
        if self.test is None:
            raise InputError("the test is missing; give its file", "test")
        if self.bandwidth is not None and "bandwidth" in self.sensor:
            raise InputError("bandwidth is given twice; give it once", "sensor")


def compare_test(request: CompareTestRequest, line: SavedLine, folder: Path) -> None:
    """Whether a model agrees with a test within the scatter of the test, and where it is worst."""
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_runs, progress_bar
    from valvetrain.cli.run_answer import SavedRequest, saved_result
    from valvetrain.compare_test.answer import AgainstTestAnswer
    from valvetrain.compare_test.compare import compare_with_test
    from valvetrain.compare_test.reader import read_test
    from valvetrain.compare_test.tables import compare_test_json, write_compare_test
    from valvetrain.measured.sensor import Sensor

    assert request.test is not None
    gauge = {"bandwidth": request.bandwidth} if request.bandwidth else {}
    sensor = Sensor(**gauge, **request.sensor) if gauge or request.sensor else None  # type: ignore[arg-type]
    measured = read_test(request.test, request.quantity)
    announce_runs(request.case)
    with progress_bar(request.case.name) as report:
        result = compare_with_test(
            request.case,
            measured,
            quantity=request.quantity,
            engine_speed=request.engine_speed,
            models=request.models,
            spring_sets=request.spring_sets,
            sensor=sensor,
            fitted=request.fitted,
            shared=request.shared,
            level=request.level,
            workers=request.workers,
            progress=report,
            limit=request.limit,
            implausible=request.implausible,
        )
    asked = options_of(CompareTestRequest)
    words = ["--test", str(request.test)]
    words += [
        part
        for name in ("quantity", "engine_speed", "bandwidth", "sensor", "shared", "fitted", "level")
        if name in request.typed
        for part in (asked[name].flag, request.typed[name])
    ]
    words += [part for name in request.spring_sets for part in ("--spring-set", name)]
    failed = list(result.failures)
    data = {"command": request.command, "completed": not failed, "failures": failed}
    deliver(
        saved_result(
            SavedRequest(request.command, request.case, line.output, folder),
            result.study.record.text,
            data | compare_test_json(result),
            lambda _: AgainstTestAnswer(result, test=shlex.join(words)),
            lambda folder: write_compare_test(result, folder),
            {"test": str(request.test)},
            line.open_page,
            failed,
        )
    )


register = command_of(CompareTestRequest, SavedLine, compare_test)
