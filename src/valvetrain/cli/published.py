"""Every published value next to the computed one, for people."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from valvetrain.cli.outcome import plain_table
from valvetrain.parameters.summary import number
from valvetrain.report.headlines import HeadlineColumn, HeadlineRow
from valvetrain.runs.error_bars import STIFFNESS_FACTORS
from valvetrain.solution.critical import DAMPING_FACTORS
from valvetrain.solution.definition import shown
from valvetrain.solution.quantity import same_speed
from valvetrain.solution.uncertainty import CONSTANTS, NOT_RESOLVED

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
NARROW = 100
#: Mark behind a number that contact constants decide and whose range was not computed.
RESTS = "*"
#: Mark behind a number whose error bar is not resolved.
UNRESOLVED = "(?)"
#: Digits of a value that are shown, and of its bar.
DIGITS, BAR_DIGITS = 4, 2
#: Share of a value from which an error bar is shown where there is no space for smaller ones.
LARGE = 0.05
#: Smallest bar that is shown; a power of ten would be as wide as a column.
MIN_BAR = 1e-4


@dataclass(frozen=True)
class ErrorBars:
    """Uncertainties by quantity; ``between`` is the text around the ± sign, ``least`` the share of a
    value up to which its bar is left to the page and to JSON.
    """

    rows: Mapping[str, Sequence[Uncertainty]] = field(default_factory=dict)
    between: str = " "
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

    def _held(
        self, value: float | None, row: HeadlineRow, column: HeadlineColumn
    ) -> Uncertainty | None:
        """The uncertainty of the value in a column; None where there is none, or of another value."""
        if value is None or not math.isfinite(value) or column.engine_speed is None:
            return None
        for held in self.rows.get(row.name, ()):
            if held.label == column.label and same_speed(held.engine_speed, column.engine_speed):
                bar = float(shown(row.name, held.numerical)[0])
                own = float(shown(row.name, held.value)[0])
                return held if math.isclose(value, own, rel_tol=1e-3, abs_tol=bar) else None
        return None

    def _cell(self, value: float | None, row: HeadlineRow, column: HeadlineColumn) -> str:
        label, held = number(value, DIGITS), self._held(value, row, column)
        if not value or held is None:
            return label
        mark = RESTS if held.rests_on_contact_constants else ""
        bar = float(shown(row.name, held.numerical)[0])
        last = 10.0 ** (math.floor(math.log10(abs(value))) - DIGITS + 1)
        if bar < max(last / 2, MIN_BAR, self.least * abs(value)):
            return label + mark
        if not held.resolved:
            return f"{label}{mark} {UNRESOLVED}"
        return f"{label}{self.between}±{self.between}{number(bar, BAR_DIGITS)}{mark}"

    def ranges(self, row: HeadlineRow, columns: Sequence[HeadlineColumn]) -> list[str]:
        """The range of each value over contact stiffness and damping: ``979 to 989``; empty where none was
        computed, or where it moves no digit.
        """
        cells = []
        for value, column in zip(row.values, columns, strict=True):
            held = self._held(value, row, column)
            found = None if held is None else held.range
            ends = () if found is None else (found.low, found.high)
            texts = dict.fromkeys(number(float(shown(row.name, end)[0]), DIGITS) for end in ends)
            cells.append(" to ".join(texts) if len(texts) > 1 else "")
        return cells

    def legend(self, rows: Sequence[HeadlineRow], columns: Sequence[HeadlineColumn]) -> str:
        """What the ranges and the marks of a table mean; empty without them."""
        lines = []
        if any(any(self.ranges(row, columns)) for row in rows):
            factors = zip(CONSTANTS, (STIFFNESS_FACTORS, DAMPING_FACTORS), strict=True)
            texts = (f"{name} × {low:g} to {high:g}" for name, (low, high) in factors)
            lines.append(f"range: the value over {' and '.join(texts)}")
        cells = [cell for row in rows for cell in self.cells(row, columns)]
        if any(UNRESOLVED in cell for cell in cells):
            lines.append(f"{UNRESOLVED} the error bar is {NOT_RESOLVED}")
        if any(RESTS in cell for cell in cells):
            lines.append(
                f"{RESTS} contact constants that nobody knows decide this number; 'valvetrain refine' computes its range"
            )
        return "\n".join(lines)


class Ranges(ErrorBars):
    """The ranges in place of the values."""

    def cells(self, row: HeadlineRow, columns: Sequence[HeadlineColumn]) -> list[str]:
        """The range of each value of a row."""
        return self.ranges(row, columns)


def fitting(bars: ErrorBars, width: Callable[[ErrorBars], int]) -> ErrorBars:
    """The bars as they fit into :data:`NARROW` columns by the ``width`` of their table: with spaces,
    without, or those above :data:`LARGE` alone.
    """
    *closer, last = (
        replace(bars, between=between, least=least)
        for between, least in ((" ", 0.0), ("", 0.0), ("", LARGE))
    )
    return next((one for one in closer if width(one) <= NARROW), last)
