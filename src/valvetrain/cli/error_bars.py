"""Numerical uncertainty beside the numbers of the terminal's tables, where it is known and moves a
digit that is shown.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from valvetrain.parameters.words import number
from valvetrain.report.headlines import HeadlineColumn, HeadlineRow
from valvetrain.solution.definition import shown
from valvetrain.solution.quantity import same_speed

if TYPE_CHECKING:
    from valvetrain.solution.study import Study
    from valvetrain.studies.error_bars import Uncertainty

#: Columns of a terminal that every table of a few runs keeps to.
NARROW = 80
#: Digits of a value that are shown, and of its bar.
DIGITS, BAR_DIGITS = 4, 2
#: Smallest bar that is shown; a power of ten would be as wide as a column.
LEAST_BAR = 1e-4


@dataclass(frozen=True)
class ErrorBars:
    """Stored uncertainties by quantity; ``between`` stands around the sign of a bar, None shows
    none.
    """

    rows: Mapping[str, Sequence[Uncertainty]] = field(default_factory=dict)
    between: str | None = " "

    @classmethod
    def of(cls, study: Study) -> ErrorBars:
        """Those of the numbers that this study computed."""
        from valvetrain.studies.uncertainty_file import fresh_uncertainty

        rows: dict[str, list[Uncertainty]] = {}
        for row in fresh_uncertainty(study):
            rows.setdefault(row.quantity, []).append(row)
        return cls(rows)

    def cells(self, row: HeadlineRow, columns: Sequence[HeadlineColumn]) -> list[str]:
        """The values of a row, each with its bar: ``965 ± 2``."""
        return [
            self._cell(value, row, column)
            for value, column in zip(row.values, columns, strict=True)
        ]

    def _cell(self, value: float | None, row: HeadlineRow, column: HeadlineColumn) -> str:
        words = number(value, DIGITS)
        if (
            self.between is None
            or not value
            or not math.isfinite(value)
            or column.engine_speed is None
        ):
            return words
        for held in self.rows.get(row.name, ()):
            if held.label in ("", column.label) and same_speed(
                held.engine_speed, column.engine_speed
            ):
                bar = float(shown(row.name, held.numerical)[0])
                last = 10.0 ** (math.floor(math.log10(abs(value))) - DIGITS + 1)
                near = math.isclose(
                    value, float(shown(row.name, held.value)[0]), rel_tol=1e-3, abs_tol=bar
                )
                return (
                    f"{words}{self.between}±{self.between}{number(bar, BAR_DIGITS)}"
                    if near and bar >= max(last / 2, LEAST_BAR)
                    else words
                )
        return words


def fitting(bars: ErrorBars, width: Callable[[ErrorBars], int]) -> ErrorBars:
    """The bars as they fit into :data:`NARROW` columns by the ``width`` of their table: with
    spaces, without, or none at all.
    """
    for between in (" ", "", None):
        found = ErrorBars(bars.rows, between)
        if width(found) <= NARROW:
            break
    return found
