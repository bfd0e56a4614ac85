"""Tables: the data of every figure, made before the figure, and writable as CSV."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.solution.uncertainty import Comparison
from valvetrain.views.text import in_unit, rpm

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

    def __getitem__(self, name: str) -> NDArray[Any]:
        return next(column.values for column in self.columns if column.name == name)

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
    plain = {
        "quantity": "quantity", "engine speed": "engine_speed", "given by": "origin", "given": "published", "computed by": "model",
        "computed": "computed", "blind": "blind", "difference": "difference", "unit": "unit",
        "relative difference": "relative_difference", "tolerance": "tolerance", "role": "role", "verdict": "verdict",
        "source": "source", "used for": "used_for", "reading": "reading",
    }  # fmt: skip
    sampled = {"low over phases": "low", "high over phases": "high", "share at or above": "share", "phases": "phases"}  # fmt: skip
    cells = {name: [getattr(row, key) for row in rows] for name, key in plain.items()}
    cells |= {
        name: [row.samples and getattr(row.samples, key) for row in rows]
        for name, key in sampled.items()
    }
    cells["engine speed"] = [one if one is None else rpm(one) for one in cells["engine speed"]]
    for name in ("given", "computed", "blind", "difference", "tolerance", *[*sampled][:2]):
        cells[name] = [
            one if one is None else in_unit(one, row.unit)
            for one, row in zip(cells[name], rows, strict=True)
        ]
    return table(
        *(
            (name, "rpm" if name == "engine speed" else "", np.array(values, dtype=object))
            for name, values in cells.items()
        )
    )
