"""One list of columns for page, CSV and JSON: how a row of a table appears in each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from valvetrain.findings.words import Amount, Words
from valvetrain.parameters.summary import number
from valvetrain.views.table import TextTable


@dataclass(frozen=True, slots=True)
class RowColumn:
    """One column of a table whose rows are objects of one type.

    ``heading`` and ``text(row)``: as people read it; without text it is for files alone. ``value``:
    attribute of the row, dotted where it is one of an attribute, or a function of the row; ``key``
    names it in JSON and ``csv`` in CSV, where they are not empty; ``csv_factor``: from SI to the unit
    of the CSV.
    ``quantity``: its name, or a function of the row that gives it,
    in whose unit :func:`table_of` writes the value; none for a plain number.
    """

    heading: str = ""
    text: Callable[[Any], str] | None = None
    value: str | Callable[[Any], Any] = ""
    key: str = ""
    csv: str = ""
    csv_factor: float = 1.0
    quantity: str | Callable[[Any], str] = ""

    def of(self, row: Any) -> Any:
        """Value of a row, SI, for JSON and CSV."""
        return attrgetter(self.value)(row) if isinstance(self.value, str) else self.value(row)


def table_of(
    title: str, columns: Sequence[RowColumn], rows: Iterable[Any], words: Words
) -> TextTable:
    """The table on a page, its amounts by ``words``; columns without heading are left out."""
    shown = [column for column in columns if column.heading]
    cells = (tuple(_cell(column, row, words) for column in shown) for row in rows)
    return TextTable(title, tuple(column.heading for column in shown), tuple(cells))


def _cell(column: RowColumn, row: Any, words: Words) -> str:
    """The text of a cell; empty for what is not a number."""
    if column.text is not None:
        return column.text(row)
    value = column.of(row)
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        return "" if value is None else str(value)
    if not math.isfinite(value):
        return "∞" if value == math.inf else ""
    name = column.quantity(row) if callable(column.quantity) else column.quantity
    return words.amount(Amount(name, value), 4) if name else number(value)


def json_row(columns: Sequence[RowColumn], row: Any) -> dict[str, Any]:
    """The values of a row by their keys."""
    return {column.key: column.of(row) for column in columns if column.key}


def csv_row(columns: Sequence[RowColumn], row: Any) -> list[Any]:
    """The values of a row in the order of the headings ``csv``."""
    return [
        column.of(row) if column.csv_factor == 1.0 else column.csv_factor * column.of(row)
        for column in columns
        if column.csv
    ]
