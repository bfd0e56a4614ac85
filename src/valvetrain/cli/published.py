"""Every published value beside the computed one, for people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from valvetrain.cli.tables import plain_table

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from valvetrain.solution.comparison import Comparison

ROLES = {
    "calibration": "calibration: the case was identified by these",
    "check": "check: known when the case was identified, not used for it",
    "prediction": "prediction: not used to identify the case",
}


def show_comparisons(console: Console, rows: Sequence[Comparison]) -> None:
    """One block per engine speed and role, then a legend and what became of the stated tolerances."""
    from valvetrain.report import theme
    from valvetrain.report.words import speed_words

    speeds = sorted(
        {row.engine_speed for row in rows}, key=lambda speed: -1.0 if speed is None else speed
    )
    for speed in speeds:
        for role in dict.fromkeys(row.role for row in rows if row.engine_speed == speed):
            block = [row for row in rows if row.engine_speed == speed and row.role == role]
            place = "statics and modes" if speed is None else speed_words(speed)
            console.print()
            console.print(comparison_table(block, f"{place} ({ROLES.get(role, role)})"))
    origins = dict.fromkeys(row.origin for row in rows)
    console.print()
    for origin in origins:
        model = next(row.model for row in reversed(rows) if row.origin == origin)
        beside = f", beside our {theme.model_words(model)}" if model else ""
        console.print(
            f"{theme.origin_style(origin)[0]}  published by {origin or 'its source'}{beside}"
        )
    for role in dict.fromkeys(row.role for row in rows):
        console.print(tally([row for row in rows if row.role == role], role))


def comparison_table(rows: Sequence[Comparison], title: str) -> Table:
    """Quantity, by whom, published, computed, difference, verdict: within 100 columns."""
    from valvetrain.parameters.words import in_unit, number
    from valvetrain.report import theme
    from valvetrain.solution.definition import label_of

    def words(value: float | None, unit: str) -> str:
        return "–" if value is None else number(in_unit(value, unit))

    table = plain_table(
        ("quantity", "by", "published", "computed", "difference", "verdict"),
        (),
        title,
        right=(2, 3, 4),
    )
    for column, width in zip(table.columns, (36, 2, 15, 10, 10, 17), strict=True):
        column.width, column.overflow = width, "fold"
    for row in rows:
        published = f"{words(row.published, row.unit)} {short_unit(row.unit)}".strip()
        table.add_row(
            label_of(row.quantity),
            theme.origin_style(row.origin)[0],
            published,
            words(row.computed, row.unit),
            difference_words(row),
            short_verdict(row),
        )
    return table


def short_unit(unit: str) -> str:
    """A unit with raised powers."""
    return unit.replace("^2", "²").replace("^3", "³")


def difference_words(row: Comparison) -> str:
    """In percent of what was published; angles, and what was published as zero, in their unit."""
    from valvetrain.parameters.words import in_unit, number
    from valvetrain.report.words import percent

    if row.difference is None:
        return "–"
    relative = row.relative_difference
    if relative is not None and not row.quantity.endswith("_angle"):
        text = percent(relative)
    else:
        value = in_unit(row.difference, row.unit)
        text = f"{'+' if value > 0 else ''}{number(value, 3)} {short_unit(row.unit)}"
    return text.replace("-", "−")


def short_verdict(row: Comparison) -> str:
    """The verdict without the difference, which has a column of its own."""
    first, _, rest = row.verdict.partition(",")
    if first.startswith("differs"):
        return "–"
    if first.startswith("misses"):
        return f"misses{' (' + rest.replace('tolerance', '').strip() + ')' if rest else ''}"
    return first.partition(":")[0]


def tally(rows: Sequence[Comparison], role: str) -> str:
    """One line: how many values, how many meet a stated tolerance."""
    kinds = Counter(row.verdict.split(" ")[0] for row in rows)
    judged = kinds["within"] + kinds["misses"]
    missing = f", {kinds['not']} not computed" if kinds["not"] else ""
    met = (
        f"{kinds['within']} of {judged} stated tolerances met"
        if judged
        else "no tolerance was stated"
    )
    return f"{role}: {len(rows)} published values, {met}{missing}"
