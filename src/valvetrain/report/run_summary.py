"""Rows of the differences of two saved runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from valvetrain.report.text import number, percent
from valvetrain.runs.differences import ResultDifference
from valvetrain.solution.definition import is_defined, label_of, shown, topics


def share(value: float) -> str:
    """A ratio in per cent with two significant digits; empty for none."""
    return (
        ""
        if not math.isfinite(value)
        else f"{100 * value:.2g} %"
        if abs(value) < 0.995
        else f"{100 * value:.0f} %"
    )


INPUT_HEADS = ("inputs", "A", "B")
RESULT_HEADS = ("results", "run", "A", "B", "", "difference")


def input_rows(inputs: Sequence[tuple[str, Any, Any]]) -> list[tuple[str, ...]]:
    """Rows of the inputs that differ: key path, value in A, value in B.

    >>> input_rows([("spring.total_coils", 6, None)])
    [('spring.total_coils', '6', '–')]
    """
    return [(key, _word(first), _word(second)) for key, first, second in inputs]


def result_rows(results: Sequence[ResultDifference]) -> list[tuple[str, ...]]:
    """Rows of the numbers that both runs have and that differ: headline quantities first, then the
    largest difference.

    >>> result_rows([ResultDifference("peak_spring_force", "massless", "N", 800.0, 840.0)])
    [('peak spring force below 10 kHz', 'massless', '800', '840', 'N', '+5.0 %')]
    """
    first = [name for names in topics().values() for name in names]
    place = {name: index for index, name in enumerate(first)}
    both = sorted(
        (row for row in results if row.difference is not None),
        key=lambda row: place.get(row.quantity, len(first)),
    )
    rows: list[tuple[str, ...]] = []
    for row in both:
        change = "" if row.relative is None else percent(row.relative)
        if is_defined(row.quantity):
            a, b = (
                number(float(shown(row.quantity, value)[0]))
                for value in (row.a or 0.0, row.b or 0.0)
            )
            rows.append(
                (label_of(row.quantity), row.run, a, b, shown(row.quantity, 1.0)[1], change)
            )
        else:
            label = row.quantity.replace("_", " ")
            rows.append(
                (
                    label,
                    row.run.replace("_", " "),
                    number(row.a or 0.0),
                    number(row.b or 0.0),
                    row.unit,
                    change,
                )
            )
    return rows


def _word(value: Any) -> str:
    text = (
        "–"
        if value is None
        else ", ".join(map(str, value))
        if isinstance(value, list)
        else str(value)
    )
    return text if len(text) <= 60 else text[:57] + "..."
