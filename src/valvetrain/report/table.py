"""Tables: the data of every figure, made before the figure, and writable as CSV."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.report.text import (
    in_unit,
    rpm,
)
from valvetrain.solution.comparison import Comparison

#: Signs with which a spreadsheet takes a cell for a formula, and words that are numbers all the
#: same.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-](inf|nan)")


@dataclass(frozen=True, eq=False)
class Column:
    """A named column with its unit (as shown), floats or words."""

    name: str
    unit: str
    values: NDArray[Any]

    @property
    def header(self) -> str:
        """Name and unit, as a reader sees them."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of equal length; raises :class:`InputError` for columns that differ in length."""

    columns: tuple[Column, ...]

    def __post_init__(self) -> None:
        if len({len(column.values) for column in self.columns}) > 1:
            raise InputError(
                f"the columns {[column.name for column in self.columns]} of a table differ in length"
            )

    def __len__(self) -> int:
        return len(self.columns[0].values) if self.columns else 0

    def __contains__(self, name: str) -> bool:
        return any(column.name == name for column in self.columns)

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.column(name).values

    def column(self, name: str) -> Column:
        """The column of that name; KeyError where there is none."""
        for column in self.columns:
            if column.name == name:
                return column
        raise KeyError(name)

    def rows(self) -> Iterable[tuple[Any, ...]]:
        """Row by row, as plain Python values."""
        return zip(*(column.values.tolist() for column in self.columns), strict=True)

    def csv(self) -> str:
        """The table as CSV text with units in its header."""
        lines = [",".join(quoted(column.header) for column in self.columns)]
        lines += [",".join(quoted(value) for value in row) for row in self.rows()]
        return "\n".join(lines) + "\n"


def table(*columns: tuple[str, str, Sequence[Any] | NDArray[Any]]) -> Table:
    """A table from (name, unit, values) triples."""
    return Table(tuple(Column(name, unit, np.asarray(values)) for name, unit, values in columns))


def quoted(value: Any) -> str:
    """One CSV cell: floats to the last digit, nothing for None, quotes where needed; words that a
    spreadsheet would compute are led by an apostrophe.
    """
    if value is None:
        return ""
    if isinstance(value, float):
        return repr(value)
    text = str(value)
    if isinstance(value, str) and text.startswith(_FORMULA) and not _NUMBER.fullmatch(text):
        text = f"'{text}"
    return '"' + text.replace('"', '""') + '"' if any(sign in text for sign in ',"\n\r') else text


def comparison_table(rows: Sequence[Comparison]) -> Table:
    """All rows as a table in the units shown, for ``comparison.csv``."""

    def shown(value: float | None, unit: str) -> float | None:
        return None if value is None else in_unit(value, unit)

    def text_cells(values: list[object]) -> np.ndarray:
        return np.array(values, dtype=object)

    return table(
        ("quantity", "", text_cells([row.quantity for row in rows])),
        (
            "engine speed",
            "rpm",
            text_cells(
                [None if row.engine_speed is None else rpm(row.engine_speed) for row in rows]
            ),
        ),
        ("given by", "", text_cells([row.origin for row in rows])),
        ("given", "", text_cells([shown(row.published, row.unit) for row in rows])),
        ("computed by", "", text_cells([row.model for row in rows])),
        ("computed", "", text_cells([shown(row.computed, row.unit) for row in rows])),
        ("blind", "", text_cells([shown(row.blind, row.unit) for row in rows])),
        ("difference", "", text_cells([shown(row.difference, row.unit) for row in rows])),
        ("unit", "", text_cells([row.unit for row in rows])),
        ("relative difference", "", text_cells([row.relative_difference for row in rows])),
        ("tolerance", "", text_cells([shown(row.tolerance, row.unit) for row in rows])),
        ("role", "", text_cells([row.role for row in rows])),
        ("verdict", "", text_cells([row.verdict for row in rows])),
        ("source", "", text_cells([row.source for row in rows])),
        ("used for", "", text_cells([row.used_for for row in rows])),
        ("reading", "", text_cells([row.reading for row in rows])),
        *(
            (
                f"{end} over phases",
                "",
                text_cells(
                    [row.samples and shown(getattr(row.samples, end), row.unit) for row in rows]
                ),
            )
            for end in ("low", "high")
        ),
        *(
            (name, "", text_cells([row.samples and getattr(row.samples, end) for row in rows]))
            for name, end in (("share at or above", "share"), ("phases", "phases"))
        ),
    )
