"""One list of columns for terminal, page, CSV and JSON: how a row of a table appears in each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

from valvetrain.report.page import Cell, Grid


@dataclass(frozen=True, slots=True)
class RowColumn:
    """One column of a table whose rows are objects of one type.

    ``heading`` and ``text(row)``: as people read it; without text it is for files alone. ``value``:
    attribute of the row, dotted where it is one of an attribute, or a function of the row; ``key``
    names it in JSON and ``csv`` in CSV, where they are not empty; ``csv_factor``: from SI to the unit
    of the CSV. ``number``: aligned right.
    ``tones``: text of a cell -> its tone on the page.
    """

    heading: str = ""
    text: Callable[[Any], str] | None = None
    value: str | Callable[[Any], Any] = ""
    key: str = ""
    csv: str = ""
    csv_factor: float = 1.0
    number: bool = True
    tones: Mapping[str, str] = field(default_factory=dict)

    def of(self, row: Any) -> Any:
        """Value of a row, SI, for JSON and CSV."""
        return attrgetter(self.value)(row) if isinstance(self.value, str) else self.value(row)


def text_table(
    columns: Sequence[RowColumn], rows: Iterable[Any]
) -> tuple[tuple[str, ...], list[tuple[str, ...]], tuple[int, ...]]:
    """Headings, rows and the places of the columns of numbers, as the terminal prints them."""
    shown = [(column, column.text) for column in columns if column.text is not None]
    return (
        tuple(column.heading for column, _ in shown),
        [tuple(text(row) for _, text in shown) for row in rows],
        tuple(place for place, (column, _) in enumerate(shown) if column.number),
    )


def grid(columns: Sequence[RowColumn], rows: Iterable[Any]) -> Grid:
    """The same table on a page."""
    tones = [column for column in columns if column.text is not None]
    headings, texts, _ = text_table(columns, rows)
    return Grid(
        headings,
        tuple(
            (
                tuple(
                    Cell(text, column.tones.get(text, "number" if column.number else ""))
                    for column, text in zip(tones, row, strict=True)
                ),
                (),
            )
            for row in texts
        ),
    )


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
