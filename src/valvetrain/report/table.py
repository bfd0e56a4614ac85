"""Tables: the data of every figure, made before the figure, and writable as CSV."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.report import theme
from valvetrain.report.page import Cell, Grid
from valvetrain.report.text import (
    in_unit,
    number,
    percent,
    quantity_label,
    rpm,
    speed_text,
    unit_text,
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


HEADERS = (
    "quantity",
    "engine speed",
    "given by",
    "given",
    "model",
    "computed",
    "difference",
    "",
    "unit",
    "role",
    "verdict",
)


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


def comparison_grid(rows: Sequence[Comparison]) -> Grid:
    """The same for the page, in order of engine speed, what is at rest first."""
    ordered = sorted(rows, key=lambda row: -1.0 if row.engine_speed is None else row.engine_speed)
    return Grid(
        HEADERS,
        tuple((_cells(row), (row.role, _speed(row), row.origin)) for row in ordered),
        ("role", "engine speed", "given by"),
    )


def _speed(row: Comparison) -> str:
    return "at rest" if row.engine_speed is None else speed_text(row.engine_speed)


def _cells(row: Comparison) -> tuple[Cell, ...]:
    sign, caption, _, _ = theme.origin_style(row.origin)
    relative = row.relative_difference
    wraps = row.unit == "deg" and row.quantity.endswith("_cam_angle")
    share = "" if relative is None or wraps else percent(relative)
    exact = row.difference is not None and abs(row.difference) < 1e-9 * max(
        abs(row.published), abs(row.computed or 0.0)
    )
    size = 0.0 if row.difference is None else in_unit(row.difference, row.unit)
    signed = ("+" if size > 0 else "") + number(size, 3)
    difference = "–" if row.difference is None else "0" if exact else signed
    return (
        Cell(quantity_label(row.quantity), "long", row.quantity),
        Cell(_speed(row), "quiet"),
        Cell(sign, "tag", caption),
        Cell(_in(row.published, row.unit), "number", row.reading),
        Cell(theme.model_label(row.model) if row.model else "", "quiet", row.model),
        Cell(
            _in(row.computed, row.unit),
            "number",
            "" if row.blind is None else f"not fitted to it: {_in(row.blind, row.unit)}",
        ),
        Cell(difference, "number"),
        Cell(share, "number quiet"),
        Cell(unit_text(row.unit), "quiet"),
        Cell(row.role, "quiet", row.used_for),
        Cell(
            "no tolerance stated"
            if row.verdict.startswith("differs") and row.samples is None
            else row.verdict.replace(" -", " −"),
            tone(row),
            row.source,
        ),
    )


def tone(row: Comparison) -> str:
    """``good`` or ``bad`` where a tolerance decides, ``quiet`` where none was stated."""
    if row.verdict.startswith("within"):
        return "good"
    return "bad" if row.verdict.startswith("misses") else "quiet"


def _in(value: float | None, unit: str) -> str:
    return "–" if value is None else number(in_unit(value, unit))
