"""Verdict on meshes: how large the error bars are."""

from __future__ import annotations

import math

from valvetrain.report.clauses import figure, sentence
from valvetrain.report.run_summary import share
from valvetrain.report.text import speed_text, unit_text
from valvetrain.runs.error_bars import UncertaintyStudy
from valvetrain.solution.definition import label_of, shown
from valvetrain.solution.uncertainty import NOT_RESOLVED, Uncertainty

#: Error bars up to this share of a value count as small.
SMALL = 0.01


def refine_verdict(study: UncertaintyStudy) -> str:
    """The error bar of the peak force, the largest one, and how many are small."""
    rows = [row for row in study.rows if row.value and math.isfinite(row.numerical)]
    failed = len(study.failures)
    first = f"{'one part' if failed == 1 else f'{failed} parts'} failed" if failed else ""
    if not rows:
        return sentence([first or "no error bar was found"])
    peak = next((row for row in rows if row.quantity == "peak_spring_force"), rows[0])
    largest = max(rows, key=_size)
    small = sum(_size(row) <= SMALL for row in rows)
    parts = [first, f"{label_of(peak.quantity)}{_at(peak)} {_value(peak)} {_bar(peak)}"]
    if largest is not peak:
        parts.append(
            f"largest error bar {_bar(largest)} in {label_of(largest.quantity)}{_at(largest)}"
        )
    if len(rows) > 1:
        parts.append(f"{small} of {len(rows)} numbers within {share(SMALL)}")
    return sentence(parts)


def _bar(row: Uncertainty) -> str:
    return f"± {share(_size(row))}" if row.resolved else NOT_RESOLVED


def _size(row: Uncertainty) -> float:
    return abs(row.numerical / row.value)


def _value(row: Uncertainty) -> str:
    value, unit = shown(row.quantity, row.value)
    return f"{figure(float(value))} {unit_text(unit)}".strip()


def _at(row: Uncertainty) -> str:
    return "" if row.engine_speed is None else f" at {speed_text(row.engine_speed)}"
