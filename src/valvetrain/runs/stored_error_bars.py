"""Error bars and calibration spread that ship with a library case."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

from valvetrain.parameters.loading import library_names
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.quantity import Quantity, same_speed
from valvetrain.solution.status import Fact
from valvetrain.solution.uncertainty import Comparison, Uncertainty

if TYPE_CHECKING:
    from valvetrain.solution.result import Solution

RPM = math.pi / 30
#: The model whose bars are stored of a spring under prescribed motion.
ROD = "finite-element"
#: Heading of the rows without engine speed, and what separates engine speed and variant in the
#: headings of a train.
_STATICS, OF_VARIANT = "statics", ", of "
#: A stored row belongs to a computed value that differs by less than this share, or less than its
#: own uncertainty.
SAME = 1e-3


def load_uncertainty(record: CaseRecord) -> tuple[Uncertainty, ...]:
    """Rows that ship with a library case; empty without a file, and for a case other than the one
    that was refined.
    """
    return rows_of(_library_file(record.name, record.digest, "uncertainty"))


def stored_rows(
    record: CaseRecord, solutions: Sequence[Solution]
) -> dict[tuple[str, float], tuple[Uncertainty, ...]]:
    """Stored rows by label and engine speed (rad/s) of those ``solutions`` that reproduce every one of theirs
    that they have.
    """
    rows, found = load_uncertainty(record), {}
    for run in solutions:
        numbers = run.quantities
        own = tuple(
            row
            for row in rows
            if row.label == run.label and same_speed(row.engine_speed, run.engine_speed)
        )
        known = [(row, numbers[row.quantity]) for row in own if row.quantity in numbers]
        if known and all(_is_same(row, value) for row, value in known):
            found[run.label, run.engine_speed] = own
    return found


def rows_of(content: Mapping[str, Mapping[str, Any]]) -> tuple[Uncertainty, ...]:
    """Rows of the tables of a file, whatever case they belong to."""
    tables = ((label, table) for label, table in content.items() if label != "case")
    return tuple(
        _row(name, label, numbers) for label, table in tables for name, numbers in table.items()
    )


@cache
def _library_file(name: str, digest: str, ending: str) -> dict[str, Any]:
    """Tables of a file next to a library case, read once; empty without one, and where its digest is not ``digest``."""
    file = resources.files("valvetrain") / "parameters" / "library" / f"{name}.{ending}"
    if name not in library_names() or not file.is_file():
        return {}
    content = tomllib.loads(file.read_text(encoding="utf-8"))
    return content if content.get("case", {}).get("digest") == digest else {}


def belongs(row: Uncertainty, quantities: Mapping[Quantity, float]) -> bool:
    """Whether ``quantities`` hold the number of a stored row, the same within its own uncertainty."""
    return any(
        _is_same(row, value)
        for key, value in quantities.items()
        if key.name == row.quantity
        and (row.engine_speed is None or key.label == row.label)
        and same_speed(key.engine_speed, row.engine_speed)
    )


def _is_same(row: Uncertainty, value: float) -> bool:
    return abs(value - row.value) <= max(SAME * abs(row.value), row.numerical)


def _row(name: str, label: str, numbers: list[float]) -> Uncertainty:
    heading, _, variant = label.partition(OF_VARIANT)
    speed = None if heading == _STATICS else float(heading.split()[0]) * math.pi / 30
    value, numerical, order, limit, step, *ranges = map(float, numbers)
    stiffness, damping = (ranges[0], ranges[1]), (ranges[2], ranges[3])
    known = None if math.isnan(order) else order
    return Uncertainty(
        name, speed, value, numerical, known, limit, step, stiffness, damping, variant
    )


def numbers_of(row: Uncertainty) -> tuple[float, ...]:
    """The numbers of a row in the order of the stored tables; NaN for an unknown order."""
    order = math.nan if row.observed_order is None else row.observed_order
    first = row.value, row.numerical, order, row.extrapolated, row.step_part
    return (*first, *row.contact_stiffness, *row.damping)


def heading_of(engine_speed: float | None) -> str:
    """An engine speed (rad/s) as headings of the stored tables have it; None for springs at rest."""
    return _STATICS if engine_speed is None else f"{engine_speed * 30 / math.pi:g} rpm"


def with_blind(rows: Sequence[Comparison], record: CaseRecord) -> tuple[Comparison, ...]:
    """Comparisons of a fitted case with the numbers of the case that was not fitted to them, where
    these ship next to it.
    """
    content = _library_file(record.name, record.digest, "blind")
    tables = [content.get(f"{heading_of(row.engine_speed)}, {row.origin}", {}) for row in rows]
    return tuple(
        replace(row, blind=table.get(row.quantity)) if table else row
        for row, table in zip(rows, tables, strict=True)
    )


def spread_facts(record: CaseRecord, solutions: Sequence[Solution]) -> tuple[Fact, ...]:
    """Ranges (5 to 95 %) that the calibration data leave open at the speeds of those ``solutions`` whose numbers
    are the ones that the spread was found with.
    """
    run = {round(speed / RPM) for _, speed in stored_rows(record, solutions)}
    # values are the percentiles 5, 50 and 95
    return tuple(
        Fact("calibration-spread", {"quantity": quantity, "engine_speed": int(speed.split()[0]) * RPM,
                                    "low": float(values[0]), "high": float(values[-1])})
        for speed, table in _library_file(record.name, record.digest, "spread").items()
        if speed != "case" and int(speed.split()[0]) in run
        for quantity, values in table.items()
    )  # fmt: skip
