"""Plain tables for people."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from rich.table import Table


def plain_table(
    headers: Sequence[str],
    rows: Iterable[Sequence[str]],
    title: str = "",
    right: Sequence[int] = (),
) -> Table:
    """A table without frames; ``right`` are the columns of numbers."""
    table = Table(
        title=title or None,
        box=None,
        pad_edge=False,
        padding=(0, 2, 0, 0),
        title_justify="left",
        title_style="bold",
        show_header=any(headers),
    )
    for place, header in enumerate(headers):
        table.add_column(header, justify="right" if place in right else "left", overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table


def shown_words(name: str, value: float | None, digits: int = 5) -> tuple[str, str]:
    """SI ``value`` of quantity ``name`` as (number, unit) in the field's units."""
    from valvetrain.parameters.words import number, unit_words
    from valvetrain.solution.definition import definition_of, shown

    unit = unit_words(definition_of(name).shown_unit)
    return ("–" if value is None else number(float(shown(name, value)[0]), digits)), unit


def quantity_rows(values: Mapping[str, float]) -> list[tuple[str, str, str]]:
    """(name, number, unit) of named SI quantities."""
    from valvetrain.solution.definition import label_of

    return [
        (label_of(name)[:1].upper() + label_of(name)[1:], *shown_words(name, value))
        for name, value in values.items()
    ]
