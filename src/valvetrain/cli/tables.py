"""Plain tables for people."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from rich.table import Table

from valvetrain.report.words import number

#: SI unit -> unit of the field and the factor between.
SHOWN: dict[str, tuple[str, float]] = {
    "m": ("mm", 1e3), "rad": ("deg", 180 / math.pi), "s": ("ms", 1e3), "N/m": ("N/mm", 1e-3), "kg": ("g", 1e3), "Pa": ("MPa", 1e-6),
    "rad/s": ("rpm", 30 / math.pi), "N s": ("mN s", 1e3), "1": ("", 1.0),
}  # fmt: skip


def plain_table(headers: Sequence[str], rows: Iterable[Sequence[str]], title: str = "", right: Sequence[int] = ()) -> Table:
    """A table without frames; ``right`` are the columns of numbers."""
    table = Table(
        title=title or None, box=None, pad_edge=False, padding=(0, 2, 0, 0), title_justify="left", title_style="bold",
        show_header=any(headers),
    )  # fmt: skip
    for place, header in enumerate(headers):
        table.add_column(header, justify="right" if place in right else "left", overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table


def shown(value: float | None, unit: str, digits: int = 5) -> tuple[str, str]:
    """SI ``value`` as (number, unit) in the field's units."""
    usual, factor = SHOWN.get(unit, (unit, 1.0))
    return ("–", usual) if value is None else (number(value * factor, digits), usual)


def quantity_rows(values: Mapping[str, float], words: Mapping[str, str] | None = None) -> list[tuple[str, str, str]]:
    """(name, number, unit) of named SI quantities; ``words`` gives other names."""
    from valvetrain.report.words import quantity_words
    from valvetrain.solution.quantity import unit_of

    return [((words or {}).get(name) or quantity_words(name), *shown(value, unit_of(name))) for name, value in values.items()]
