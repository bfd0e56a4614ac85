"""Printed values next to those computed here and by the case that was not fitted."""

from __future__ import annotations

from collections.abc import Sequence

from valvetrain.findings.words import RPM, digits_text, speed_text
from valvetrain.solution.definition import definition_of, label_of, shown
from valvetrain.solution.uncertainty import Comparison
from valvetrain.units.reader import shown_system
from valvetrain.views.table import TextTable

#: Rows of a source that the first screen shows, and engine speeds that make it worth a table.
LEAST_ROWS, LEAST_SPEEDS = 3, 2
ROLES = {"calibration": "fitted", "check": "not fitted", "prediction": "predicted"}


def paper_table(comparisons: Sequence[Comparison]) -> TextTable | None:
    """Peak forces here, in the paper and by the case that was not fitted, by engine speed; of the paper's first method.

    Parameters
    ----------
    comparisons : those of a study

    Returns
    -------
    The table; None where the source prints fewer than three peak forces, or one engine speed
    """
    known = [
        row
        for row in comparisons
        if row.quantity.endswith("peak_force") and row.engine_speed and row.computed is not None and not row.doubt
    ]  # fmt: skip
    origin = known[0].origin if known else ""
    rows = {(row.quantity, row.engine_speed or 0.0): row for row in known if row.origin == origin}
    speeds = sorted({speed for _, speed in rows})
    if len(rows) < LEAST_ROWS or len(speeds) < LEAST_SPEEDS:
        return None
    blind = any(row.blind is not None for row in rows.values())
    unit = definition_of(known[0].quantity).shown_unit
    lines = [
        (
            label_of(name).removesuffix(" force"),
            *(cell(rows[name, speed]) if (name, speed) in rows else "" for speed in speeds),
        )
        for name in dict.fromkeys(quantity for quantity, _ in rows)
    ]
    head = f"here/paper{'/blind' * blind}, {unit}"
    return TextTable("Here and in the paper", (head, *map(speed_text, speeds)), tuple(lines))


def cell(row: Comparison) -> str:
    """``778/818/817``: computed, printed, computed blind."""
    texts = (
        value_text(row, row.computed),
        value_text(row, row.published),
        value_text(row, row.blind),
    )
    return "/".join(filter(None, texts))


def value_text(row: Comparison, value: float | None) -> str:
    """A value (SI) with as many decimals as the printed one has, in units other than its own three digits; empty for
    None.
    """
    if value is None:
        return ""
    if shown_system() != "si":
        return digits_text(float(shown(row.quantity, value)[0]))
    printed = f"{float(shown(row.quantity, row.published)[0]):.10g}"
    places = min(len(printed.partition(".")[2]), 4)
    return f"{float(shown(row.quantity, value)[0]):.{places}f}".replace("-", "−")


def published_rows(comparisons: Sequence[Comparison]) -> list[tuple[str, ...]]:
    """Every printed value as texts: quantity, rpm, method, unit, paper, here, blind, off, used, doubt."""
    rows: list[tuple[str, ...]] = []
    for row in comparisons:
        share = row.relative_difference
        off = "" if share is None else f"{100 * share:+.0f} %".replace("-", "−")
        speed = "" if row.engine_speed is None else f"{row.engine_speed / RPM:.0f}"
        here, paper, blind = (
            value_text(row, one) for one in (row.computed, row.published, row.blind)
        )
        unit = definition_of(row.quantity).shown_unit.replace("^2", "²")
        used = ROLES.get(row.role, row.role)
        rows.append(
            (
                label_of(row.quantity),
                speed,
                row.origin,
                unit,
                paper,
                here or "–",
                blind,
                off,
                used,
                row.doubt,
            )
        )
    return rows
