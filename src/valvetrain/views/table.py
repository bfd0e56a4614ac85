"""A line of the first table, and a folded table, as texts."""

from __future__ import annotations

from dataclasses import dataclass, field

from valvetrain.findings.engine import Mark


@dataclass(frozen=True)
class Line:
    """A row with its texts: ``cells`` of the columns, ``mark`` and ``remark``."""

    label: str
    cells: tuple[str, ...]
    mark: Mark = ""
    remark: str = ""


@dataclass(frozen=True)
class TextTable:
    """A table as texts.

    Parameters
    ----------
    title : above the table
    columns : headings
    rows : cells, a text for each column; a row of one cell is a heading across
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...] = field(default=())
