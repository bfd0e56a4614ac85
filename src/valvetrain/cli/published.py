"""Every published value next to the computed one, for people."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from valvetrain.cli.outcome import plain_table
from valvetrain.parameters.summary import number
from valvetrain.report.headlines import HeadlineColumn, HeadlineRow
from valvetrain.solution.definition import shown
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.uncertainty import NOT_RESOLVED

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from valvetrain.solution.comparison import Comparison
    from valvetrain.solution.study import Study
    from valvetrain.solution.uncertainty import Uncertainty


ROLES = {
    "calibration": "calibration: the case was identified by these",
    "check": "check: known when the case was identified, not used for it",
    "prediction": "prediction: not used to identify the case",
}


def show_comparisons(console: Console, rows: Sequence[Comparison]) -> None:
    """One block per engine speed and role, then a legend and what became of the stated tolerances."""
    from valvetrain.report import theme
    from valvetrain.report.text import speed_text

    speeds = sorted(
        {row.engine_speed for row in rows}, key=lambda speed: -1.0 if speed is None else speed
    )
    for speed in speeds:
        for role in dict.fromkeys(row.role for row in rows if row.engine_speed == speed):
            block = [row for row in rows if row.engine_speed == speed and row.role == role]
            place = "statics and modes" if speed is None else speed_text(speed)
            console.print()
            console.print(comparison_table(block, f"{place} ({ROLES.get(role, role)})"))
    origins = dict.fromkeys(row.origin for row in rows)
    console.print()
    for origin in origins:
        model = next(row.model for row in reversed(rows) if row.origin == origin)
        compared = f", next to our {theme.model_label(model)}" if model else ""
        console.print(
            f"{theme.origin_style(origin)[0]}  published by {origin or 'its source'}{compared}"
        )
    for role in dict.fromkeys(row.role for row in rows):
        console.print(tally([row for row in rows if row.role == role], role))


def comparison_table(rows: Sequence[Comparison], title: str) -> Table:
    """Quantity, by whom, published, computed, difference, verdict: within 100 columns."""
    from valvetrain.parameters.summary import in_unit, number
    from valvetrain.report import theme
    from valvetrain.solution.definition import label_of

    def shown(value: float | None, unit: str) -> str:
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
        published = f"{shown(row.published, row.unit)} {short_unit(row.unit)}".strip()
        table.add_row(
            label_of(row.quantity),
            theme.origin_style(row.origin)[0],
            published,
            shown(row.computed, row.unit),
            difference_text(row),
            short_verdict(row),
        )
    return table


def short_unit(unit: str) -> str:
    """A unit with raised powers."""
    return unit.replace("^2", "²").replace("^3", "³")


def difference_text(row: Comparison) -> str:
    """Difference in per cent of the published value; angles, and differences from a published zero,
    in their unit.
    """
    from valvetrain.parameters.summary import in_unit, number
    from valvetrain.report.text import percent

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
    """The verdict without the difference."""
    verdict, _, spread = row.verdict.partition("; ")
    first, _, rest = verdict.partition(",")
    if first.startswith("differs"):
        return spread or "–"
    if first.startswith("misses"):
        short = f"misses{' (' + rest.replace('tolerance', '').strip() + ')' if rest else ''}"
    else:
        short = first.partition(":")[0]
    return f"{short}; {spread}" if spread else short


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


#: Columns of a terminal that no table of a few runs exceeds.
NARROW = 80
#: Digits of a value that are shown, and of its bar.
DIGITS, BAR_DIGITS = 4, 2
#: Share of a value from which an error bar is shown where there is no space for smaller ones.
LARGE = 0.05
#: Smallest bar that is shown; a power of ten would be as wide as a column.
MIN_BAR = 1e-4


@dataclass(frozen=True)
class ErrorBars:
    """Stored uncertainties by quantity; ``between`` is the text around the ± sign, None hides the
    bars; ``least``: share of a value up to which its bar is hidden.
    """

    rows: Mapping[str, Sequence[Uncertainty]] = field(default_factory=dict)
    between: str | None = " "
    least: float = 0.0

    @classmethod
    def of(cls, study: Study) -> ErrorBars:
        """Error bars of the quantities of this study."""
        rows: dict[str, list[Uncertainty]] = {}
        for row in study.error_bars.rows:
            rows.setdefault(row.quantity, []).append(row)
        return cls(rows)

    def cells(self, row: HeadlineRow, columns: Sequence[HeadlineColumn]) -> list[str]:
        """The values of a row, each with its bar: ``965 ± 2``."""
        return [
            self._cell(value, row, column) + row.mark(place)
            for place, (value, column) in enumerate(zip(row.values, columns, strict=True))
        ]

    def _cell(self, value: float | None, row: HeadlineRow, column: HeadlineColumn) -> str:
        label = number(value, DIGITS)
        if (
            self.between is None
            or not value
            or not math.isfinite(value)
            or column.engine_speed is None
        ):
            return label
        for held in self.rows.get(row.name, ()):
            if held.label == column.label and same_speed(held.engine_speed, column.engine_speed):
                bar = float(shown(row.name, held.numerical)[0])
                last = 10.0 ** (math.floor(math.log10(abs(value))) - DIGITS + 1)
                near = math.isclose(
                    value, float(shown(row.name, held.value)[0]), rel_tol=1e-3, abs_tol=bar
                )
                if not near or bar < max(last / 2, MIN_BAR, self.least * abs(value)):
                    return label
                if not held.resolved:
                    return f"{label} ({NOT_RESOLVED})"
                return f"{label}{self.between}±{self.between}{number(bar, BAR_DIGITS)}"
        return label


def fitting(bars: ErrorBars, width: Callable[[ErrorBars], int]) -> ErrorBars:
    """The bars as they fit by the ``width`` of their table, which is :data:`NARROW` or what values take: with
    spaces, without, those above :data:`LARGE` alone, or none at all.
    """
    room = max(NARROW, width(ErrorBars(bars.rows, None)))
    for between, least in ((" ", 0.0), ("", 0.0), ("", LARGE), (None, 0.0)):
        found = ErrorBars(bars.rows, between, least)
        if width(found) <= room:
            break
    return found
