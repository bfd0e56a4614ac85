"""What is asked of a comparison of a case with a test."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.errors import FrozenMapping, InputError
from valvetrain.runs.request_fields import (
    option,
    read_count,
    read_pairs,
    read_path,
    read_positive,
    read_speed,
    read_text,
    read_words,
)
from valvetrain.runs.requests import ParallelRequest, SpringRequest

if TYPE_CHECKING:  # a command line loads none of these
    from valvetrain.compare_test.reader import AnyTest
    from valvetrain.measured.sensor import Sensor


def read_any_test(given: Any, where: str) -> Any:
    """The path of a file; measured cycles or a table of values as they are."""
    return read_path(given, where) if isinstance(given, (str, Path)) else given


def read_gauge(given: Any, where: str) -> Any:
    """Properties of a gauge, ``KEY=VALUE, ...``; a gauge as it is."""
    words = isinstance(given, (str, list, tuple))
    return read_pairs(read_words(given, where), where) if words else given


@dataclass(frozen=True, kw_only=True)
class CompareTest(SpringRequest, ParallelRequest):
    """A case against a test."""

    command = "compare-test"

    test: AnyTest | None = option(
        read_any_test,
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
    sensor: FrozenMapping | Sensor = option(
        read_gauge,
        "More of the gauge: 'natural_frequency=40 kHz, order=2'.",
        "--sensor",
        "WORDS",
        default=FrozenMapping(),
    )
    shared: tuple[str, ...] = option(
        read_words,
        "Errors that all cycles share: '2 N, 0.5 %, 0.1 deg'.",
        "--shared",
        "AMOUNTS",
        default=(),
    )
    fitted: int = option(
        partial(read_count, 0, 10**6),
        "Number of model parameters fitted to this test.",
        "--fitted",
        "N",
        default=0,
    )

    def __post_init__(self) -> None:
        """Raise :class:`InputError` without a test, and for a bandwidth that is given twice."""
        if self.test is None:
            raise InputError("the test is missing; give its file", "test")
        if isinstance(self.sensor, FrozenMapping) and self.bandwidth and "bandwidth" in self.sensor:
            raise InputError("bandwidth is given twice; give it once", "sensor")

    @property
    def gauge(self) -> Sensor | None:
        """The gauge through which the model is seen; None without one."""
        from valvetrain.measured.sensor import Sensor

        bandwidth = {"bandwidth": self.bandwidth} if self.bandwidth else {}
        if not isinstance(self.sensor, FrozenMapping):
            return self.sensor
        known: dict[str, Any] = {**self.sensor, **bandwidth}
        return Sensor(**known) if known else None
