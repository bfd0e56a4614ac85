"""A spring study for people: computed beside published, or all that was computed where nothing was published."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from valvetrain.cli.tables import plain_table, shown

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from valvetrain.quantities.study import SpringStudy
    from valvetrain.solution.comparison import Comparison

ROLES = {"calibration": "calibration: used to identify the case", "prediction": "prediction: not used to identify the case"}


def show_study(console: Console, study: SpringStudy) -> None:
    """Print title, table and notes."""
    console.print(study.case.title or study.case.name)
    if study.comparisons:
        show_comparisons(console, study.comparisons)
    else:
        console.print()
        console.print(quantity_table(study))
    for note in study.notes:
        console.print(f"\n{note}")


def show_comparisons(console: Console, rows: Sequence[Comparison]) -> None:
    """One block per engine speed and role, then a legend and what became of the stated tolerances."""
    from valvetrain.report import theme
    from valvetrain.report.words import speed_words

    speeds = sorted({row.engine_speed for row in rows}, key=lambda speed: -1.0 if speed is None else speed)
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
        console.print(f"{theme.origin_style(origin)[0]}  published by {origin or 'its source'}{beside}")
    for role in dict.fromkeys(row.role for row in rows):
        console.print(tally([row for row in rows if row.role == role], role))


def comparison_table(rows: Sequence[Comparison], title: str) -> Table:
    """Quantity, by whom, published, computed, difference, verdict: within 100 columns."""
    from valvetrain.report import theme
    from valvetrain.report.words import in_unit, number, quantity_words

    def words(value: float | None, unit: str) -> str:
        return "–" if value is None else number(in_unit(value, unit))

    table = plain_table(("quantity", "by", "published", "computed", "difference", "verdict"), (), title, right=(2, 3, 4))
    for column, width in zip(table.columns, (36, 2, 15, 10, 10, 17), strict=True):
        column.width, column.overflow = width, "fold"
    for row in rows:
        published = f"{words(row.published, row.unit)} {short_unit(row.unit)}".strip()
        table.add_row(
            quantity_words(row.quantity), theme.origin_style(row.origin)[0], published, words(row.computed, row.unit),
            difference_words(row), short_verdict(row),
        )  # fmt: skip
    return table


def short_unit(unit: str) -> str:
    """A unit with raised powers."""
    return unit.replace("^2", "²").replace("^3", "³")


def difference_words(row: Comparison) -> str:
    """In percent of what was published; angles, and what was published as zero, in their unit."""
    from valvetrain.report.words import in_unit, number, percent

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
    met = f"{kinds['within']} of {judged} stated tolerances met" if judged else "no tolerance was stated"
    return f"{role}: {len(rows)} published values, {met}{missing}"


def quantity_table(study: SpringStudy) -> Table:
    """Every computed quantity, one column per run, statics and modes first."""
    from valvetrain.report.words import quantity_words, rpm
    from valvetrain.solution.quantity import Quantity, unit_of

    runs = [(run.model, run.engine_speed) for run in study.solutions]
    names = list(dict.fromkeys(key.name for key in study.quantities))
    still = {key.name: value for key, value in study.quantities.items() if key.engine_speed is None}
    headers = ["quantity", "unit", *(["static"] if still else []), *(f"{model} {rpm(speed):g} rpm" for model, speed in runs)]
    table = plain_table(headers, (), right=range(2, len(headers)))
    for name in names:
        unit = unit_of(name)
        first = [shown(still.get(name), unit)[0] if name in still else ""] if still else []
        found = (study.quantities.get(Quantity(name, speed, model)) for model, speed in runs)
        moving = ["" if value is None else shown(value, unit)[0] for value in found]
        table.add_row(quantity_words(name), shown(None, unit)[1], *first, *moving)
    return table
